//! Rows that another thread reads ahead: to take a file apart and to make something of its rows keep a core busy each.

use std::collections::BTreeMap;
use std::panic::resume_unwind;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::thread::{JoinHandle, spawn};

use super::{Row, Rows, Source};
use crate::error::ReadError;

/// Cells that are handed over at once.
const CELLS: usize = 1 << 15;
/// Batches that may wait.
const WAITING: usize = 2;

/// Rows from another thread, in batches.
pub(crate) struct Ahead {
    batches: Receiver<Batch>,
    /// Rows that have been read, for their memory.
    used: Sender<Vec<Row>>,
    thread: Option<JoinHandle<()>>,
    batch: Batch,
    /// How many rows of the batch have been given.
    given: usize,
}

/// Some rows, and what their reader says after them.
struct Batch {
    rows: Vec<Row>,
    /// The first so many are of this batch.
    count: usize,
    said: Said,
    /// What comes after them: rows, the end, or an error.
    next: Result<bool, ReadError>,
}

/// What is said of a recording.
struct Said {
    columns: Vec<String>,
    dates: Vec<bool>,
    source: Source,
    remarks: Vec<String>,
    lost: Vec<String>,
    metadata: BTreeMap<String, String>,
    progress: f64,
}

impl Said {
    fn of(rows: &dyn Rows) -> Said {
        Said {
            columns: rows.columns().to_vec(),
            dates: (0..rows.columns().len()).map(|column| rows.holds_dates(column)).collect(),
            source: rows.source(),
            remarks: rows.remarks(),
            lost: rows.lost(),
            metadata: rows.metadata(),
            progress: rows.progress(),
        }
    }
}

impl Batch {
    /// The next rows of a recording, in memory of others.
    fn read(from: &mut dyn Rows, mut rows: Vec<Row>) -> Batch {
        let (mut count, mut cells) = (0, 0);
        let mut next = Ok(true);
        while cells < CELLS && matches!(next, Ok(true)) {
            if count == rows.len() {
                rows.push(Row::default());
            }
            next = from.read(&mut rows[count]);
            if matches!(next, Ok(true)) {
                cells += 1 + rows[count].cells.len();
                count += 1;
            }
        }
        Batch { rows, count, said: Said::of(from), next }
    }
}

impl Ahead {
    /// Begins to read.
    pub(crate) fn new(rows: Box<dyn Rows + Send>) -> Ahead {
        let batch = Batch { rows: Vec::new(), count: 0, said: Said::of(rows.as_ref()), next: Ok(true) };
        let (send, batches) = sync_channel(WAITING);
        let (used, free) = channel();
        let thread = spawn(move || read(rows, &send, &free));
        Ahead { batches, used, thread: Some(thread), batch, given: 0 }
    }
}

/// Reads to the end, or until nobody wants more.
fn read(mut rows: Box<dyn Rows + Send>, batches: &SyncSender<Batch>, used: &Receiver<Vec<Row>>) {
    loop {
        let batch = Batch::read(rows.as_mut(), used.try_recv().unwrap_or_default());
        let goes_on = matches!(batch.next, Ok(true));
        if batches.send(batch).is_err() || !goes_on {
            return;
        }
    }
}

impl Rows for Ahead {
    fn columns(&self) -> &[String] {
        &self.batch.said.columns
    }

    fn read(&mut self, row: &mut Row) -> Result<bool, ReadError> {
        while self.given == self.batch.count {
            if !std::mem::replace(&mut self.batch.next, Ok(false))? {
                return Ok(false);
            }
            let Ok(batch) = self.batches.recv() else {
                // Only where it panicked is it gone without having said how it ends.
                return match self.thread.take().map(JoinHandle::join) {
                    Some(Err(panicked)) => resume_unwind(panicked),
                    _ => Ok(false),
                };
            };
            let read = std::mem::replace(&mut self.batch, batch);
            // At the end nobody takes it.
            let _ = self.used.send(read.rows);
            self.given = 0;
        }
        std::mem::swap(row, &mut self.batch.rows[self.given]);
        row.cells.resize(self.batch.said.columns.len(), f64::NAN);
        self.given += 1;
        Ok(true)
    }

