//! Rows with somebody who is told how far they are read.

use std::collections::BTreeMap;

use super::{Row, Rows, Source};
use crate::error::ReadError;

/// Rows between two words of how far it is.
const PACE: u64 = 10_000;

/// Passes rows on, and tells which share is read.
pub struct Watched<'a> {
    rows: Box<dyn Rows>,
    watch: &'a dyn Fn(f64),
    read: u64,
}

impl<'a> Watched<'a> {
    /// `watch` is told which share of the rows is read, from 0 to 1.
    pub fn new(rows: Box<dyn Rows>, watch: &'a dyn Fn(f64)) -> Watched<'a> {
        Watched { rows, watch, read: 0 }
    }
}

impl Rows for Watched<'_> {
    fn columns(&self) -> &[String] {
        self.rows.columns()
    }

    fn read(&mut self, row: &mut Row) -> Result<bool, ReadError> {
        self.read += 1;
        if self.read.is_multiple_of(PACE) {
            (self.watch)(self.rows.progress());
        }
        self.rows.read(row)
    }

    fn holds_dates(&self, column: usize) -> bool {
        self.rows.holds_dates(column)
    }

    fn source(&self) -> Source {
        self.rows.source()
    }

    fn remarks(&self) -> Vec<String> {
        self.rows.remarks()
    }

    fn lost(&self) -> Vec<String> {
        self.rows.lost()
    }

    fn metadata(&self) -> BTreeMap<String, String> {
        self.rows.metadata()
    }

    fn progress(&self) -> f64 {
        self.rows.progress()
    }
}
