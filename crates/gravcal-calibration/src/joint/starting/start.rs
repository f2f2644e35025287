//! Where the joint problem starts.
//!
//! For given gravity, gains and offsets every torque reading is linear in the biases, the links' masses and moments
//! and the placements of the loads. So a candidate is a direction of gravity (with the nominal sensor values, or
//! those that the sequential estimator found), and its worth is the cost after that linear problem is solved. A few of the
//! best are followed a little further, and the one that comes lowest wins.

use gravcal_estimation::in_parallel;
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::Session;

use crate::joint::error::BuildError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::starting::directions::{directions, turned};
use crate::joint::starting::linear_part::{Candidate, LinearPart};
use crate::joint::starting::sample::{Nearby, POSES, Sample, thinned};
use crate::joint::variables::State;

/// One direction of so many suffices to compare signs.
const FEW: usize = 6;
/// Angles by which the best of them is turned, rad: about half of what lies between them, and down to what other errors hide.
const FIRST_TURN: f64 = 0.4;
const LAST_TURN: f64 = 0.02;
/// Poses that suffice to compare sessions that differ in signs and columns, which cost many times as much where one is wrong.
const COMPARED: usize = 60;
/// Candidates that are solved for briefly, and the least angle between their directions, rad.
const CONTENDERS: usize = 4;
const APART: f64 = 0.3;
/// Candidates that are followed to their end where the first one ended at what the noise does not explain.
const FURTHER: usize = 12;
/// Ends whose cost is so many times the lowest, beyond what explains the readings roughly, are not followed.
const WORTH_FOLLOWING: f64 = 3.0;
/// Ends are the same where their gravities are so near, rad.
const SAME_END: f64 = 0.02;

/// The best of `known` (if any) and the nominal values under directions spread over the declared hemisphere, or over the
/// sphere where none is declared.
///
/// What `known` leads to by one step or a few iterations is it, if that explains the readings of the sample. Else a candidate that
/// explains them roughly, or those that are left the lowest cost and differ in direction, are followed so, and the lowest end is
/// where the estimate starts.
pub(in crate::joint) fn best_start(
    session: &Session,
    sample: &Sample,
    known: Option<&State>,
    environment: &SolveEnvironment<'_>,
) -> Result<State, BuildError> {
    if let Some(known) = known {
        let part = LinearPart::new(session, &sample.readings, &State::nominal(session))?;
        if let Some(near) = near_known(&part, sample, known, environment) {
            return Ok(near);
        }
    }
    let ends = rough_ends(session, sample, known, Extent::Sufficient, environment)?;
    Ok(ends.into_iter().next().unwrap_or_else(|| State::nominal(session)))
}

/// How many candidates are followed.
#[derive(Clone, Copy, PartialEq)]
enum Extent {
    /// The first that explains the readings; without such, a few.
    Sufficient,
    /// All that are apart, up to so many.
    All(usize),
}

/// Where the best candidates lead if the sample's readings are explained roughly, the lowest first.
fn rough_ends(
    session: &Session,
    sample: &Sample,
    known: Option<&State>,
    extent: Extent,
    environment: &SolveEnvironment<'_>,
) -> Result<Vec<State>, BuildError> {
    let rough = Sample::new(session, &sample.readings.roughly(session))?;
    let part = LinearPart::new(session, &rough.readings, &State::nominal(session))?;
    let suited = |candidate: Candidate<'_>| part.solve_to_scale(candidate);
    let candidates = candidates(session, known);
    let (most, solved) = match extent {
        Extent::All(most) => (most, in_parallel(candidates, suited)),
        Extent::Sufficient => {
            let mut solved: Vec<(f64, State)> = Vec::new();
            for (cost, start) in candidates.map(suited) {
                if cost < rough.explained() {
                    solved = vec![(cost, start)];
                    break;
                }
                solved.push((cost, start));
            }
            (CONTENDERS, solved)
        }
    };
    let follow = |start: State| rough.nearby(session, &start, 0.0, environment);
    let mut ends: Vec<Nearby> = in_parallel(contenders(solved, most), follow);
    ends.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let lowest = ends.first().map_or(0.0, |near| near.cost);
    ends.retain(|near| near.cost <= WORTH_FOLLOWING * lowest + rough.explained());
    let mut different: Vec<State> = Vec::new();
    for Nearby { end, .. } in ends {
        if different.iter().all(|other| angle(&other.gravity, &end.gravity) > SAME_END) {
            different.push(end);
        }
    }
    Ok(different)
}

