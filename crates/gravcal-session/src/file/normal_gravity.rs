//! Gravity from latitude and altitude.
//!
//! Normal gravity of the WGS 84 ellipsoid (Somigliana's closed formula), and its decrease with altitude to second order:
//!
//! ```text
//!     γ(φ)    = γ_e (1 + k sin²φ) / √(1 − e² sin²φ)
//!     γ(φ, h) = γ(φ) [1 − 2 (1 + f + m − 2 f sin²φ) h/a + 3 (h/a)²]
//! ```
//!
//! with φ the geodetic latitude, h the altitude above the ellipsoid (that above the sea differs by up to 100 m, worth
//! 3e-4 m/s²). Source: NIMA TR8350.2, *Department of Defense World Geodetic System 1984*, third edition, eqs. (4-1) and
//! (4-3), tables 3.1 to 3.4. Real gravity differs from it by some 5e-4 m/s², seldom more than 3e-3 m/s².

/// Gravity on the equator γ_e, m/s².
const EQUATOR: f64 = 9.7803253359;
/// Somigliana's k.
const SOMIGLIANA: f64 = 0.00193185265241;
/// Square of the first eccentricity e².
const ECCENTRICITY_SQUARED: f64 = 6.69437999014e-3;
/// Semi-major axis a, m.
const SEMI_MAJOR_AXIS: f64 = 6378137.0;
/// Flattening f.
const FLATTENING: f64 = 1.0 / 298.257223563;
/// Centrifugal over gravitational acceleration on the equator, m.
const ROTATION: f64 = 0.00344978650684;

/// Normal gravity, m/s², at a latitude (rad) and an altitude (m).
pub(super) fn normal_gravity(latitude: f64, altitude: f64) -> f64 {
    let sin_squared = latitude.sin().powi(2);
    let surface = EQUATOR * (1.0 + SOMIGLIANA * sin_squared) / (1.0 - ECCENTRICITY_SQUARED * sin_squared).sqrt();
    let height = altitude / SEMI_MAJOR_AXIS;
    let slope = 2.0 * (1.0 + FLATTENING + ROTATION - 2.0 * FLATTENING * sin_squared);
    surface * (1.0 - slope * height + 3.0 * height * height)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    use super::*;

    /// Table 3.4 of the source: equator, pole; and the well-known value at 45°.
    #[test]
    fn published_values() {
        assert_eq!(normal_gravity(0.0, 0.0), 9.7803253359);
        for pole in [FRAC_PI_2, -FRAC_PI_2] {
            assert!((normal_gravity(pole, 0.0) - 9.8321849378).abs() < 1e-10);
        }
        assert!((normal_gravity(FRAC_PI_4, 0.0) - 9.80620).abs() < 1e-5);
    }

    /// The free-air gradient, 0.3086 mGal a metre.
    #[test]
    fn gravity_decreases_with_altitude() {
        let gradient = normal_gravity(FRAC_PI_4, 1.0) - normal_gravity(FRAC_PI_4, 0.0);
        assert!((gradient + 3.086e-6).abs() < 1e-9, "{gradient}");
    }
}
