//! Positions of a joint as a spline, and with them velocities and accelerations.
//!
//! The joint's jerk is taken for white noise of density `λ r²`, its position readings for its positions with white noise of variance `r²`:
//!
//! ```text
//!     d/dt (q, q̇, q̈) = (q̇, q̈, w),     q_k = q(t_k) + e_k
//! ```
//!
//! What then is most likely is a smoothing spline of fifth degree (Wahba 1978). A Kalman filter forward and its adjoint backward (Bryson and Frazier) find it in
//! time that grows with the number of samples, at any spacing; `λ` is the most likely one, `r` follows from it. Between two samples the spline is the polynomial of
//! fifth degree through both states.
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
/// Samples that tell how firm.
const TELLING: usize = 4000;

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
        let informative = series.iter().max_by_key(|series| series.values.len());
        let Some(informative) = informative else { continue };
        let density = informative.most_likely();
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

    /// The most likely density of the jerk.
    fn most_likely(&self) -> f64 {
        let count = self.values.len().min(TELLING);
        let worth = |logarithm: f64| self.minus_log_likelihood(10f64.powf(logarithm), count);
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

    /// Of the first samples, at the most likely variance of a reading, but for constants.
    fn minus_log_likelihood(&self, density: f64, count: usize) -> f64 {
        let (mut squares, mut logarithms, mut innovations) = (0.0, 0.0, 0.0);
        let mut filter = Predicted::first();
        for (sample, value) in self.values[..count].iter().enumerate() {
            if sample > 0 {
                filter = filter.updated(self.values[sample - 1]).moved(self.steps[sample - 1], density);
            }
            // Three samples say where it starts, and nothing of how smooth it is.
            if sample > 2 {
                let variance = filter.covariance[(0, 0)] + 1.0;
                squares += (value - filter.state[0]).powi(2) / variance;
                logarithms += variance.ln();
                innovations += 1.0;
            }
        }
        innovations * f64::max(squares / f64::max(innovations, 1.0), f64::MIN_POSITIVE).ln() + logarithms
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
