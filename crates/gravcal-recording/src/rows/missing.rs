//! What counts as missing in a recording, told once for all columns that have such.

/// Cells that count as missing where numbers stand: NaN above all, which robots log for a joint without a sensor.
pub(crate) const NOT_FINITE: &str = "cells that are no finite numbers";

/// The same where dates with times stand.
pub(crate) const NO_DATES: &str = "cells that are no dates with times (ISO 8601)";

/// What of a column counts as missing.
pub(crate) struct Missing<'a> {
    pub column: &'a str,
    pub count: u64,
    /// Line with the first, where rows have lines.
    pub first: Option<u64>,
}

/// In one sentence; `None` where every column is whole. `which`: what counts as missing, such as "cells that are no finite numbers".
pub(crate) fn report_missing<'a>(which: &str, missing: impl Iterator<Item = Missing<'a>>) -> Option<String> {
    let missing: Vec<Missing<'a>> = missing.filter(|missing| missing.count > 0).collect();
    let columns: Vec<String> =
        missing.iter().map(|missing| format!("{} of `{}`", missing.count, missing.column)).collect();
    let first = missing.iter().filter_map(|missing| missing.first).min();
    let first = first.map_or_else(String::new, |line| format!("; the first is on line {line}"));
    (!columns.is_empty()).then(|| format!("{which} count as missing: {}{first}", columns.join(", ")))
}
