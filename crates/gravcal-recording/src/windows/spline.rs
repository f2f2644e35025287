//! Positions of a joint as a spline, and with them velocities and accelerations.
//!
//! The joint's jerk is taken for white noise of density `λ r²`, its position readings for its positions with white noise of variance `r²`:
//!
//! ```text
//!     d/dt (q, q̇, q̈) = (q̇, q̈, w),     q_k = q(t_k) + e_k
//! ```
//!
//! What then is most likely is a smoothing spline of fifth degree (Wahba 1978). A Kalman filter forward and its adjoint backward (Bryson and Frazier) find it in
//! time that grows with the number of samples, at any spacing. Between two samples the spline is the polynomial of fifth degree through both states.
//!
//! `λ` is the one that is most likely where the joint moves most, and `r` follows from it. A joint that stands is explained by the firmest spline, which
//! would smooth away the motion that follows; a spline that is soft enough for that follows noise a little farther where the joint stands.
//!
//! Times are counted in median steps, so that all numbers of a state are of like size.

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

use super::clock::Recorded;

/// Variance of velocity and acceleration before anything is read, in that of a reading: anything may be.
const ANYTHING: f64 = 1e12;
/// Decimal logarithms of `λ`, between which the most likely one is looked for.
const FIRMEST: f64 = -14.0;
const SOFTEST: f64 = 4.0;
/// How often the interval is narrowed, to 0.02.
const NARROWED: usize = 14;
/// Samples of a stretch, and of how many stretches the readings tell how firm.
const STRETCH: usize = 500;
const STRETCHES: usize = 8;
/// Samples that say where a stretch starts, and nothing of how smooth it is.
const STARTING: usize = 3;

/// Position, velocity and acceleration at a moment, all joints.
#[derive(Clone, Debug)]
pub(super) struct Run {
    pub rows: Range<usize>,
    /// By joint, then by row.
    pub states: Vec<Vec<[f64; 3]>>,
}

/// All runs that hold a window.
#[derive(Clone, Debug)]
pub(super) struct Splines {
    pub runs: Vec<Run>,
    /// Of each joint.
    pub noise: Vec<f64>,
}

/// Splines of all joints; runs shorter than `least`, s, are left out.
pub(super) fn of_joints(recorded: &Recorded, least: f64) -> Splines {
    let unit = recorded.interval().filter(|unit| *unit > 0.0).unwrap_or(1.0);
    let long =
        |rows: &Range<usize>| rows.len() > 3 && recorded.times[rows.end - 1] - recorded.times[rows.start] >= least;
    let mut runs: Vec<Run> =
        recorded.runs().into_iter().filter(long).map(|rows| Run { rows, states: Vec::new() }).collect();
    let mut noise = Vec::new();
    for joint in 0..recorded.joints {
        let series: Vec<Series> = runs.iter().map(|run| Series::new(recorded, &run.rows, joint, unit)).collect();
        let density = most_likely(&liveliest(&series));
        let (mut squares, mut count) = (0.0, 0.0);
        for (run, series) in runs.iter_mut().zip(&series) {
            let states = series.smooth(density);
            squares += series.values.iter().zip(&states).map(|(value, state)| (value - state[0]).powi(2)).sum::<f64>();
            count += states.len() as f64;
            let first = recorded.value(run.rows.start, joint);
            let si = |state: &Vector3<f64>| [first + state[0], state[1] / unit, state[2] / (unit * unit)];
            run.states.push(states.iter().map(si).collect());
        }
        noise.push(f64::sqrt(squares / f64::max(count, 1.0)));
    }
    Splines { runs, noise }
}

impl Run {
    /// Position, velocity and acceleration of a joint at a moment between `row` and the next, as the polynomial of fifth degree through both.
    pub fn between(&self, times: &[f64], joint: usize, row: usize, time: f64) -> [f64; 3] {
        let states = &self.states[joint];
        let (a, b) = (states[row - self.rows.start], states[row + 1 - self.rows.start]);
        let length = times[row + 1] - times[row];
        quintic(a, b, length, (time - times[row]) / length)
    }
}

