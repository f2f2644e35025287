//! CSV that is opened in a spreadsheet: there a cell that begins like a formula is one, whoever wrote it.

use std::borrow::Cow;

/// A text as a cell. Where a spreadsheet would compute it, an apostrophe before it makes it a text; a number stays one.
pub(crate) fn text_cell(text: &str) -> Cow<'_, str> {
    let is_number = text.parse::<f64>().is_ok_and(f64::is_finite);
    match text.starts_with(['=', '+', '-', '@', '\t', '\r', '\n']) && !is_number {
        true => format!("'{text}").into(),
        false => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_texts_and_numbers_numbers() {
        for formula in ["=1+1", "+A1", "-A1.torque_gain", "@SUM(A1)", "\t=1", "-inf", "="] {
            assert_eq!(text_cell(formula), format!("'{formula}"));
        }
        for text in ["joint1.torque_gain", "-1.5e-3", "+2", "", "N·m", "'=1"] {
            assert_eq!(text_cell(text), text);
        }
    }
}
