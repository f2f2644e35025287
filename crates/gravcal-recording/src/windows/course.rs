//! How an arm moves in a window, by moments that windows which overlap share.

use std::sync::Arc;

use super::Kept;

/// Moments in a stretch at most: as many as vector registers have lanes.
pub(super) const STRETCH: usize = 4;

/// How an arm moved in a window.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// In order.
    pub stretches: Vec<WeighedStretch>,
    /// What was made of it.
    pub kept: Kept,
}

/// A part of a window.
#[derive(Clone, Debug, PartialEq)]
pub struct WeighedStretch {
    /// One to four that follow each other; other windows see the same ones.
    pub moments: Arc<[MotionSample]>,
    /// Share of each in the window; their sum over the window is 1. Nothing of moments beyond its ends.
    pub weights: Vec<f64>,
}

/// A moment of an arm in motion, by the joints' position readings.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionSample {
    /// When, s; from where is the recording's own.
    pub time: f64,
    /// rad, m, or the sensor's own unit.
    pub position: Vec<f64>,
    /// The same per second.
    pub velocity: Vec<f64>,
    /// The same per second squared.
    pub acceleration: Vec<f64>,
}

impl Course {
    /// Of moments that no other window sees, and the share of each.
    pub fn of(moments: &[(f64, MotionSample)]) -> Course {
        let stretch = |part: &[(f64, MotionSample)]| WeighedStretch {
            moments: part.iter().map(|(_, moment)| moment.clone()).collect(),
            weights: part.iter().map(|(weight, _)| *weight).collect(),
        };
        Course { stretches: moments.chunks(STRETCH).map(stretch).collect(), kept: Kept::default() }
    }

    /// Moments with their shares, in order.
    pub fn moments(&self) -> impl Iterator<Item = (f64, &MotionSample)> {
        self.stretches.iter().flat_map(|stretch| stretch.weights.iter().copied().zip(stretch.moments.iter()))
    }
}
