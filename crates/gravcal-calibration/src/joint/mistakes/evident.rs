//! Columns that are swapped, or a unit that is another, so evidently that nothing need be solved as the session stands.
//!
//! With columns of two joints swapped there is no minimum that explains anything, and to look for it takes minutes: solves creep along valleys that lead nowhere, from
//! one start after the other. A part of the readings tells both at once: none of the best starts comes near to explaining them, even roughly, and with two columns
//! exchanged, or positions in their own unit, the best does. No image of a right session has other columns or another unit, so that no start of a right session is
//! accused.

use std::sync::Arc;

use gravcal_estimation::in_parallel;
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::Session;

use super::hypothesis::{Cause, Hypothesis};
use super::search::{BETTER, BETTER_START, SOLVED, in_words};
use super::{other_unit, swapped_columns};
use crate::joint::error::EstimateError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::order::Order;
use crate::joint::starting::sample::Sample;
use crate::joint::starting::start::{best_start, start_cost};
use crate::joint::variables::State;

/// Nothing is looked for where the best start costs less than so many times what explains the readings roughly: of 9 sessions that were looked at, the right ones
/// cost 0.6 to 0.7 of it, and those with swapped columns 6 to 33 times as much.
const HOPELESS: f64 = 4.0;
/// What is named costs at most so many times as much as explains them, and so small a share of what the session as it stands does.
const EXPLAINED: f64 = 2.0;
/// Fewer readings for each unknown that poses share tell no columns.
const TELLING: usize = 2;

/// Looks for these. `sample`: a part of the readings; `start`: the best for the session as it stands.
///
/// # Errors
/// Where no problem can be built.
pub(in crate::joint) fn evident_mistake(
    session: &Session,
    sample: &Sample,
    start: &State,
    environment: &SolveEnvironment<'_>,
) -> Result<Option<Cause>, EstimateError> {
    if sample.readings.order != Order::Together || sample.readings.count() < TELLING * sample.shared_columns() {
        return Ok(None);
    }
    let readings = sample.readings.roughly(session);
    let rough = Sample::new(session, &readings)?;
    let hopeless = HOPELESS * rough.explained();
    let before = rough.nearby(session, start, hopeless, environment).cost;
    if before < hopeless {
        return Ok(None);
    }
    environment.report("looking for swapped columns and other units");
    let as_it_stands = start_cost(session, &readings)?;
    let tried = [other_unit::all(session), swapped_columns::all(session), swapped_columns::in_one_table(session)];
    for alike in tried {
        for mistake in promising(alike, session, &readings, as_it_stands)? {
            let after = cost_of(&*mistake, session, &readings, environment)?;
            if after < EXPLAINED * rough.explained() && after < BETTER * before {
                return Ok(Some(in_words(&*mistake, session, (after / before).sqrt(), None)));
            }
        }
    }
    Ok(None)
}

/// The few whose starts cost least, where they cost less than that of the session as it stands.
fn promising(
    mistakes: Vec<Arc<dyn Hypothesis>>,
    session: &Session,
    readings: &MeasurementSet,
    as_it_stands: f64,
) -> Result<Vec<Arc<dyn Hypothesis>>, EstimateError> {
    let promise =
        |mistake: Arc<dyn Hypothesis>| Ok((start_cost(&mistake.made(session), &mistake.read(readings))?, mistake));
    let costs: Result<Vec<_>, EstimateError> = in_parallel(mistakes, promise).into_iter().collect();
    let mut costs = costs?;
    costs.retain(|(cost, _)| *cost < BETTER_START * as_it_stands);
    costs.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    Ok(costs.into_iter().map(|(_, mistake)| mistake).take(SOLVED).collect())
}

/// What the readings cost with a mistake mended, where the best starts lead.
fn cost_of(
    mistake: &dyn Hypothesis,
    session: &Session,
    readings: &MeasurementSet,
    environment: &SolveEnvironment<'_>,
) -> Result<f64, EstimateError> {
    let made = mistake.made(session);
    let sample = Sample::new(&made, &mistake.read(readings))?;
    let start = best_start(&made, &sample, None, environment)?;
    Ok(sample.nearby(&made, &start, sample.explained(), environment).cost)
}

#[cfg(test)]
mod tests {
    use gravcal_recording::PositionUnit;

