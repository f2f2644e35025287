//! Runs on NIST's certified regressions.

use std::fmt;

use gravcal_estimation::published::nist::{CertifiedProblem, Digits};
use gravcal_estimation::published::{PublishedProblem, Start};
use gravcal_estimation::{SolveContext, Solver};

/// What came of one run.
enum End {
    Ended { digits: Digits, iterations: usize, reached: bool, termination: String },
    Failed(String),
    NotApplicable(String),
}

/// One solver on all data sets, from both starts.
pub struct CertifiedRuns<'p> {
    rows: Vec<(&'p PublishedProblem, Vec<End>)>,
}

impl<'p> CertifiedRuns<'p> {
    pub fn new(solver: &dyn Solver, data_sets: &'p [CertifiedProblem]) -> Result<Self, String> {
        let row = |certified: &'p CertifiedProblem| {
            let ends = certified.problem.starts.iter().map(|start| run(solver, certified, start));
            Ok((&certified.problem, ends.collect::<Result<_, String>>()?))
        };
        Ok(CertifiedRuns { rows: data_sets.iter().map(row).collect::<Result<_, String>>()? })
    }

    /// Cells of the summary: runs that reached the certified values, their fewest digits, their iterations.
    pub fn summary(&self) -> String {
        let all: Vec<&End> = self.rows.iter().flat_map(|(_, ends)| ends).collect();
        let refused = all.iter().filter(|end| matches!(end, End::NotApplicable(_))).count();
        let reached = all.iter().filter_map(|end| match end {
            End::Ended { digits, iterations, reached: true, .. } => Some((digits.parameters, *iterations)),
            _ => None,
        });
        let (digits, mut iterations): (Vec<f64>, Vec<usize>) = reached.unzip();
        iterations.sort_unstable();
        let refusals = if refused == 0 { String::new() } else { format!(", {refused} not applicable") };
        let of = format!("{} of {}{refusals}", digits.len(), all.len() - refused);
        match (iterations.get(iterations.len() / 2), iterations.last()) {
            (Some(median), Some(most)) => {
                format!("{of} | {:.1} | {median}, {most}", digits.into_iter().fold(f64::INFINITY, f64::min))
            }
            _ => format!("{of} | | "),
        }
    }
}

fn run(solver: &dyn Solver, certified: &CertifiedProblem, start: &Start) -> Result<End, String> {
    let (built, initial) = certified.problem.build(start).map_err(|e| e.to_string())?;
    if let Err(refusal) = solver.check(&built) {
        return Ok(End::NotApplicable(refusal.reason));
    }
    let estimate = match solver.solve(&built, &initial, &mut SolveContext::default()) {
        Ok(estimate) => estimate,
        Err(error) => return Ok(End::Failed(error.to_string())),
    };
    let digits = certified.digits(&built, &estimate.values).map_err(|e| e.to_string())?;
    Ok(End::Ended {
        digits,
        iterations: estimate.iterations.len().saturating_sub(1),
        reached: certified.reached(digits),
        termination: estimate.termination.to_string(),
    })
}

impl fmt::Display for CertifiedRuns<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "From start 1 and start 2: digits that agree with the certified ones, of at most 11.\n")?;
        writeln!(f, "| data set | parameters | standard deviations | Σ r² | iterations | not reached |")?;
        writeln!(f, "|---|---|---|---|---|---|")?;
        for (problem, ends) in &self.rows {
            let digits = |of: fn(&Digits) -> f64| joined(ends, |digits, _| format!("{:.1}", of(digits)));
            let (parameters, deviations) = (digits(|d| d.parameters), digits(|d| d.standard_deviations));
            let (squares, iterations) = (digits(|d| d.sum_of_squares), joined(ends, |_, count| count.to_string()));
            let missed: Vec<String> = problem.starts.iter().zip(ends).filter_map(|(s, e)| missed(s, e)).collect();
            let missed = missed.join("; ");
            writeln!(f, "| {} | {parameters} | {deviations} | {squares} | {iterations} | {missed} |", problem.name)?;
        }
        Ok(())
    }
}

fn joined(ends: &[End], cell: impl Fn(&Digits, usize) -> String) -> String {
    let cells = ends.iter().map(|end| match end {
        End::Ended { digits, iterations, .. } => cell(digits, *iterations),
        End::Failed(_) | End::NotApplicable(_) => "–".to_owned(),
    });
    cells.collect::<Vec<_>>().join(", ")
}

fn missed(start: &Start, end: &End) -> Option<String> {
    match end {
        End::Ended { reached: true, .. } => None,
        End::Ended { termination, .. } => Some(format!("{}: {termination}", start.name)),
        End::Failed(error) => Some(format!("{}: {error}", start.name)),
        End::NotApplicable(reason) => Some(format!("{}: not applicable: {reason}", start.name)),
    }
}
