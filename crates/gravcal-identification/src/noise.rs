//! Noise of sensors where no reading states it: from the residuals, one standard deviation for each channel.
//!
//! A channel's variance `s² = Σ r²/d` has few degrees of freedom `d` where poses are few, and may by chance be a quarter of what it should be.
//! The variances of channels that are alike (torque sensors of joints; the forces of a wrist sensor; its moments) are therefore taken for draws
//! from one distribution, `1/σ² ~ χ²_{d₀}/(d₀ s₀²)`, whose `d₀` and `s₀` come from how much they differ (Smyth, *Statistical Applications in Genetics and Molecular Biology* 3, 2004, equations in section 6.2), and each is
//!
//! ```text
//!     (d₀ s₀² + d s²)/(d₀ + d)
//! ```
//!
//! Where channels differ by more than chance ([`DIFFERENT`]), and have been read often, that is `s²` as it was; where they do not, it is that of
//! all. Few degrees of freedom do not tell whether they differ, and a channel that passes for a quiet one has more weight, and fewer degrees of
//! freedom the next time: each would be as quiet as the fit can make it. Chance is judged by Bartlett's test (*Proc. R. Soc. Lond. A* 160, 1937), with
//! `d = Σ d_j` and `s² = Σ d_j s_j²/d` of k channels,
//!
//! ```text
//!     (d ln s² − Σ d_j ln s_j²) / (1 + (Σ 1/d_j − 1/d)/(3 (k − 1)))  ~  χ²(k − 1)
//! ```
//!
//! Why it is so, and what was tried: `docs/decisions/moderated-noise.md`.
//!
//! Where a loss is heeded it is the scaled median of the residuals, of which up to half may be outliers:
//!
//! ```text
//!     σ = median |r| / √(1 − h) / 0.6745         (Huber, Robust statistics, 1981, section 5.1; h: leverage)
//! ```

use std::collections::BTreeMap;

use statrs::distribution::{ChiSquared, ContinuousCDF};
use statrs::function::gamma::digamma;

use crate::median::{NORMAL_MEDIAN, median};
use crate::residuals::RowResidual;

/// Probability of variances that differ so much by chance, below which channels are not alike.
const DIFFERENT: f64 = 0.05;

/// What leverages leave by rounding where unknowns take up all of a channel's readings.
const NO_FREEDOM: f64 = 1e-6;

/// A residual of a reading.
#[derive(Clone, Copy, Debug)]
pub struct ReadingResidual {
    /// Which sensor read it.
    pub channel: usize,
    /// The standard deviation by which the residual is whitened, unit of the reading.
    pub std: f64,
    /// The residual.
    pub row: RowResidual,
}

/// The noise of a channel's readings as their residuals show it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelNoise {
    /// Standard deviation, unit of the reading.
    pub std: f64,
    /// Degrees of freedom of the channel's own residuals, `d`.
    pub own: f64,
    /// All that tell it: `d + d₀`; those of all channels that are alike where these have one noise.
    pub freedom: f64,
}

/// The noise of each channel's readings by the squares of its residuals, allowing for the parameters that the rows themselves took
/// up; nothing for a channel whose residuals tell none. `groups`: of each channel, the number of those whose noises are drawn
/// from one distribution, if it is one of several that are alike.
pub fn noise_by_squares(readings: &[ReadingResidual], groups: &[Option<usize>]) -> Vec<Option<ChannelNoise>> {
    let mut residuals = vec![Residuals::default(); groups.len()];
    for ReadingResidual { channel, std, row } in readings {
        let residual = row.whitened * std;
        residuals[*channel].squares += residual * residual;
        residuals[*channel].freedom += (1.0 - row.leverage).max(0.0);
    }
    let mut members: BTreeMap<usize, Vec<Residuals>> = BTreeMap::new();
    for (residuals, group) in residuals.iter().zip(groups) {
        group.iter().for_each(|group| members.entry(*group).or_default().push(*residuals));
    }
    let common: BTreeMap<usize, CommonNoise> =
        members.into_iter().filter_map(|(group, members)| Some((group, CommonNoise::of(&members)?))).collect();
    let noise = residuals.iter().zip(groups).map(|(residuals, group)| {
        let common = group.and_then(|group| common.get(&group));
        residuals.variance().map(|own| ChannelNoise {
            std: common.map_or(own, |common| common.moderated(*residuals)).sqrt(),
            own: residuals.freedom,
            freedom: common.map_or(residuals.freedom, |common| common.telling(*residuals)),
        })
    });
    noise.collect()
}

