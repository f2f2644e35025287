//! What an earlier calibration knows of this session's unknowns: linear functions of them, with their whole covariance.
//!
//! A vector of known length (gravity on its sphere, a displacement of known distance) has a singular covariance: nothing
//! varies along the vector `v` itself. Its three components become the two along its tangent plane,
//!
//! ```text
//!     b₁ · x = 0,  b₂ · x = 0        b₁, b₂, v/‖v‖ orthonormal
//! ```
//!
//! whose covariance is `B C Bᵀ`. Of masses and moments `h` readings tell the products with a torque gain `k`, far better than `h` or `k` by itself where
//! little tells the scale of torques. Known together as linear functions they would deny, at another scale, what readings tell: by `ε²`, the scale
//! being `ε` off. So what is known is
//!
//! ```text
//!     k h = k₀ h₀,     δ(k h) = k₀ δh + h₀ δk
//! ```
//!
//! What remains of the covariance is positive definite, and leaving quantities out of it is
//! leaving their rows and columns out.

use gravcal_estimation::{Noise, NoiseError};
use nalgebra::Vector3;

/// A vector varies along itself by less than this share of its variance: its length is known.
const KNOWN_LENGTH: f64 = 1e-9;

/// Knowledge from an earlier calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct EarlierCalibration {
    /// The file, as the session names it, and the estimator in it.
    pub source: String,
    /// File names of recordings that it was made from as well as this session, which takes parts of them.
    shared: Vec<String>,
    quantities: Vec<KnownCombination>,
    /// Row-major.
    covariance: Vec<f64>,
}

/// `times · Σ coefficient · component = value`, components by their names in a problem.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownCombination {
    /// Such as `joint1.torque_gain`, `gravity.x`, `link2.first_moment.x`, and coefficient.
    pub terms: Vec<(String, f64)>,
    /// The torque gain that multiplies the sum; `None`: 1.
    pub times: Option<String>,
    /// Its known value.
    pub value: f64,
}

impl EarlierCalibration {
    /// Quantities with their covariance, row-major.
    ///
    /// # Errors
    /// The covariance is not positive definite once vectors of known length lie in their tangent planes.
    pub fn new(source: String, quantities: Vec<KnownCombination>, covariance: Vec<f64>) -> Result<Self, NoiseError> {
        let itself: Vec<Vec<(usize, f64)>> = (0..quantities.len()).map(|place| vec![(place, 1.0)]).collect();
        let covariance = combined(&itself, &covariance, quantities.len());
        let mut earlier = EarlierCalibration { source, shared: Vec::new(), quantities, covariance };
        while let Some(start) = (0..earlier.quantities.len()).find(|start| earlier.has_known_length(*start)) {
            earlier = earlier.in_tangent_plane(start);
        }
        Noise::correlated(&earlier.covariance, earlier.quantities.len())?;
        Ok(earlier)
    }

    /// The same, made from these recordings, of which the session takes parts.
    #[must_use]
    pub fn sharing(self, shared: Vec<String>) -> Self {
        EarlierCalibration { shared, ..self }
    }

    /// What the reader of a result should know.
    pub fn notes(&self) -> Vec<String> {
        let EarlierCalibration { source, shared, quantities, .. } = self;
        let known =
            format!("{} quantities are known from {source}, and enter with their covariance.", quantities.len());
        let parts = shared.iter().map(|name| {
            format!("{source} was made from {name}, too: that it took other parts of it than this session is for you to see.")
        });
        [known].into_iter().chain(parts).collect()
    }

    /// Whether it knows anything whose name begins like this.
    pub fn knows_any(&self, start: &str) -> bool {
        self.quantities.iter().flat_map(|quantity| &quantity.terms).any(|(name, _)| name.starts_with(start))
    }

    /// What is known.
    pub fn quantities(&self) -> &[KnownCombination] {
        &self.quantities
    }

    /// Variance of a quantity, in the square of its unit.
    pub fn variance(&self, place: usize) -> f64 {
        self.covariance[place * (self.quantities.len() + 1)]
    }

    /// Whether a component is known by itself.
    pub fn knows(&self, component: &str) -> bool {
        self.value(component).is_some()
    }

    /// The value of a component that is known by itself.
    pub fn value(&self, component: &str) -> Option<f64> {
        let known = &self.quantities[self.alone(component)?];
        let times = known.times.as_ref().map_or(Some(1.0), |gain| self.value(gain))?;
        Some(known.value / times)
    }