/// What suits `known` best, or one step or a few iterations on, if that explains the readings of the sample.
fn near_known(
    part: &LinearPart<'_>,
    sample: &Sample,
    known: &State,
    environment: &SolveEnvironment<'_>,
) -> Option<State> {
    let (cost, start) = part.solve(known);
    if cost < sample.explained() {
        return Some(start);
    }
    let step = sample.one_step(part.session(), &start).filter(|step| step.cost < sample.explained());
    if let Some(step) = step {
        return Some(step.end);
    }
    let near = sample.nearby(part.session(), &start, sample.explained(), environment);
    (near.cost < sample.explained()).then_some(near.end)
}

/// Where else an estimate may start whose end cannot be the right one, the most promising first.
pub(in crate::joint) fn further_starts(
    session: &Session,
    sample: &Sample,
    known: Option<&State>,
    environment: &SolveEnvironment<'_>,
) -> Result<Vec<State>, BuildError> {
    rough_ends(session, sample, known, Extent::All(FURTHER), environment)
}

/// `known`, and the nominal values under each direction of gravity.
fn candidates<'a>(session: &Session, known: Option<&'a State>) -> impl Iterator<Item = Candidate<'a>> {
    known.map(Candidate::Known).into_iter().chain(directions(session.gravity.hemisphere).map(Candidate::Under))
}

/// The best few candidates that are apart from each other.
fn contenders(mut candidates: Vec<(f64, State)>, most: usize) -> Vec<State> {
    candidates.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let mut contenders: Vec<State> = Vec::new();
    for (_, candidate) in candidates {
        if contenders.len() < most && contenders.iter().all(|other| angle(&other.gravity, &candidate.gravity) > APART) {
            contenders.push(candidate);
        }
    }
    contenders
}

fn angle(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    nalgebra::Vector3::from(*a).angle(&nalgebra::Vector3::from(*b))
}

/// What the best of the nominal values under any direction of gravity costs, for comparing sessions that differ in signs and columns. The
/// best of some directions is turned step by step, as a wrong direction may cost more than a wrong sign.
pub(in crate::joint) fn start_cost(session: &Session, readings: &MeasurementSet) -> Result<f64, BuildError> {
    let part = LinearPart::new(session, &thinned(session, readings, COMPARED), &State::nominal(session))?;
    let cost = |direction: [f64; 3]| part.least_cost(direction);
    let some = directions(session.gravity.hemisphere).step_by(FEW).map(|direction| (cost(direction), direction));
    let Some(mut best) = some.min_by(|(a, _), (b, _)| a.total_cmp(b)) else { return Ok(f64::INFINITY) };
    let mut turn = FIRST_TURN;
    while turn > LAST_TURN {
        let turned = turned(best.1, turn).map(|direction| (cost(direction), direction));
        match turned.into_iter().min_by(|(a, _), (b, _)| a.total_cmp(b)) {
            Some(lower) if lower.0 < best.0 => best = lower,
            _ => turn *= 0.5,
        }
    }
    Ok(best.0)
}

