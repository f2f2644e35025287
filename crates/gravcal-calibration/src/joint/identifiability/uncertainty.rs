//! Where the standard deviations of a solved joint problem come from, as the session chooses.
//!
//! The samples are the poses: a block is some neighbouring ones, of all joints. Priors, known lengths and the like are
//! knowledge, and keep their stated noise. Noise that was estimated from the residuals stays as it was found while poses
//! are drawn anew.

use gravcal_estimation::statistics::{
    Bootstrap, DeterminedByOneBlock, Jackknife, NoiseScale, Resampling, SampleBlocks, Solution, StatisticsError,
    Uncertainty, larger_for_fewer,
};
use gravcal_estimation::{BlockId, Loss, RankAnalysis};
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{PoseBlocks, Session, UncertaintyChoice};

use crate::joint::error::EstimateError;
use crate::joint::identifiability::pose_blocks::BlocksOfPoses;
use crate::joint::solved::Solved;
use crate::joint::solving::noise::NoisesFound;
use crate::result::{JackknifeResult, NoiseSource, UncertaintyResult};

/// Fewer poses do not tell by themselves what an error of the model does.
const FEWEST_POSES: usize = 14;
/// Degrees of freedom from which on a standard deviation that was estimated with them says something: Student's t has a variance from here on.
pub(in crate::joint) const LEAST_FREEDOM: usize = 3;
/// Share of a variance along what one block alone tells from which on that is worth a word.
const ALONE_SHARE: f64 = 0.01;

