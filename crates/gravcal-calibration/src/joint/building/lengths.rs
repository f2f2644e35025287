//! How far joints sit from where the robot's description has them: unknowns where the session says how well lengths are known.
//!
//! A joint that sits `δ` (m, along the axes of the link `p` that it hangs on) aside carries what hangs on it, of the mass `m`, as much aside. Of an arm at
//! rest this is
//!
//! ```text
//!     h_p → h_p + m δ
//! ```
//!
//! exactly. Where the links' masses are unknown, `m` is that of the load that a pose carries beyond the joint: what else hangs there is in the moment of
//! `p`, which is an unknown.
//!
//! Of an arm in motion the joint also accelerates otherwise what hangs on it. Readings are those of [`gravcal_robot_model::residuals::Displaced`] then, at
//! rest, too, where one session has both (`displacements.rs`).

use std::sync::Arc;

use gravcal_estimation::{BlockId, ProblemBuilder, Residual, Values};
use gravcal_robot_model::residuals::{Shift, Shifted};
use gravcal_robot_model::session::{InertiaPrior, Session};

use crate::joint::building::sweep_moments::by_sweep;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::variables::{JointDisplacements, State, VariableIndex};

/// First entry of the first moment in a link's block.
const MOMENT: usize = 1;
/// Axes of a link along which its joint may sit aside.
pub(in crate::joint) const AXES: [&str; 3] = ["x", "y", "z"];

/// The links whose joint hangs on another link, and whose place makes a difference to a reading that enters: of an arm in motion all. None where
/// moments are described by sweep, which asks for no lengths.
pub(in crate::joint) fn placed_links(session: &Session, readings: &MeasurementSet) -> Vec<usize> {
    let chain = &session.robot.chain;
    if by_sweep(session) {
        return Vec::new();
    }
    if session.has_windows() {
        return (0..chain.link_count()).filter(|link| chain.parent(*link).is_some()).collect();
    }
    let used = || (0..session.poses.len()).filter(|pose| !readings.used[*pose].is_empty());
    let matters = |link: &usize| used().any(|pose| mass_beyond(session, *link, pose) > 0.0);
    (0..chain.link_count()).filter(|link| chain.parent(*link).is_some()).filter(matters).collect()
}

/// Mass that hangs on the joint that moves a link, in a pose, kg, as it is stated: of loads, and of links where the session knows these.
pub(in crate::joint) fn mass_beyond(session: &Session, link: usize, pose: usize) -> f64 {
    let chain = &session.robot.chain;
    let of_link = |other: usize| chain.links()[other].inertia.as_ref().map_or(0.0, |inertia| inertia.mass);
    let known = matches!(session.inertia, InertiaPrior::Model { .. });
    let links = (0..chain.link_count()).filter(|other| known && chain.carries(link, *other)).map(of_link).sum::<f64>();
    let load = session.poses[pose].load.map(|load| &session.loads[load]);
    let load = load.filter(|load| !load.is_unknown() && chain.carries(link, load.link));
    links + load.map_or(0.0, |load| load.mass)
}

/// Adds the unknown, from where `start` has it; nothing where lengths are exact, or it is not yet known what they do in motion.
pub(in crate::joint) fn add_unknown(
    session: &Session,
    readings: &MeasurementSet,
    start: &State,
    builder: &mut ProblemBuilder,
) -> Option<JointDisplacements> {
    let std = session.length_std.filter(|_| !session.has_windows() || readings.displaced.is_some())?;
    let links = placed_links(session, readings);
    JointDisplacements::add(session, ("lengths", "m"), (links, &AXES), (std, &start.lengths), builder)
}

impl JointDisplacements {
    /// The residual of a pose of an arm at rest with the unknown lengths around it.
    pub(in crate::joint) fn around(
        &self,
        (session, variables, stored): (&Session, &VariableIndex, &Values),
        pose: usize,
        inner: Arc<dyn Residual>,
    ) -> Arc<dyn Residual> {
        let of_link = |link: &usize| {
            let mass = mass_beyond(session, *link, pose);
            let parent: Option<BlockId> = session.robot.chain.parent(*link).map(|parent| variables.inertia[parent]);
            (0..AXES.len()).filter_map(move |axis| Some(Shift { block: parent?, entry: MOMENT + axis, scale: mass }))
        };
        let shifts: Vec<Shift> = self.links.iter().flat_map(of_link).collect();
        match shifts.iter().all(|shift| shift.scale == 0.0) {
            true => inner,
            false => Arc::new(Shifted::new(inner, |id| stored.get(id).len(), &shifts, self.block)),
        }
    }
}
