//! Functions of two to four parameters without data, and their repetitions.

use std::f64::consts::PI;

use crate::Number;

/// Problems 1 and 21.
pub(super) fn rosenbrock<N: Number>(x: &[N], f: &mut [N]) {
    for (x, f) in x.chunks_exact(2).zip(f.chunks_exact_mut(2)) {
        f[0] = (x[1] - x[0] * x[0]) * 10.0;
        f[1] = -x[0] + 1.0;
    }
}

/// Problem 2.
pub(super) fn freudenstein_roth<N: Number>(x: &[N], f: &mut [N]) {
    f[0] = x[0] - 13.0 + ((-x[1] + 5.0) * x[1] - 2.0) * x[1];
    f[1] = x[0] - 29.0 + ((x[1] + 1.0) * x[1] - 14.0) * x[1];
}

/// Problem 3.
pub(super) fn powell_badly_scaled<N: Number>(x: &[N], f: &mut [N]) {
    f[0] = x[0] * x[1] * 1e4 - 1.0;
    f[1] = (-x[0]).exp() + (-x[1]).exp() - 1.0001;
}

/// Problem 4.
pub(super) fn brown_badly_scaled<N: Number>(x: &[N], f: &mut [N]) {
    f[0] = x[0] - 1e6;
    f[1] = x[1] - 2e-6;
    f[2] = x[0] * x[1] - 2.0;
}

/// Problem 5.
pub(super) fn beale<N: Number>(x: &[N], f: &mut [N]) {
    for (i, y) in [1.5, 2.25, 2.625].into_iter().enumerate() {
        f[i] = x[0] * (x[1].powi(i as i32 + 1) - 1.0) + y;
    }
}

/// Problem 6.
pub(super) fn jennrich_sampson<N: Number>(x: &[N], f: &mut [N]) {
    for (i, f) in (1..).map(f64::from).zip(f) {
        *f = -(x[0] * i).exp() - (x[1] * i).exp() + (2.0 + 2.0 * i);
    }
}

/// Problem 7. The angle is measured from −1/4 to 3/4 of a turn, with its jump on the negative second axis.
pub(super) fn helical_valley<N: Number>(x: &[N], f: &mut [N]) {
    let half = if x[0] < 0.0 { 0.5 } else { 0.0 };
    let angle = (x[1] / x[0]).atan() / (2.0 * PI) + half;
    f[0] = (x[2] - angle * 10.0) * 10.0;
    f[1] = ((x[0] * x[0] + x[1] * x[1]).sqrt() - 1.0) * 10.0;
    f[2] = x[2];
}

/// Problem 12.
pub(super) fn box_three<N: Number>(x: &[N], f: &mut [N]) {
    for (i, f) in (1..).map(f64::from).zip(f) {
        let t = 0.1 * i;
        *f = (-x[0] * t).exp() - (-x[1] * t).exp() - x[2] * ((-t).exp() - (-10.0 * t).exp());
    }
}

/// Problems 13 and 22.
pub(super) fn powell_singular<N: Number>(x: &[N], f: &mut [N]) {
    for (x, f) in x.chunks_exact(4).zip(f.chunks_exact_mut(4)) {
        f[0] = x[0] + x[1] * 10.0;
        f[1] = (x[2] - x[3]) * 5f64.sqrt();
        f[2] = (x[1] - x[2] * 2.0).powi(2);
        f[3] = (x[0] - x[3]).powi(2) * 10f64.sqrt();
    }
}

/// Problem 14.
pub(super) fn wood<N: Number>(x: &[N], f: &mut [N]) {
    f[0] = (x[1] - x[0] * x[0]) * 10.0;
    f[1] = -x[0] + 1.0;
    f[2] = (x[3] - x[2] * x[2]) * 90f64.sqrt();
    f[3] = -x[2] + 1.0;
    f[4] = (x[1] + x[3] - 2.0) * 10f64.sqrt();
    f[5] = (x[1] - x[3]) / 10f64.sqrt();
}

/// Problem 16.
pub(super) fn brown_dennis<N: Number>(x: &[N], f: &mut [N]) {
    for (i, f) in (1..).map(f64::from).zip(f) {
        let t = i / 5.0;
        *f = (x[0] + x[1] * t - t.exp()).powi(2) + (x[2] + x[3] * t.sin() - t.cos()).powi(2);
    }
}
