//! Ours beside the peers', and the ratio of times where it means something.

use serde::Deserialize;

use crate::COSINE;

/// Relative difference of costs up to which two programs solved the same problem; at the start, and at the end.
const SAME_START: f64 = 1e-9;
const SAME_COST: f64 = 1e-6;

/// One program's solution. A peer prints it as JSON.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Row {
    /// Median time from the built problem to its solution, s.
    pub seconds: f64,
    pub iterations: usize,
    /// Cost ½ Σ r² at the start.
    pub initial_cost: f64,
    /// Cost at the end.
    pub cost: f64,
    /// Largest |cosine| between the residual and a column of J at the end.
    pub cosine: f64,
}

impl Row {
    /// How many times longer than `ours` this took, or why that must not be told.
    fn ratio(&self, ours: &Row) -> Result<f64, String> {
        let differs = |a: f64, b: f64, share: f64| (a - b).abs().is_nan() || (a - b).abs() > share * b.abs();
        if differs(self.initial_cost, ours.initial_cost, SAME_START) {
            return Err(format!("another model: cost {} at the start, ours {}", self.initial_cost, ours.initial_cost));
        }
        if differs(self.cost, ours.cost, SAME_COST) {
            return Err("another cost".into());
        }
        match self.cosine.max(ours.cosine) {
            cosine if cosine <= COSINE => Ok(self.seconds / ours.seconds),
            cosine => Err(format!("a cosine of {cosine:.1e} is no solution")),
        }
    }
}

/// Prints ours and the peers', each with its ratio or the reason why it has none.
pub fn print_table(poses: usize, ours: &Row, peers: Vec<(&str, Result<Row, String>)>) {
    heading("time / ours");
    print_row("gravcal", poses, ours, "1");
    for (name, row) in peers {
        match row {
            Ok(row) => {
                let ratio =
                    row.ratio(ours).map_or_else(|why| format!("no ratio: {why}"), |ratio| format!("{ratio:.1}"));
                print_row(name, poses, &row, &ratio);
            }
            Err(message) => println!("  {name:19} {message}"),
        }
    }
}

/// Prints what stands above the columns, `ratio` above the last.
pub fn heading(ratio: &str) {
    println!(
        "  {:19} {:>10} {:>10} {:>14} {:>20} {:>8} {ratio:>12}",
        "", "seconds", "iterations", "µs/(pose·it.)", "cost", "cosine"
    );
}

/// Prints one program's or method's row.
pub fn print_row(name: &str, poses: usize, row: &Row, ratio: &str) {
    let each = row.seconds * 1e6 / (poses * row.iterations.max(1)) as f64;
    println!(
        "  {name:19} {:10.4} {:10} {each:14.2} {:20.9} {:8.1e} {ratio:>12}",
        row.seconds, row.iterations, row.cost, row.cosine
    );
}
