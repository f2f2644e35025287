//! What blocks of poses that are left out cannot tell.

use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::findings::verdict::Findings;

impl Answer {
    /// Says what blocks of poses left out cannot tell.
    pub(in crate::joint::reporting) fn remark_on_blocks(&self, findings: &mut Findings) {
        let Some(jackknife) = self.uncertainty.jackknife() else { return };
        if !jackknife.told_by_one_block.is_empty() {
            findings.doubt_for(format!(
                "A part of {} is determined by a single block of poses, so that the jackknife cannot tell how well it is known: the standard \
                 deviation assumes that noise is the only error. Add poses like these, or state shorter blocks ([uncertainty] \
                 block_poses).",
                jackknife.told_by_one_block.join(", ")
            ));
        }
        if !jackknife.correlated_blocks.is_empty() {
            let channels = jackknife.correlated_blocks.iter();
            let named = channels.map(|blocks| format!("{} ({:.2})", blocks.channel, blocks.correlation));
            findings.doubt_for(format!(
                "Errors outlast the blocks of poses that tell the standard deviations: sums of residuals over neighbouring blocks are \
                 correlated in {}. Standard deviations are too small. Look at the residuals over time: a drifting zero makes such errors; \
                 let the sensors warm up, or estimate a drift ([[joint]] sensor_models).",
                named.collect::<Vec<_>>().join(", ")
            ));
        }
        if let Some(wanted) = jackknife.too_short_for {
            findings.remark(format!(
                "Residuals stay correlated over more poses than a block has: those of neighbouring poses by {:.2}, for which blocks \
                 should have {wanted} poses, and there are too few poses for that. Intervals may be too narrow. Look at the residuals \
                 over time: a drifting zero makes such errors, and a bias for each table or a drift ([[joint]] sensor_models) takes them up.",
                jackknife.correlation.unwrap_or(0.0)
            ));
        }
    }
}
