//! The tests of a solution's residuals: which solutions are tested, and what it comes to.

use gravcal_estimation::statistics::{ResidualMaker, Solution, StatisticsError, moved_by};
use gravcal_estimation::{Loss, RankAnalysis, in_parallel};
use gravcal_robot_model::session::Session;

use super::columns::Columns;
use super::neighbours::Neighbours;
use super::rows::Rows;
use super::search::Search;
use crate::joint::{Order, Solved};
use crate::judgement::Judgement;
use crate::result::{ResidualTest, TakenAsExact, UncertaintyResult};

/// Entries of the Jacobian beyond which it is not made a second time.
const MOST_ENTRIES: usize = 100_000_000;

/// Whether a solution's residuals are not tested because its Jacobian has too many entries.
pub(crate) fn too_large(solved: &Solved) -> bool {
    let problem = solved.judged_problem();
    problem.rows().saturating_mul(problem.columns().len()) >= MOST_ENTRIES
}

/// The tests of a solution's residuals.
#[derive(Debug, Default)]
pub(crate) struct ResidualTests {
    /// What is named first, in the order in which it was found.
    pub tests: Vec<ResidualTest>,
    /// By how much each column of the problem that is judged would be another with each of the terms that are named and spoil intervals.
    pub moved: Vec<Vec<f64>>,
    /// What hangs on that which the session takes as exact.
    pub taken_as_exact: Vec<TakenAsExact>,
}

/// Which tests on residuals are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TestsWanted {
    /// Every one.
    All,
    /// All or none: none where nothing is named.
    WhereNamed,
}

/// Tests the residuals of a solution. `uncertainty`: where its standard deviations come from; `err_by_pose`: whether readings err from pose to pose by
/// more than noise.
///
/// # Errors
/// Where a residual cannot be evaluated.
pub(crate) fn residual_tests(
    session: &Session,
    solved: &Solved,
    judgement: &Judgement,
    (uncertainty, err_by_pose): (&UncertaintyResult, bool),
    wanted: TestsWanted,
) -> Result<ResidualTests, StatisticsError> {
    let problem = solved.judged_problem();
    let tested = solved.estimate.termination.converged()
        && solved.readings().order == Order::Together
        && problem.rows() > solved.analysis.rank()
        && !too_large(solved);
    if !tested {
        return Ok(ResidualTests::default());
    }
    // Under a loss the solution is that of least squares with each row's weight.
    let values = &solved.estimate.values;
    let weighted = match solved.built.loss {
        Loss::None => None,
        _ => {
            let weighted = problem.weighted_at(values)?;
            let analysis = RankAnalysis::new(&weighted, values)?;
            Some((weighted, analysis, problem.weights(values)?))
        }
    };
    let (solution, weights) = match &weighted {
        None => (Solution { problem, values, analysis: &solved.analysis }, None),
        Some((problem, analysis, weights)) => (Solution { problem, values, analysis }, Some(weights.as_slice())),
    };
    let maker = ResidualMaker::new(&solution)?;
    let columns = Columns::new(session, solved, problem.rows())?;
    let rows = Rows::new(session, solved, &maker).sharing_errors(err_by_pose);
    let rows = match weights {
        Some(weights) => rows.weighted(weights, &maker),
        None => rows,
    };
    let robust = !matches!(uncertainty, UncertaintyResult::Noise { .. });
    let search = Search { session, solved, solution, columns, weights, robust };
    let neighbours = in_parallel(0..rows.channels(), |channel| Neighbours::of(&maker, &rows, channel));
    let candidates = search.candidates(&maker, &rows);
    if wanted == TestsWanted::WhereNamed && search.names_nothing(&maker, &rows, &neighbours, &candidates) {
        return Ok(ResidualTests::default());
    }
    let (tests, missing) = search.all(maker, rows, neighbours, &candidates)?;
    let moved = moved_by(&search.solution, &missing)?;
    let taken_as_exact = match wanted {
        TestsWanted::All => search.taken_as_exact(judgement, (&tests, &moved))?,
        TestsWanted::WhereNamed => Vec::new(),
    };
    Ok(ResidualTests { tests, moved, taken_as_exact })
}
