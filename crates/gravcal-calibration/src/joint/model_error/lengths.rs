//! Where joints sit: what a length that is wrong does to the readings, and what these tell of lengths that are unknowns.
//!
//! A joint that sits aside by `δ` moves the first moment of the link that it hangs on, times the mass beyond it (`building/lengths.rs`).

use gravcal_estimation::{EvaluateError, in_parallel};
use gravcal_robot_model::number::measured;
use gravcal_robot_model::session::Session;

use crate::joint::building::lengths::{mass_beyond, placed_links};
use crate::joint::solved::Solved;
use crate::joint::variables::AXES;

/// Step of a first moment, kg·m: what readings are of is linear in it.
const STEP: f64 = 1.0;
/// A length is told where its standard deviation is a smaller share of what was known of it.
const TOLD: f64 = 0.5;

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
        if session.has_windows() {
            return self.joint_placements_in_motion(session);
        }
        let links = if session.length_std.is_some() { Vec::new() } else { placed_links(session, self.readings()) };
        let here = self.built.problem.residuals(&self.estimate.values)?;
        let of = |link: usize| {
            let carried = self.built.rows.iter().map(|id| mass_beyond(session, link, id.pose));
            let parent = session.robot.chain.parent(link).unwrap_or_default();
            Ok(JointPlacement { link, columns: self.aside((parent, &carried.collect::<Vec<_>>()), &here)? })
        };
        in_parallel(links, of).into_iter().collect()
    }

    fn joint_placements_in_motion(&self, session: &Session) -> Result<Vec<JointPlacement>, EvaluateError> {
        let chain = &session.robot.chain;
        let of = |link: usize| {
            let along = |axis: usize| {
                move |metres: f64| {
                    chain.with_joint_aside(link, std::array::from_fn(|own| f64::from(own == axis) * metres))
                }
            };
            let columns = self.by_changes_of_chain(session, [&along(0), &along(1), &along(2)])?;
            Ok(JointPlacement { link, columns })
        };
        let known = !self.built.variables.inertia.is_empty();
        let links = (0..chain.link_count()).filter(|link| known && chain.parent(*link).is_some());
        in_parallel(links.collect::<Vec<_>>(), of).into_iter().collect()
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
            let (link, std) = (lengths.link_of(number), covariance.std(column));
            let parent = chain.links()[chain.parent(link)?].name.as_str();
            (std < TOLD * lengths.std).then(|| {
                let axis = ["x", "y", "z"][number % AXES];
                let (found, std) = measured(1e3 * found, 1e3 * std);
                format!("{} by {found} ± {std} mm along {axis} of {parent}", chain.movers()[link].name)
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
}