/// `u`: share of the way.
fn quintic(a: [f64; 3], b: [f64; 3], length: f64, u: f64) -> [f64; 3] {
    let (va, vb) = (a[1] * length, b[1] * length);
    let (aa, ab) = (a[2] * length * length, b[2] * length * length);
    let way = b[0] - a[0] - va - 0.5 * aa;
    let (speed, rate) = (vb - va - aa, ab - aa);
    let c3 = 10.0 * way - 4.0 * speed + 0.5 * rate;
    let c4 = -15.0 * way + 7.0 * speed - rate;
    let c5 = 6.0 * way - 3.0 * speed + 0.5 * rate;
    let position = a[0] + u * (va + u * (0.5 * aa + u * (c3 + u * (c4 + u * c5))));
    let velocity = va + u * (aa + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)));
    let acceleration = aa + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5));
    [position, velocity / length, acceleration / (length * length)]
}

/// Readings of one joint in one run, less the first.
#[derive(Clone, Debug)]
struct Series {
    /// From each sample to the next, in steps.
    steps: Vec<f64>,
    values: Vec<f64>,
}

/// Consecutive samples of a series.
#[derive(Clone, Debug)]
struct Stretch<'a> {
    /// From each sample to the next, in steps.
    steps: &'a [f64],
    values: &'a [f64],
}

/// A sample that is predicted.
struct Predicted {
    state: Vector3<f64>,
    covariance: Matrix3<f64>,
}

impl Series {
    fn new(recorded: &Recorded, rows: &Range<usize>, joint: usize, unit: f64) -> Series {
        let times = &recorded.times[rows.clone()];
        let first = recorded.value(rows.start, joint);
        Series {
            steps: times.windows(2).map(|pair| (pair[1] - pair[0]) / unit).collect(),
            values: rows.clone().map(|row| recorded.value(row, joint) - first).collect(),
        }
    }

    fn stretches(&self) -> impl Iterator<Item = Stretch<'_>> {
        let all = (0..self.values.len()).step_by(STRETCH);
        all.map(|first| {
            let values = &self.values[first..(first + STRETCH).min(self.values.len())];
            Stretch { steps: &self.steps[first..first + values.len() - 1], values }
        })
    }

    /// The spline's states at all samples, per step.
    fn smooth(&self, density: f64) -> Vec<Vector3<f64>> {
        let mut predicted = Vec::with_capacity(self.values.len());
        predicted.push(Predicted::first());
        for (step, value) in self.steps.iter().zip(&self.values) {
            let next = predicted[predicted.len() - 1].updated(*value).moved(*step, density);
            predicted.push(next);
        }
        let mut adjoint = Vector3::zeros();
        let mut states = vec![Vector3::zeros(); self.values.len()];
        for (sample, (filter, value)) in predicted.iter().zip(&self.values).enumerate().rev() {
            if let Some(step) = self.steps.get(sample) {
                adjoint = transition(*step).tr_mul(&adjoint);
            }
            let variance = filter.covariance[(0, 0)] + 1.0;
            let gain = filter.covariance.column(0) / variance;
            adjoint[0] -= gain.dot(&adjoint) + (value - filter.state[0]) / variance;
            states[sample] = filter.state - filter.covariance * adjoint;
        }
        states
    }
}

impl Stretch<'_> {
    /// From the lowest reading to the highest.
    fn range(&self) -> f64 {
        let [low, high] = [f64::min, f64::max].map(|of| self.values.iter().copied().reduce(of).unwrap_or(0.0));
        high - low
    }

    /// How badly each sample but the first is predicted from those before.
    fn innovations(&self, density: f64) -> Innovations {
        let mut found = Innovations::default();
        let mut filter = Predicted::first();
        for (sample, value) in self.values.iter().enumerate() {
            if sample > 0 {
                filter = filter.updated(self.values[sample - 1]).moved(self.steps[sample - 1], density);
            }
            if sample >= STARTING {
                let variance = filter.covariance[(0, 0)] + 1.0;
                found.squares += (value - filter.state[0]).powi(2) / variance;
                found.logarithms += variance.ln();
                found.count += 1.0;
            }
        }
        found
    }
}

/// The stretches of a joint in which it travels farthest.
fn liveliest(series: &[Series]) -> Vec<Stretch<'_>> {
    let mut stretches: Vec<Stretch<'_>> = series.iter().flat_map(Series::stretches).collect();
    stretches.sort_by(|a, b| b.range().total_cmp(&a.range()));
    stretches.truncate(STRETCHES);
    stretches
}

