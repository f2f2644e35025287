//! Texts as TOML has them.

/// A text as TOML has it.
pub(super) fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

/// Texts as a list.
pub(super) fn list(texts: &[&str]) -> String {
    format!("[{}]", texts.iter().map(|text| quoted(text)).collect::<Vec<_>>().join(", "))
}

/// One text where all that say anything are the same, else a list.
pub(super) fn one_or_list(texts: &[&str]) -> String {
    let mut some = texts.iter().filter(|text| !text.is_empty());
    match some.next() {
        Some(first) if some.all(|text| text == first) => quoted(first),
        _ => list(texts),
    }
}
