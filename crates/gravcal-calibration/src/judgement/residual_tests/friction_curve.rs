//! Friction of an arm in motion that is no line over the speed: more of it, or less, where a joint hardly moves (Stribeck).
//!
//! ```text
//!     y = … + d Σ c_k exp(−|q̇| / (s_k V))        d: the direction, V: the joint's highest speed
//! ```
//!
//! One such term whose speed is an unknown is what a session can estimate. The one of these with the largest coefficient says where that begins.

/// How many terms there are.
pub const TERMS: usize = 2;
/// Shares of the highest speed over which the friction falls: both are as far from a line where all speeds are alike. What falls more slowly bends so
/// little that a filter of the torques passes for it.
const SHARES: [f64; TERMS] = [0.04, 0.25];

/// What a unit of each coefficient adds to a reading; `speed`: in shares of the highest.
pub fn terms(direction: f64, speed: f64) -> [f64; TERMS] {
    SHARES.map(|share| direction * (-speed.abs() / share).exp())
}

/// The largest of these coefficients, and over which share of the highest speed its term falls.
pub fn seen_most(coefficients: &[f64]) -> Option<(f64, f64)> {
    coefficients.iter().copied().zip(SHARES).max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The distance of each term from its best line, by its means over a thousand speeds.
    #[test]
    fn terms_are_as_far_from_lines() {
        let speeds: Vec<f64> = (0..1000).map(|k| (f64::from(k) + 0.5) / 1000.0).collect();
        let mean = |of: &dyn Fn(f64) -> f64| speeds.iter().map(|speed| of(*speed)).sum::<f64>() / 1000.0;
        let distances: Vec<f64> = (0..TERMS)
            .map(|term| {
                let (value, about) = (|speed: f64| terms(-1.0, speed)[term], |speed: f64| speed - 0.5);
                let (level, across) = (mean(&value), mean(&|speed| about(speed).powi(2)));
                let slope = mean(&|speed| value(speed) * about(speed)) / across;
                mean(&|speed| (value(speed) - level - slope * about(speed)).powi(2)).sqrt()
            })
            .collect();
        assert!((distances[0] / distances[1] - 1.0).abs() < 0.1, "{distances:?}");
    }

    #[test]
    fn what_is_seen_most_has_its_sign_and_its_speed() {
        assert_eq!(seen_most(&[-0.1, 0.4]), Some((0.4, 0.25)));
        assert_eq!(seen_most(&[-0.6, 0.2]), Some((-0.6, 0.04)));
        assert_eq!(seen_most(&[]), None);
    }
}
