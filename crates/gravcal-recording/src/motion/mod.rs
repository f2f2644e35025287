//! A recording in motion as blocks of samples: what standstills ([`crate::still`]) and sweeps ([`crate::sweep`]) are found in.

mod alternation;
pub(crate) mod approach;
pub(crate) mod block;
pub(crate) mod channels;
pub(crate) mod reader;
pub(crate) mod rough_noise;
pub(crate) mod row_clock;
pub(crate) mod sampler;
mod wraps;

/// The middle one, or the mean of the two in the middle.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}
