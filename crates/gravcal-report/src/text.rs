//! Plain text within the width of a terminal.

use std::borrow::Cow;

/// The text as a terminal may be told it. Names come from files, and whatever in them would move its cursor, change its colours or turn
/// its lines round becomes `�`; only line breaks and tabs stay.
pub fn plain(text: &str) -> Cow<'_, str> {
    let acts = |c: char| {
        let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        turns || c.is_control() && !matches!(c, '\n' | '\t')
    };
    match text.contains(acts) {
        true => text.replace(acts, "\u{fffd}").into(),
        false => text.into(),
    }
}

/// Columns of a table.
pub(crate) const WIDTH: usize = 80;

/// Columns that a text takes: every character that these tables use is one wide (`±`, `·`, `χ`, `²`, `°`).
pub(crate) fn width(text: &str) -> usize {
    text.chars().count()
}

/// The text broken between words so that lines fit [`WIDTH`], the first after `first`, the others after `rest`.
/// A word that is longer than a line stands on a line of its own.
pub(crate) fn wrapped(first: &str, rest: &str, text: &str) -> String {
    let mut lines = String::new();
    let mut line = first.to_owned();
    let mut empty = true;
    for word in text.split_whitespace() {
        let space = usize::from(!empty);
        if !empty && width(&line) + space + width(word) > WIDTH {
            push_line(&mut lines, &line);
            line = rest.to_owned();
            empty = true;
        }
        if !empty {
            line.push(' ');
        }
        line.push_str(word);
        empty = false;
    }
    push_line(&mut lines, &line);
    lines
}

/// Appends a line without spaces at its end.
pub(crate) fn push_line(text: &mut String, line: &str) {
    text.push_str(line.trim_end());
    text.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_acts_on_a_terminal_is_not_reported() {
        let named = "\u{1b}]0;title\u{7}joint\u{1b}[2J\u{9b}31m\r\u{202e}1\n\té ± 中";
        assert_eq!(plain(named), "�]0;title�joint�[2J�31m��1\n\té ± 中");
        assert!(matches!(plain("7.1 ± 0.2 N·m\n"), Cow::Borrowed(_)));
    }

    #[test]
    fn lines_break_between_words() {
        let text = "word ".repeat(30);
        let reported = wrapped("  - ", "    ", &text);
        assert!(reported.lines().all(|line| width(line) <= WIDTH));
        assert!(reported.starts_with("  - word word"));
        assert!(reported.lines().skip(1).all(|line| line.starts_with("    word")));
        assert_eq!(reported.split_whitespace().filter(|w| *w == "word").count(), 30);
    }

    #[test]
    fn a_long_word_has_a_line_of_its_own() {
        let long = "x".repeat(100);
        assert_eq!(wrapped("", "  ", &format!("a {long} b")), format!("a\n  {long}\n  b\n"));
    }

    #[test]
    fn nothing_is_an_empty_line() {
        assert_eq!(wrapped("  ", "", ""), "\n");
    }

    #[test]
    fn characters_count_not_bytes() {
        assert_eq!(width("7.1 ± 0.2 N·m"), 13);
    }
}
