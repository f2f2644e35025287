//! Mirrored placements: the vector between two placements of a known distance shows in its length and in what the joints carry of it; along the
//! axis of the joint that carries it the latter may be little, and its sign a matter of where the start lay.

use gravcal_identification::{DECISIVE, SolveEnvironment, Symmetry};
use gravcal_robot_model::session::Session;
use nalgebra::Vector3;

use crate::joint::error::EstimateError;
use crate::joint::solved::Solved;
use crate::joint::solving::solve_from::solve_from;
use crate::joint::starting::sample::Sample;
use crate::joint::variables::State;

/// Of two placements of a known distance.
pub(super) struct MirroredPlacements<'a> {
    pub session: &'a Session,
    /// By it images are looked at.
    pub sample: &'a Sample,
}

impl MirroredPlacements<'_> {
    /// Whether values lie on the side on which that vector is.
    fn is_back(&self, end: &State, along: &AlongAxis) -> bool {
        along_axis(self.session, end).is_some_and(|end| end.vector.dot(&along.vector) > 0.0)
    }
}

impl Symmetry for MirroredPlacements<'_> {
    type Solution = Solved;
    type Start = State;
    type Error = EstimateError;

    fn name(&self) -> &'static str {
        "placements the other way round"
    }

    fn images(&self, solved: &Solved, environment: &SolveEnvironment<'_>) -> Result<Vec<State>, EstimateError> {
        let MirroredPlacements { session, sample } = *self;
        let found = solved.state(&State::nominal(session));
        let Some(along) = along_axis(session, &found) else { return Ok(Vec::new()) };
        let mirrored = mirrored_placements(&found, along);
        // Where the readings tell the sign well, one step leads back; else it is the first of some.
        let step = sample.one_step(session, &mirrored).map(|step| step.end);
        if step.as_ref().is_some_and(|end| self.is_back(end, &along)) {
            return Ok(Vec::new());
        }
        let there = sample.nearby(session, step.as_ref().unwrap_or(&mirrored), 0.0, environment);
        let ruled_out = || there.cost > sample.nearby(session, &found, 0.0, environment).cost + DECISIVE;
        Ok(if self.is_back(&there.end, &along) || ruled_out() { Vec::new() } else { vec![mirrored] })
    }

    fn follow(
        &self,
        image: State,
        solved: &Solved,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Option<Solved>, EstimateError> {
        solve_from(self.session, solved.readings(), image, environment).map(Some)
    }

    fn height(&self, solved: &Solved) -> f64 {
        solved.estimate.cost
    }

    fn is_another(&self, end: &Solved, solved: &Solved) -> bool {
        let [end, found] = [end, solved].map(|solution| solution.state(&State::nominal(self.session)));
        along_axis(self.session, &found).is_none_or(|along| !self.is_back(&end, &along))
    }

    fn replaced(&self, solved: Solved, end: Solved, _: &SolveEnvironment<'_>) -> Result<Solved, EstimateError> {
        Ok(Solved { sign_known: solved.sign_known, ..end })
    }
}

/// Of the vector between two placements, the part along the axis of the joint that carries them.
#[derive(Clone, Copy)]
struct AlongAxis {
    loads: [usize; 2],
    vector: Vector3<f64>,
}

/// That of the placements of a known distance. Nothing where there is no such pair, or no joint.
fn along_axis(session: &Session, values: &State) -> Option<AlongAxis> {
    if session.joints.is_empty() {
        return None;
    }
    let loads = session.pair_of_free_placements()?.between;
    let joint = &session.robot.chain.movers()[session.loads[loads[0]].link];
    let axis = Vector3::from(joint.after.inverse().rotate_vector(joint.axis));
    let [p, q] = loads.map(|load| Vector3::from(values.loads[load]));
    Some(AlongAxis { loads, vector: axis * axis.dot(&(q - p)) })
}

/// The vector between two placements reversed along the axis.
fn mirrored_placements(values: &State, along: AlongAxis) -> State {
    let [a, b] = along.loads;
    let mut mirrored = values.clone();
    mirrored.loads[a] = (Vector3::from(values.loads[a]) + along.vector).into();
    mirrored.loads[b] = (Vector3::from(values.loads[b]) - along.vector).into();
    mirrored
}
