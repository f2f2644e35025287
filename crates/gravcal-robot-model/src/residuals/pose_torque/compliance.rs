//! Joints that give way under the torque they carry, unseen by their position sensors.
//!
//! ```text
//!     θ_j = s_j q_j + o_j + c_j τ_j(θ)
//! ```
//!
//! c_j in rad/(N·m) (m/N). What gravity makes a gear carry bends it whether its joint stands or passes the angle slowly. τ is the model's own torque, so
//! that joints without a reading deflect too and no reading's noise or outlier enters another's prediction. With `C = diag(c)` and `H = ∂τ/∂θ`
//! where the joints come to rest,
//!
//! ```text
//!     dτ = A⁻¹ (H dθ⁰ + ∂τ/∂g dg + ∂τ/∂m dm),   A = 1 − H C,   ∂τ/∂c_j = (A⁻¹ H)_j τ_j
//! ```
//!
//! by the implicit function theorem: a compliance enters like an offset, times the torque.

use gravcal_dynamics::{Chain, GravityTorque};
use gravcal_estimation::EvaluateError;
use nalgebra::{DMatrix, DVector};

/// Newton's rounds at most: three suffice where joints give way by some degrees.
const ROUNDS: usize = 20;
/// The joints are at rest where a round moves them by less, rad or m.
const AT_REST: f64 = 1e-13;

/// Moves the joints from where they stand unloaded to where they come to rest, and fills `torque` there with total
/// derivatives, by coordinates those of the unloaded joints. `compliance`: one for each joint.
///
/// # Errors
/// Where they come to no rest: compliances so large that the arm would fall.
pub(super) fn settle(
    chain: &Chain,
    coordinates: &mut [f64],
    gravity: [f64; 3],
    inertia: &[f64],
    compliance: &[f64],
    torque: &mut GravityTorque,
) -> Result<(), EvaluateError> {
    let n = coordinates.len();
    let unloaded = coordinates.to_vec();
    for _ in 0..ROUNDS {
        chain.linearize_gravity_torque(coordinates, gravity, inertia, torque);
        let stiffness = DMatrix::from_row_slice(n, n, &torque.by_coordinate);
        // (1 − C H) step = θ⁰ + C τ − θ
        let system = DMatrix::from_fn(n, n, |i, j| f64::from(i == j) - compliance[i] * stiffness[(i, j)]);
        let excess = DVector::from_fn(n, |i, _| unloaded[i] + compliance[i] * torque.torque[i] - coordinates[i]);
        let step = system.lu().solve(&excess).filter(|step| step.iter().all(|s| s.is_finite())).ok_or_else(no_rest)?;
        if step.amax() < AT_REST {
            return totals(stiffness, compliance, torque);
        }
        coordinates.iter_mut().zip(step.iter()).for_each(|(coordinate, step)| *coordinate += step);
    }
    Err(no_rest())
}

fn no_rest() -> EvaluateError {
    EvaluateError("the joints give way so much that they come to no rest".into())
}

/// Multiplies the derivatives by A⁻¹.
fn totals(stiffness: DMatrix<f64>, compliance: &[f64], torque: &mut GravityTorque) -> Result<(), EvaluateError> {
    let n = compliance.len();
    let system = DMatrix::from_fn(n, n, |i, j| f64::from(i == j) - stiffness[(i, j)] * compliance[j]).lu();
    for derivative in [&mut torque.by_coordinate, &mut torque.by_gravity, &mut torque.by_inertia] {
        let width = derivative.len() / n;
        let total = system.solve(&DMatrix::from_row_slice(n, width, derivative)).ok_or_else(no_rest)?;
        let entries = (0..n).flat_map(|i| (0..width).map(move |j| (i, j)));
        derivative.iter_mut().zip(entries).for_each(|(entry, place)| *entry = total[place]);
    }
    Ok(())
}
