//! Errors of the samples: as the noise is stated, and otherwise.

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64;

use crate::decay::{NOISE, time};

/// Number of samples.
pub const SAMPLES: usize = 240;
/// Neighbouring samples that make a block.
pub const BLOCK: usize = 6;

/// How samples err, whatever is stated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Errors {
    /// Normal, independent, as stated.
    Normal,
    /// Normal and independent, three times the stated noise at the start of a recording, 0.4 times at its end.
    Unequal,
    /// Normal with a part that all samples of a block share, as large as their own.
    Shared,
    /// Normal, each with 0.5 of the one before: blocks are not quite independent.
    Autocorrelated,
    /// As stated, but one in ten is ten times as large.
    Outliers,
}

impl Errors {
    /// In words.
    pub fn as_str(self) -> &'static str {
        match self {
            Errors::Normal => "as stated",
            Errors::Unequal => "unequal",
            Errors::Shared => "shared in blocks",
            Errors::Autocorrelated => "autocorrelated",
            Errors::Outliers => "outliers",
        }
    }

    /// The errors of one draw, `each` in a recording.
    pub fn draw(self, each: usize, random: &mut Pcg64) -> Vec<f64> {
        let own: Vec<f64> = (0..SAMPLES).map(|_| normal(random)).collect();
        match self {
            Errors::Normal => own,
            Errors::Unequal => own.iter().enumerate().map(|(k, e)| 3.0 * (-0.5 * time(k, each)).exp() * e).collect(),
            Errors::Shared => {
                let shared: Vec<f64> = (0..SAMPLES / BLOCK).map(|_| normal(random)).collect();
                own.iter().enumerate().map(|(k, e)| e + shared[k / BLOCK]).collect()
            }
            Errors::Autocorrelated => {
                let mut last = 2.0 / 3.0_f64.sqrt() * normal(random);
                own.iter()
                    .map(|e| {
                        last = 0.5 * last + e;
                        last
                    })
                    .collect()
            }
            Errors::Outliers => own.iter().map(|e| if one_in_ten(random) { 10.0 * e } else { *e }).collect(),
        }
    }
}

fn normal(random: &mut Pcg64) -> f64 {
    let unit: f64 = StandardNormal.sample(random);
    NOISE * unit
}

fn one_in_ten(random: &mut Pcg64) -> bool {
    Uniform::new(0.0, 1.0).is_ok_and(|uniform| uniform.sample(random) < 0.1)
}
