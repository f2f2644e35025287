//! Numbers with all their digits, as other languages read them.

/// With a point and a signed exponent, which every reader of YAML, C and Python takes for a floating-point number; zero without a
/// sign.
pub(super) fn float(value: f64) -> String {
    let text = format!("{:?}", value + 0.0);
    match text.split_once('e') {
        None => text,
        Some((mantissa, exponent)) => {
            let point = if mantissa.contains('.') { "" } else { ".0" };
            let sign = if exponent.starts_with('-') { "" } else { "+" };
            format!("{mantissa}{point}e{sign}{exponent}")
        }
    }
}

/// One line, whatever the names in it hold.
pub(super) fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// In double quotes: a string of YAML, Python and C alike.
pub(super) fn quoted(text: &str) -> String {
    let escaped: String = one_line(text)
        .chars()
        .flat_map(|c| ['\\'].into_iter().filter(move |_| matches!(c, '\\' | '"')).chain([c]))
        .collect();
    format!("\"{escaped}\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_float_reads_back_as_itself() {
        for value in [0.1 + 0.2, 2048.0, 1e-7, -3.25e300, 0.0, 5e-324, 1e16] {
            let text = float(value);
            assert_eq!(text.parse(), Ok(value), "{text}");
            assert!(text.contains('.'), "{text}");
        }
        assert_eq!(float(-0.0), "0.0");
        assert_eq!((float(1e-7), float(1e16)), ("1.0e-7".to_owned(), "1.0e+16".to_owned()));
    }

    #[test]
    fn strings_cannot_break_out() {
        assert_eq!(quoted("a\"b\\c\nd"), r#""a\"b\\c d""#);
    }
}
