//! Joints that are not where the robot's description has them, as unknowns: what is common to lengths (`lengths.rs`) and axes (`axes.rs`).

use std::sync::Arc;

use gravcal_dynamics::Chain;
use gravcal_estimation::{
    Block, BlockId, EvaluateError, Factor, LocalValues, Noise, NoiseError, ProblemBuilder, Residual, Values,
    in_parallel,
};
use gravcal_robot_model::residuals::{Displaced, Prior};
use gravcal_robot_model::session::Session;
use nalgebra::Vector3;

use crate::joint::building::axes::{across, tilted_links};
use crate::joint::building::blocks::add_unknown_blocks;
use crate::joint::building::factors::PoseResiduals;
use crate::joint::building::lengths::{AXES, placed_links};
use crate::joint::measurement_set::{Displacements, Effect, MeasurementSet};
use crate::joint::variables::{JointDisplacements, State, VariableIndex};

/// How far from where they are described joints, and mountings of instruments, are where it is computed what that does, m or rad.
pub(in crate::joint) const STEP: f64 = 1e-3;

impl JointDisplacements {
    /// The unknown of these links' joints, from where `start` has it; nothing where there is none. `name`: the block's name and unit; `numbers`: what the
    /// numbers of each joint are called.
    pub(in crate::joint::building) fn add(
        session: &Session,
        (name, unit): (&str, &'static str),
        (links, numbers): (Vec<usize>, &[&str]),
        (std, start): (f64, &[f64]),
        builder: &mut ProblemBuilder,
    ) -> Option<JointDisplacements> {
        let movers = session.robot.chain.movers();
        let of_link = |link: usize| numbers.iter().map(move |number| format!("{}.{number}", movers[link].name));
        let names: Vec<String> = links.iter().copied().flat_map(of_link).collect();
        if names.is_empty() {
            return None;
        }
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let zeros = vec![0.0; names.len()];
        let start = if start.len() == zeros.len() { start } else { &zeros };
        let block = builder.add_block(Block::vector(name, unit, &names), start);
        Some(JointDisplacements { block, links, each: numbers.len(), std })
    }

    /// Adds what is known of it beforehand.
    pub(in crate::joint) fn add_prior(&self, builder: &mut ProblemBuilder) -> Result<(), NoiseError> {
        let count = self.numbers();
        let prior = Prior::new(self.block, vec![0.0; count]);
        builder.add_factor(Factor::new(prior, Noise::independent(&vec![self.std; count])?));
        Ok(())
    }
}

/// The session's chain with the joint that moves a link a step aside, along each axis of the link that it hangs on.
fn aside(session: &Session, link: usize) -> Vec<Chain> {
    let along = |axis: usize| session.robot.chain.with_joint_aside(link, (STEP * Vector3::ith(axis, 1.0)).into());
    (0..AXES.len()).map(along).collect()
}

/// The same tilted, about two axes across its own.
fn tilted(session: &Session, link: usize) -> Vec<Chain> {
    let chain = &session.robot.chain;
    across(chain, link).map(|axis| chain.with_joint_turned(link, (STEP * axis).into())).into()
}

/// What a unit (m or rad) of the displacement of a joint does to the readings: by link that it moves, and number.
pub(in crate::joint) type OfLinks = Vec<(usize, Vec<Effect>)>;

/// What each displacement does at these values: of places of these links' joints along three axes, and of the axes of those about two.
///
/// # Errors
/// Where a residual has no value there.
pub(in crate::joint) fn effects(
    session: &Session,
    readings: &MeasurementSet,
    state: &State,
    (placed, turned): (Vec<usize>, Vec<usize>),
) -> Result<[OfLinks; 2], EvaluateError> {
    if placed.is_empty() && turned.is_empty() {
        return Ok([Vec::new(), Vec::new()]);
    }
    let readings = MeasurementSet { displaced: None, ..readings.clone() };
    let described = predictions(session, &readings, state, &session.robot.chain)?;
    let of_links = |links: Vec<usize>, displaced: &(dyn Fn(&Session, usize) -> Vec<Chain> + Sync)| {
        let of = |link: usize| {
            let chains = displaced(session, link);
            let effects = chains.iter().map(|chain| effect(session, &readings, state, (chain, &described)));
            Ok((link, effects.collect::<Result<Vec<_>, _>>()?))
        };
        in_parallel(links, of).into_iter().collect::<Result<OfLinks, EvaluateError>>()
    };
    Ok([of_links(placed, &aside)?, of_links(turned, &tilted)?])
}

/// What a chain that is a step away reads more, for each unit; by pose and channel.
fn effect(
    session: &Session,
    readings: &MeasurementSet,
    state: &State,
    (chain, described): (&Chain, &[Vec<f64>]),
) -> Result<Effect, EvaluateError> {
    let there = predictions(session, readings, state, chain)?;
    let of_pose = |(there, here): (&Vec<f64>, &Vec<f64>)| {
        there.iter().zip(here).map(|(there, here)| (there - here) / STEP).collect()
    };
    Ok(there.iter().zip(described).map(of_pose).collect())
}

/// Residuals of the readings that enter, at these values and of this chain, by pose and channel; zero of those that do not enter.
pub(in crate::joint) fn predictions(
    session: &Session,
    readings: &MeasurementSet,
    state: &State,
    chain: &Chain,
) -> Result<Vec<Vec<f64>>, EvaluateError> {
    let mut builder = ProblemBuilder::new();
    let variables = add_unknown_blocks(session, readings, state, &mut builder);
    let values = builder.initial();
    let mut residuals = PoseResiduals::new(session, &variables, chain.clone(), None, values.clone());
    let mut all = vec![vec![0.0; session.channel_count()]; readings.used.len()];
    for (pose, used) in readings.used.iter().enumerate().filter(|(_, used)| !used.is_empty()) {
        let own = at(&values, &*residuals.of(pose, used, &builder))?;
        used.iter().zip(own).for_each(|(channel, own)| all[pose][*channel] = own);
    }
    Ok(all)
}

/// A residual's values.
fn at(values: &Values, residual: &dyn Residual) -> Result<Vec<f64>, EvaluateError> {
    let (mut local, mut starts) = (Vec::new(), vec![0]);
    for id in residual.blocks() {
        local.extend_from_slice(values.get(*id));
        starts.push(local.len());
    }
    let mut own = vec![0.0; residual.len()];
    residual.evaluate(LocalValues::new(&local, &starts), &mut own, None)?;
    Ok(own)
}

impl MeasurementSet {
    /// The same with what displacements of joints do to them at these values, where the session says how well joints' places in motion, or their axes, are known.
    ///
    /// # Errors
    /// Where a residual has no value there.
    pub(crate) fn with_displacements(&self, session: &Session, state: &State) -> Result<MeasurementSet, EvaluateError> {
        let placed = session.length_std.filter(|_| session.has_windows()).map(|_| placed_links(session, self));
        let turned = session.axis_std.map(|_| tilted_links(session));
        if placed.is_none() && turned.is_none() {
            return Ok(self.clone());
        }
        let links = (placed.unwrap_or_default(), turned.unwrap_or_default());
        let [aside, tilted] = effects(session, self, state, links)?;
        let by_number = aside.into_iter().chain(tilted).flat_map(|(_, numbers)| numbers).collect();
        Ok(MeasurementSet { displaced: Some(Arc::new(Displacements { by_number })), ..self.clone() })
    }
}

impl Displacements {
    /// The residual of a pose with the unknowns around it; itself where a problem has none, as that of a start.
    pub(in crate::joint::building) fn around(
        &self,
        (session, variables, stored): (&Session, &VariableIndex, &Values),
        (pose, used): (usize, &[usize]),
        described: Arc<dyn Residual>,
    ) -> Arc<dyn Residual> {
        let lengths = variables.lengths.iter().filter(|_| session.has_windows());
        let blocks: Vec<BlockId> = lengths.chain(&variables.axes).map(|unknown| unknown.block).collect();
        if blocks.is_empty() {
            return described;
        }
        let column = |number: &Effect| used.iter().map(|channel| number[pose][*channel]).collect();
        let columns: Vec<Vec<f64>> = self.by_number.iter().map(column).collect();
        Arc::new(Displaced::new(described, &columns, |id| stored.get(id).len(), &blocks))
    }
}
