//! What can be known: singular values, and combinations by name.

use std::fmt::Write;

use gravcal_calibration::result::EstimatorResult;
use re_sdk::{RecordingStream, RecordingStreamError, entity_path};
use re_sdk_types::archetypes::{BarChart, TextDocument};
use re_sdk_types::datatypes::TensorData;

use crate::contents::CalibrationRecording;
use crate::style;

/// Where singular values end: beyond, they are zero but for rounding.
const SMALLEST: f64 = 1e-16;

/// Logs both for every estimator that solved anything.
pub fn log(stream: &RecordingStream, calibration: &CalibrationRecording<'_>) -> Result<(), RecordingStreamError> {
    for result in calibration.results {
        let name = &result.name;
        if let Some(largest) = result.detail.singular_values.first() {
            let relative = result.detail.singular_values.iter().map(|s| (s / largest).max(SMALLEST).log10());
            let bars = TensorData::from(relative.collect::<Vec<f64>>());
            let chart = BarChart::new(bars).with_color(style::of(name));
            stream.log_static(entity_path!["identifiability", name, "singular_values"], &chart)?;
        }
        let text = TextDocument::from_markdown(combinations(result));
        stream.log_static(entity_path!["identifiability", name, "combinations"], &text)?;
    }
    Ok(())
}

/// What is undetermined, held or weak, by name.
fn combinations(result: &EstimatorResult) -> String {
    let mut text = format!("# What can be known: {}\n\n", result.name);
    if result.undetermined.is_empty() {
        text += "Nothing is undetermined.\n\n";
    } else {
        text += "## Undetermined\n\n";
    }
    for one in &result.undetermined {
        // Writing to a string does not fail.
        let _ = writeln!(text, "- **{}** – {}  \n  *Cure*: {}", one.combination, one.why, one.cure);
    }
    if !result.weak.is_empty() {
        text += "\n## Known badly\n\n";
    }
    for one in &result.weak {
        let _ = writeln!(text, "- {} ({:.0} times worse than the median)", one.combination, one.times_worse);
    }
    if !result.held.is_empty() {
        text += "\n## Held while the rest was solved for\n\n";
    }
    for one in &result.held {
        let _ = writeln!(text, "- {}: {}", one.name, one.why);
    }
    text += "\nThe bars are singular values of the Jacobian over the largest, log₁₀, columns scaled to unit length: long bars are \
             combinations of which the readings say little, −9 or less nothing.\n";
    text
}
