//! Parts become one table, in their order.

use gravcal_recording::{LARGEST_DOCUMENT, NewFile, WriteError, read_whole};
use parquet::errors::ParquetError;

use super::BatchError;
use super::folder::StudyFolder;
use super::order::Expected;
use super::part::Part;
use super::table::{TableReader, compressed, writer};

/// Puts all parts together, those of the folder and of the others (which stay), into the folder's `trials.parquet` and
/// `times.csv`. Memory does not grow with their number.
///
/// # Errors
/// A part is missing, damaged or holds the trials of another, or another folder is of another study.
pub fn merge(folder: &StudyFolder, others: &[StudyFolder]) -> Result<(), BatchError> {
    if let Some(other) = others.iter().find(|other| other.manifest != folder.manifest) {
        return Err(BatchError::Another { folder: other.path().to_owned() });
    }
    if folder.is_complete() {
        return folder.forget_parts();
    }
    let folders: Vec<&StudyFolder> = std::iter::once(folder).chain(others).collect();
    let done = folders.iter().map(|folder| folder.done()).collect::<Result<Vec<_>, _>>()?;
    let parts = folder.manifest.parts();
    let holder = |number: usize| folders.iter().zip(&done).find(|(_, done)| done.contains(&number)).map(|(f, _)| *f);
    let missing = parts.iter().filter(|part| holder(part.number).is_none()).count();
    if missing > 0 {
        let folders = folders.iter().map(|folder| folder.path().to_owned()).collect();
        return Err(BatchError::Incomplete { missing, parts: parts.len(), folders });
    }
    let held = || parts.iter().filter_map(|part| Some((part, holder(part.number)?)));
    write_times(folder, held())?;
    write_trials(folder, held())?;
    folder.forget_parts()
}

fn write_trials<'a>(
    folder: &StudyFolder,
    parts: impl Iterator<Item = (&'a Part, &'a StudyFolder)>,
) -> Result<(), BatchError> {
    let path = folder.trials();
    let columns = folder.manifest.columns();
    let failed = |error: ParquetError| {
        BatchError::Write(WriteError::Io { path: path.clone(), cause: std::io::Error::other(error) })
    };
    let mut table = writer(columns.schema(), NewFile::create(&path, false)?, compressed()).map_err(failed)?;
    for (part, holder) in parts {
        let of_part = holder.part(part.number);
        let mut rows = TableReader::open(&of_part, &columns)?;
        let mut expected = Expected::new(&of_part, &folder.manifest, std::iter::once(part.clone()));
        while let Some(batch) = rows.next_batch() {
            let batch = batch?;
            rows.rows(&batch)?.iter().try_for_each(|row| expected.take(row))?;
            table.write(&batch).map_err(failed)?;
        }
        expected.end()?;
    }
    Ok(table.into_inner().map_err(failed)?.finish()?)
}

/// How long the trials of each point took, all threads together.
fn write_times<'a>(
    folder: &StudyFolder,
    parts: impl Iterator<Item = (&'a Part, &'a StudyFolder)>,
) -> Result<(), BatchError> {
    let mut sums = vec![[0.0; 3]; folder.manifest.points.len()];
    for (part, holder) in parts {
        // Times decide nothing: where they are lost, they count as none.
        let text = read_whole(&holder.part_times(part.number), LARGEST_DOCUMENT).unwrap_or_default();
        let text = String::from_utf8(text).unwrap_or_default();
        let mut cells = text.trim().split(',');
        let Some(point) = cells.next().and_then(|point| point.parse::<usize>().ok()) else { continue };
        if let Some(sums) = sums.get_mut(point) {
            let numbers = cells.map(|cell| cell.parse::<f64>().unwrap_or(0.0));
            sums.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += number);
        }
    }
    let mut text = "point,trials,simulating_s,calibrating_s\n".to_owned();
    for (point, [trials, simulating, calibrating]) in sums.iter().enumerate() {
        text.push_str(&format!("{point},{trials},{simulating:.6},{calibrating:.6}\n"));
    }
    folder.write_times(&text)
}