    use super::*;
    use crate::joint::{Signals, select};
    use crate::testing::{sarcos_shoulder, with_environment};

    fn found(session: &Session) -> Option<String> {
        let sample = Sample::new(session, &select(session, Signals::All)).unwrap();
        with_environment(|environment| {
            let start = best_start(session, &sample, None, environment)?;
            evident_mistake(session, &sample, &start, environment)
        })
        .unwrap()
        .map(|cause| cause.mistake.advice)
    }

    #[test]
    fn columns_that_are_swapped_are_named_before_anything_is_solved() {
        let right = sarcos_shoulder().session(0);
        assert_eq!(found(&right), None);
        let mut torques = right.clone();
        torques.poses.iter_mut().for_each(|pose| pose.torque.swap(1, 2));
        let told = found(&torques).unwrap();
        assert!(told.contains("swapped torque columns: joint2 and joint3"), "{told}");
        let mut positions = right.clone();
        positions.poses.iter_mut().for_each(|pose| pose.position.swap(0, 1));
        let told = found(&positions).unwrap();
        assert!(told.contains("swapped position columns: joint1 and joint2"), "{told}");
    }

    #[test]
    fn positions_in_another_unit_are_named_before_anything_is_solved() {
        let right = sarcos_shoulder().session(0);
        let told = |unit: PositionUnit, factor: f64| {
            let mut session = right.clone();
            session.joints.iter_mut().for_each(|joint| joint.position_unit = unit);
            session.poses.iter_mut().flat_map(|pose| &mut pose.position).for_each(|reading| *reading *= factor);
            found(&session)
        };
        assert_eq!(told(PositionUnit::Radian, 1.0), None);
        let degrees = told(PositionUnit::Radian, 1_f64.to_degrees()).unwrap();
        assert!(degrees.contains("position readings in deg that are declared as rad"), "{degrees}");
        assert!(degrees.contains("say unit = \"deg\" in [readings] position"), "{degrees}");
        let radians = told(PositionUnit::Degree, 1_f64.to_radians()).unwrap();
        assert!(radians.contains("position readings in rad that are declared as deg"), "{radians}");
    }

    /// Standstills of recordings state how well each position is known: each is an unknown then.
    #[test]
    fn columns_that_are_swapped_are_named_where_each_position_is_an_unknown() {
        let mut session = sarcos_shoulder().session(0);
        session.deflection.reading_std = vec![1e-4; 3];
        assert_eq!(found(&session), None);
        session.poses.iter_mut().for_each(|pose| pose.torque.swap(1, 2));
        let told = found(&session).unwrap();
        assert!(told.contains("swapped torque columns: joint2 and joint3"), "{told}");
    }

    /// Half of the tables were recorded by someone else.
    #[test]
    fn columns_that_are_swapped_in_one_file_are_named_with_it() {
        let mut session = sarcos_shoulder().session(0);
        session.tables.truncate(2);
        session.tables[1].path = "other.csv".into();
        session.poses.iter_mut().enumerate().for_each(|(place, pose)| pose.table = place % 2);
        assert_eq!(found(&session), None);
        session.poses.iter_mut().skip(1).step_by(2).for_each(|pose| pose.torque.swap(1, 2));
        let told = found(&session).unwrap();
        assert!(told.contains("swapped torque columns in other.csv: joint2 and joint3"), "{told}");
    }

    /// What else is wrong is none of it: a sensor that reads the other way, a joint that is stuck, friction of a fifth of what readings spread over.
    #[test]
    fn nothing_else_is_named() {
        let right = sarcos_shoulder().session(0);
        let mut reversed = right.clone();
        reversed.poses.iter_mut().flat_map(|pose| pose.torque[1].as_mut()).for_each(|torque| torque.value *= -1.0);
        let mut stuck = right.clone();
        stuck.poses.iter_mut().for_each(|pose| pose.position[1] = 0.3);
        let mut rubs = right.clone();
        for (place, pose) in rubs.poses.iter_mut().enumerate() {
            let side = if (7 * place) % 5 < 2 { 1.0 } else { -1.0 };
            pose.torque.iter_mut().flatten().for_each(|torque| torque.value += 60.0 * side);
        }
        assert_eq!([reversed, stuck, rubs].map(|session| found(&session)), [None, None, None]);
    }
}
