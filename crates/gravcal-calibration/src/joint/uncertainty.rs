//! Where the standard deviations of a solved joint problem come from, as the session chooses.
//!
//! The samples are the poses: a block is some neighbouring ones, of all joints. Priors, known lengths and the like are
//! knowledge, and keep their stated noise. Noise that was estimated from the residuals stays as it was found while poses
//! are drawn anew.

use gravcal_estimation::statistics::{Bootstrap, NoiseKnowledge, Resampling, SampleBlocks, Solution, Uncertainty};
use gravcal_estimation::{Loss, Spectrum};

use super::EstimateError;
use super::solve::Solved;
use crate::result::{NoiseSource, UncertaintyResult};
use crate::session::{Session, UncertaintyChoice};
use crate::workbench::Workbench;

impl Solved {
    pub(super) fn solution(&self) -> Solution<'_> {
        Solution { problem: self.judged_problem(), values: &self.estimate.values, spectrum: &self.spectrum }
    }

    /// The uncertainty that the session chooses, and what to say of it. `misfit`: how many times worse than their stated
    /// noise the readings are explained, where that is no accident.
    pub(super) fn chosen_uncertainty(
        &self,
        session: &Session,
        misfit: Option<f64>,
        workbench: &Workbench<'_>,
    ) -> Result<(Uncertainty, UncertaintyResult), EstimateError> {
        let blocks = |block_poses| SampleBlocks::new(0..self.posed.poses, block_poses);
        match session.uncertainty {
            // Only at a minimum do blocks scatter about zero; an estimate that is none has failed anyway.
            _ if !self.estimate.termination.converged() => self.noise_uncertainty(session, misfit),
            UncertaintyChoice::Noise => self.noise_uncertainty(session, misfit),
            UncertaintyChoice::Sandwich { block_poses } => {
                let blocks = blocks(block_poses)?;
                let told = UncertaintyResult::Sandwich { blocks: blocks.count(), block_poses };
                Ok((Uncertainty::sandwich(&self.solution(), &blocks)?, told))
            }
            UncertaintyChoice::Bootstrap { block_poses, replicates, seed } => {
                workbench.tell("judging by bootstrap");
                let blocks = blocks(block_poses)?;
                let resampling = Resampling { blocks: &blocks, replicates, seed, held: &[] };
                // Replicates obey the constraints by themselves, and need not lean on the same ones.
                let (problem, values) = (&self.posed.problem, &self.estimate.values);
                let solution = Solution { problem, values, spectrum: &Spectrum::new(problem, values)? };
                let drawn = Bootstrap::new(&solution, &resampling, workbench.solver())?;
                let told = UncertaintyResult::Bootstrap {
                    blocks: blocks.count(),
                    block_poses,
                    replicates: drawn.replicates,
                    not_converged: drawn.not_converged,
                    undetermined: drawn.undetermined,
                };
                Ok((drawn.uncertainty, told))
            }
        }
    }

    /// A loss takes the size of the noise from the residuals by itself, so that nothing needs to be widened.
    fn noise_uncertainty(
        &self,
        session: &Session,
        misfit: Option<f64>,
    ) -> Result<(Uncertainty, UncertaintyResult), EstimateError> {
        let estimated = self.readings.noise_found(session);
        let robust = self.posed.loss != Loss::None;
        let widened_by = misfit.filter(|_| !robust);
        let knowledge = match (widened_by, estimated) {
            (Some(_), _) => NoiseKnowledge::Relative,
            (None, true) => NoiseKnowledge::Found,
            (None, false) => NoiseKnowledge::Stated,
        };
        let source = match (session.noise_estimated().contains(&true) || robust, estimated) {
            (true, _) => NoiseSource::Residuals,
            (false, true) => NoiseSource::StatedAndUnexplained,
            (false, false) => NoiseSource::Stated,
        };
        let uncertainty = Uncertainty::from_noise(&self.solution(), knowledge)?;
        Ok((uncertainty, UncertaintyResult::Noise { source, widened_by }))
    }
}
