//! Functions that fit a model to data.

use crate::Number;

/// Problem 8.
pub(super) fn bard<N: Number>(x: &[N], f: &mut [N]) {
    const Y: [f64; 15] = [0.14, 0.18, 0.22, 0.25, 0.29, 0.32, 0.35, 0.39, 0.37, 0.58, 0.73, 0.96, 1.34, 2.10, 4.39];
    for (i, (f, y)) in f.iter_mut().zip(Y).enumerate() {
        let u = (i + 1) as f64;
        let v = 16.0 - u;
        *f = -(x[0] + (x[1] * v + x[2] * u.min(v)).recip() * u) + y;
    }
}

/// Problem 9.
pub(super) fn gaussian<N: Number>(x: &[N], f: &mut [N]) {
    const Y: [f64; 8] = [0.0009, 0.0044, 0.0175, 0.0540, 0.1295, 0.2420, 0.3521, 0.3989];
    let symmetric = Y.into_iter().chain(Y.into_iter().rev().skip(1));
    for (i, (f, y)) in f.iter_mut().zip(symmetric).enumerate() {
        let t = (7.0 - i as f64) / 2.0;
        *f = x[0] * (-x[1] * (-x[2] + t).powi(2) / 2.0).exp() - y;
    }
}

/// Problem 10.
pub(super) fn meyer<N: Number>(x: &[N], f: &mut [N]) {
    const Y: [f64; 16] = [
        34780.0, 28610.0, 23650.0, 19630.0, 16370.0, 13720.0, 11540.0, 9744.0, 8261.0, 7030.0, 6005.0, 5147.0, 4427.0,
        3820.0, 3307.0, 2872.0,
    ];
    for (i, (f, y)) in f.iter_mut().zip(Y).enumerate() {
        let t = 50.0 + 5.0 * i as f64;
        *f = x[0] * (x[1] / (x[2] + t)).exp() - y;
    }
}

/// Problem 11. The paper prints `y_i m i x2` in the power; it means `y_i − x2`, without which its minimum is none.
pub(super) fn gulf<N: Number>(x: &[N], f: &mut [N]) {
    for (i, f) in (1..).map(f64::from).zip(f) {
        let t = i / 100.0;
        let y = 25.0 + (-50.0 * t.ln()).powf(2.0 / 3.0);
        *f = (-(-x[1] + y).abs().powd(x[2]) / x[0]).exp() - t;
    }
}

/// Problem 15.
pub(super) fn kowalik_osborne<N: Number>(x: &[N], f: &mut [N]) {
    const Y: [f64; 11] = [0.1957, 0.1947, 0.1735, 0.1600, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246];
    const U: [f64; 11] = [4.0, 2.0, 1.0, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625];
    for ((f, y), u) in f.iter_mut().zip(Y).zip(U) {
        *f = -x[0] * (x[1] * u + u * u) / (x[2] * u + x[3] + u * u) + y;
    }
}

/// Problem 17.
pub(super) fn osborne_1<N: Number>(x: &[N], f: &mut [N]) {
    const Y: [f64; 33] = [
        0.844, 0.908, 0.932, 0.936, 0.925, 0.908, 0.881, 0.850, 0.818, 0.784, 0.751, 0.718, 0.685, 0.658, 0.628, 0.603,
        0.580, 0.558, 0.538, 0.522, 0.506, 0.490, 0.478, 0.467, 0.457, 0.448, 0.438, 0.431, 0.424, 0.420, 0.414, 0.411,
        0.406,
    ];
    for (i, (f, y)) in f.iter_mut().zip(Y).enumerate() {
        let t = 10.0 * i as f64;
        *f = -(x[0] + x[1] * (-x[3] * t).exp() + x[2] * (-x[4] * t).exp()) + y;
    }
}

/// Problem 18.
pub(super) fn biggs_exp6<N: Number>(x: &[N], f: &mut [N]) {
    for (i, f) in (1..).map(f64::from).zip(f) {
        let t = 0.1 * i;
        let y = (-t).exp() - 5.0 * (-10.0 * t).exp() + 3.0 * (-4.0 * t).exp();
        *f = x[2] * (-x[0] * t).exp() - x[3] * (-x[1] * t).exp() + x[5] * (-x[4] * t).exp() - y;
    }
}

/// Problem 19.
pub(super) fn osborne_2<N: Number>(x: &[N], f: &mut [N]) {
    const Y: [f64; 65] = [
        1.366, 1.191, 1.112, 1.013, 0.991, 0.885, 0.831, 0.847, 0.786, 0.725, 0.746, 0.679, 0.608, 0.655, 0.616, 0.606,
        0.602, 0.626, 0.651, 0.724, 0.649, 0.649, 0.694, 0.644, 0.624, 0.661, 0.612, 0.558, 0.533, 0.495, 0.500, 0.423,
        0.395, 0.375, 0.372, 0.391, 0.396, 0.405, 0.428, 0.429, 0.523, 0.562, 0.607, 0.653, 0.672, 0.708, 0.633, 0.668,
        0.645, 0.632, 0.591, 0.559, 0.597, 0.625, 0.739, 0.710, 0.729, 0.720, 0.636, 0.581, 0.428, 0.292, 0.162, 0.098,
        0.054,
    ];
    for (i, (f, y)) in f.iter_mut().zip(Y).enumerate() {
        let t = i as f64 / 10.0;
        let bump = |k: usize| x[k] * (-(-x[k + 7] + t).powi(2) * x[k + 4]).exp();
        *f = -(x[0] * (-x[4] * t).exp() + bump(1) + bump(2) + bump(3)) + y;
    }
}