    fn holds_dates(&self, column: usize) -> bool {
        self.batch.said.dates.get(column).is_some_and(|dates| *dates)
    }

    fn source(&self) -> Source {
        self.batch.said.source.clone()
    }

    fn remarks(&self) -> Vec<String> {
        self.batch.said.remarks.clone()
    }

    fn lost(&self) -> Vec<String> {
        self.batch.said.lost.clone()
    }

    fn metadata(&self) -> BTreeMap<String, String> {
        self.batch.said.metadata.clone()
    }

    fn progress(&self) -> f64 {
        self.batch.said.progress
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// So many rows, with one more column from the third on, and how they end.
    struct Counted {
        rows: u64,
        read: u64,
        columns: Vec<String>,
        end: fn() -> Result<bool, ReadError>,
    }

    impl Rows for Counted {
        fn columns(&self) -> &[String] {
            &self.columns
        }

        fn read(&mut self, row: &mut Row) -> Result<bool, ReadError> {
            if self.read == self.rows {
                return (self.end)();
            }
            self.read += 1;
            if self.read == 3 {
                self.columns.push("b".to_owned());
            }
            (row.number, row.cells) = (self.read, vec![self.read as f64; self.columns.len()]);
            Ok(true)
        }

        fn source(&self) -> Source {
            Source::default()
        }

        fn remarks(&self) -> Vec<String> {
            vec![format!("{} rows", self.read)]
        }

        fn metadata(&self) -> BTreeMap<String, String> {
            BTreeMap::new()
        }

        fn progress(&self) -> f64 {
            self.read as f64 / self.rows as f64
        }
    }

    fn ahead(rows: u64, end: fn() -> Result<bool, ReadError>) -> Ahead {
        Ahead::new(Box::new(Counted { rows, read: 0, columns: vec!["a".to_owned()], end }))
    }

    #[test]
    fn rows_come_in_their_order_with_a_cell_for_each_column() {
        for count in [0, 1, 2, 100_000] {
            let (mut rows, mut row, mut read) = (ahead(count, || Ok(false)), Row::default(), 0);
            while rows.read(&mut row).unwrap() {
                read += 1;
                assert_eq!((row.number, row.cells[0]), (read, read as f64));
                assert_eq!(row.cells.len(), rows.columns().len());
                assert!(read < 3 || row.cells[1] == read as f64);
            }
            assert_eq!((read, rows.remarks()), (count, vec![format!("{count} rows")]));
            assert!(!rows.read(&mut row).unwrap(), "after the end there is nothing");
        }
    }

    #[test]
    fn an_error_comes_after_the_rows_before_it() {
        let failed =
            || Err(ReadError::NothingRecorded { path: Path::new("r.mcap").to_owned(), column: "t".to_owned() });
        let (mut rows, mut row) = (ahead(5, failed), Row::default());
        (0..5).for_each(|_| assert!(rows.read(&mut row).unwrap()));
        assert!(matches!(rows.read(&mut row), Err(ReadError::NothingRecorded { .. })));
        assert!(!rows.read(&mut row).unwrap());
    }

    #[test]
    #[should_panic(expected = "a library's fault")]
    fn a_panic_is_that_of_whoever_reads() {
        let mut rows = ahead(1, || panic!("a library's fault"));
        let mut row = Row::default();
        while rows.read(&mut row).unwrap() {}
    }

    #[test]
    fn who_wants_no_more_rows_may_go() {
        let mut rows = ahead(u64::MAX, || Ok(false));
        assert!(rows.read(&mut Row::default()).unwrap());
        let thread = rows.thread.take().unwrap();
        drop(rows);
        thread.join().unwrap();
    }
}