/// Masses, moments and placements that suit given gravity and sensors, which stay as they are.
pub(crate) fn start_around(session: &Session, readings: &MeasurementSet, known: &State) -> Result<State, BuildError> {
    let (_, solved) = LinearPart::new(session, &thinned(session, readings, POSES), known)?.solve(known);
    Ok(State { gravity: known.gravity, sensors: known.sensors.clone(), further: known.further.clone(), ..solved })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::{Signals, select};
    use crate::testing::{sarcos_shoulder, with_environment};

    #[test]
    fn contenders_are_the_cheapest_that_are_apart() {
        let session = sarcos_shoulder().session(0);
        let pointing =
            |angle: f64| State { gravity: [9.8 * angle.sin(), 0.0, -9.8 * angle.cos()], ..State::nominal(&session) };
        let costs_and_angles = [(3.0, 0.0), (1.0, 0.2), (2.0, 0.2 + 0.9 * APART), (4.0, 0.2 + 1.1 * APART), (5.0, 1.0)];
        let angles = |most: usize| -> Vec<f64> {
            let candidates = costs_and_angles.map(|(cost, angle)| (cost, pointing(angle)));
            let contenders = contenders(candidates.to_vec(), most);
            contenders.iter().map(|state| (state.gravity[0] / -state.gravity[2]).atan()).collect()
        };
        let expected = [0.2, 0.2 + 1.1 * APART, 1.0];
        assert!(angles(9).iter().zip(expected).all(|(found, angle)| (found - angle).abs() < 1e-12), "{:?}", angles(9));
        assert_eq!((angles(9).len(), angles(2)), (3, angles(9)[..2].to_vec()));
    }

    /// Without a hemisphere, gravity the other way up explains the readings as well, with torques and masses of the other sign.
    #[test]
    fn ends_are_different_and_one_that_explains_is_enough() {
        let mut simulation = sarcos_shoulder();
        simulation.template.gravity.hemisphere = None;
        let session = simulation.session(0);
        let sample = Sample::new(&session, &select(&session, Signals::All)).unwrap();
        with_environment(|environment| {
            let ends = |known: Option<&State>, extent: Extent| -> Vec<f64> {
                let ends = rough_ends(&session, &sample, known, extent, environment).unwrap();
                ends.iter().map(|end| angle(&end.gravity, &simulation.truth.gravity)).collect()
            };
            let mut both = ends(None, Extent::All(FURTHER));
            both.sort_by(f64::total_cmp);
            assert!(both.len() == 2 && both[0] < 0.02 && both[1] > 3.12, "{both:?}");
            assert_eq!(ends(None, Extent::All(1)).len(), 1);
            // The truth explains the readings: nothing else is followed.
            let one = ends(Some(&simulation.truth), Extent::Sufficient);
            assert!(one.len() == 1 && one[0] < 0.02, "{one:?}");
            assert_eq!(ends(Some(&simulation.truth), Extent::All(FURTHER)).len(), 2);
        });
    }

    #[test]
    fn known_values_start_where_they_explain_the_readings_and_do_not_where_they_mislead() {
        let simulation = sarcos_shoulder();
        let session = simulation.session(0);
        let sample = Sample::new(&session, &select(&session, Signals::All)).unwrap();
        // Values from which a few iterations do not lead to the truth, some of them.
        let with_gain = |gain: f64| {
            let mut state = simulation.truth.clone();
            (state.sensors[1][2], state.sensors[2][2]) = (gain, -gain);
            state
        };
        let misleading = [0.1, 0.3, 3.0].map(with_gain);
        with_environment(|environment| {
            let explained = |start: &State| sample.nearby(&session, start, 0.0, environment).cost < sample.explained();
            assert!(!misleading.iter().all(explained));
            let start = |known| best_start(&session, &sample, Some(known), environment).unwrap();
            let nonlinear = |state: &State| state.sensors.iter().map(|[k, _, s, o]| [*k, *s, *o]).collect::<Vec<_>>();
            let near = start(&simulation.truth);
            assert_eq!((nonlinear(&near), near.gravity), (nonlinear(&simulation.truth), simulation.truth.gravity));
            for known in &misleading {
                let near = start(known);
                assert!(explained(&near), "{near:?}");
                assert!(angle(&near.gravity, &simulation.truth.gravity) < 0.02, "{near:?}");
            }
        });
    }
}
