//! Remarks too long for a cell, numbered below the table.

use crate::text::wrapped;

/// Footnotes in the order of their first mark.
#[derive(Clone, Debug, Default)]
pub(crate) struct Footnotes(Vec<String>);

impl Footnotes {
    /// The mark of a footnote, such as `[1]`; the same text has one mark.
    pub fn mark(&mut self, text: &str) -> String {
        let index = self.0.iter().position(|known| known == text).unwrap_or_else(|| {
            self.0.push(text.to_owned());
            self.0.len() - 1
        });
        format!("[{}]", index + 1)
    }

    /// The footnotes, each on lines of its own.
    pub fn lines(&self, indent: &str) -> String {
        let report = |(index, text): (usize, &String)| {
            let mark = format!("{indent}[{}] ", index + 1);
            wrapped(&mark, &" ".repeat(mark.len()), text)
        };
        self.0.iter().enumerate().map(report).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_text_has_one_mark() {
        let mut notes = Footnotes::default();
        assert_eq!([notes.mark("a"), notes.mark("b"), notes.mark("a")], ["[1]", "[2]", "[1]"]);
        assert_eq!(notes.lines("  "), "  [1] a\n  [2] b\n");
    }
}