impl Solved {
    pub(in crate::joint) fn solution(&self) -> Solution<'_> {
        Solution { problem: self.judged_problem(), values: &self.estimate.values, analysis: &self.analysis }
    }

    /// The uncertainty that the session chooses, and what to say of it. `misfit`: how many times worse than their stated
    /// noise the readings are explained, where that is no accident; `errs_by_pose`: whether they err from pose to pose by more than noise.
    pub(in crate::joint) fn chosen_uncertainty(
        &self,
        session: &Session,
        misfit: Option<f64>,
        errs_by_pose: bool,
        environment: &SolveEnvironment<'_>,
    ) -> Result<(Uncertainty, UncertaintyResult), EstimateError> {
        let blocks = |block_poses| SampleBlocks::new(0..self.built.poses, block_poses);
        match session.uncertainty {
            // Only at a minimum do blocks scatter about zero; an estimate that is none has failed anyway.
            _ if !self.estimate.termination.converged() => self.noise_uncertainty(session, misfit, errs_by_pose),
            UncertaintyChoice::Noise => self.noise_uncertainty(session, misfit, errs_by_pose),
            UncertaintyChoice::Jackknife { blocks } => {
                let (uncertainty, reported) = self.jackknife(session, blocks)?;
                // Errors of curves are no noise, and blocks of them scatter less than they are off.
                let uncertainty = match self.is_as_exact_as_curves(session) {
                    true => uncertainty.larger_of(Uncertainty::from_noise(&self.solution(), NoiseScale::Stated)?),
                    false => uncertainty,
                };
                Ok((uncertainty, UncertaintyResult::Jackknife(reported)))
            }
            UncertaintyChoice::Sandwich { block_poses } => {
                let blocks = blocks(block_poses)?;
                let reported = UncertaintyResult::Sandwich { blocks: blocks.count(), block_poses };
                Ok((Uncertainty::sandwich(&self.solution(), &blocks)?, reported))
            }
            UncertaintyChoice::Bootstrap { block_poses, replicates, seed } => {
                environment.report("judging by bootstrap");
                let blocks = blocks(block_poses)?;
                let resampling = Resampling { blocks: &blocks, replicates, seed, fixed: &[] };
                // Replicates obey the constraints by themselves, and need not lean on the same ones.
                let (problem, values) = (&self.built.problem, &self.estimate.values);
                let solution = Solution { problem, values, analysis: &RankAnalysis::new(problem, values)? };
                let drawn = Bootstrap::new(&solution, &resampling, environment.solver())?;
                let reported = UncertaintyResult::Bootstrap {
                    blocks: blocks.count(),
                    block_poses,
                    replicates: drawn.replicates,
                    not_converged: drawn.not_converged,
                    undetermined: drawn.undetermined,
                };
                Ok((drawn.uncertainty, reported))
            }
        }
    }

    /// A loss takes the size of the noise from the residuals by itself, so that nothing needs to be widened.
    fn noise_uncertainty(
        &self,
        session: &Session,
        misfit: Option<f64>,
        errs_by_pose: bool,
    ) -> Result<(Uncertainty, UncertaintyResult), EstimateError> {
        // What nothing tells the size of is not told: `undetermined.rs` says so.
        let estimated = self.readings().noise_found(session) && self.freedom_of_noise(session).is_none();
        let robust = self.built.loss != Loss::None;
        let widened_by = misfit.filter(|_| !robust);
        let noises = if estimated { Some(self.noises_found(session)?) } else { None };
        let noise_scale = match (widened_by, &noises) {
            (_, Some(noises)) => NoiseScale::Found { noises: noises.count },
            (Some(_), None) => NoiseScale::Relative,
            (None, None) => NoiseScale::Stated,
        };
        let source = match (session.noise_estimated().contains(&true) || robust, estimated) {
            (true, _) => NoiseSource::Residuals,
            (false, true) => NoiseSource::StatedAndUnexplained,
            (false, false) => NoiseSource::Stated,
        };
        let uncertainty = Uncertainty::from_noise(&self.solution(), noise_scale)?;
        // Where only some channels state their noise, χ² of all says nothing of theirs.
        let uncertainty = match widened_by.filter(|_| estimated) {
            Some(factor) => uncertainty.widened(&vec![factor; self.judged_problem().columns().len()]),
            None => uncertainty,
        };
        let uncertainty = match &noises {
            Some(noises) => uncertainty.widened(&self.fewer_degrees_of_freedom(session, noises)),
            None => uncertainty,
        };
        let by_noise = UncertaintyResult::Noise { source, widened_by };
        let errs = misfit.is_some() || errs_by_pose || self.shows_unexplained(session)?;
        if !errs || !self.may_leave_out_poses() {
            return Ok((uncertainty, by_noise));
        }
        let (left_out, jackknife) = match self.jackknife(session, PoseBlocks::Found) {
            // A loss that forgives most of what contradicts the model leaves no minimum to leave out anything from.
            Err(EstimateError::Statistics(StatisticsError::NotConvex)) => return Ok((uncertainty, by_noise)),
            jackknife => jackknife?,
        };
        let reported = UncertaintyResult::LargerOfNoiseAndJackknife { source, widened_by, jackknife };
        Ok((uncertainty.larger_of(left_out), reported))
    }

    /// Whether readings show errors beyond their noise: larger than chance makes them, or alike in neighbouring poses. What leaving out poses tells
    /// scatters, and the larger of two is too wide where nothing shows.
    fn shows_unexplained(&self, session: &Session) -> Result<bool, EstimateError> {
        let readings = self.readings();
        if !readings.unexplained_found(session) {
            return Ok(false);
        }
        if readings.loss != Loss::None || readings.lasting.is_some() || self.residuals_exceed_noise(session)? {
            return Ok(true);
        }
        Ok(self.neighbours_correlation(session)? > 0.0)
    }

    /// By what the standard deviation of each column is larger that rests on one joint's noise, where this has fewer degrees of freedom than
    /// noises have on the average: gain, bias and models of the joint's torque sensor.
    fn fewer_degrees_of_freedom(&self, session: &Session, noises: &NoisesFound) -> Vec<f64> {
        let mut factors = vec![1.0; self.judged_problem().columns().len()];
        let common = self.freedom() as f64 / noises.count.max(1.0);
        for id in session.parameters() {
            let joint = match id {
                ParameterId::Sensor(joint, SensorParameter::TorqueGain | SensorParameter::TorqueBias) => Some(joint),
                ParameterId::Sensor(..) => None,
                ParameterId::Further(place) => {
                    session.terms.site(place).filter(|(_, torque)| *torque).map(|site| site.0)
                }
            };
            let Some(own) = joint.and_then(|joint| noises.of_channels[joint]) else { continue };
            let factor = larger_for_fewer(own, common);
            self.judged_problem()
                .columns_of(self.built.variables.block(id))
                .for_each(|column| factors[column] = factor);
        }
        factors
    }

    /// Degrees of freedom that are left to tell the noise, where it is to be found from them and they are too few for that.
    pub(in crate::joint) fn freedom_of_noise(&self, session: &Session) -> Option<usize> {
        (self.readings().noise_found(session) && self.freedom() < LEAST_FREEDOM).then_some(self.freedom())
    }

    /// Degrees of freedom from which the noise was found, where no reading states it.
    pub(in crate::joint) fn freedom_of_found_noise(&self, session: &Session) -> Option<f64> {
        (self.readings().noise_found(session) && self.freedom() > 0).then_some(self.freedom() as f64)
    }

    pub(in crate::joint) fn freedom(&self) -> usize {
        self.judged_problem().rows().saturating_sub(self.analysis.rank())
    }

    /// Whether leaving out poses tells anything: there are enough, and the estimate is that of all of them together.
    pub(in crate::joint) fn may_leave_out_poses(&self) -> bool {
        self.is_minimum_of_all() && self.built.poses >= FEWEST_POSES
    }

    /// What the estimate without each of some blocks of poses tells, and what to say of it.
    pub(in crate::joint) fn jackknife(
        &self,
        session: &Session,
        choice: PoseBlocks,
    ) -> Result<(Uncertainty, JackknifeResult), EstimateError> {
        let BlocksOfPoses { blocks, correlation, too_short_for } = self.blocks(session, choice)?;
        let Jackknife { uncertainty, alone } = Uncertainty::jackknife(&self.solution(), &blocks)?;
        let lengths = || blocks.iter().map(|block| block.len());
        let reported = JackknifeResult {
            correlated_blocks: self.correlated_blocks(session, &blocks)?,
            blocks: blocks.count(),
            block_poses: [lengths().min().unwrap_or(0), lengths().max().unwrap_or(0)],
            correlation,
            too_short_for,
            told_by_one_block: self.told_by_one_block(session, &alone),
        };
        Ok((uncertainty, reported))
    }

    /// What was asked for of which single blocks tell more than [`ALONE_SHARE`] of its variance.
    fn told_by_one_block(&self, session: &Session, alone: &[DeterminedByOneBlock]) -> Vec<String> {
        let noise = self.analysis.covariance();
        let share = |column: usize| {
            let along: f64 = alone.iter().map(|reported| reported.step[column].powi(2)).sum();
            along > ALONE_SHARE * noise.at(column, column)
        };
        let reported = |block: BlockId| self.built.problem.columns_of(block).any(share);
        let variables = &self.built.variables;
        let asked = session.parameters().into_iter().filter(|id| session.asks(&session.parameter_name(*id)));
        let gravity = (session.asks("gravity") && reported(variables.gravity)).then(|| "gravity".to_owned());
        let parameters = asked.filter(|id| reported(variables.block(*id))).map(|id| session.parameter_name(id));
        gravity.into_iter().chain(parameters).collect()
    }
}
