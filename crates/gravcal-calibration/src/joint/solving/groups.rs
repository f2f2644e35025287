//! In which order readings enter an estimate: all at once, or in groups of which each enters once and is then passed on.
//!
//! - **Step by step**: the readings of the paper's steps, in the order of the steps (step 1 joint by joint, step 2, step 3 joint by
//!   joint), each in the first that reads it. Every step estimates all that is unknown, from its own readings and what the
//!   steps before have determined, with the whole covariance. Most is open after a step (of a sweep: everything but amplitude, phase,
//!   gain and bias), so its result is passed on as the numbers that it determines, in [condensed] form. No
//!   approximation is left but those of second order in the noise.
//! - **Pose by pose**: an information filter. It begins with the first poses that together know gravity and every parameter of a
//!   sensor at most [`TIMES_WORSE`] times worse than all poses do, because until then some direction is open, and a
//!   [linearized] prior that is moved along it is wrong by more than noise. Then each pose is one update: linearized where it
//!   ends, and not iterated back.
//!
//! [condensed]: gravcal_estimation::passing_on::condensed
//! [linearized]: gravcal_estimation::passing_on::linearized

use gravcal_estimation::{BlockId, EvaluateError, Factor, Loss, Problem, RankAnalysis, Values};
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{Session, UncertaintyChoice};

use crate::joint::building::build::build_with_constraints;
use crate::joint::error::EstimateError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::order::Order;
use crate::joint::problem::JointProblem;
use crate::joint::select::{Signals, select};
use crate::joint::starting::sample::Sample;
use crate::joint::starting::start::best_start;
use crate::plan::Plan;

/// How many times worse than all poses the first ones may know a parameter before single poses follow. On the Sarcos shoulder
/// (60 to 100 sessions of `experiments/step-by-step`) 2 or 3 raise the rms errors of torque gains by 1 % of their bound over those
/// of the joint estimate at most, 5 by 7 %, and 15 to almost four times the bound.
const TIMES_WORSE: f64 = 3.0;

/// The readings of the paper's steps, to enter step by step.
pub fn step_by_step(session: &Session) -> MeasurementSet {
    MeasurementSet {
        order: Order::StepByStep(Plan::new(session).readings_by_step()),
        ..select(session, Signals::PaperSteps)
    }
}

/// All readings, to enter pose by pose after the first ones.
///
/// How many are first is judged at starting values: it depends on the poses, and hardly on what is read there.
///
/// # Errors
/// Where no problem can be built.
pub fn pose_by_pose(session: &Session, environment: &SolveEnvironment<'_>) -> Result<MeasurementSet, EstimateError> {
    let readings = select(session, Signals::All);
    let start = best_start(session, &Sample::new(session, &readings)?, None, environment)?;
    let built = build_with_constraints(session, &readings, &start)?;
    let first = first_factors(&built)?;
    let mut used = (0..session.poses.len()).filter(|pose| !readings.used[*pose].is_empty());
    let from = used.nth(first).unwrap_or(session.poses.len());
    Ok(MeasurementSet { order: Order::PoseByPose { from }, ..readings })
}

/// What of a session stands against estimating group by group, if anything does.
pub(crate) fn why_not_by_groups(session: &Session, built: &JointProblem) -> Option<&'static str> {
    let by_noise = session.uncertainty == UncertaintyChoice::Noise;
    [
        (built.loss != Loss::None, "a loss ([loss]) tells outliers by the residuals of all readings"),
        (!session.constraints.is_empty(), "constraints ([constraints]) hold for the estimate from all readings"),
        (!by_noise, "blocks of poses ([uncertainty]) scatter about the estimate from all readings only"),
        (
            built.problem.blocks().iter().any(|block| block.eliminated),
            "errors of single poses' positions (a std of `position`, or a deflection of poses of no sweep) are unknowns of all \
             readings",
        ),
    ]
    .into_iter()
    .find_map(|(holds, why)| holds.then_some(why))
}

impl MeasurementSet {
    /// Those that enter first, from which values can be had to start with.
    pub(in crate::joint) fn first(&self) -> MeasurementSet {
        match self.order {
            Order::PoseByPose { from } => self.only(|id| id.pose < from),
            _ => self.clone(),
        }
    }
}

/// The fewest factors of first poses that know enough.
fn first_factors(built: &JointProblem) -> Result<usize, EvaluateError> {
    let sensors =
        built.variables.sensors.iter().flat_map(|ids| SensorParameter::ALL.map(|quantity| ids[quantity as usize]));
    let asked: Vec<BlockId> = sensors.chain([built.variables.gravity]).chain(built.variables.further_once()).collect();
    let all = Precision::of(&built.problem, &built.initial, &asked)?;
    let enough = |poses: usize| -> Result<bool, EvaluateError> {
        let factors = first_of(built, poses);
        let Ok(problem) = built.problem.with_only(factors, NOT_YET) else { return Ok(false) };
        Ok(all.is_nearly(&Precision::of(&problem, &built.initial, &asked)?))
    };
    // More poses never know less.
    let (mut too_few, mut sufficient) = (0, built.poses);
    while sufficient - too_few > 1 {
        let middle = too_few.midpoint(sufficient);
        if enough(middle)? { sufficient = middle } else { too_few = middle }
    }
    Ok(sufficient)
}

/// Why a block is fixed that no reading so far depends on.
pub(in crate::joint) const NOT_YET: &str = "nothing was read yet that depends on it";

/// The factors of the first poses, and all that is known otherwise.
pub(in crate::joint) fn first_of(built: &JointProblem, poses: usize) -> Vec<Factor> {
    let factors = built.problem.factors();
    factors[..poses].iter().chain(&factors[built.poses..]).cloned().collect()
}

/// What is known of some blocks.
struct Precision {
    /// How many directions of theirs are open.
    open: usize,
    /// Standard deviation of each of their columns.
    std: Vec<f64>,
}

impl Precision {
    fn of(problem: &Problem, values: &Values, blocks: &[BlockId]) -> Result<Self, EvaluateError> {
        let analysis = RankAnalysis::new(problem, values)?;
        let covariance = analysis.covariance();
        let columns: Vec<usize> = blocks.iter().flat_map(|id| problem.columns_of(*id)).collect();
        let open = analysis.null_space_within(&columns).len();
        Ok(Precision { open, std: columns.iter().map(|column| covariance.std(*column)).collect() })
    }

    /// Whether fewer readings know the same things nearly as well.
    fn is_nearly(&self, fewer: &Precision) -> bool {
        let near = |(all, fewer): (&f64, &f64)| *fewer <= TIMES_WORSE * all;
        // Where a block is fixed because nothing reads it yet, columns are missing.
        (self.open, self.std.len()) == (fewer.open, fewer.std.len()) && self.std.iter().zip(&fewer.std).all(near)
    }
}
