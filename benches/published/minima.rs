//! Runs on the problems of Moré, Garbow and Hillstrom.

use std::collections::BTreeSet;
use std::fmt;

use gravcal_estimation::published::{PublishedProblem, Start};
use gravcal_estimation::{SolveContext, Solver};

/// What came of one run.
enum End {
    Reached { sum_of_squares: f64 },
    Elsewhere { sum_of_squares: f64, termination: String },
    Failed(String),
    NotApplicable(String),
}

/// One solver on all problems, from three starts each.
pub struct MinimumRuns<'p> {
    rows: Vec<(&'p PublishedProblem, Vec<End>)>,
}

impl<'p> MinimumRuns<'p> {
    pub fn new(solver: &dyn Solver, problems: &'p [PublishedProblem]) -> Result<Self, String> {
        let row = |problem: &'p PublishedProblem| {
            let ends = problem.starts.iter().map(|start| run(solver, problem, start));
            Ok((problem, ends.collect::<Result<_, String>>()?))
        };
        Ok(MinimumRuns { rows: problems.iter().map(row).collect::<Result<_, String>>()? })
    }

    fn runs(&self) -> impl Iterator<Item = (&'p PublishedProblem, &'p Start, &End)> {
        self.rows.iter().flat_map(|(problem, ends)| problem.starts.iter().zip(ends).map(|(s, e)| (*problem, s, e)))
    }

    /// Cells of the summary: runs that reached a published minimum, of those from which that is to be expected; and
    /// problems of the 35 that did so from every start.
    pub fn summary(&self) -> String {
        let expected = || self.runs().filter(|(_, start, _)| start.unreachable.is_none());
        let refused = expected().filter(|(_, _, end)| matches!(end, End::NotApplicable(_))).count();
        let reached = expected().filter(|(_, _, end)| matches!(end, End::Reached { .. })).count();
        let sources = |reached: bool| -> BTreeSet<&str> {
            let runs = expected().filter(|(_, _, end)| reached || !matches!(end, End::Reached { .. }));
            runs.map(|(problem, _, _)| problem.source.as_str()).collect()
        };
        let (all, missed) = (sources(true).len(), sources(false).len());
        let refusals = if refused == 0 { String::new() } else { format!(", {refused} not applicable") };
        format!("{reached} of {}{refusals} | {} of {all}", expected().count() - refused, all - missed)
    }
}

fn run(solver: &dyn Solver, problem: &PublishedProblem, start: &Start) -> Result<End, String> {
    let (built, initial) = problem.build(start).map_err(|e| e.to_string())?;
    if let Err(refusal) = solver.check(&built) {
        return Ok(End::NotApplicable(refusal.reason));
    }
    Ok(match solver.solve(&built, &initial, &mut SolveContext::default()) {
        Err(error) => End::Failed(error.to_string()),
        Ok(estimate) => {
            let sum_of_squares = 2.0 * estimate.cost;
            match problem.minimum_at(sum_of_squares) {
                Some(_) => End::Reached { sum_of_squares },
                None => End::Elsewhere { sum_of_squares, termination: estimate.termination.to_string() },
            }
        }
    })
}

impl fmt::Display for MinimumRuns<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "Σ r² where the runs end; in brackets where it is no published minimum.\n")?;
        writeln!(f, "| problem | published minima | standard | 10 × | 100 × |\n|---|---|---|---|---|")?;
        for (problem, ends) in &self.rows {
            let minima: Vec<String> = problem.minima.iter().map(|m| number(m.sum_of_squares)).collect();
            let cells: Vec<String> = ends.iter().map(cell).collect();
            writeln!(f, "| {} | {} | {} |", problem.name, minima.join(", "), cells.join(" | "))?;
        }
        writeln!(f)?;
        for (problem, start, end) in self.runs() {
            if let Some(how) = how(end) {
                let why = start.unreachable.map(|reason| format!(" ({reason})")).unwrap_or_default();
                writeln!(f, "- {}, {}: {how}{why}", problem.name, start.name)?;
            }
        }
        Ok(())
    }
}

fn cell(end: &End) -> String {
    match end {
        End::Reached { sum_of_squares } => number(*sum_of_squares),
        End::Elsewhere { sum_of_squares, .. } => format!("[{}]", number(*sum_of_squares)),
        End::Failed(_) => "failed".to_owned(),
        End::NotApplicable(_) => "–".to_owned(),
    }
}

/// How a run ended that did not reach a published minimum.
fn how(end: &End) -> Option<String> {
    match end {
        End::Reached { .. } => None,
        End::Elsewhere { termination, .. } => Some(termination.clone()),
        End::Failed(error) => Some(error.clone()),
        End::NotApplicable(reason) => Some(format!("not applicable: {reason}")),
    }
}

/// Six digits; zero where it is a rounding error.
fn number(value: f64) -> String {
    if value < 1e-16 {
        "0".to_owned()
    } else if (1e-3..1e6).contains(&value) {
        format!("{value:.*}", (5 - value.log10().floor() as i32).max(0) as usize)
    } else {
        format!("{value:.5e}")
    }
}
