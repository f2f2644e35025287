//! Joints that are not where the robot's description has them, aside or tilted: what that does to the readings, and what these tell of it where it is
//! an unknown.
//!
//! What it does is computed as it is for these unknowns (`building/displacements.rs`).

use std::sync::Arc;

use gravcal_estimation::EvaluateError;
use gravcal_robot_model::number::{measured, significant};
use gravcal_robot_model::session::{ReadingId, Session};

use crate::joint::building::axes::{across, tilted_links};
use crate::joint::building::displacements::effects;
use crate::joint::building::lengths::{AXES, placed_links};
use crate::joint::measurement_set::{Displacements, Effect};
use crate::joint::solved::Solved;
use crate::joint::variables::{JointDisplacements, State};

/// A displacement is told where its standard deviation is a smaller share of what was known of it.
const TOLD: f64 = 0.5;
/// What a reading may be off by where displacements do a little more or less than was taken, standard deviations.
const SETTLED: f64 = 0.01;

/// What displacements of a joint do.
#[derive(Clone, Debug)]
pub(crate) struct DisplacedJoint {
    /// The link that it moves.
    pub link: usize,
    /// What a metre, along each axis of the link that it hangs on, or a radian, about two axes across its own, does to the whitened residuals of the problem
    /// that is judged.
    pub columns: Vec<Vec<f64>>,
}

/// Those of all joints whose place, or whose axis, is taken as exact.
#[derive(Clone, Debug)]
pub(crate) struct DisplacedJoints {
    pub aside: Vec<DisplacedJoint>,
    pub tilted: Vec<DisplacedJoint>,
}

impl Solved {
    /// What each displacement would do that is taken as exact. None where moments are described by sweep; of those aside, where no known mass would show it.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated at the solution.
    pub(crate) fn displaced_joints(&self, session: &Session) -> Result<DisplacedJoints, EvaluateError> {
        let placed = if session.length_std.is_some() { Vec::new() } else { placed_links(session, self.readings()) };
        let turned = if session.axis_std.is_some() { Vec::new() } else { tilted_links(session) };
        let state = self.state(&State::nominal(session));
        let [aside, tilted] = effects(session, self.readings(), &state, (placed, turned))?;
        let column = |effect: Effect| self.whitened(session, |id| effect[id.pose][id.channel]);
        let of = |(link, effects): (usize, Vec<Effect>)| DisplacedJoint {
            link,
            columns: effects.into_iter().map(column).collect(),
        };
        Ok(DisplacedJoints { aside: aside.into_iter().map(of).collect(), tilted: tilted.into_iter().map(of).collect() })
    }

    /// What changes the readings by so much, unit of each, as a column of the problem that is judged.
    pub(crate) fn whitened(&self, session: &Session, by: impl Fn(ReadingId) -> f64) -> Vec<f64> {
        let of_row = |id: &ReadingId| by(*id) / self.readings().std(session, *id);
        let mut column: Vec<f64> = self.built.rows.iter().map(of_row).collect();
        column.resize(self.judged_problem().rows(), 0.0);
        column
    }

    /// What displacements of joints do at its values, where that is an unknown and moves a reading by more than [`SETTLED`] from what it took it for.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated at the solution.
    pub(in crate::joint) fn displaced_anew(
        &self,
        session: &Session,
    ) -> Result<Option<Arc<Displacements>>, EvaluateError> {
        if !self.estimate.termination.converged() {
            return Ok(None);
        }
        let readings = self.readings().with_displacements(session, &self.state(&State::nominal(session)))?;
        let (Some(before), Some(now)) = (&self.readings().displaced, &readings.displaced) else {
            return Ok(readings.displaced);
        };
        let unknowns = self.built.variables.lengths.iter().filter(|_| session.has_windows());
        let unknowns = unknowns.chain(&self.built.variables.axes);
        let found: Vec<f64> = unknowns.flat_map(|unknown| self.estimate.values.get(unknown.block)).copied().collect();
        let numbers = || found.iter().zip(before.by_number.iter().zip(&now.by_number));
        let moved = |id: &ReadingId| {
            let of_number = |(found, (before, now)): (&f64, (&Effect, &Effect))| {
                found * (now[id.pose][id.channel] - before[id.pose][id.channel])
            };
            numbers().map(of_number).sum::<f64>().abs() / self.readings().std(session, *id)
        };
        let settled = self.built.rows.iter().all(|id| moved(id) < SETTLED);
        Ok(readings.displaced.filter(|_| !settled))
    }

    /// Says where joints sit, as far as readings tell more of it than was known; nothing where lengths are exact.
    pub(in crate::joint) fn lengths_found(&self, session: &Session) -> Option<String> {
        let (chain, lengths) = (&session.robot.chain, self.built.variables.lengths.as_ref()?);
        let aside = |Told { link, number, found, std }: &Told| {
            let parent = chain.links()[chain.parent(*link)?].name.as_str();
            let (found, std) = measured(1e3 * found, 1e3 * std);
            Some(format!("{} by {found} ± {std} mm along {} of {parent}", chain.movers()[*link].name, AXES[*number]))
        };
        let told: Vec<String> = self.displacements_told(lengths).iter().filter_map(aside).collect();
        let list = told.join(", ");
        (!told.is_empty()).then(|| {
            format!("The readings tell how far joints sit from where the robot's description has them: {list}.")
        })
    }

    /// Says how far axes are tilted, as far as readings tell more of it than was known; nothing where axes are exact.
    pub(in crate::joint) fn tilts_found(&self, session: &Session) -> Option<String> {
        let (chain, axes) = (&session.robot.chain, self.built.variables.axes.as_ref()?);
        let tilted = |Told { link, number, found, std }: &Told| {
            let about: Vec<String> = across(chain, *link)[*number].iter().map(|one| significant(*one, 2)).collect();
            let (found, std) = measured(found.to_degrees(), std.to_degrees());
            let name = &chain.movers()[*link].name;
            format!("{name} by {found} ± {std}° about ({}) of its frame", about.join(", "))
        };
        let told: Vec<String> = self.displacements_told(axes).iter().map(tilted).collect();
        let list = told.join(", ");
        (!told.is_empty())
            .then(|| format!("The readings tell how far axes are tilted against the robot's description: {list}."))
    }

    /// The numbers that readings tell more of than was known.
    fn displacements_told(&self, unknown: &JointDisplacements) -> Vec<Told> {
        let covariance = self.covariance();
        let columns = self.judged_problem().columns_of(unknown.block);
        let numbers = columns.zip(self.estimate.values.get(unknown.block)).enumerate();
        let told = |(number, (column, found)): (usize, (usize, &f64))| {
            let (link, number) = unknown.link_of(number);
            Told { link, number, found: *found, std: covariance.std(column) }
        };
        numbers.map(told).filter(|told| told.std < TOLD * unknown.std).collect()
    }
}

/// One number of a joint's displacement, m or rad.
struct Told {
    link: usize,
    number: usize,
    found: f64,
    std: f64,
}
