//! Gravity in the other hemisphere than the declared one.

use std::sync::Arc;

use gravcal_robot_model::session::Session;
use nalgebra::Vector3;

use super::hypothesis::{Hypothesis, Rival};
use crate::joint::solved::Solved;
use crate::joint::variables::State;

/// From so far from the middle of the declared hemisphere on gravity may lie in the other one, rad.
const EDGE: f64 = std::f64::consts::FRAC_PI_3;

/// The hemisphere that is declared is the wrong one.
#[derive(Clone, Copy, Debug)]
struct OtherHemisphere;

/// The one there is, where a hemisphere is declared.
pub(super) fn all(session: &Session) -> Option<Arc<dyn Hypothesis>> {
    session.gravity.hemisphere.is_some().then(|| Arc::new(OtherHemisphere) as Arc<dyn Hypothesis>)
}

/// Whether gravity came out so far from the middle of the declared hemisphere that the truth may lie in the other one.
fn is_near_edge(session: &Session, solved: &Solved) -> bool {
    let (Some(pole), g) = (session.gravity.hemisphere, solved.state(&State::nominal(session)).gravity) else {
        return false;
    };
    let (pole, g) = (Vector3::from(pole), Vector3::from(g));
    g.dot(&pole) < EDGE.cos() * g.norm() * pole.norm()
}

impl Hypothesis for OtherHemisphere {
    fn made(&self, session: &Session) -> Session {
        Session { gravity: session.gravity.other_hemisphere(), ..session.clone() }
    }

    fn words(&self, _session: &Session) -> (String, String) {
        let cure = "Correct [gravity] hemisphere; or, if it is right, all torques have the other sign (torque_sign = \"reversed\" in [joints]).";
        ("gravity in the other hemisphere than the declared one".to_owned(), cure.to_owned())
    }

    /// Sensors that all read the other way explain gravity in the other hemisphere as well, and are not as declared: there the solution counts.
    fn rival(&self, _session: &Session) -> Rival {
        Rival::Solution
    }

    /// Beyond the edge of the declared hemisphere lies gravity that starts on this side of it as well.
    fn is_suspected(&self, session: &Session, solved: &Solved) -> bool {
        is_near_edge(session, solved)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// From 60° on the other hemisphere is tried whatever its start costs.
    #[test]
    fn gravity_far_from_the_middle_of_its_hemisphere_may_lie_in_the_other_one() {
        let mut session = sarcos_shoulder().session(0);
        let readings = select(&session, Signals::All);
        let solved = with_environment(|environment| solve(&session, &readings, None, environment)).unwrap();
        let g = Vector3::from(solved.state(&State::nominal(&session)).gravity).normalize();
        let across = g.cross(&Vector3::x()).normalize();
        let mut near = |degrees: f64| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            session.gravity.hemisphere = Some((cosine * g + sine * across).into());
            is_near_edge(&session, &solved)
        };
        assert_eq!([0.0, 59.0, 61.0, 87.0].map(&mut near), [false, false, true, true]);
        session.gravity.hemisphere = None;
        assert!(!is_near_edge(&session, &solved));
    }
}