/// The same by the median of the residuals.
pub fn noise_by_median(readings: &[ReadingResidual], channels: usize) -> Vec<Option<f64>> {
    let noise = |channel: usize| {
        let own = readings.iter().filter(|reading| reading.channel == channel);
        let mut sizes: Vec<f64> = own.map(|reading| reading.row.freed().abs() * reading.std).collect();
        median(&mut sizes).filter(|median| *median > 0.0).map(|median| median / NORMAL_MEDIAN)
    };
    (0..channels).map(noise).collect()
}

/// Sum of squares and degrees of freedom of a channel's residuals.
#[derive(Clone, Copy, Default)]
struct Residuals {
    squares: f64,
    freedom: f64,
}

impl Residuals {
    fn variance(self) -> Option<f64> {
        (self.squares > 0.0 && self.freedom > NO_FREEDOM).then(|| self.squares / self.freedom)
    }
}

/// What the variances of like channels have in common.
#[derive(Clone, Copy, Debug)]
struct CommonNoise {
    /// `s₀²`.
    variance: f64,
    /// `d₀`; infinite where the channels differ by no more than chance.
    freedom: f64,
    /// `Σ d` of the channels.
    of_all: f64,
}

impl CommonNoise {
    /// Nothing where no channel tells anything.
    fn of(channels: &[Residuals]) -> Option<CommonNoise> {
        let informative: Vec<&Residuals> =
            channels.iter().filter(|c| c.variance().is_some() && c.freedom >= 1.0).collect();
        let count = informative.len() as f64;
        if !differ(&informative) {
            return CommonNoise::of_all(channels);
        }
        let logarithms = || informative.iter().filter_map(|c| Some(c.variance()?.ln() - excess(c.freedom)));
        let of_all = channels.iter().map(|channel| channel.freedom).sum();
        let mean = logarithms().sum::<f64>() / count;
        let scatter = logarithms().map(|e| (e - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let by_chance = informative.iter().map(|c| trigamma(0.5 * c.freedom)).sum::<f64>() / count;
        Some(match freedom_of_scatter(scatter - by_chance) {
            Some(freedom) => CommonNoise { variance: (mean + excess(freedom)).exp(), freedom, of_all },
            None => return CommonNoise::of_all(channels),
        })
    }

    /// Of channels that are taken for alike.
    fn of_all<'r>(channels: impl IntoIterator<Item = &'r Residuals>) -> Option<CommonNoise> {
        let all = channels.into_iter().fold(Residuals::default(), |all, channel| Residuals {
            squares: all.squares + channel.squares,
            freedom: all.freedom + channel.freedom,
        });
        Some(CommonNoise { variance: all.variance()?, freedom: f64::INFINITY, of_all: all.freedom })
    }

    /// The degrees of freedom that tell the noise of one of the channels: no more than all of them have.
    fn telling(&self, own: Residuals) -> f64 {
        (own.freedom + self.freedom).min(self.of_all)
    }

    fn moderated(&self, own: Residuals) -> f64 {
        if self.freedom.is_infinite() {
            return self.variance;
        }
        (self.freedom * self.variance + own.squares) / (self.freedom + own.freedom)
    }
}

/// Whether variances of channels differ by more than chance.
fn differ(channels: &[&Residuals]) -> bool {
    let count = channels.len() as f64;
    let (Some(common), Ok(by_chance)) =
        (CommonNoise::of_all(channels.iter().copied()), ChiSquared::new((count - 1.0).max(0.0)))
    else {
        return false;
    };
    let freedom: f64 = channels.iter().map(|channel| channel.freedom).sum();
    let apart: f64 = channels
        .iter()
        .filter_map(|channel| Some(channel.freedom * (common.variance / channel.variance()?).ln()))
        .sum();
    let inverses: f64 = channels.iter().map(|channel| 1.0 / channel.freedom).sum();
    let correction = 1.0 + (inverses - 1.0 / freedom) / (3.0 * (count - 1.0));
    by_chance.sf(apart / correction) < DIFFERENT
}

/// Mean of `ln(χ²_d/d)`.
fn excess(freedom: f64) -> f64 {
    digamma(0.5 * freedom) - (0.5 * freedom).ln()
}

/// ψ′, as the slope of ψ.
fn trigamma(x: f64) -> f64 {
    let h = 1e-4 * x;
    (digamma(x + h) - digamma(x - h)) / (2.0 * h)
}

/// `d₀` with `ψ′(d₀/2)` so large; nothing where that is more than 10⁴, or no scatter at all.
fn freedom_of_scatter(scatter: f64) -> Option<f64> {
    let (mut low, mut high) = (1e-3_f64, 1e4_f64);
    if scatter <= trigamma(0.5 * high) {
        return None;
    }
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        let larger = trigamma(0.5 * middle) > scatter;
        if larger { low = middle } else { high = middle }
    }
    Some((low * high).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channels(of: &[(f64, f64)]) -> Vec<Residuals> {
        of.iter().map(|(variance, freedom)| Residuals { squares: variance * freedom, freedom: *freedom }).collect()
    }

    fn moderated(of: &[(f64, f64)]) -> Vec<f64> {
        let channels = channels(of);
        let common = CommonNoise::of(&channels).unwrap();
        channels.iter().map(|c| common.moderated(*c)).collect()
    }

    #[test]
    fn variances_that_differ_by_chance_are_one() {
        // 0.4 to 1.6 times the variance are no rarity of five degrees of freedom.
        let found = moderated(&[(0.4, 5.0), (1.1, 5.0), (0.9, 5.0), (1.6, 5.0), (0.8, 5.0)]);
        assert!(found.iter().all(|v| (v - 0.96).abs() < 1e-12), "{found:?}");
    }

    #[test]
    fn sensors_that_differ_keep_their_own() {
        for (found, own) in moderated(&[(1.0, 500.0), (0.01, 500.0), (1e-4, 500.0)]).into_iter().zip([1.0, 0.01, 1e-4])
        {
            assert!((found / own - 1.0).abs() < 0.01, "{found} {own}");
        }
    }

    #[test]
    fn sensors_without_a_degree_of_freedom_each_are_one() {
        let found = moderated(&[(900.0, 0.5), (1.0, 0.3), (1e-9, 0.2)]);
        assert!(found.iter().all(|v| (v - 450.3).abs() < 1e-6), "{found:?}");
    }

    /// A fit that takes up every reading, to the last digit but one, leaves residuals of no size.
    #[test]
    fn what_rounding_leaves_of_readings_that_are_all_taken_up_is_no_noise() {
        let row = RowResidual { whitened: 1e-7, leverage: 1.0 - 1e-13 };
        let readings = [0, 0, 1].map(|channel| ReadingResidual { channel, std: 1.0, row });
        for group in [None, Some(0)] {
            assert_eq!(noise_by_squares(&readings, &[group; 2]), [None, None]);
        }
    }

    /// With s² of 1 and 16 and five degrees of freedom each, the statistic is (10 ln 8.5 − 5 ln 16) / 1.1 = 6.9, which χ² of one degree of freedom
    /// exceeds in 0.9 %; with two each it is 2.4, in 12 %.
    #[test]
    fn channels_differ_where_chance_does_not_make_it() {
        let differ = |of: &[(f64, f64)]| super::differ(&channels(of).iter().collect::<Vec<_>>());
        assert!(differ(&[(1.0, 5.0), (16.0, 5.0)]) && differ(&[(1.0, 16.0), (16.0, 16.0)]));
        assert!(!differ(&[(1.0, 2.0), (16.0, 2.0)]) && !differ(&[(1.0, 50.0)]) && !differ(&[]));
    }

    /// Six channels share three degrees of freedom, and one of them has half of these: by themselves five would be a hundred times quieter.
    #[test]
    fn few_degrees_of_freedom_do_not_make_quiet_channels() {
        let found = moderated(&[(4e-4, 1.5), (1e-6, 1.1), (1e-8, 0.2), (1e-9, 0.1), (1e-8, 0.05), (1e-9, 0.05)]);
        assert!(found.iter().all(|v| (v / 2e-4 - 1.0).abs() < 0.01), "{found:?}");
    }

    #[test]
    fn the_slope_of_psi_and_its_inverse_are_right() {
        assert!((trigamma(1.0) - std::f64::consts::PI.powi(2) / 6.0).abs() < 1e-6);
        assert!((trigamma(0.5) - std::f64::consts::PI.powi(2) / 2.0).abs() < 1e-6);
        assert!((freedom_of_scatter(trigamma(3.5)).unwrap() - 7.0).abs() < 1e-6);
        assert!(freedom_of_scatter(-1.0).is_none() && CommonNoise::of(&channels(&[(0.0, 0.0)])).is_none());
    }

    #[test]
    fn moderation_is_between_own_and_common() {
        // Of few readings, one sensor that is much noisier than the others: its variance comes nearer to theirs, and stays by far the largest.
        let found = moderated(&[(1.0, 6.0), (1.5, 6.0), (0.7, 6.0), (60.0, 6.0)]);
        assert!((10.0..60.0).contains(&found[3]) && found[..3].iter().all(|v| (0.7..10.0).contains(v)), "{found:?}");
    }

    /// Readings of one channel that a fit of their mean explains so.
    fn of_channel(channel: usize, std: f64, residuals: &[f64]) -> Vec<ReadingResidual> {
        let row = |r: &f64| RowResidual { whitened: r / std, leverage: 1.0 / residuals.len() as f64 };
        residuals.iter().map(|r| ReadingResidual { channel, std, row: row(r) }).collect()
    }

    #[test]
    fn the_noise_about_a_mean_is_the_sample_standard_deviation() {
        let (first, second) = ([0.3, -0.5, 0.1, 0.4, -0.3], [20.0, -30.0, 10.0]);
        let readings = [of_channel(0, 2.0, &first), of_channel(2, 0.5, &second)].concat();
        let sample = |r: &[f64]| (r.iter().map(|r| r * r).sum::<f64>() / (r.len() - 1) as f64).sqrt();
        let noise = noise_by_squares(&readings, &[None; 3]);
        assert!(
            (noise[0].unwrap().std - sample(&first)).abs() < 1e-12
                && (noise[2].unwrap().std - sample(&second)).abs() < 1e-9
        );
        assert_eq!(noise[1], None, "nobody read it");
        assert!(noise[0].unwrap().freedom == noise[0].unwrap().own && (noise[0].unwrap().own - 4.0).abs() < 1e-12);
    }

    /// Channels 0 and 1 differ by chance, 2 and 3 too, and 4 belongs to none.
    #[test]
    fn channels_of_a_group_have_one_noise_and_those_of_others_theirs() {
        let readings: Vec<ReadingResidual> = [0.1, 0.2, 10.0, 20.0, 5.0]
            .into_iter()
            .enumerate()
            .flat_map(|(channel, size)| of_channel(channel, 1.0, &[size, -size, size]))
            .collect();
        let noise = noise_by_squares(&readings, &[Some(0), Some(0), Some(3), Some(3), None]);
        let [a, b, c, d, e] = [0, 1, 2, 3, 4].map(|channel: usize| noise[channel].unwrap().std);
        let root = |mean: f64| (1.5 * mean).sqrt();
        let near = |found: f64, expected: f64| (found / expected - 1.0).abs() < 1e-12;
        assert!(near(a, root(0.025)) && a == b && near(c, root(250.0)) && c == d && near(e, root(25.0)), "{noise:?}");
        // Three residuals about their mean have two degrees of freedom, and both channels of a group tell its noise.
        assert!(noise[..4].iter().all(|found| near(found.unwrap().freedom, 4.0)), "{noise:?}");
    }

    /// Four channels with eleven degrees of freedom each and noises from 1 to 100: none tells much of another.
    #[test]
    fn channels_that_differ_have_the_freedom_of_their_own_residuals_and_little_more() {
        let sizes = [1.0, 5.0, 20.0, 100.0].into_iter().enumerate();
        let of = |(channel, size): (usize, f64)| of_channel(channel, 1.0, &[[size, -size]; 6].concat());
        let readings: Vec<ReadingResidual> = sizes.flat_map(of).collect();
        for found in noise_by_squares(&readings, &[Some(0); 4]) {
            let ChannelNoise { own, freedom, .. } = found.unwrap();
            assert!((own - 11.0).abs() < 1e-9 && freedom > own && freedom < own + 2.0, "{found:?}");
        }
    }

    #[test]
    fn an_outlier_does_not_move_the_median() {
        let residuals = [0.3, -0.5, 0.1, 0.4, -200.0];
        let noise = noise_by_median(&of_channel(0, 2.0, &residuals), 2);
        assert!((noise[0].unwrap() - 0.4 / 0.8_f64.sqrt() / 0.674_489_75).abs() < 1e-6, "{noise:?}");
        assert_eq!(noise[1], None);
    }
}
