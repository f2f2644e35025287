//! What counts as missing in a recording, told once for all columns that have such.

/// What of a column counts as missing.
pub(super) struct Missing<'a> {
    pub column: &'a str,
    pub count: u64,
    /// Line with the first, where rows have lines.
    pub first: Option<u64>,
}

/// In one sentence; `None` where every column is whole. `which`: what counts as missing, such as "cells that are no finite numbers".
pub(super) fn report_missing<'a>(which: &str, missing: impl Iterator<Item = Missing<'a>>) -> Option<String> {
    let missing: Vec<Missing<'a>> = missing.filter(|missing| missing.count > 0).collect();
    let columns: Vec<String> =
        missing.iter().map(|missing| format!("{} of `{}`", missing.count, missing.column)).collect();
    let first = missing.iter().filter_map(|missing| missing.first).min();
    let first = first.map_or_else(String::new, |line| format!("; the first is on line {line}"));
    (!columns.is_empty()).then(|| format!("{which} count as missing: {}{first}", columns.join(", ")))
}