    /// Place of a component that is known by itself.
    fn alone(&self, component: &str) -> Option<usize> {
        self.quantities.iter().position(|q| q.terms.len() == 1 && q.terms[0].0 == component)
    }

    /// The same with quantities times a torque gain, where it is known by itself. `gain_of`: the gain of each quantity of masses and moments.
    #[must_use]
    pub fn times_gains(self, gain_of: impl Fn(&KnownCombination) -> Option<String>) -> Self {
        let size = self.quantities.len();
        let gains: Vec<Option<(String, usize)>> = self
            .quantities
            .iter()
            .map(|known| gain_of(known).and_then(|gain| self.alone(&gain).map(|place| (gain, place))))
            .collect();
        // Each new quantity as coefficients of small changes of the old ones.
        let row = |(place, gain): (usize, &Option<(String, usize)>)| match gain {
            Some((_, of_gain)) => {
                vec![(place, self.quantities[*of_gain].value), (*of_gain, self.quantities[place].value)]
            }
            None => vec![(place, 1.0)],
        };
        let rows: Vec<Vec<(usize, f64)>> = gains.iter().enumerate().map(row).collect();
        let multiplied = |(known, gain): (&KnownCombination, &Option<(String, usize)>)| match gain {
            Some((name, place)) => KnownCombination {
                terms: known.terms.clone(),
                times: Some(name.clone()),
                value: known.value * self.quantities[*place].value,
            },
            None => known.clone(),
        };
        let quantities = self.quantities.iter().zip(&gains).map(multiplied).collect();
        let covariance = combined(&rows, &self.covariance, size);
        EarlierCalibration { quantities, covariance, source: self.source, shared: self.shared }
    }

    /// Covariance of some of the quantities.
    ///
    /// # Errors
    /// None but those of [`EarlierCalibration::new`].
    pub fn noise(&self, kept: &[usize]) -> Result<Noise, NoiseError> {
        let size = self.quantities.len();
        let entry = |(i, j): (usize, usize)| self.covariance[i * size + j];
        let pairs = kept.iter().flat_map(|i| kept.iter().map(move |j| (*i, *j)));
        let part: Vec<f64> = pairs.map(entry).collect();
        Noise::correlated(&part, kept.len())
    }

    /// The three quantities from `start` on, where they are the components of one vector.
    fn vector(&self, start: usize) -> Option<Vector3<f64>> {
        let triple = self.quantities.get(start..start + 3)?;
        let stem = |q: &KnownCombination, axis: &str| match q.terms.as_slice() {
            [(name, 1.0)] => name.strip_suffix(axis).map(str::to_owned),
            _ => None,
        };
        let stems = [stem(&triple[0], ".x")?, stem(&triple[1], ".y")?, stem(&triple[2], ".z")?];
        let one = stems[0] == stems[1] && stems[1] == stems[2];
        one.then(|| Vector3::new(triple[0].value, triple[1].value, triple[2].value))
    }

    fn has_known_length(&self, start: usize) -> bool {
        let Some(direction) = self.vector(start).and_then(|v| v.try_normalize(0.0)) else { return false };
        let entry = |i: usize, j: usize| self.covariance[(start + i) * self.quantities.len() + start + j];
        let along: f64 = (0..9).map(|k| direction[k / 3] * entry(k / 3, k % 3) * direction[k % 3]).sum();
        along < KNOWN_LENGTH * (0..3).map(|i| entry(i, i)).sum::<f64>()
    }

    /// The same with the vector that begins at `start` along its tangent plane.
    fn in_tangent_plane(self, start: usize) -> Self {
        let vector = self.vector(start).unwrap_or_else(Vector3::x);
        let least = vector.iamin();
        let first = vector.cross(&Vector3::ith(least, 1.0)).normalize();
        let basis = [first, vector.cross(&first).normalize()];
        let old = self.quantities.len();
        // Each new quantity as coefficients of old ones.
        let kept = |i: usize| vec![(i, 1.0)];
        let tangent = basis.iter().map(|b| (0..3).map(|axis| (start + axis, b[axis])).collect());
        let rows: Vec<Vec<(usize, f64)>> =
            (0..start).map(kept).chain(tangent).chain((start + 3..old).map(kept)).collect();
        let of_row = |row: &Vec<(usize, f64)>| {
            let of = |(i, share): &(usize, f64)| {
                self.quantities[*i].terms.iter().map(|(name, c)| (name.clone(), share * c)).collect::<Vec<_>>()
            };
            let value = row.iter().map(|(i, share)| share * self.quantities[*i].value).sum();
            KnownCombination { terms: row.iter().flat_map(of).collect(), times: None, value }
        };
        EarlierCalibration {
            quantities: rows.iter().map(of_row).collect(),
            covariance: combined(&rows, &self.covariance, old),
            source: self.source,
            shared: self.shared,
        }
    }
}

