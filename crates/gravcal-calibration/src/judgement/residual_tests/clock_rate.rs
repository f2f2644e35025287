//! A clock that runs fast or slow: of an arm in motion.
//!
//! Where times of the recording are longer by a share `ε` than they were, velocities are smaller by `ε` and accelerations by `2 ε` than they were, and so are
//! centrifugal torques:
//!
//! ```text
//!     y ≈ ŷ + ε (2 k τ_inertia + viscous friction)
//! ```

use gravcal_estimation::EvaluateError;
use gravcal_robot_model::sensors::Need;
use gravcal_robot_model::session::Session;

use super::uneven_friction::modelled_friction;
use crate::joint::Solved;
use crate::judgement::torque_parts::torque_parts;

/// What a clock that is fast by its own rate does to the whitened residuals; nothing where the arm stands.
pub fn fast_clock(session: &Session, solved: &Solved, rows: usize) -> Result<Vec<Vec<f64>>, EvaluateError> {
    if !session.has_windows() {
        return Ok(Vec::new());
    }
    let viscous: Vec<Vec<f64>> =
        (0..session.joints.len()).map(|joint| modelled_friction(session, solved, joint, &[Need::Velocity])).collect();
    let mut column = vec![0.0; rows];
    let parts = torque_parts(session, solved)?;
    for ((id, parts), entry) in solved.built.rows.iter().zip(parts).zip(&mut column) {
        let Some(parts) = parts else { continue };
        let friction = viscous[id.channel].get(id.pose).copied().unwrap_or(0.0);
        *entry = (2.0 * parts.inertia + friction) / solved.readings().std(session, *id);
    }
    Ok(vec![column])
}
