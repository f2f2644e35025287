//! How series are spread over frequency.
//!
//! Runs of samples, `r` a second, are cut into segments of N that overlap by half. Of each, less its mean, a Hann window `w` and the discrete
//! Fourier transform tell the power in a band of 1 Hz,
//!
//! ```text
//!     P(f_k) = c_k |Σ_n w_n x_n e^{−2πi kn/N}|² / (r Σ_n w_n²),      f_k = k r/N,      c_k = 2, but 1 at k = N/2
//! ```
//!
//! and the mean over all segments (Welch, IEEE Transactions on Audio and Electroacoustics 15, 1967) its square: the amplitude spectral density `√P`. White noise
//! of standard deviation σ has `σ √(2/r)` at every frequency; a sine of amplitude A has `A √(N/(3 r))` where it is.

use std::f64::consts::TAU;
use std::sync::Arc;

use realfft::num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};

/// Samples in a segment.
const SHORTEST: usize = 16;
const LONGEST: usize = 256;
/// So many segments' lengths are in all runs together, where they are long enough.
const SEGMENTS: usize = 4;

/// Amplitude spectral density over frequency; frequency 0, which the mean is taken from, is left out.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spectrum {
    /// Hz, ascending, up to half of the rate.
    pub frequency: Vec<f64>,
    /// Unit of the series over √Hz.
    pub density: Vec<f64>,
}

/// That of runs of evenly spaced samples, `rate` a second; nothing where all are too short.
pub(crate) fn spectrum(runs: &[Vec<f64>], rate: f64) -> Option<Spectrum> {
    let mut welch = Welch::new(segment_length(runs)?, rate);
    runs.iter().for_each(|run| welch.add(run));
    Some(welch.mean())
}

/// An even number.
fn segment_length(runs: &[Vec<f64>]) -> Option<usize> {
    let samples: usize = runs.iter().map(Vec::len).sum();
    let longest = runs.iter().map(Vec::len).max()?;
    let length = (samples / SEGMENTS).clamp(SHORTEST, LONGEST).min(longest) / 2 * 2;
    (length >= SHORTEST).then_some(length)
}

/// Segments on their way to their mean.
struct Welch {
    rate: f64,
    window: Vec<f64>,
    transform: Arc<dyn RealToComplex<f64>>,
    /// Σ over segments of |…|², by frequency.
    power: Vec<f64>,
    segments: usize,
}

impl Welch {
    fn new(length: usize, rate: f64) -> Welch {
        let hann = |n: usize| 1.0 - (TAU * n as f64 / length as f64).cos();
        Welch {
            rate,
            window: (0..length).map(hann).collect(),
            transform: RealFftPlanner::new().plan_fft_forward(length),
            power: vec![0.0; length / 2 + 1],
            segments: 0,
        }
    }

    fn add(&mut self, run: &[f64]) {
        let length = self.window.len();
        for segment in run.windows(length).step_by(length / 2) {
            let mean = segment.iter().sum::<f64>() / length as f64;
            let mut weighted: Vec<f64> = segment.iter().zip(&self.window).map(|(x, w)| w * (x - mean)).collect();
            let mut transformed = vec![Complex::default(); length / 2 + 1];
            // Both have the lengths of the plan.
            if self.transform.process(&mut weighted, &mut transformed).is_ok() {
                self.power.iter_mut().zip(&transformed).for_each(|(sum, amplitude)| *sum += amplitude.norm_sqr());
                self.segments += 1;
            }
        }
    }

    fn mean(&self) -> Spectrum {
        let length = self.window.len();
        let squares: f64 = self.window.iter().map(|w| w * w).sum();
        let density = |k: usize| {
            let sides = if k == length / 2 { 1.0 } else { 2.0 };
            (sides * self.power[k] / (self.segments.max(1) as f64 * self.rate * squares)).sqrt()
        };
        Spectrum {
            frequency: (1..=length / 2).map(|k| k as f64 * self.rate / length as f64).collect(),
            density: (1..=length / 2).map(density).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: f64 = 8.0;

    /// Mean square, as the spectrum has it.
    fn mean_square(spectrum: &Spectrum) -> f64 {
        let step = spectrum.frequency[1] - spectrum.frequency[0];
        spectrum.density.iter().map(|density| density * density * step).sum()
    }

    #[test]
    fn a_sine_is_where_it_is_and_as_large() {
        let (frequency, amplitude) = (1.25, 0.3);
        let run: Vec<f64> =
            (0..512).map(|n| 5.0 + amplitude * (TAU * frequency * n as f64 / RATE + 0.4).sin()).collect();
        let spectrum = spectrum(&[run], RATE).unwrap();
        assert_eq!((spectrum.density.len(), spectrum.frequency[63]), (64, RATE / 2.0));
        let peak = (0..64).max_by(|a, b| spectrum.density[*a].total_cmp(&spectrum.density[*b])).unwrap();
        assert_eq!(spectrum.frequency[peak], frequency);
        let expected = amplitude * (128.0 / (3.0 * RATE)).sqrt();
        assert!((spectrum.density[peak] / expected - 1.0).abs() < 1e-9, "{} {expected}", spectrum.density[peak]);
        assert!((mean_square(&spectrum) / (0.5 * amplitude * amplitude) - 1.0).abs() < 1e-9);
        // A window's own width, and nothing beyond.
        assert!(spectrum.density.iter().enumerate().all(|(k, density)| k.abs_diff(peak) < 2 || *density < 1e-9));
    }

    /// Parseval: the area below is the mean square of the weighted samples over that of the weights.
    #[test]
    fn the_area_is_the_mean_square() {
        let run: Vec<f64> = (0..64).map(|n| ((n * n * 31 + 7 * n) % 97) as f64 - 48.0).collect();
        let mut welch = Welch::new(64, RATE);
        welch.add(&run);
        let mean = run.iter().sum::<f64>() / 64.0;
        let weighted: Vec<f64> = run.iter().zip(&welch.window).map(|(x, w)| w * (x - mean)).collect();
        let squares: f64 = welch.window.iter().map(|w| w * w).sum();
        let at_zero = weighted.iter().sum::<f64>().powi(2) / 64.0;
        let expected = (weighted.iter().map(|x| x * x).sum::<f64>() - at_zero) / squares;
        assert!((mean_square(&welch.mean()) / expected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn white_noise_is_flat_whatever_the_runs() {
        // Fractions of multiples of squares, nearly white: of variance 1/12.
        let noise = |n: usize| (0.5 * (n * n) as f64 * 2f64.sqrt()).fract() - 0.5;
        let runs: Vec<Vec<f64>> = (0..20).map(|run| (0..200).map(|n| noise(1000 * run + n)).collect()).collect();
        let spectrum = spectrum(&runs, RATE).unwrap();
        let expected = (2.0 / 12.0 / RATE).sqrt();
        let beyond_the_mean = &spectrum.density[2..spectrum.density.len() - 2];
        let share = beyond_the_mean.iter().map(|density| density * density).sum::<f64>() / beyond_the_mean.len() as f64;
        assert!((share.sqrt() / expected - 1.0).abs() < 0.1, "{} {expected}", share.sqrt());
    }

    #[test]
    fn short_runs_tell_nothing() {
        assert_eq!(spectrum(&[vec![0.0; 15], vec![1.0; 12]], RATE), None);
        assert_eq!(spectrum(&[], RATE), None);
        assert_eq!(spectrum(&[vec![0.0; 17]], RATE).unwrap().frequency.len(), 8);
    }
}