/// `R C Rᵀ`, row-major, of a covariance of this size; rows as places with their coefficients. Both halves are alike to the bit, whatever rounding left.
fn combined(rows: &[Vec<(usize, f64)>], covariance: &[f64], size: usize) -> Vec<f64> {
    let between = |a: &[(usize, f64)], b: &[(usize, f64)]| -> f64 {
        let entry = |i: usize, j: usize| 0.5 * (covariance[i * size + j] + covariance[j * size + i]);
        a.iter().map(|(i, a)| b.iter().map(|(j, b)| a * b * entry(*i, *j)).sum::<f64>()).sum()
    };
    let count = rows.len();
    (0..count * count)
        .map(|place| (place / count, place % count))
        .map(|(i, j)| between(&rows[i.max(j)], &rows[i.min(j)]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn component(name: &str, value: f64) -> KnownCombination {
        KnownCombination { terms: vec![(name.to_owned(), 1.0)], times: None, value }
    }

    fn gravity() -> Vec<KnownCombination> {
        vec![component("k", 7.0), component("g.x", 0.0), component("g.y", 0.0), component("g.z", -9.8)]
    }

    #[test]
    fn a_vector_of_known_length_has_two_quantities() {
        #[rustfmt::skip]
        let covariance = vec![
            4.0, 0.2, 0.4, 0.0,
            0.2, 1.0, 0.5, 0.0,
            0.4, 0.5, 2.0, 0.0,
            0.0, 0.0, 0.0, 0.0,
        ];
        let earlier = EarlierCalibration::new("file".into(), gravity(), covariance).unwrap();
        assert_eq!(earlier.quantities().len(), 3);
        assert_eq!((earlier.value("k"), earlier.knows("g.x")), (Some(7.0), false));
        for tangent in &earlier.quantities()[1..] {
            let along: f64 = tangent.terms.iter().zip([0.0, 0.0, -9.8]).map(|((_, c), g)| c * g).sum();
            assert!(along.abs() < 1e-15 && tangent.value.abs() < 1e-15, "{tangent:?}");
        }
        // The determinant does not depend on the basis of the plane.
        let c = &earlier.covariance;
        assert!((c[4] * c[8] - c[5] * c[7] - (2.0 - 0.25)).abs() < 1e-14, "{c:?}");
        assert!((c[1].hypot(c[2]) - 0.2f64.hypot(0.4)).abs() < 1e-15, "{c:?}");
    }

    #[test]
    fn moments_are_known_times_a_gain() {
        let known = vec![component("k", 2.0), component("h", 3.0)];
        // A scale that is 10 % off: k up by what h is down.
        let covariance = vec![0.04, -0.06, -0.06, 0.0901];
        let earlier = EarlierCalibration::new("file".into(), known, covariance).unwrap();
        let earlier = earlier.times_gains(|known| (known.terms[0].0 == "h").then(|| "k".to_owned()));
        assert_eq!((earlier.value("k"), earlier.value("h")), (Some(2.0), Some(3.0)));
        assert_eq!((earlier.quantities()[1].value, earlier.quantities()[1].times.as_deref()), (6.0, Some("k")));
        // var(2 δh + 3 δk) = 4 · 0.0901 + 9 · 0.04 − 12 · 0.06
        let expected = [0.04, 2.0 * -0.06 + 3.0 * 0.04, 4.0 * 0.0901 + 9.0 * 0.04 - 12.0 * 0.06];
        let c = &earlier.covariance;
        [c[0], c[1], c[3]].iter().zip(expected).for_each(|(c, expected)| assert!((c - expected).abs() < 1e-14, "{c}"));
    }

    #[test]
    fn a_vector_of_unknown_length_stays_and_a_singular_covariance_is_refused() {
        let diagonal = |z: f64| (0..16).map(|k| if k % 5 == 0 { if k == 15 { z } else { 1.0 } } else { 0.0 }).collect();
        let free = EarlierCalibration::new("file".into(), gravity(), diagonal(0.5)).unwrap();
        assert_eq!((free.quantities().len(), free.value("g.z")), (4, Some(-9.8)));
        let mut singular: Vec<f64> = diagonal(0.5);
        singular[0] = 0.0;
        assert!(EarlierCalibration::new("file".into(), gravity(), singular).is_err());
    }
}
