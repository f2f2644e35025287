//! Noise that was found from residuals of which few are many times as large as all others: these are no noise.
//!
//! A load that some rows do not carry, spikes and wrong cells make the standard deviation many times what the median of the residuals says
//! (`1.48 median |r|`, the same for a normal distribution). They weigh with all others then, and shift what they pull at.

use gravcal_estimation::{EvaluateError, Loss};
use gravcal_robot_model::session::{ReadingId, Session};

use crate::joint::solved::Solved;

/// From this ratio of the two on readings are of two kinds: beside a normal distribution the squares of few make up eight ninths of all.
const OF_TWO_KINDS: f64 = 3.0;
/// Fewer readings tell no tails.
const FEWEST: usize = 30;
/// Median deviations from which a reading is far off.
const FAR: f64 = 6.0;

/// Readings of two kinds.
pub(in crate::joint) struct HeavyTails {
    /// Each channel that has them, with the rms of its residuals and what that usually is, in its unit.
    pub channels: Vec<(usize, [f64; 2])>,
    /// Poses in which one is far off, the farthest first.
    pub poses: Vec<usize>,
}

impl Solved {
    /// Nothing where there are none; of an arm in motion, and under a loss, none are looked for.
    ///
    /// # Errors
    /// Where the model has no finite value at the solution.
    pub(in crate::joint) fn heavy_tails(&self, session: &Session) -> Result<Option<HeavyTails>, EvaluateError> {
        if self.built.loss != Loss::None || session.has_windows() || !self.estimate.termination.converged() {
            return Ok(None);
        }
        let rows = self.row_residuals()?;
        let (usual, found) = (self.median_noise(session, &rows), session.noise_estimated());
        let (mut channels, mut far) = (Vec::new(), Vec::new());
        for channel in (0..session.channel_count()).filter(|channel| found[*channel]) {
            let readings = self.readings();
            let known =
                |id: &ReadingId| readings.of_unknown_side(session, *id) == 0.0 && readings.lasting_alone(*id) == 0.0;
            let own = || {
                self.built.rows.iter().zip(&rows).filter(|(id, _)| id.channel == channel).filter(|(id, _)| known(id))
            };
            let count = own().count();
            let squares: f64 = own().map(|(id, row)| (row.whitened * self.readings().std(session, *id)).powi(2)).sum();
            let (rms, usual) = ((squares / count.max(1) as f64).sqrt(), usual[channel]);
            if count < FEWEST || usual <= 0.0 || rms < OF_TWO_KINDS * usual {
                continue;
            }
            channels.push((channel, [rms, usual]));
            far.extend(own().filter_map(|(id, row)| {
                let off = row.whitened.abs() * self.readings().std(session, *id) / usual;
                (off > FAR).then_some((off, id.pose))
            }));
        }
        far.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut poses: Vec<usize> = Vec::new();
        for (_, pose) in far {
            if !poses.contains(&pose) {
                poses.push(pose);
            }
        }
        Ok((!channels.is_empty()).then_some(HeavyTails { channels, poses }))
    }
}
