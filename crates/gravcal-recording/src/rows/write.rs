//! Recordings out, row by row: the writers of each kind of file, chosen by the end of its name.

use std::path::Path;

use crate::write::WriteError;

mod csv;
pub(crate) mod mcap;
mod parquet;
mod row_writer;

use row_writer::check_cells;
pub use row_writer::{Heading, RowWriter};

/// Begins a recording; the end of its name says which kind: `.mcap` (messages `sensor_msgs/JointState`), `.csv` or
/// `.parquet`.
///
/// # Errors
///
/// The name ends otherwise, there is such a file already and not `overwrite`, its folder does not exist, a column has no name,
/// that of another, or no place in the kind of file, or the file cannot be written.
pub fn create(path: &Path, heading: &Heading, overwrite: bool) -> Result<Box<dyn RowWriter>, WriteError> {
    crate::write_table::check_columns(path, &heading.columns)?;
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("mcap") => Ok(Box::new(mcap::McapWriter::create(path, heading, overwrite)?)),
        Some("csv") => Ok(Box::new(csv::CsvWriter::create(path, heading, overwrite)?)),
        Some("parquet") => Ok(Box::new(parquet::ParquetWriter::create(path, heading, overwrite)?)),
        _ => Err(WriteError::UnknownKind { path: path.to_owned() }),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::fs;

    use super::*;

    fn heading(columns: &[&str]) -> Heading {
        let metadata = BTreeMap::from([("load".to_owned(), "plate-a".to_owned())]);
        Heading { columns: columns.iter().map(|column| column.to_string()).collect(), metadata }
    }

    #[test]
    fn the_name_says_the_kind() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.txt", "a", "a.csv.gz"] {
            let path = folder.path().join(name);
            let error = create(&path, &heading(&["time_s"]), false).err().unwrap().to_string();
            assert!(error.ends_with("a recording is written as .mcap, .csv or .parquet, and its name must end so"));
        }
    }

    #[test]
    fn a_file_has_its_name_at_the_end_or_never() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.mcap", "a.csv", "a.parquet"] {
            let path = folder.path().join(name);
            let begin = |overwrite| create(&path, &heading(&["time_s", "a.position"]), overwrite);
            let mut killed = begin(false).unwrap();
            killed.write(&[0.5, 1.0]).unwrap();
            drop(killed);
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{name}");

            let mut writer = begin(false).unwrap();
            writer.write(&[0.5, 1.0]).unwrap();
            assert!(!path.exists());
            let late = begin(false).unwrap();
            writer.finish().unwrap();
            let old = fs::read(&path).unwrap();
            for error in [begin(false).err(), late.finish().err()] {
                assert!(matches!(error, Some(WriteError::Exists { .. })), "{error:?}");
            }
            assert_eq!(fs::read(&path).unwrap(), old);
            begin(true).unwrap().finish().unwrap();
            assert_ne!(fs::read(&path).unwrap(), old);
            fs::remove_file(&path).unwrap();
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let columns = ["time_s", "a.position"];
        for name in ["a.mcap", "a.csv", "a.parquet"] {
            let mut writer = create(&folder.path().join(name), &heading(&columns), false).unwrap();
            let short = writer.write(&[1.0]).unwrap_err();
            assert!(matches!(short, WriteError::Ragged { row: 1, expected: 2, found: 1, .. }), "{short}");
            let infinite = writer.write(&[1.0, f64::INFINITY]).unwrap_err();
            assert!(matches!(infinite, WriteError::NotFinite { row: 2, .. }), "{infinite}");
        }
        let path = folder.path().join("b.mcap");
        let error = create(&path, &heading(&["time_s", "temperature"]), false).err().unwrap();
        assert!(error.to_string().contains("column `temperature` has no place in a message of joint states"));
        let mut writer = create(&path, &heading(&columns), false).unwrap();
        for time in [-1.0, f64::NAN, 3e9] {
            assert!(matches!(writer.write(&[time, 0.0]), Err(WriteError::Time { .. })));
        }
    }
}
