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

use std::sync::Arc;

use gravcal_estimation::{Block, BlockId, Factor, Noise, NoiseError, ProblemBuilder, Residual, Values};
use gravcal_robot_model::residuals::{Prior, Shift, Shifted};
use gravcal_robot_model::session::{InertiaPrior, Session};

use crate::joint::building::sweep_moments::by_sweep;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::variables::{AXES, Lengths, State, VariableIndex};

/// First entry of the first moment in a link's block.
const MOMENT: usize = 1;

/// The links whose joint hangs on another link, and whose place makes a difference to a reading that enters. None where the arm moves, and where
/// moments are described by sweep, which asks for no lengths.
pub(in crate::joint) fn placed_links(session: &Session, readings: &MeasurementSet) -> Vec<usize> {
    if session.has_windows() || by_sweep(session) {
        return Vec::new();
    }
    let chain = &session.robot.chain;
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

/// Adds the unknown, from where `start` has it; nothing where lengths are exact.
pub(in crate::joint) fn add_unknown(
    session: &Session,
    readings: &MeasurementSet,
    start: &State,
    builder: &mut ProblemBuilder,
) -> Option<Lengths> {
    let std = session.length_std?;
    let links = placed_links(session, readings);
    let movers = session.robot.chain.movers();
    let names: Vec<String> =
        links.iter().flat_map(|link| ["x", "y", "z"].map(|axis| format!("{}.{axis}", movers[*link].name))).collect();
    if names.is_empty() {
        return None;
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let zeros = vec![0.0; names.len()];
    let start = if start.lengths.len() == zeros.len() { &start.lengths } else { &zeros };
    let block = builder.add_block(Block::vector("lengths", "m", &names), start);
    Some(Lengths { block, links, std })
}

impl Lengths {
    /// Adds what is known of it beforehand.
    pub(in crate::joint) fn add_prior(&self, builder: &mut ProblemBuilder) -> Result<(), NoiseError> {
        let count = self.numbers();
        let prior = Prior::new(self.block, vec![0.0; count]);
        builder.add_factor(Factor::new(prior, Noise::independent(&vec![self.std; count])?));
        Ok(())
    }

    /// The residual of a pose with the unknown around it.
    pub(in crate::joint) fn around(
        &self,
        (session, variables, stored): (&Session, &VariableIndex, &Values),
        pose: usize,
        inner: Arc<dyn Residual>,
    ) -> Arc<dyn Residual> {
        let of_link = |link: &usize| {
            let mass = mass_beyond(session, *link, pose);
            let parent: Option<BlockId> = session.robot.chain.parent(*link).map(|parent| variables.inertia[parent]);
            (0..AXES).filter_map(move |axis| Some(Shift { block: parent?, entry: MOMENT + axis, scale: mass }))
        };
        let shifts: Vec<Shift> = self.links.iter().flat_map(of_link).collect();
        match shifts.iter().all(|shift| shift.scale == 0.0) {
            true => inner,
            false => Arc::new(Shifted::new(inner, |id| stored.get(id).len(), &shifts, self.block)),
        }
    }
}
