//! Tables in a file, between two markers.

use std::path::Path;

const BEGIN: &str = "<!-- tables of `published`: begin -->\n";
const END: &str = "<!-- tables of `published`: end -->";

/// Replaces what stands between the markers.
pub fn replace(path: &Path, tables: &str) -> Result<(), String> {
    let say = |what: String| format!("{}: {what}", path.display());
    let text = std::fs::read_to_string(path).map_err(|e| say(e.to_string()))?;
    let missing = |marker: &str| say(format!("no line `{}`", marker.trim()));
    let (head, rest) = text.split_once(BEGIN).ok_or_else(|| missing(BEGIN))?;
    let (_, tail) = rest.split_once(END).ok_or_else(|| missing(END))?;
    std::fs::write(path, format!("{head}{BEGIN}\n{tables}\n{END}{tail}")).map_err(|e| say(e.to_string()))
}
