//! What every estimator's reader should know of a session, whatever comes out.

use gravcal_dynamics::Joint;
use gravcal_robot_model::number::significant;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{InertiaPrior, PriorKind, Session};

/// What every estimator's reader should know of frames, positions and loads.
pub(crate) fn session_notes(session: &Session) -> Vec<String> {
    let mut notes: Vec<String> = session.repeated_note().into_iter().collect();
    notes.extend(session.unmoved_note());
    notes.extend(base_frame_note(session));
    notes.extend(load_mass_note(session));
    notes.extend(strength_note(session));
    notes.extend(mimic_notes(session));
    for (joint, count) in session.robot.chain.joints().iter().zip(&session.saturated).filter(|(_, count)| **count > 0) {
        notes.push(format!(
            "{count} torque readings of {} are at an end of the sensor's range: left out, as the true ones may be \
             anything beyond.",
            joint.name
        ));
    }
    notes.extend(session.searched.iter().flat_map(|searched| searched.notes(&session.readings)));
    notes.extend(rounding_note(session));
    notes.extend(static_friction_note(session));
    notes.extend(session.motion_notes());
    notes.extend(session.selection_note());
    let cut = session.robot.chain.cut_joints();
    if !cut.is_empty() {
        let end =
            if session.robot.chain.is_serial() { "The chain ends at its tip" } else { "Branches end at their tips" };
        notes.push(format!("{end}: what hangs there by {} is left out.", cut.join(", ")));
    }
    notes
}

/// What coarse position sensors leave unknown.
fn rounding_note(session: &Session) -> Option<String> {
    let coarsest = session.deflection.rounding_std.iter().copied().fold(0.0, f64::max);
    (coarsest > 0.0).then(|| {
        format!(
            "Position readings step by up to {:.2} deg. Where a joint stands all through a sweep, what rounding leaves of its angle is an \
             unknown of that sweep.",
            (f64::sqrt(12.0) * coarsest).to_degrees()
        )
    })
}

/// What joints read while others sweep.
fn static_friction_note(session: &Session) -> Option<String> {
    let joints = session.robot.chain.joints().iter().enumerate();
    let shown = joints.filter(|(joint, _)| session.static_friction.get(*joint).is_some_and(|friction| *friction > 0.0));
    let of_joint = |(joint, described): (usize, &Joint)| {
        let unit = session.channel_unit(joint);
        format!("{} {} {unit}", described.name, significant(session.static_friction[joint], 2))
    };
    let shown: Vec<String> = shown.map(of_joint).collect();
    (!shown.is_empty()).then(|| {
        format!(
            "Joints with friction ({}): while another joint sweeps, an unknown part of it is in the torque of each that stands, one unknown for each joint and sweep.",
            shown.join(", ")
        )
    })
}

/// What the torque gains take over from the loads.
fn load_mass_note(session: &Session) -> Option<String> {
    let open = session.joints.iter().any(|joint| joint.of(SensorParameter::TorqueGain).kind == PriorKind::Flat);
    let exact = |load: usize| !session.loads[load].is_unknown() && session.load_mass(load).is_none();
    let carried = session.poses.iter().any(|pose| pose.load.is_some_and(exact));
    (open && carried).then(|| {
        "Torque gains are measured against the loads' masses, taken as exact: a mass that is 1 % off puts every torque gain \
         1 % off, and no standard deviation here says so. If it was weighed with an error, say so: mass_kg = { nominal = …, std = … }."
            .to_owned()
    })
}

/// Strength of gravity where nobody looked it up, m/s².
const STANDARD: [f64; 4] = [9.8, 9.80665, 9.807, 9.81];

/// Masses of links that are known no better hide what the strength of gravity is off.
const KNOWN: f64 = 0.01;

/// What torque gains take over from the strength of gravity, where known masses tell them.
fn strength_note(session: &Session) -> Option<String> {
    let open = session.joints.iter().any(|joint| joint.of(SensorParameter::TorqueGain).kind == PriorKind::Flat);
    let known = session.loads.iter().any(|load| !load.is_unknown())
        || matches!(&session.inertia, InertiaPrior::Model { relative_std } if relative_std.iter().any(|std| std.is_none_or(|std| std < KNOWN)));
    (is_strength_guessed(session) && open && known).then(|| {
        format!(
            "The strength of gravity is taken as exactly {} m/s². On earth it lies between 9.764 and 9.834, and an error of 0.1 % in it is one of 0.1 % in all torque gains. Say \
             latitude_deg and altitude_m instead of magnitude_m_per_s2, or add magnitude_std_m_per_s2.",
            session.gravity.magnitude
        )
    })
}

/// Whether the strength of gravity is one that people write down where nobody looked it up.
pub(crate) fn is_strength_guessed(session: &Session) -> bool {
    session.gravity.magnitude_std.is_none() && STANDARD.contains(&session.gravity.magnitude)
}

/// What the frame of the base is, where a joint defines it.
fn base_frame_note(session: &Session) -> Option<String> {
    let root = session.robot.chain.root_joint()?;
    let name = SensorParameter::PositionOffset.name(&session.robot.chain.joints()[root].name);
    Some(match session.joints[root].of(SensorParameter::PositionOffset).nominal {
        0.0 => format!("{name} is zero by definition of the base frame."),
        given => format!("{name} is held at {given:.6}, which defines the base frame."),
    })
}

/// Whose torque holds the joints that have no sensor of their own because they mimic another.
fn mimic_notes(session: &Session) -> Vec<String> {
    let chain = &session.robot.chain;
    let followers = |joint: usize| {
        let name = &chain.joints()[joint].name;
        let movers = chain.links_of(joint).map(|link| chain.movers()[link].name.clone());
        movers.filter(|mover| mover != name).collect::<Vec<_>>().join(", ")
    };
    let note = |joint: usize| {
        let (leader, followers) = (&chain.joints()[joint].name, followers(joint));
        (!followers.is_empty()).then(|| {
            format!("The torque of {leader} is also that of {followers}, which mimics it, times the multiplier.")
        })
    };
    (0..session.joints.len()).filter_map(note).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::sarcos_shoulder;

    #[test]
    fn a_standard_strength_is_noted_where_known_masses_tell_torque_gains() {
        let session = sarcos_shoulder().session(0);
        assert!(strength_note(&session).is_some());
        let with = |change: &dyn Fn(&mut Session)| {
            let mut other = session.clone();
            change(&mut other);
            strength_note(&other).is_some()
        };
        assert!(!with(&|other| other.gravity.magnitude = 9.8078), "looked up");
        assert!(!with(&|other| other.gravity.magnitude_std = Some(0.01)));
        let unknown = |other: &mut Session| other.loads.iter_mut().for_each(|load| load.mass = f64::NAN);
        assert!(!with(&unknown));
        let links = |relative_std: Option<f64>| {
            with(&|other| {
                unknown(other);
                other.inertia = InertiaPrior::Model { relative_std: vec![relative_std; 3] };
            })
        };
        assert_eq!([None, Some(0.005), Some(0.1)].map(links), [true, true, false]);
    }
}
