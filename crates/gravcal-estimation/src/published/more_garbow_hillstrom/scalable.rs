//! Functions of any number of parameters.

use crate::Number;

/// Problem 20, of 31 rows.
pub(super) fn watson<N: Number>(x: &[N], f: &mut [N]) {
    f[29] = x[0];
    f[30] = x[1] - x[0] * x[0] - 1.0;
    for (i, f) in (1..).map(f64::from).zip(&mut f[..29]) {
        let t = i / 29.0;
        let value = x.iter().rev().fold(N::from(0.0), |sum, c| sum * t + *c);
        let slope = x.iter().enumerate().skip(1).rev().fold(N::from(0.0), |sum, (j, c)| sum * t + *c * j as f64);
        *f = slope - value * value - 1.0;
    }
}

/// Problem 23.
pub(super) fn penalty_1<N: Number>(x: &[N], f: &mut [N]) {
    for (f, x) in f.iter_mut().zip(x) {
        *f = (*x - 1.0) * 1e-5f64.sqrt();
    }
    f[x.len()] = x.iter().map(|x| *x * *x).sum::<N>() - 0.25;
}

/// Problem 24.
pub(super) fn penalty_2<N: Number>(x: &[N], f: &mut [N]) {
    let (n, a) = (x.len(), 1e-5f64.sqrt());
    f[0] = x[0] - 0.2;
    for i in 1..n {
        let y = (0.1 * (i + 1) as f64).exp() + (0.1 * i as f64).exp();
        f[i] = ((x[i] * 0.1).exp() + (x[i - 1] * 0.1).exp() - y) * a;
        f[n + i - 1] = ((x[i] * 0.1).exp() - (-0.1f64).exp()) * a;
    }
    f[2 * n - 1] = x.iter().enumerate().map(|(j, x)| *x * *x * (n - j) as f64).sum::<N>() - 1.0;
}

/// Problem 25.
pub(super) fn variably_dimensioned<N: Number>(x: &[N], f: &mut [N]) {
    let n = x.len();
    for (f, x) in f.iter_mut().zip(x) {
        *f = *x - 1.0;
    }
    f[n] = (1..).zip(x).map(|(j, x)| (*x - 1.0) * f64::from(j)).sum();
    f[n + 1] = f[n] * f[n];
}

/// Problem 26.
pub(super) fn trigonometric<N: Number>(x: &[N], f: &mut [N]) {
    // n − Σ cos x_j, without cancellation
    let common: N = x.iter().map(|x| -x.cos() + 1.0).sum();
    for (i, (f, x)) in (1..).map(f64::from).zip(f.iter_mut().zip(x)) {
        *f = common + (-x.cos() + 1.0) * i - x.sin();
    }
}

/// Problem 27.
pub(super) fn brown_almost_linear<N: Number>(x: &[N], f: &mut [N]) {
    let n = x.len();
    let sum: N = x.iter().copied().sum::<N>() - (n + 1) as f64;
    for (f, x) in f.iter_mut().zip(x) {
        *f = *x + sum;
    }
    f[n - 1] = x.iter().copied().product::<N>() - 1.0;
}

/// Problem 28.
pub(super) fn discrete_boundary_value<N: Number>(x: &[N], f: &mut [N]) {
    let h = 1.0 / (x.len() + 1) as f64;
    for i in 0..x.len() {
        let t = (i + 1) as f64 * h;
        f[i] = x[i] * 2.0 - before(x, i) - after(x, i) + (x[i] + t + 1.0).powi(3) * (h * h / 2.0);
    }
}

/// Problem 29.
pub(super) fn discrete_integral_equation<N: Number>(x: &[N], f: &mut [N]) {
    let h = 1.0 / (x.len() + 1) as f64;
    let cube = |j: usize| (x[j] + (j + 1) as f64 * h + 1.0).powi(3);
    for i in 0..x.len() {
        let t = (i + 1) as f64 * h;
        let below: N = (0..=i).map(|j| cube(j) * ((j + 1) as f64 * h)).sum();
        let above: N = (i + 1..x.len()).map(|j| cube(j) * (1.0 - (j + 1) as f64 * h)).sum();
        f[i] = x[i] + (below * (1.0 - t) + above * t) * (h / 2.0);
    }
}

/// Problem 30.
pub(super) fn broyden_tridiagonal<N: Number>(x: &[N], f: &mut [N]) {
    for i in 0..x.len() {
        f[i] = (-x[i] * 2.0 + 3.0) * x[i] - before(x, i) - after(x, i) * 2.0 + 1.0;
    }
}

/// Problem 31.
pub(super) fn broyden_banded<N: Number>(x: &[N], f: &mut [N]) {
    for i in 0..x.len() {
        let band = i.saturating_sub(5)..x.len().min(i + 2);
        let neighbours: N = band.filter(|j| *j != i).map(|j| x[j] * (x[j] + 1.0)).sum();
        f[i] = x[i] * (x[i] * x[i] * 5.0 + 2.0) + 1.0 - neighbours;
    }
}

/// Problem 32.
pub(super) fn linear_full_rank<N: Number>(x: &[N], f: &mut [N]) {
    let mean = x.iter().copied().sum::<N>() * (2.0 / f.len() as f64);
    for (i, f) in f.iter_mut().enumerate() {
        *f = -mean - 1.0 + x.get(i).copied().unwrap_or(N::from(0.0));
    }
}

/// Problem 33.
pub(super) fn linear_rank_one<N: Number>(x: &[N], f: &mut [N]) {
    let sum: N = (1..).zip(x).map(|(j, x)| *x * f64::from(j)).sum();
    for (i, f) in (1..).map(f64::from).zip(f) {
        *f = sum * i - 1.0;
    }
}

/// Problem 34.
pub(super) fn linear_rank_one_with_zeros<N: Number>(x: &[N], f: &mut [N]) {
    let (inner, last) = (x.len() - 1, f.len() - 1);
    let sum: N = (1..inner).map(|j| x[j] * (j + 1) as f64).sum();
    for (i, f) in f.iter_mut().enumerate() {
        *f = if i == 0 || i == last { N::from(-1.0) } else { sum * i as f64 - 1.0 };
    }
}

/// Problem 35: means of the Chebyshev polynomials, shifted to the unit interval, less their integrals.
pub(super) fn chebyquad<N: Number>(x: &[N], f: &mut [N]) {
    f.fill(N::from(0.0));
    for x in x {
        let y = *x * 2.0 - 1.0;
        let (mut lower, mut polynomial) = (N::from(1.0), y);
        for f in f.iter_mut() {
            *f += polynomial;
            (lower, polynomial) = (polynomial, y * polynomial * 2.0 - lower);
        }
    }
    for (i, f) in (1..).map(f64::from).zip(f) {
        let integral = if i % 2.0 == 0.0 { -1.0 / (i * i - 1.0) } else { 0.0 };
        *f = *f / x.len() as f64 - integral;
    }
}

fn before<N: Number>(x: &[N], i: usize) -> N {
    if i == 0 { N::from(0.0) } else { x[i - 1] }
}

fn after<N: Number>(x: &[N], i: usize) -> N {
    x.get(i + 1).copied().unwrap_or(N::from(0.0))
}
