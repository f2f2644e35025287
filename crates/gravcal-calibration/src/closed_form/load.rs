//! Torque gain and position offset of a joint from the difference that two placements of a load make.
//!
//! With `x = o − γ` (γ the direction of gravity in the joint's axis frame), `u = g_⊥ cos(s q + x)`,
//! `w = g_⊥ sin(s q + x)` and `n = C_iᵀ (w, u, 0)`, equations (19)–(22) of the paper are
//!
//! ```text
//!     a = n_y D_x − n_x D_y,   c = n_x D_x + n_y D_y,   e = n_z D_z,     D = k m Δr
//! ```
//!
//! linear in the rank-one matrix `D (cos x, sin x)`: three equations a position, six unknowns. Its principal
//! directions give x and `|k| = ‖D‖ / (m Δr)`, up to the symmetric solution `(x + π, −D)`.

use faer::Mat;
use nalgebra::{Matrix3, Vector3};

/// The difference `(a, c, e)` at one position of the observed joint.
#[derive(Clone, Debug)]
pub(crate) struct PositionDifference {
    /// Coordinate of the observed joint without its offset, `s q`, rad.
    pub coordinate: f64,
    /// Direction γ (rad) of gravity in the joint's axis frame, and the length of its part across the axis, m/s².
    pub gravity_angle: f64,
    /// See `gravity_angle`.
    pub gravity_across: f64,
    /// `(a, c, e)` in the unit of the torque reading.
    pub difference: Vector3<f64>,
}

/// `D` (unit of the reading per m/s²) and, where it was unknown, `o` (rad, within ±90° of `nominal`).
pub(crate) fn gain_and_offset(
    positions: &[PositionDifference],
    to_next: &Matrix3<f64>,
    nominal: f64,
) -> Option<(Vector3<f64>, f64)> {
    // Unknowns D cos o (columns 0..3) and D sin o (columns 3..6).
    let quarter = std::f64::consts::FRAC_PI_2;
    let solution = solve(positions, 6, |position, column| {
        let angle = position.coordinate - position.gravity_angle + if column < 3 { 0.0 } else { quarter };
        lever_pattern(&lever(angle, position.gravity_across, to_next)).column(column % 3).into()
    })?;
    // The best rank-one matrix D (cos o, sin o): o is the principal direction of the rows, D their extent along it.
    let cos_part = Vector3::from_column_slice(&solution[..3]);
    let sin_part = Vector3::from_column_slice(&solution[3..]);
    let offset = 0.5 * (2.0 * cos_part.dot(&sin_part)).atan2(cos_part.norm_squared() - sin_part.norm_squared());
    let displacement = offset.cos() * cos_part + offset.sin() * sin_part;
    let from_nominal = wrap(offset - nominal);
    Some(if from_nominal.abs() <= std::f64::consts::FRAC_PI_2 {
        (displacement, nominal + from_nominal)
    } else {
        (-displacement, nominal + wrap(from_nominal + std::f64::consts::PI))
    })
}

/// `D` where the offset is known; one position suffices.
pub(crate) fn gain_at_known_offset(
    positions: &[PositionDifference],
    to_next: &Matrix3<f64>,
    offset: f64,
) -> Option<Vector3<f64>> {
    let solution = solve(positions, 3, |position, column| {
        let angle = position.coordinate + offset - position.gravity_angle;
        lever_pattern(&lever(angle, position.gravity_across, to_next)).column(column).into()
    })?;
    Some(Vector3::from_column_slice(&solution))
}

/// Least squares over the three equations of every position; `None` where they leave a direction open.
///
/// By faer: nalgebra's decomposition does not recompose some matrices of deficient rank.
fn solve(
    positions: &[PositionDifference],
    unknowns: usize,
    column: impl Fn(&PositionDifference, usize) -> Vector3<f64>,
) -> Option<Vec<f64>> {
    if 3 * positions.len() < unknowns {
        return None;
    }
    let system = Mat::from_fn(3 * positions.len(), unknowns, |i, j| column(&positions[i / 3], j)[i % 3]);
    let svd = system.thin_svd().ok()?;
    if svd.S()[unknowns - 1] <= 1e-9 * svd.S()[0] {
        return None;
    }
    let measured = |i: usize| positions[i / 3].difference[i % 3];
    let along: Vec<f64> = (0..unknowns)
        .map(|k| (0..system.nrows()).map(|i| svd.U()[(i, k)] * measured(i)).sum::<f64>() / svd.S()[k])
        .collect();
    Some((0..unknowns).map(|j| (0..unknowns).map(|k| svd.V()[(j, k)] * along[k]).sum()).collect())
}

/// `n = C_iᵀ (w, u, 0)`.
fn lever(angle: f64, across: f64, to_next: &Matrix3<f64>) -> Vector3<f64> {
    to_next.tr_mul(&(across * Vector3::new(angle.sin(), angle.cos(), 0.0)))
}

/// `(a, c, e)` by `D`.
fn lever_pattern(n: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(n.y, -n.x, 0.0, n.x, n.y, 0.0, 0.0, 0.0, n.z)
}

/// The same angle in (−π, π].
pub(crate) fn wrap(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    let wrapped = angle - turn * (angle / turn).round();
    if wrapped <= -std::f64::consts::PI { wrapped + turn } else { wrapped }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gain_and_offset_come_back_for_any_twist() {
        let displacement = Vector3::new(0.3, -0.2, 0.5);
        let offset = 134.2_f64.to_radians();
        for twist in [90.0_f64, -90.0, 37.0, 150.0] {
            let (s, c) = twist.to_radians().sin_cos();
            let to_next = Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c);
            let positions: Vec<PositionDifference> = [-0.7, 0.8]
                .into_iter()
                .map(|coordinate| {
                    let n = lever(coordinate + offset - 0.4, 7.7, &to_next);
                    let difference = lever_pattern(&n) * displacement;
                    PositionDifference { coordinate, gravity_angle: 0.4, gravity_across: 7.7, difference }
                })
                .collect();
            let (found, angle) = gain_and_offset(&positions, &to_next, 135_f64.to_radians()).unwrap();
            assert!(
                (found - displacement).amax() < 1e-12 && (angle - offset).abs() < 1e-12,
                "{twist} {found} {angle} {offset}"
            );
            let known = gain_at_known_offset(&positions[..1], &to_next, offset).unwrap();
            assert!((known - displacement).amax() < 1e-12);
        }
    }

    #[test]
    fn one_position_does_not_give_an_offset() {
        let position = PositionDifference {
            coordinate: 0.3,
            gravity_angle: 0.4,
            gravity_across: 7.7,
            difference: Vector3::new(1.0, 2.0, 3.0),
        };
        assert!(gain_and_offset(&[position], &Matrix3::identity(), 0.0).is_none());
    }
}
