//! How an accelerometer is mounted on a tilt table: a rotation, from readings at known tilts of the table (Wahba's problem).
//!
//! ```text
//!     reading_S = R_TSᵀ a_T,   a_T = g (−cos α sin β, sin α, cos α cos β)
//! ```
//!
//! with `R_TS` from the sensor's frame S to the table's frame T, which is tilted by α about x and then by β about y, and `a_T` the specific
//! force. Standard deviations are those of turning the sensor about its own axes. Where the table is never tilted, the sensor may be turned
//! about the vertical as one likes: this direction is named.
//!
//! ```sh
//! cargo run --release -p gravcal-identification --example mounting
//! ```

use std::error::Error;

use gravcal_estimation::{
    Automatic, Block, BlockId, EvaluateError, Factor, Formula, LocalNumbers, Noise, Number, ProblemBuilder,
    RankAnalysis, Rotation, SolveContext,
};
use gravcal_solvers::SolverName;

const GRAVITY: f64 = 9.80665;
/// Standard deviation of a reading, m/s².
const NOISE: f64 = 0.02;

/// Tilts of the table α and β, degrees.
type Tilt = [f64; 2];

/// Tilts, and what the sensor reads there, m/s²: mounted upside down, turned by 91° and 2° and 1.5° askew.
const READINGS: [(Tilt, [f64; 3]); 6] = [
    ([0.0, 0.0], [0.347, 0.260, -9.807]),
    ([30.0, 0.0], [-4.592, 0.325, -8.648]),
    ([-30.0, 0.0], [5.231, 0.109, -8.312]),
    ([0.0, 30.0], [0.372, 5.102, -8.360]),
    ([0.0, -30.0], [0.219, -4.676, -8.603]),
    ([20.0, 20.0], [-2.946, 3.450, -8.718]),
];

/// Specific force in the frame of the table, m/s².
fn specific_force([alpha, beta]: Tilt) -> [f64; 3] {
    let [(s1, c1), (s2, c2)] = [alpha, beta].map(|angle| angle.to_radians().sin_cos());
    [-c1 * s2, s1, c1 * c2].map(|c| GRAVITY * c)
}

/// `R_TSᵀ a_T` less a reading.
#[derive(Debug)]
struct Sensed {
    mounting: [BlockId; 1],
    force: [f64; 3],
    reading: [f64; 3],
}

impl Formula for Sensed {
    fn blocks(&self) -> &[BlockId] {
        &self.mounting
    }

    fn len(&self) -> usize {
        3
    }

    fn evaluate<N: Number>(&self, x: LocalNumbers<'_, N>, residual: &mut [N]) -> Result<(), EvaluateError> {
        for (axis, column) in columns(x.block(0)).into_iter().enumerate() {
            let [x, y, z] = column;
            residual[axis] = x * self.force[0] + y * self.force[1] + z * self.force[2] - self.reading[axis];
        }
        Ok(())
    }
}

/// Columns of the rotation matrix of a unit quaternion: the axes of S in T.
fn columns<N: Number>(q: &[N]) -> [[N; 3]; 3] {
    let [w, x, y, z] = [q[0], q[1], q[2], q[3]];
    [
        [w * w + x * x - y * y - z * z, (x * y + w * z) * 2.0, (x * z - w * y) * 2.0],
        [(x * y - w * z) * 2.0, w * w - x * x + y * y - z * z, (y * z + w * x) * 2.0],
        [(x * z + w * y) * 2.0, (y * z - w * x) * 2.0, w * w - x * x - y * y + z * z],
    ]
}

/// How the sensor is mounted.
struct Mounting {
    /// Unit quaternion of `R_TS`.
    quaternion: [f64; 4],
    /// Of turning about each axis of S, rad; where all of it is determined.
    std: Option<[f64; 3]>,
    /// Axes in S about which the readings let the sensor turn.
    open: Vec<Vec<f64>>,
}

