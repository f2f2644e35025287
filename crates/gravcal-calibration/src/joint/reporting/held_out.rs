//! Poses that a fit did not see, and how well it predicts them.
//!
//! Consecutive poses share what the model leaves out: friction of one approach, a deflection, a drift. One pose between two that are
//! fitted is therefore hardly a prediction. So a stretch of consecutive poses is held out of a second fit, a tenth of each
//! sweep, and of what else is in a table: where the arm is least often at places to which it also comes before or after, and of equals that in the middle. Or the
//! session names tables that enter no fit at all.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use gravcal_identification::SolveEnvironment;
use gravcal_recording::file_name;
use gravcal_robot_model::session::Session;
use gravcal_robot_model::sweeps::find_sweeps;

use crate::joint::building::build::{build_problem, build_with_constraints};
use crate::joint::error::EstimateError;
use crate::joint::measurement_set::{Bending, MeasurementSet};
use crate::joint::model_error::bending_in_motion::effects_in_motion;
use crate::joint::problem::JointProblem;
use crate::joint::reporting::smaller_models::smaller_models;
use crate::joint::solved::Solved;
use crate::joint::solving::fit::fit;
use crate::joint::variables::State;
use crate::judgement::{self, held_out};
use crate::result::{Fit, HeldOut};

/// One pose in so many is held out.
const SHARE: usize = 10;
/// Of fewer consecutive poses none is.
const LEAST: usize = SHARE / 2;
/// Edge of a place: poses whose joints are all within the same such steps, rad or m, are at one place.
const PLACE: f64 = 0.1;

/// Tells the fit, with the prediction of poses that were not seen: by itself those of `[[validation]]`, else by a second fit a tenth of
/// the poses, which that does not see.
///
/// Where the second fit does not converge, nothing is predicted.
pub(crate) fn fit_with_held_out(
    session: &Session,
    solved: &Solved,
    environment: &SolveEnvironment<'_>,
) -> Result<Fit, EstimateError> {
    if environment.stopped() {
        return fit_without_held_out(session, solved, "stopped");
    }
    let whitened = solved.built.problem.residuals(&solved.estimate.values)?;
    let mut reported = judgement::fit(session, solved, &whitened)?;
    environment.report("predicting held-out poses");
    // What a prediction is off by is told to three digits.
    let environment = &environment.roughly();
    match session.validation.is_empty() {
        false => {
            let found = solved.state(&State::nominal(session));
            reported.held_out = of_validation(session, solved.readings(), found)?;
        }
        true => match seen_by_second_fit(session, solved, environment)? {
            Second::Predicted(held_out) => reported.held_out = held_out,
            Second::Missing(why) => reported.held_out_missing = Some(why),
        },
    }
    if session.has_windows() && reported.held_out.is_some() {
        reported.smaller_models = smaller_models(session, solved, environment)?;
    }
    Ok(reported)
}

/// Tells the fit alone. `why`: what the second fit was.
pub(in crate::joint) fn fit_without_held_out(
    session: &Session,
    solved: &Solved,
    why: &str,
) -> Result<Fit, EstimateError> {
    let whitened = solved.built.problem.residuals(&solved.estimate.values)?;
    let reported = judgement::fit(session, solved, &whitened)?;
    Ok(Fit { held_out_missing: Some(why.to_owned()), ..reported })
}

/// How well what was found predicts the tables that enter no fit. `fitted`: the readings that it was found from.
pub(in crate::joint) fn of_validation(
    session: &Session,
    fitted: &MeasurementSet,
    found: State,
) -> Result<Option<HeldOut>, EstimateError> {
    let unseen =
        Session { poses: session.validation.clone(), validation: Vec::new(), repeated: Vec::new(), ..session.clone() };
    // Joints that stand in other sweeps deflect otherwise, and stick otherwise.
    let prediction = State { deflections: Vec::new(), static_friction: Vec::new(), ..found };
    let readings = bending_as(fitted, fitted.of_other_poses(&unseen), &unseen, &prediction)?;
    let readings =
        if fitted.displaced.is_some() { readings.with_displacements(&unseen, &prediction)? } else { readings };
    let predicted = predict(&unseen, &readings, &prediction)?;
    let tables: BTreeSet<usize> = unseen.poses.iter().map(|pose| pose.table).collect();
    let files = tables.into_iter().map(|table| file_name(&session.tables[table].path)).collect();
    Ok(predicted.map(|held_out| HeldOut { files, ..held_out }))
}

