//! Reads the files as NIST ships them: text for people, with the numbers in fixed places.

use std::path::{Path, PathBuf};

use thiserror::Error;

use super::models::Model;
use super::{Certified, Regression};

/// A file that does not hold what it should.
#[derive(Debug, Error)]
pub enum FileError {
    /// It cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Unreadable {
        /// Which file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// Something is not there.
    #[error("{}: no {what}; is it the file as NIST ships it?", path.display())]
    Missing {
        /// Which file.
        path: PathBuf,
        /// What is not there.
        what: String,
    },
    /// A line does not hold the numbers it should.
    #[error("{}, line {line}: expected {expected} numbers, found `{found}`", path.display())]
    Numbers {
        /// Which file.
        path: PathBuf,
        /// Which line, from 1.
        line: usize,
        /// How many numbers belong there.
        expected: usize,
        /// What is there.
        found: String,
    },
    /// The file contradicts itself.
    #[error("{}: {what} is stated as {stated}, but follows as {found}", path.display())]
    Contradiction {
        /// Which file.
        path: PathBuf,
        /// Of what.
        what: &'static str,
        /// The number stated.
        stated: f64,
        /// The number that follows from the rest of the file.
        found: f64,
    },
}

/// What one file holds.
#[derive(Debug)]
pub(super) struct Contents {
    pub(super) starts: [Vec<f64>; 2],
    pub(super) certified: Certified,
    pub(super) regression: Regression,
}

pub(super) fn read(path: PathBuf, model: Model) -> Result<Contents, FileError> {
    match std::fs::read_to_string(&path) {
        Ok(text) => parse(&Lines { path: &path, lines: text.lines().collect() }, model),
        Err(source) => Err(FileError::Unreadable { path, source }),
    }
}

fn parse(file: &Lines<'_>, model: Model) -> Result<Contents, FileError> {
    // One line a parameter: start 1, start 2, certified value, standard deviation.
    let rows: Vec<Vec<f64>> =
        (1..=model.parameters()).map(|k| file.after(&format!("b{k} ="), 4)).collect::<Result<_, _>>()?;
    let column = |index: usize| rows.iter().map(|row| row[index]).collect::<Vec<f64>>();
    let regression = observations(file, model)?;
    let rows = regression.responses.len() as f64;
    file.agree("the number of observations", file.one("Number of Observations:")?, rows)?;
    let certified = Certified {
        parameters: column(2),
        standard_deviations: column(3),
        sum_of_squares: file.one("Residual Sum of Squares:")?,
        residual_standard_deviation: file.one("Residual Standard Deviation:")?,
        // Not as the file prints them: Rat43's prints 9 of 15 observations less 4 parameters.
        degrees_of_freedom: rows - model.parameters() as f64,
    };
    let deviation = (certified.sum_of_squares / certified.degrees_of_freedom).sqrt();
    file.agree("the residual standard deviation", certified.residual_standard_deviation, deviation)?;
    Ok(Contents { starts: [column(0), column(1)], certified, regression })
}

/// The table at the end, under the last line that begins with `Data:`.
fn observations(file: &Lines<'_>, model: Model) -> Result<Regression, FileError> {
    let head = file.lines.iter().rposition(|line| line.starts_with("Data:"));
    let head = head.ok_or_else(|| file.missing("line `Data:` above the observations"))?;
    let mut regression = Regression { model, responses: Vec::new(), predictors: Vec::new() };
    for line in head + 1..file.lines.len() {
        if !file.lines[line].trim().is_empty() {
            let row = file.numbers(line, file.lines[line], 1 + model.predictors())?;
            regression.responses.push(model.response(row[0]));
            regression.predictors.extend_from_slice(&row[1..]);
        }
    }
    Ok(regression)
}

/// A file and its lines.
struct Lines<'a> {
    path: &'a Path,
    lines: Vec<&'a str>,
}

