//! Which way Coulomb friction acts, where a velocity tells it.
//!
//! A session's `readings.select` calibrates friction from readings faster than `speed_above` only. Slower ones have no sign here either:
//!
//! ```text
//!     direction = sgn(q̇)  where |q̇| > speed_above,  else 0
//! ```

use gravcal_recording::{Conditions, MotionSource};
use gravcal_robot_model::session::Session;

/// Tells the direction of every joint from its speed, and counts the torques that have none.
#[derive(Debug)]
pub(super) struct FrictionSign {
    /// By joint, rad/s or m/s; 0 where the session states none. Empty where directions have columns of their own, or no velocity is
    /// read.
    least_speed: Vec<f64>,
    joints: Vec<Counted>,
}

/// One joint.
#[derive(Clone, Copy, Debug, Default)]
struct Counted {
    has_friction: bool,
    /// Torques at no more than that speed.
    resting: u64,
    /// Torques at more.
    moving: u64,
}

impl FrictionSign {
    /// `by_slope`: whether velocities are slopes of positions.
    pub fn new(session: &Session, by_slope: bool) -> FrictionSign {
        let (with_friction, followed) = (session.terms.with_friction(), session.terms.with_presliding());
        let has_friction = |joint: usize| with_friction.contains(&joint) && !followed.contains(&joint);
        let conditions = &session.readings.conditions;
        let is_told = by_slope || matches!(conditions.velocity, MotionSource::Columns(_));
        let by_velocity = conditions.direction.is_empty() && is_told;
        let count = if by_velocity { session.joints.len() } else { 0 };
        FrictionSign {
            least_speed: (0..count).map(|joint| session.readings.selection.least_speed(joint).unwrap_or(0.0)).collect(),
            joints: (0..count)
                .map(|joint| Counted { has_friction: has_friction(joint), ..Counted::default() })
                .collect(),
        }
    }

    /// Sets the directions that follow from the velocities.
    pub fn report(&self, conditions: &mut Conditions) {
        if self.least_speed.is_empty() {
            return;
        }
        let sign = |(velocity, least): (&f64, &f64)| if velocity.abs() <= *least { 0.0 } else { velocity.signum() };
        conditions.direction = conditions.velocity.iter().zip(&self.least_speed).map(sign).collect();
    }

    /// Takes note of a torque that was told.
    pub fn count(&mut self, joint: usize, conditions: &Conditions) {
        let Some(counted) = self.joints.get_mut(joint).filter(|counted| counted.has_friction) else { return };
        match conditions.direction[joint] == 0.0 {
            true => counted.resting += 1,
            false => counted.moving += 1,
        }
    }

    /// Where no friction was taken off, and where it may have had the sign of noise.
    pub fn remarks(&self, session: &Session) -> Vec<String> {
        let names = session.robot.chain.joints().iter().map(|joint| &joint.name);
        let reported = names.zip(&self.joints).enumerate();
        reported
            .flat_map(|(joint, (name, counted))| {
                let stated = session.readings.selection.least_speed(joint).is_some();
                [resting_remark(name, *counted, stated), noise_remark(name, *counted, stated)]
            })
            .flatten()
            .collect()
    }
}

fn resting_remark(name: &str, Counted { resting, moving, .. }: Counted, stated: bool) -> Option<String> {
    let all = resting + moving;
    let rule = if stated { "it was no faster than speed_above of readings.select" } else { "its speed was 0" };
    (resting > 0).then(|| {
        format!(
            "joint {name}: at {resting} of its {all} torque readings {rule}, where the sign of Coulomb friction is not known: \
             none was taken off"
        )
    })
}

fn noise_remark(name: &str, Counted { moving, .. }: Counted, stated: bool) -> Option<String> {
    (moving > 0 && !stated).then(|| {
        format!(
            "joint {name}: Coulomb friction has the sign of the velocity however slow, and where the joint rests that is the sign \
             of noise; a session with readings.select.joint.speed_above would know"
        )
    })
}
