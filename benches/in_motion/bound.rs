//! The Cramér-Rao bound from single samples with white noise, by differences and nalgebra: the estimator has no part in it.

use nalgebra::DMatrix;

use crate::arm::{Arm, JOINTS, UNKNOWN};

/// Steps of the differences.
const STEP: f64 = 1e-4;
/// Singular values below this share of the largest are zero; a number has a part in what is not told from this share on.
const ZERO: f64 = 1e-7;
const SHARED: f64 = 1e-4;
/// The first joint's offset defines the base's frame.
const HELD: usize = 2 + 3;

/// Standard deviation of each unknown that noise of 1 N·m a sample leaves; infinite where the samples do not tell it.
pub fn bound(arm: &Arm) -> Vec<f64> {
    let column = |place: usize| -> Vec<f64> {
        let at = |step: f64| {
            let mut x = arm.truth;
            x[place] += if place == HELD { 0.0 } else { step };
            arm.readings(&x).concat()
        };
        at(STEP).iter().zip(at(-STEP)).map(|(ahead, behind)| (ahead - behind) / (2.0 * STEP)).collect()
    };
    let mut jacobian = DMatrix::zeros(JOINTS * arm.samples.len(), UNKNOWN);
    let mut scales = vec![1.0; UNKNOWN];
    for (place, scale) in scales.iter_mut().enumerate() {
        let own = column(place);
        let length = own.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        *scale = if length > 0.0 { length } else { 1.0 };
        jacobian.column_mut(place).iter_mut().zip(own).for_each(|(entry, own)| *entry = own / *scale);
    }
    let svd = jacobian.qr().r().svd(false, true);
    let largest = svd.singular_values.max();
    let std = |place: usize| {
        let (mut variance, mut open) = (0.0, 0.0);
        for (size, direction) in svd.singular_values.iter().zip(svd.v_t.iter().flat_map(|v_t| v_t.row_iter())) {
            let part = direction[place] * direction[place];
            if *size > ZERO * largest {
                variance += part / (size * size);
            } else {
                open += part;
            }
        }
        if open > SHARED { f64::INFINITY } else { f64::sqrt(variance) / scales[place] }
    };
    (0..UNKNOWN).map(std).collect()
}
