//! Where gravity's hemisphere is declared the end must lie in it.
//!
//! An end that does not has images that may: gravity, masses, moments and placements negative; or gravity negative and a joint across it half a
//! turn on, which is as good where those before it carry nothing. Without such an image the readings contradict the declaration, or say hardly
//! anything of gravity.

use std::f64::consts::PI;

use gravcal_identification::{DECISIVE, SolveEnvironment, Symmetry, settle};
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::Session;
use nalgebra::Vector3;

use crate::joint::error::EstimateError;
use crate::joint::solved::Solved;
use crate::joint::solving::solve_from::solve_from;
use crate::joint::starting::directions::directions;
use crate::joint::starting::start::start_around;
use crate::joint::variables::State;

/// Iterations at most in which the rest follows gravity on the border of its hemisphere.
const AT_BORDER: usize = 300;

/// Of a declared hemisphere.
pub(super) struct InHemisphere<'a> {
    pub session: &'a Session,
}

impl InHemisphere<'_> {
    /// Whether the end lies in the other hemisphere, and that is not known yet.
    fn is_elsewhere(&self, solved: &Solved, pole: [f64; 3]) -> bool {
        let known = solved.hemisphere_contradicted || !solved.estimate.termination.converged();
        !known && !self.lies_within(solved, pole)
    }

    /// Gravity as declared, the sensors at their nominal values, and what explains the readings with them.
    fn declared_start(&self, solved: &Solved) -> Result<Option<State>, EstimateError> {
        let size = self.session.gravity.magnitude;
        let Some(along) = directions(self.session.gravity.hemisphere).next() else { return Ok(None) };
        let declared = State { gravity: along.map(|component| size * component), ..State::nominal(self.session) };
        Ok(Some(start_around(self.session, solved.readings(), &declared)?))
    }

    fn lies_within(&self, solved: &Solved, pole: [f64; 3]) -> bool {
        let gravity = solved.state(&State::nominal(self.session)).gravity;
        Vector3::from(gravity).dot(&Vector3::from(pole)) >= 0.0
    }
}

impl Symmetry for InHemisphere<'_> {
    type Solution = Solved;
    type Start = State;
    type Error = EstimateError;

    fn name(&self) -> &'static str {
        "gravity in the declared hemisphere"
    }

    fn images(&self, solved: &Solved, _: &SolveEnvironment<'_>) -> Result<Vec<State>, EstimateError> {
        let session = self.session;
        if !session.gravity.hemisphere.is_some_and(|pole| self.is_elsewhere(solved, pole)) {
            return Ok(Vec::new());
        }
        let found = solved.state(&State::nominal(session));
        let free = |joint: &usize| session.fixed_reason(*joint, SensorParameter::PositionOffset).is_none();
        let first = (0..session.joints.len()).find(free);
        let turned = first.map(|joint| half_a_turn_on(session, &found, joint));
        let about_axis = first.and_then(|joint| half_a_turn_about_axis(session, &found, joint));
        let declared = self.declared_start(solved)?;
        Ok(std::iter::once(found.upside_down(session)).chain(turned).chain(about_axis).chain(declared).collect())
    }

    /// What leads nowhere explains nothing.
    fn follow(
        &self,
        image: State,
        solved: &Solved,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Option<Solved>, EstimateError> {
        let is_there = |other: &Solved| {
            let within = self.session.gravity.hemisphere.is_none_or(|pole| self.lies_within(other, pole));
            within && other.estimate.termination.converged()
        };
        Ok(solve_from(self.session, solved.readings(), image, environment).ok().filter(is_there))
    }

    fn height(&self, solved: &Solved) -> f64 {
        solved.estimate.cost
    }

    fn is_declared(&self) -> bool {
        true
    }

    fn kept(&self, solved: Solved, environment: &SolveEnvironment<'_>) -> Result<Solved, EstimateError> {
        let Some(pole) = self.session.gravity.hemisphere else { return Ok(solved) };
        Ok(match explained_at_border(&solved, pole, environment)? {
            true => Solved { sign_known: false, ..solved },
            false => Solved { hemisphere_contradicted: true, ..solved },
        })
    }
}

/// The solution, or an image of it that lies in the declared hemisphere. Whoever solves anew asks this last.
///
/// # Errors
/// As [`solve_from`].
pub(in crate::joint) fn in_hemisphere(
    session: &Session,
    solved: Solved,
    environment: &SolveEnvironment<'_>,
) -> Result<Solved, EstimateError> {
    Ok(settle(solved, &[&InHemisphere { session }], environment)?.solution)
}

/// Whether the readings are hardly explained worse with gravity on the border of its hemisphere: then they say too little of it to contradict
/// anything.
fn explained_at_border(
    solved: &Solved,
    pole: [f64; 3],
    environment: &SolveEnvironment<'_>,
) -> Result<bool, EstimateError> {
    let (problem, gravity) = (&solved.built.problem, solved.built.variables.gravity);
    let found = Vector3::from_column_slice(solved.estimate.values.get(gravity));
    let pole = Vector3::from(pole).normalize();
    let Some(border) = (found - pole * pole.dot(&found)).try_normalize(f64::MIN_POSITIVE) else { return Ok(false) };
    let mut start = solved.estimate.values.clone();
    start.set(gravity, (border * found.norm()).as_slice());
    let held = problem.with_fixed(&[gravity], "on the border of its hemisphere");
    // What cannot be solved there explains nothing.
    let Ok(there) = environment.within(AT_BORDER).solve(&held, &start) else { return Ok(false) };
    Ok(held.without_reference().cost(&there.values)? < solved.estimate.cost + DECISIVE)
}

