//! What an earlier calibration knows of this session's unknowns: linear functions of them, with their whole covariance.
//!
//! A vector of known length (gravity on its sphere, a displacement of known distance) has a singular covariance: nothing
//! varies along the vector `v` itself. Its three components become the two along its tangent plane,
//!
//! ```text
//!     b₁ · x = 0,  b₂ · x = 0        b₁, b₂, v/‖v‖ orthonormal
//! ```
//!
//! whose covariance is `B C Bᵀ`. What remains of the covariance is positive definite, and leaving quantities out of it is
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

/// `Σ coefficient · component = value`, components by their names in a problem.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownCombination {
    /// Such as `joint1.torque_gain`, `gravity.x`, `link2.first_moment.x`, and coefficient.
    pub terms: Vec<(String, f64)>,
    /// Its known value.
    pub value: f64,
}

impl EarlierCalibration {
    /// Quantities with their covariance, row-major.
    ///
    /// # Errors
    /// The covariance is not positive definite once vectors of known length lie in their tangent planes.
    pub fn new(source: String, quantities: Vec<KnownCombination>, covariance: Vec<f64>) -> Result<Self, NoiseError> {
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
        let alone = |q: &&KnownCombination| q.terms.len() == 1 && q.terms[0].0 == component;
        self.quantities.iter().find(alone).map(|q| q.value)
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
        let combined = |row: &Vec<(usize, f64)>| {
            let of = |(i, share): &(usize, f64)| {
                self.quantities[*i].terms.iter().map(|(name, c)| (name.clone(), share * c)).collect::<Vec<_>>()
            };
            let value = row.iter().map(|(i, share)| share * self.quantities[*i].value).sum();
            KnownCombination { terms: row.iter().flat_map(of).collect(), value }
        };
        let between = |a: &[(usize, f64)], b: &[(usize, f64)]| -> f64 {
            a.iter().map(|(i, a)| b.iter().map(|(j, b)| a * b * self.covariance[i * old + j]).sum::<f64>()).sum()
        };
        EarlierCalibration {
            quantities: rows.iter().map(combined).collect(),
            covariance: rows.iter().flat_map(|a| rows.iter().map(|b| between(a, b))).collect(),
            source: self.source,
            shared: self.shared,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn component(name: &str, value: f64) -> KnownCombination {
        KnownCombination { terms: vec![(name.to_owned(), 1.0)], value }
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
    fn a_vector_of_unknown_length_stays_and_a_singular_covariance_is_refused() {
        let diagonal = |z: f64| (0..16).map(|k| if k % 5 == 0 { if k == 15 { z } else { 1.0 } } else { 0.0 }).collect();
        let free = EarlierCalibration::new("file".into(), gravity(), diagonal(0.5)).unwrap();
        assert_eq!((free.quantities().len(), free.value("g.z")), (4, Some(-9.8)));
        let mut singular: Vec<f64> = diagonal(0.5);
        singular[0] = 0.0;
        assert!(EarlierCalibration::new("file".into(), gravity(), singular).is_err());
    }
}
