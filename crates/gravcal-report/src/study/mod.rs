//! A study for people and papers: text, Markdown, CSV, figures.

mod comparison;
mod contents;
mod csv;
mod figure;
mod markdown;
mod page;
mod panels;
mod ranges;
mod summary;
#[cfg(test)]
mod testing;
mod text;

use std::fmt;

use crate::text::plain;

use thiserror::Error;

/// A report cannot be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A figure cannot be drawn.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// The measures cannot be written as CSV.
    #[error("the measures cannot be written as CSV: {0}")]
    Csv(#[from] ::csv::Error),
}

pub use contents::StudyReport;
pub use figure::FigureError;
pub use summary::StudySummary;

impl fmt::Display for StudyReport<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&plain(&text::text(self)))
    }
}

/// The files of a report by their names: `report.txt`, `report.md`, `measures.csv`, `study.html`, and figures
/// as SVG.
///
/// # Errors
/// A figure cannot be drawn.
pub fn report_files(report: &StudyReport<'_>) -> Result<Vec<(String, String)>, ReportError> {
    let mut files = vec![
        ("report.txt".to_owned(), report.to_string()),
        ("report.md".to_owned(), plain(&markdown::markdown(report)).into_owned()),
        ("measures.csv".to_owned(), csv::csv(report)?),
    ];
    let figures = panels::figures(report).into_iter().map(|(name, figure)| Ok((format!("{name}.svg"), figure.svg()?)));
    let figures = figures.collect::<Result<Vec<_>, ReportError>>()?;
    files.push(("study.html".to_owned(), page::page(report, &figures)));
    files.extend(figures);
    Ok(files)
}