/// The most likely density of the jerk.
fn most_likely(stretches: &[Stretch<'_>]) -> f64 {
    let worth = |logarithm: f64| Innovations::of(stretches, 10f64.powf(logarithm)).minus_log_likelihood();
    let (mut low, mut high) = (FIRMEST, SOFTEST);
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let (mut a, mut b) = (high - golden * (high - low), low + golden * (high - low));
    let (mut of_a, mut of_b) = (worth(a), worth(b));
    for _ in 0..NARROWED {
        if of_a < of_b {
            (high, b, of_b) = (b, a, of_a);
            a = high - golden * (high - low);
            of_a = worth(a);
        } else {
            (low, a, of_a) = (a, b, of_b);
            b = low + golden * (high - low);
            of_b = worth(b);
        }
    }
    10f64.powf(0.5 * (low + high))
}

/// How badly samples are predicted: squares by their variances, and the logarithms of these.
#[derive(Clone, Copy, Debug, Default)]
struct Innovations {
    squares: f64,
    logarithms: f64,
    count: f64,
}

impl Innovations {
    fn of(stretches: &[Stretch<'_>], density: f64) -> Innovations {
        stretches.iter().map(|stretch| stretch.innovations(density)).fold(Innovations::default(), |sum, own| {
            Innovations {
                squares: sum.squares + own.squares,
                logarithms: sum.logarithms + own.logarithms,
                count: sum.count + own.count,
            }
        })
    }

    /// At the most likely variance of a reading, but for constants.
    fn minus_log_likelihood(self) -> f64 {
        let Innovations { squares, logarithms, count } = self;
        count * f64::max(squares / f64::max(count, 1.0), f64::MIN_POSITIVE).ln() + logarithms
    }
}

impl Predicted {
    fn first() -> Predicted {
        let covariance = Matrix3::from_diagonal(&Vector3::new(ANYTHING, ANYTHING, ANYTHING));
        Predicted { state: Vector3::zeros(), covariance }
    }

    fn updated(&self, value: f64) -> Predicted {
        let column = self.covariance.column(0).into_owned();
        let variance = column[0] + 1.0;
        let gain = column / variance;
        let covariance = self.covariance - gain * column.transpose();
        Predicted { state: self.state + gain * (value - self.state[0]), covariance }
    }

    fn moved(&self, step: f64, density: f64) -> Predicted {
        let over = transition(step);
        let covariance = over * self.covariance * over.transpose() + wander(step) * density;
        Predicted { state: over * self.state, covariance: 0.5 * (covariance + covariance.transpose()) }
    }
}

fn transition(step: f64) -> Matrix3<f64> {
    Matrix3::new(1.0, step, 0.5 * step * step, 0.0, 1.0, step, 0.0, 0.0, 1.0)
}

/// What white jerk of density 1 adds to the covariance.
fn wander(step: f64) -> Matrix3<f64> {
    let power = |exponent: i32| step.powi(exponent);
    let (a, b, c) = (power(5) / 20.0, power(4) / 8.0, power(3) / 6.0);
    let (d, e) = (power(3) / 3.0, power(2) / 2.0);
    Matrix3::new(a, b, c, b, d, e, c, e, step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A joint that stands for twice as many samples as tell how firm a spline is, and then moves: 1 rad, six times a hundred samples, read to 0.1 mrad.
    #[test]
    fn motion_after_a_long_standstill_is_followed() {
        let standing = 2 * STRETCH * STRETCHES;
        let truth = |sample: usize| f64::sin(0.06 * sample.saturating_sub(standing) as f64);
        let noise = |sample: usize| 1e-4 * f64::sin(37.0 * (sample * sample) as f64);
        let count = standing + 1500;
        let series = Series {
            steps: vec![1.0; count - 1],
            values: (0..count).map(|sample| truth(sample) + noise(sample)).collect(),
        };
        let density = most_likely(&liveliest(std::slice::from_ref(&series)));
        let states = series.smooth(density);
        let apart =
            states.iter().enumerate().skip(standing + 20).map(|(sample, state)| (state[0] - truth(sample)).abs());
        let largest = apart.take(1460).fold(0.0, f64::max);
        assert!(largest < 3e-4, "{largest}");
    }
}