impl Lines<'_> {
    /// The numbers on the first line that begins with `label`, after it.
    fn after(&self, label: &str, expected: usize) -> Result<Vec<f64>, FileError> {
        let mut found = self.lines.iter().enumerate().filter_map(|(k, l)| Some((k, l.trim().strip_prefix(label)?)));
        let (line, rest) = found.next().ok_or_else(|| self.missing(&format!("line `{label}`")))?;
        self.numbers(line, rest, expected)
    }

    /// The only number after `label`.
    fn one(&self, label: &str) -> Result<f64, FileError> {
        Ok(self.after(label, 1)?[0])
    }

    fn numbers(&self, line: usize, text: &str, expected: usize) -> Result<Vec<f64>, FileError> {
        let numbers: Option<Vec<f64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
        match numbers {
            Some(numbers) if numbers.len() == expected => Ok(numbers),
            _ => {
                let found = text.trim().to_owned();
                Err(FileError::Numbers { path: self.path.to_owned(), line: line + 1, expected, found })
            }
        }
    }

    /// Equal to the digits printed.
    fn agree(&self, what: &'static str, stated: f64, found: f64) -> Result<(), FileError> {
        if (stated - found).abs() <= 1e-9 * stated.abs() {
            return Ok(());
        }
        Err(FileError::Contradiction { path: self.path.to_owned(), what, stated, found })
    }

    fn missing(&self, what: &str) -> FileError {
        FileError::Missing { path: self.path.to_owned(), what: what.to_owned() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file in the form of NIST's: y = b1 (1 − exp(−b2 x)) at b = (2, 1), with errors of 0.1 and −0.1.
    const SMALL: &str = "\
Data:          1 Response  (y)
        Start 1     Start 2           Parameter     Standard Deviation
  b1 =   1           1.5          2.0E+00  1.0E-01
  b2 =   2           1.5          1.0E+00  2.0E-01

Residual Sum of Squares:                    2.0E-02
Residual Standard Deviation:                1.0E-01
Degrees of Freedom:                                2
Number of Observations:                            4

Data:   y               x
      1.0E0      1.0E0
      1.5E0      2.0E0
      1.8E0      3.0E0
      2.0E0      4.0E0
";

    fn read_text(text: &str) -> Result<Contents, FileError> {
        parse(&Lines { path: Path::new("small.dat"), lines: text.lines().collect() }, Model::Misra1a)
    }

    #[test]
    fn everything_is_read() {
        let contents = read_text(&SMALL.replace('\n', "\r\n")).unwrap();
        assert_eq!(contents.starts, [vec![1.0, 2.0], vec![1.5, 1.5]]);
        assert_eq!(contents.certified.parameters, [2.0, 1.0]);
        assert_eq!(contents.certified.standard_deviations, [0.1, 0.2]);
        assert_eq!(contents.certified.degrees_of_freedom, 2.0);
        assert_eq!(contents.regression.responses, [1.0, 1.5, 1.8, 2.0]);
        assert_eq!(contents.regression.predictors, [1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn what_is_wrong_with_a_file_is_said() {
        let said = |from: &str, to: &str| read_text(&SMALL.replace(from, to)).unwrap_err().to_string();
        assert_eq!(said("  b2 =", "  b3 ="), "small.dat: no line `b2 =`; is it the file as NIST ships it?");
        assert_eq!(said("2.0E0      4.0E0", "2.0E0"), "small.dat, line 15: expected 2 numbers, found `2.0E0`");
        assert_eq!(said("1.8E0", "one"), "small.dat, line 14: expected 2 numbers, found `one      3.0E0`");
        assert_eq!(
            said("      1.0E0      1.0E0\n", ""),
            "small.dat: the number of observations is stated as 4, but follows as 3"
        );
        assert!(said("2.0E-02", "3.0E-02").starts_with("small.dat: the residual standard deviation is stated as 0.1"));
        assert!(
            said("Data:   y", "Datum").starts_with("small.dat, line 2: expected 2 numbers"),
            "the other `Data:` line"
        );
        assert!(read_text("").is_err());
    }
}