/// Readings of other poses of the arm, in which its joints bend under what these numbers predict.
fn bending_as(
    fitted: &MeasurementSet,
    mut readings: MeasurementSet,
    unseen: &Session,
    found: &State,
) -> Result<MeasurementSet, EstimateError> {
    let Some(bending) = &fitted.bending else { return Ok(readings) };
    let in_motion = effects_in_motion(unseen, &readings, found, &bending.std)?;
    let under = |torques| Some(Arc::new(Bending { std: bending.std.clone(), torques, in_motion: in_motion.clone() }));
    let stiff = vec![vec![0.0; unseen.joints.len()]; unseen.poses.len()];
    let mut bent = MeasurementSet { bending: under(stiff), ..readings.clone() };
    // First what stiff joints would carry, then what those carry that bend by it.
    for _ in 0..2 {
        let Ok(built) = build_problem(unseen, &bent, found) else { return Ok(readings) };
        bent.bending = under(Solved::at_start(built)?.bending_torques(unseen)?);
    }
    readings.bending = bent.bending;
    Ok(readings)
}

/// What came of the second fit.
enum Second {
    Predicted(Option<HeldOut>),
    Missing(String),
}

fn seen_by_second_fit(
    session: &Session,
    solved: &Solved,
    environment: &SolveEnvironment<'_>,
) -> Result<Second, EstimateError> {
    let stretches = stretches(session, solved.readings());
    let part = |held: bool| solved.readings().only(|id| stretches.contains(&id.pose) == held);
    let start = solved.state(&State::nominal(session));
    let readings = part(false);
    let Ok(seen) = build_with_constraints(session, &readings, &start) else { return Ok(Second::Predicted(None)) };
    let seen = fixed_alike(solved, seen)?;
    let (seen, estimate) = fit(&seen, environment)?;
    if !estimate.termination.converged() {
        return Ok(Second::Missing(estimate.termination.to_string()));
    }
    let prediction = seen.variables.state(&estimate.values, &start);
    Ok(Second::Predicted(predict(session, &part(true), &prediction)?))
}

/// What the first fit held, by the sequential steps say, the second holds too.
pub(in crate::joint) fn fixed_alike(solved: &Solved, seen: JointProblem) -> Result<JointProblem, EstimateError> {
    let first = &solved.built.problem;
    let is_fixed = |name: &str| first.find(name).is_some_and(|same| first.block(same).fixed.is_some());
    let also: Vec<_> = seen.problem.block_ids().filter(|id| is_fixed(&seen.problem.block(*id).name)).collect();
    let mut seen = seen.with_loss(solved.built.loss)?;
    seen.problem = seen.problem.with_fixed(&also, "held in the first fit");
    Ok(seen)
}

pub(in crate::joint) fn predict(
    session: &Session,
    readings: &MeasurementSet,
    found: &State,
) -> Result<Option<HeldOut>, EstimateError> {
    let Ok(built) = build_problem(session, readings, found) else { return Ok(None) };
    let whitened = built.problem.residuals(&built.initial)?;
    Ok(Some(held_out(session, readings, &built.rows, &whitened)))
}

/// The poses that are held out: a tenth of each sweep, and of the other poses of each table; where tables are too small for that, of consecutive
/// poses with the same load.
pub(in crate::joint) fn stretches(session: &Session, readings: &MeasurementSet) -> BTreeSet<usize> {
    let entering: Vec<usize> = (0..readings.used.len()).filter(|pose| !readings.used[*pose].is_empty()).collect();
    let mut sweep = vec![None; session.poses.len()];
    for (index, found) in find_sweeps(session).iter().enumerate() {
        found.poses.iter().for_each(|pose| sweep[*pose] = Some(index));
    }
    let of = |pose: &usize| &session.poses[*pose];
    let places = Places::of(session, &entering);
    let of_tables = tenths(entering.chunk_by(|a, b| of(a).table == of(b).table && sweep[*a] == sweep[*b]), &places);
    match of_tables.is_empty() {
        false => of_tables,
        true => tenths(entering.chunk_by(|a, b| of(a).load == of(b).load), &places),
    }
}

