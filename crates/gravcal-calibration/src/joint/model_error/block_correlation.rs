//! Whether errors outlast the blocks that a jackknife leaves out.
//!
//! ```text
//!     S_b = Σ r over the readings of a channel in block b,   R = Σ S_b S_{b+1} / Σ S_b²     of neighbouring blocks of one table
//! ```
//!
//! Blocks scatter as their errors do only where they are independent: then `R √n` of n pairs is about a standard normal number, and a drift makes
//! `R` more than a half. Where blocks are few, no channel shows it by itself: the mean of all C channels has a spread of `1/√(n C)`.

use std::ops::Range;

use gravcal_estimation::EvaluateError;
use gravcal_estimation::statistics::SampleBlocks;
use gravcal_robot_model::session::{ReadingId, Session};

use crate::joint::solved::Solved;
use crate::result::CorrelatedBlocks;

/// Correlation from which blocks tell variances that are too small by half.
const CORRELATED: f64 = 0.5;
/// Standard deviations of chance beyond which a correlation is none.
const BEYOND_CHANCE: f64 = 4.0;
/// What all channels show together.
const ALL_CHANNELS: &str = "all channels";

impl Solved {
    /// The channels whose errors outlast these blocks, of factors.
    pub(in crate::joint) fn correlated_blocks(
        &self,
        session: &Session,
        blocks: &SampleBlocks,
    ) -> Result<Vec<CorrelatedBlocks>, EvaluateError> {
        let poses = self.poses(session);
        let blocks: Vec<Range<usize>> = blocks.iter().collect();
        let mut block_of = vec![None; session.poses.len()];
        for (index, block) in blocks.iter().enumerate() {
            poses[block.clone()].iter().for_each(|pose| block_of[*pose] = Some(index));
        }
        let mut sums = vec![vec![0.0; blocks.len()]; session.channel_count()];
        for (ReadingId { pose, channel }, row) in self.built.rows.iter().zip(self.row_residuals()?) {
            if let Some(block) = block_of[*pose] {
                sums[*channel][block] += row.whitened;
            }
        }
        let table = |block: &Range<usize>| session.poses[poses[block.start]].table;
        let neighbours: Vec<usize> =
            (1..blocks.len()).filter(|block| table(&blocks[*block]) == table(&blocks[*block - 1])).collect();
        let correlations: Vec<(String, f64)> = sums
            .iter()
            .enumerate()
            .filter_map(|(channel, sums)| Some((session.channel_name(channel), correlation(sums, &neighbours)?)))
            .collect();
        Ok(beyond_chance(correlations, neighbours.len()))
    }
}

/// `R`; nothing of a channel without residuals. `neighbours`: blocks that follow on the one before.
fn correlation(sums: &[f64], neighbours: &[usize]) -> Option<f64> {
    let squares: f64 = sums.iter().map(|sum| sum * sum).sum();
    let products: f64 = neighbours.iter().map(|block| sums[block - 1] * sums[*block]).sum();
    (squares > 0.0).then(|| products / squares)
}

/// The channels whose correlation of so many pairs is large, and beyond chance; all together where none is by itself.
fn beyond_chance(correlations: Vec<(String, f64)>, pairs: usize) -> Vec<CorrelatedBlocks> {
    let is_beyond = |correlation: f64, pairs: usize| {
        correlation > CORRELATED && correlation * (pairs as f64).sqrt() > BEYOND_CHANCE
    };
    let channels = correlations.len();
    let mean = correlations.iter().map(|(_, correlation)| correlation).sum::<f64>() / channels.max(1) as f64;
    let named = |(channel, correlation)| CorrelatedBlocks { channel, correlation };
    let alone: Vec<CorrelatedBlocks> =
        correlations.into_iter().filter(|(_, correlation)| is_beyond(*correlation, pairs)).map(named).collect();
    if alone.is_empty() && is_beyond(mean, pairs * channels) {
        return vec![named((ALL_CHANNELS.to_owned(), mean))];
    }
    alone
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    #[test]
    fn only_what_is_large_and_beyond_chance_counts() {
        let neighbours: Vec<usize> = (1..40).collect();
        let ramp: Vec<f64> = (0..40).map(|block| f64::from(block) - 19.5).collect();
        // Σ s_b s_{b+1} = Σ s² − ½ (s_0² + s_39²) − ½ · 39 · 1² of a ramp of steps of 1.
        let squares: f64 = ramp.iter().map(|sum| sum * sum).sum();
        let by_hand = 1.0 - (19.5 * 19.5 + 19.5) / squares;
        assert!((correlation(&ramp, &neighbours).unwrap() - by_hand).abs() < 1e-12);
        assert!(correlation(&[0.0; 40], &neighbours).is_none());
        let found = |correlations: &[f64], pairs: usize| {
            let named =
                correlations.iter().enumerate().map(|(channel, correlation)| (channel.to_string(), *correlation));
            let found = beyond_chance(named.collect(), pairs);
            found.into_iter().map(|blocks| blocks.channel).collect::<Vec<String>>()
        };
        assert_eq!(found(&[0.6, 0.1], 50), ["0"]);
        assert!(found(&[0.4, 0.4], 500).is_empty(), "not large");
        assert!(found(&[0.6, 0.1], 40).is_empty(), "of few blocks that happens");
        assert_eq!(found(&[0.6; 5], 12), [ALL_CHANNELS], "not in five channels");
    }

    #[test]
    fn a_drift_outlasts_blocks_and_noise_does_not() {
        let mut session = sarcos_shoulder().session(0);
        let found = |session: &Session| {
            let readings = select(session, Signals::All);
            let solved = with_environment(|environment| solve(session, &readings, None, environment)).unwrap();
            let blocks = SampleBlocks::new(0..session.poses.len(), 4).unwrap();
            solved.correlated_blocks(session, &blocks).unwrap()
        };
        assert_eq!(found(&session), []);
        let count = session.poses.len() as f64;
        for (place, pose) in session.poses.iter_mut().enumerate() {
            let reading = pose.torque[1].as_mut().unwrap();
            reading.value += 20.0 * (place as f64 / count) * reading.std.unwrap();
        }
        let drifting = found(&session);
        assert!(drifting.iter().any(|blocks| blocks.channel == "joint2" && blocks.correlation > 0.5), "{drifting:?}");
    }
}
