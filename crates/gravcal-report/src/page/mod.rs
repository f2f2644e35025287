//! `report.html`: a calibration on one page, for people who decide.
//!
//! One file without any request to a network, in light and dark and on paper. What decides stands first, as text that needs no script;
//! figures are drawn on canvases from binary arrays (base64 of little-endian 32-bit floats), so that a recording of 20,000 poses is a
//! page of a few megabytes. At most two estimators are drawn: the one that decides, and the first other one that has a fit.
//!
//! The same input gives the same bytes.

mod arrays;
mod contents;
mod correlation;
mod document;
mod figures;
mod fit;
mod identifiability;
mod parameters;
mod provenance;
mod spectra;
#[cfg(test)]
mod tests;
mod verdict;

use gravcal_calibration::doubts_of_results;
use maud::{Markup, html};

use crate::doubts::HEADING;
use crate::json::JsonError;
pub use contents::CalibrationPage;
pub(crate) use document::document;

const SCRIPT: &str = concat!(include_str!("plot.js"), include_str!("page.js"));

impl CalibrationPage<'_> {
    /// The page.
    ///
    /// # Errors
    /// Where the figures' data are no JSON; none that is known of.
    pub fn to_html(&self) -> Result<String, JsonError> {
        let title = format!("Calibration of {}", self.session.robot.name);
        let data = figures::data(self)?;
        let body = html! {
            h1 { (title) }
            (doubts(&[&self.session.doubts[..], &doubts_of_results(self.session, self.results)].concat()))
            (verdict::section(self))
            (parameters::section(self))
            (identifiability::section(self))
            (fit::section(self))
            (figures::section(self))
            (notes(self))
            (provenance::section(self.provenance))
        };
        Ok(document(&title, &body, Some((&data, SCRIPT))))
    }
}

/// What can hardly be so of what the session says.
fn doubts(doubts: &[String]) -> Markup {
    html! {
        @if !doubts.is_empty() {
            section.verdict.failed { h2 { (HEADING) } ul { @for doubt in doubts { li { (doubt) } } } }
        }
    }
}

fn notes(page: &CalibrationPage<'_>) -> Markup {
    html! {
        @for result in page.results.iter().filter(|result| !result.notes.is_empty()) {
            section { h2 { "Notes of the estimator " (result.name) } ul { @for note in &result.notes { li { (note) } } } }
        }
    }
}