/// Of each group the tenth that says least of poses which are fitted.
fn tenths<'p>(groups: impl Iterator<Item = &'p [usize]>, places: &Places) -> BTreeSet<usize> {
    let tenth = |group: &'p [usize]| {
        let count = if group.len() < LEAST { 0 } else { (group.len() + SHARE / 2) / SHARE };
        let middle = (group.len() - count) / 2;
        let firsts = (0..=group.len() - count).step_by(count.max(1)).chain([middle]);
        let seen_again = |first: &usize| (places.seen_again(&group[*first..first + count]), first.abs_diff(middle));
        let first = firsts.min_by_key(seen_again).unwrap_or(middle);
        &group[first..first + count]
    };
    groups.flat_map(tenth).copied().collect()
}

/// Where the arm is in each pose, and with which load.
struct Places {
    /// By pose, the number of its place.
    of_poses: Vec<usize>,
    /// The poses at each place, in their order.
    poses: Vec<Vec<usize>>,
}

impl Places {
    fn of(session: &Session, poses: &[usize]) -> Places {
        let mut known: BTreeMap<(Option<usize>, Vec<i64>), usize> = BTreeMap::new();
        let (mut of_poses, mut at) = (vec![0; session.poses.len()], Vec::new());
        for pose in poses {
            let own = &session.poses[*pose];
            let steps =
                session.nominal_coordinates(own).into_iter().map(|coordinate| (coordinate / PLACE).floor() as i64);
            let place = *known.entry((own.load, steps.collect())).or_insert(at.len());
            of_poses[*pose] = place;
            if place == at.len() {
                at.push(Vec::new());
            }
            at[place].push(*pose);
        }
        Places { of_poses, poses: at }
    }

    /// How many of some consecutive poses are at places to which the arm also comes long before or after: no sooner than they last.
    fn seen_again(&self, stretch: &[usize]) -> usize {
        let (Some(first), Some(last)) = (stretch.first(), stretch.last()) else { return 0 };
        let long = stretch.len();
        let again = |pose: &&usize| {
            let there = &self.poses[self.of_poses[**pose]];
            there.first().is_some_and(|other| other + long < *first)
                || there.last().is_some_and(|other| *other > last + long)
        };
        stretch.iter().filter(again).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Poses that are each at a place of their own, but for some.
    fn places(count: usize, same: &[[usize; 2]]) -> Places {
        let mut of_poses: Vec<usize> = (0..count).collect();
        same.iter().for_each(|[one, other]| of_poses[*other] = of_poses[*one]);
        let at = |place| (0..count).filter(|pose| of_poses[*pose] == place).collect();
        Places { poses: (0..count).map(at).collect(), of_poses }
    }

    #[test]
    fn where_the_arm_comes_again_is_not_held_out() {
        let poses: Vec<usize> = (0..40).collect();
        let held =
            |same: &[[usize; 2]]| tenths([&poses[..]].into_iter(), &places(40, same)).into_iter().collect::<Vec<_>>();
        assert_eq!(held(&[]), [18, 19, 20, 21]);
        assert_eq!(held(&[[2, 19]]), [16, 17, 18, 19].map(|pose| pose + 4), "the next that is seen once");
        assert_eq!(held(&[[18, 21]]), [18, 19, 20, 21], "neighbours are alike");
    }

    #[test]
    fn the_middle_of_a_group_is_one_stretch_of_a_tenth() {
        let of = |sizes: &[usize]| {
            let poses: Vec<usize> = (0..sizes.iter().sum()).collect();
            let mut rest = poses.as_slice();
            let groups = sizes.iter().map(|size| {
                let (group, others) = rest.split_at(*size);
                rest = others;
                group
            });
            let count = sizes.iter().sum();
            tenths(groups, &places(count, &[])).into_iter().collect::<Vec<_>>()
        };
        assert_eq!(of(&[40]), [18, 19, 20, 21]);
        assert_eq!(of(&[4, 5, 15]), [6, 15, 16]);
        assert_eq!(of(&[4, 4]), [0_usize; 0]);
    }
}