/// Gravity negative, and the offset of a joint half a turn towards its nominal value.
fn half_a_turn_on(session: &Session, found: &State, joint: usize) -> State {
    let id = ParameterId::Sensor(joint, SensorParameter::PositionOffset);
    let mut image = State { gravity: found.gravity.map(|component| -component), ..found.clone() };
    let towards = (session.nominal(id) - found.value(id)).signum();
    *image.value_mut(id) += towards * PI;
    image
}

/// The same with gravity turned by half a turn about the joint's axis, which is exact for this joint and all beyond where the joints before
/// it stand, however the base leans: `−g + 2 (g·a) a`.
fn half_a_turn_about_axis(session: &Session, found: &State, joint: usize) -> Option<State> {
    let pose = session.poses.first()?;
    let coordinates = session.terms.coordinates(&pose.position, &pose.conditions, found);
    let chain = &session.robot.chain;
    let axis = Vector3::from(chain.axes(&coordinates)[chain.links_of(joint).next()?]);
    let gravity = Vector3::from(found.gravity);
    let turned = axis * (2.0 * axis.dot(&gravity)) - gravity;
    Some(State { gravity: turned.into(), ..half_a_turn_on(session, found, joint) })
}

#[cfg(test)]
mod tests {
    use gravcal_session::simulation::{Disturbance, Run};

    use super::*;
    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// An upright arm with the joint across gravity half a turn on, and gravity negative, reads the same.
    #[test]
    fn an_end_in_the_other_hemisphere_is_led_back() {
        let mut simulation = sarcos_shoulder();
        simulation.truth.gravity = [0.0, 0.0, -9.8];
        simulation.template.gravity.hemisphere = Some([0.0, 0.0, -1.0]);
        let session = simulation.session(0);
        let readings = select(&session, Signals::All);
        let nominal = State::nominal(&session);
        let free = |joint: &usize| session.fixed_reason(*joint, SensorParameter::PositionOffset).is_none();
        let first_free = (0..session.joints.len()).find(free).unwrap();
        let (above, back) = with_environment(|w| {
            let found = solve(&session, &readings, None, w)?.state(&nominal);
            let above = solve_from(&session, &readings, half_a_turn_on(&session, &found, first_free), w)?;
            let (height, cost) = (above.state(&nominal).gravity[2], above.estimate.cost);
            assert!(height > 9.0, "{height}");
            Ok::<_, EstimateError>((cost, in_hemisphere(&session, above, w)?))
        })
        .unwrap();
        assert!(back.state(&nominal).gravity[2] < -9.0 && !back.hemisphere_contradicted);
        assert!((back.estimate.cost - above).abs() < DECISIVE);
    }

    #[test]
    fn half_a_turn_about_a_joint_with_gravity_reads_the_same_from_there_on() {
        let mut simulation = sarcos_shoulder();
        simulation.truth.gravity = [2.0, 3.0, -9.1];
        for run in &mut simulation.runs {
            let Run::Sweep { swept, held, .. } = run else { panic!("all are sweeps") };
            (*swept, held[0]) = ((*swept).max(1), 0.3);
        }
        let session = simulation.session(0);
        let readings = select(&session, Signals::All);
        let solved = with_environment(|w| solve(&session, &readings, None, w)).unwrap();
        let found = solved.state(&State::nominal(&session));
        let predicted = |state: &State| {
            let built = solved.built.starting_at(&session, state);
            built.predicted(&session).unwrap().into_iter().filter(|(id, _)| id.channel >= 1)
        };
        let image = half_a_turn_about_axis(&session, &found, 1).unwrap();
        assert!((image.sensors[1][3] - found.sensors[1][3]).abs() > 3.0 && image.gravity[2] > 0.0, "{image:?}");
        for ((_, one), (id, other)) in predicted(&found).zip(predicted(&image)) {
            assert!((one - other).abs() < 1e-9 * one.abs().max(1.0), "{id:?}: {one} {other}");
        }
    }

    /// Whether readings with noise of so many counts are explained as well with gravity on a border 30° away from it.
    fn explained_on_a_border(noise: f64) -> bool {
        let mut simulation = sarcos_shoulder();
        simulation.disturbance = Disturbance::noise(vec![noise; 3]);
        let session = simulation.session(0);
        let readings = select(&session, Signals::All);
        let solved = with_environment(|w| solve(&session, &readings, None, w)).unwrap();
        let gravity = Vector3::from(solved.state(&State::nominal(&session)).gravity).normalize();
        let across = gravity.cross(&Vector3::x()).normalize();
        let pole = 3f64.sqrt() / 2.0 * across - 0.5 * gravity;
        with_environment(|w| explained_at_border(&solved, pole.into(), w)).unwrap()
    }

    #[test]
    fn readings_contradict_a_hemisphere_only_where_they_say_something_of_gravity() {
        assert!(!explained_on_a_border(0.8));
        // The noise is many times what gravity does.
        assert!(explained_on_a_border(1e3) && explained_on_a_border(3e3));
    }
}