/// From a sensor that is mounted as the table is.
fn mounting(readings: &[(Tilt, [f64; 3])]) -> Result<Mounting, Box<dyn Error>> {
    let mut builder = ProblemBuilder::new();
    let block = Block::vector("mounting", "", &["w", "x", "y", "z"]).on(Rotation);
    let id = builder.add_block(block, &[1.0, 0.0, 0.0, 0.0]);
    for (tilt, reading) in readings {
        let sensed = Sensed { mounting: [id], force: specific_force(*tilt), reading: *reading };
        builder.add_factor(Factor::new(Automatic(sensed), Noise::independent(&[NOISE; 3])?));
    }
    let (problem, start) = builder.build()?;
    let solver = SolverName::LevenbergMarquardt.build();
    let estimate = solver.solve(&problem, &start, &mut SolveContext::default())?;
    let analysis = RankAnalysis::of(&problem, &estimate)?;
    let open = analysis.null_space_within(&[0, 1, 2]);
    let covariance = analysis.covariance();
    let quaternion = estimate.values.get(id).try_into()?;
    Ok(Mounting { quaternion, std: open.is_empty().then(|| [0, 1, 2].map(|axis| covariance.std(axis))), open })
}

fn main() -> Result<(), Box<dyn Error>> {
    for readings in [&READINGS[..], &READINGS[..1]] {
        let Mounting { quaternion, std, open } = mounting(readings)?;
        for (axis, column) in ["x", "y", "z"].iter().zip(columns(&quaternion)) {
            println!("{axis} of the sensor points to {column:>8.5?} in the frame of the table");
        }
        match std {
            Some(std) => println!("± {:.3?}° about the axes of the sensor", std.map(f64::to_degrees)),
            None => println!("the readings let it turn about {open:.3?}: tilt the table"),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

    use super::*;

    /// As the readings were simulated, (w, x, y, z).
    const TRUTH: [f64; 4] = [0.02156624334, 0.70057953452, -0.71324084024, 0.00327364882];

    fn unit([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
        UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
    }

    /// `R_ST`: F. L. Markley, *Attitude determination using vector observations and the singular value decomposition*, Journal of the
    /// Astronautical Sciences 36, 1988.
    fn by_singular_values() -> Matrix3<f64> {
        let outer = |(tilt, reading): &(Tilt, [f64; 3])| {
            Vector3::from(*reading) * Vector3::from(specific_force(*tilt)).transpose()
        };
        let svd = READINGS.iter().map(outer).sum::<Matrix3<f64>>().svd(true, true);
        let (u, v_t) = (svd.u.unwrap(), svd.v_t.unwrap());
        u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, u.determinant() * v_t.determinant())) * v_t
    }

    /// The inverse of `Σ (‖b‖² I − b bᵀ) / σ²` over what would be read without noise, `b`.
    fn closed_form_std(r_st: &Matrix3<f64>) -> Vector3<f64> {
        let of_reading = |(tilt, _): &(Tilt, [f64; 3])| {
            let b = r_st * Vector3::from(specific_force(*tilt));
            (Matrix3::identity() * b.norm_squared() - b * b.transpose()) / NOISE.powi(2)
        };
        let information: Matrix3<f64> = READINGS.iter().map(of_reading).sum();
        information.try_inverse().unwrap().diagonal().map(f64::sqrt)
    }

    #[test]
    fn it_is_the_closed_form_solution_with_its_standard_deviations() {
        let Mounting { quaternion, std, .. } = mounting(&READINGS).unwrap();
        let found = unit(quaternion);
        let r_st = by_singular_values();
        let apart = found.to_rotation_matrix().matrix() - r_st.transpose();
        assert!(apart.norm() < 1e-7, "{apart}");
        let (std, closed) = (Vector3::from(std.unwrap()), closed_form_std(&r_st));
        assert!(std.zip_map(&closed, |a, b| (a / b - 1.0).abs()).max() < 1e-6, "{std} {closed}");
        // Turned from the truth, about the axes of the sensor.
        let error = (unit(TRUTH).inverse() * found).scaled_axis();
        assert!(error.zip_map(&std, |error, std| error.abs() / std).max() < 4.0, "{error} ± {std}");
    }

    #[test]
    fn on_a_level_table_turning_about_the_vertical_is_open() {
        let Mounting { std, open, .. } = mounting(&READINGS[..1]).unwrap();
        assert_eq!((std, open.len()), (None, 1));
        let read = Vector3::from(READINGS[0].1).normalize();
        let about = Vector3::from_row_slice(&open[0]).normalize();
        assert!(about.dot(&read).abs() > 1.0 - 1e-6, "{about}");
    }

    #[test]
    fn it_runs() {
        main().unwrap();
    }
}
