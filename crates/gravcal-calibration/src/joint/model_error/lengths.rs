//! What lengths that are taken as exact do to numbers.
//!
//! A joint that sits aside by `δ` moves the first moment of the link that it hangs on, times the mass beyond it (`building/lengths.rs`). Much of it passes
//! for torque gains and offsets of position sensors, and nothing of it is left in residuals: who trusts lengths should know what hangs on them.

use gravcal_estimation::statistics::{Solution, StatisticsError, moved_by};
use gravcal_estimation::{EvaluateError, in_parallel};
use gravcal_robot_model::number::significant;
use gravcal_robot_model::parameter::ParameterId;
use gravcal_robot_model::session::Session;

use crate::joint::building::lengths::{mass_beyond, placed_links};
use crate::joint::solved::Solved;

/// Step of a first moment, kg·m: what readings are of is linear in it.
const STEP: f64 = 1.0;
/// How far joints sit from where a description says that nobody has measured, m, for the remark on what this would do.
const UNSAID: f64 = 1e-3;
/// A length is told where its standard deviation is a smaller share of what was known of it.
const TOLD: f64 = 0.5;
/// By how many of its standard deviations such lengths move a number that is worth a remark.
const REMARKABLE: f64 = 1.0;

/// A joint that hangs on another link than the base.
#[derive(Clone, Debug)]
pub(crate) struct JointPlacement {
    /// The link that it moves.
    pub link: usize,
    /// What a metre does to the whitened residuals of the problem that is judged, along each axis of the link that it hangs on.
    pub columns: Vec<Vec<f64>>,
}

impl Solved {
    /// Those whose place makes a difference, where lengths are taken as exact.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated beside the solution.
    pub(crate) fn joint_placements(&self, session: &Session) -> Result<Vec<JointPlacement>, EvaluateError> {
        let links = if session.length_std.is_some() { Vec::new() } else { placed_links(session, self.readings()) };
        let here = self.built.problem.residuals(&self.estimate.values)?;
        let of = |link: usize| {
            let carried = self.built.rows.iter().map(|id| mass_beyond(session, link, id.pose));
            let parent = session.robot.chain.parent(link).unwrap_or_default();
            Ok(JointPlacement { link, columns: self.aside((parent, &carried.collect::<Vec<_>>()), &here)? })
        };
        in_parallel(links, of).into_iter().collect()
    }

    /// What a metre along each axis of a link does; `carried`: the mass that is moved, by row, kg.
    fn aside(&self, (link, carried): (usize, &[f64]), here: &[f64]) -> Result<Vec<Vec<f64>>, EvaluateError> {
        let block = self.built.variables.inertia[link];
        let along = |axis: usize| {
            let mut values = self.estimate.values.clone();
            let mut body = values.get(block).to_vec();
            body[1 + axis] += STEP;
            values.set(block, &body);
            let there = self.built.problem.residuals(&values)?;
            let slopes = there.iter().zip(here).map(|(there, here)| (there - here) / STEP);
            let mut column: Vec<f64> = slopes.zip(carried).map(|(slope, mass)| mass * slope).collect();
            column.resize(self.judged_problem().rows(), 0.0);
            Ok(column)
        };
        Ok(vec![along(0)?, along(1)?, along(2)?])
    }

    /// Says where joints sit, as far as readings tell more of it than was known; nothing where lengths are exact.
    pub(in crate::joint) fn lengths_found(&self, session: &Session) -> Option<String> {
        let lengths = self.built.variables.lengths.as_ref()?;
        let (chain, covariance) = (&session.robot.chain, self.covariance());
        let columns = self.judged_problem().columns_of(lengths.block);
        let numbers = columns.zip(self.estimate.values.get(lengths.block)).enumerate();
        let told = |(number, (column, found)): (usize, (usize, &f64))| {
            let (link, std) = (lengths.links[number / 3], covariance.std(column));
            let parent = chain.links()[chain.parent(link)?].name.as_str();
            let [found, digits] = [1e3 * found, 1e3 * std];
            (std < TOLD * lengths.std).then(|| {
                let axis = ["x", "y", "z"][number % 3];
                format!("{} by {found:.2} ± {digits:.2} mm along {axis} of {parent}", chain.movers()[link].name)
            })
        };
        let told: Vec<String> = numbers.filter_map(told).collect();
        (!told.is_empty()).then(|| {
            format!(
                "The readings tell how far joints sit from where the robot's description has them: {}.",
                told.join(", ")
            )
        })
    }

    /// Says which number hangs on lengths most, where these are taken as exact and it hangs on them much. `self`: with its standard deviations as told.
    pub(in crate::joint) fn numbers_that_hang_on_lengths(
        &self,
        session: &Session,
    ) -> Result<Option<String>, StatisticsError> {
        let placements = self.joint_placements(session)?;
        if placements.is_empty() || !self.estimate.termination.converged() {
            return Ok(None);
        }
        let aside = |column: &Vec<f64>| column.iter().map(|entry| UNSAID * entry).collect::<Vec<f64>>();
        let missing: Vec<Vec<f64>> = placements.iter().flat_map(|placed| &placed.columns).map(aside).collect();
        let solution =
            Solution { problem: self.judged_problem(), values: &self.estimate.values, analysis: &self.analysis };
        let moved = moved_by(&solution, &missing)?;
        let off = |id: ParameterId| {
            let column = self.judged_problem().columns_of(self.built.variables.block(id)).next()?;
            let std = self.covariance().std(column);
            let by = moved.iter().map(|moved| moved[column] * moved[column]).sum::<f64>().sqrt();
            (std > 0.0).then_some((id, by / std))
        };
        let most = session.parameters().into_iter().filter_map(off).max_by(|a, b| a.1.total_cmp(&b.1));
        Ok(most.filter(|(_, times)| *times > REMARKABLE && times.is_finite()).map(|(id, times)| {
            format!(
                "Lengths of the robot are taken as exact. Were each joint {} mm from where the robot's description has it, {} would be {} of its standard \
                 deviations off, and residuals need not show it. Say how well lengths are known, and intervals include it: [inertia] length_std_m.",
                significant(1e3 * UNSAID, 1),
                session.parameter_name(id),
                significant(times, 2)
            )
        }))
    }
}
