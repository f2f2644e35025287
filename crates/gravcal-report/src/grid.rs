//! Columns of text and of measured values, aligned.

use crate::text::{push_line, width};

/// Between two columns.
const GAP: &str = "  ";

/// On which side the texts of a column stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Left,
    Right,
}

/// One cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Cell {
    /// Words, on the column's side.
    Text(String),
    /// A value and its standard deviation; the `±` of a column stand below each other.
    Measured(String, String),
    /// A value alone, aligned with those that have a standard deviation.
    Value(String),
}

impl Cell {
    pub fn empty() -> Cell {
        Cell::Text(String::new())
    }

    pub fn text(text: impl Into<String>) -> Cell {
        Cell::Text(text.into())
    }
}

#[derive(Clone, Debug)]
enum Row {
    Heading(String),
    Cells(Vec<Cell>),
}

/// Rows of cells below each other, with headings between them.
#[derive(Clone, Debug)]
pub(crate) struct Grid {
    sides: Vec<Side>,
    rows: Vec<Row>,
}

impl Grid {
    /// A grid with one column for each side given.
    pub fn new(sides: Vec<Side>) -> Grid {
        Grid { sides, rows: Vec::new() }
    }

    /// A line of its own, which no column's width depends on.
    pub fn heading(&mut self, text: impl Into<String>) {
        self.rows.push(Row::Heading(text.into()));
    }

    /// A row; missing cells are empty, those without a column are left out.
    pub fn row(&mut self, cells: Vec<Cell>) {
        self.rows.push(Row::Cells(cells));
    }

    /// Columns of the widest row, headings aside.
    pub fn width(&self) -> usize {
        let columns = self.columns();
        columns.iter().map(Column::width).sum::<usize>() + GAP.len() * columns.len().saturating_sub(1)
    }

    /// The grid as lines, each after `indent`.
    pub fn lines(&self, indent: &str) -> String {
        let columns = self.columns();
        let mut text = String::new();
        for row in &self.rows {
            match row {
                Row::Heading(heading) => push_line(&mut text, &format!("{indent}{heading}")),
                Row::Cells(cells) => {
                    let reported: Vec<String> =
                        columns.iter().zip(cells).map(|(column, cell)| column.report(cell)).collect();
                    push_line(&mut text, &format!("{indent}{}", reported.join(GAP)));
                }
            }
        }
        text
    }

    fn columns(&self) -> Vec<Column> {
        let mut columns: Vec<Column> = self.sides.iter().map(|side| Column::new(*side)).collect();
        for row in &self.rows {
            if let Row::Cells(cells) = row {
                columns.iter_mut().zip(cells).for_each(|(column, cell)| column.make_room(cell));
            }
        }
        columns
    }
}

/// Widths of what stands in one column.
#[derive(Clone, Copy, Debug)]
struct Column {
    side: Side,
    text: usize,
    value: usize,
    /// Of the standard deviation with the ` ± ` before it.
    std: usize,
}

impl Column {
    fn new(side: Side) -> Column {
        Column { side, text: 0, value: 0, std: 0 }
    }

    fn make_room(&mut self, cell: &Cell) {
        match cell {
            Cell::Text(text) => self.text = self.text.max(width(text)),
            Cell::Value(value) => self.value = self.value.max(width(value)),
            Cell::Measured(value, std) => {
                self.value = self.value.max(width(value));
                self.std = self.std.max(3 + width(std));
            }
        }
    }

    fn width(&self) -> usize {
        self.text.max(self.value + self.std)
    }

    fn report(&self, cell: &Cell) -> String {
        match cell {
            Cell::Text(text) => padded(text, self.width(), self.side),
            Cell::Value(value) => self.number(value, ""),
            Cell::Measured(value, std) => self.number(value, &format!(" ± {std}")),
        }
    }

    fn number(&self, value: &str, std: &str) -> String {
        let number = padded(value, self.value, Side::Right) + &padded(std, self.std, Side::Left);
        padded(&number, self.width(), Side::Right)
    }
}

fn padded(text: &str, to: usize, side: Side) -> String {
    let space = " ".repeat(to.saturating_sub(width(text)));
    match side {
        Side::Left => format!("{text}{space}"),
        Side::Right => format!("{space}{text}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(value: &str, std: &str) -> Cell {
        Cell::Measured(value.into(), std.into())
    }

    #[test]
    fn values_align_at_the_sign_and_words_on_their_side() {
        let mut grid = Grid::new(vec![Side::Left, Side::Right]);
        grid.row(vec![Cell::empty(), Cell::text("joint")]);
        grid.heading("a heading that is far longer than any row");
        grid.row(vec![Cell::text("gain"), measured("7.118", "0.020")]);
        grid.row(vec![Cell::text("bias"), measured("2075.1", "1.2")]);
        grid.row(vec![Cell::text("tilt"), Cell::Value("44".into())]);
        assert_eq!(
            grid.lines("  "),
            "                 joint\n\
             \x20 a heading that is far longer than any row\n\
             \x20 gain   7.118 ± 0.020\n\
             \x20 bias  2075.1 ± 1.2\n\
             \x20 tilt      44\n"
        );
        assert_eq!(grid.width(), "gain   7.118 ± 0.020".chars().count());
    }

    #[test]
    fn a_wide_word_moves_numbers_to_the_right() {
        let mut grid = Grid::new(vec![Side::Right]);
        grid.row(vec![Cell::text("undetermined")]);
        grid.row(vec![measured("1.0", "0.1")]);
        assert_eq!(grid.lines(""), "undetermined\n   1.0 ± 0.1\n");
    }

    #[test]
    fn rows_of_the_wrong_length_are_no_panic() {
        let mut grid = Grid::new(vec![Side::Left]);
        grid.row(vec![]);
        grid.row(vec![Cell::text("a"), Cell::text("left out")]);
        assert_eq!(grid.lines(""), "\na\n");
    }
}
