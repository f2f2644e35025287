//! The session's URDF with joints' origins moved by their position offsets, and a root that hangs as gravity says: see
//! [`UrdfCorrection`].
//!
//! The model takes `position_gain · reading` for a joint's value. A URDF has no place for gains nor for torque sensors.

use gravcal_dynamics::{BodyInertia, UrdfCorrection};

use super::corrections::{Corrections, JointCorrection};
use super::numbers::float;
use super::{Export, ExportError, Exported, RobotDescription, head};

const CONVENTION: [&str; 6] = [
    "Convention: the joint's value in this model is position_gain * reading, in rad or m; origins are moved by the position",
    "offsets, limits are those of that value. A URDF holds neither gains nor torque sensors: export these to ros2, c or python.",
    "Link gravity_aligned_world has its z axis upward; gravity says nothing of the heading, so the base is turned by the",
    "smallest rotation. Without gravity the root is as it was.",
    "Inertias are the file's own, unless the calibration has such of rigid bodies ([constraints] inertia = physical): then theirs,",
    "without loads, each on the link that a joint carries, links fixed to that included.",
];

pub(super) fn export(export: &Export<'_>, corrections: &Corrections) -> Result<Exported, ExportError> {
    let RobotDescription { urdf, base } = export.robot.ok_or(ExportError::NoUrdf)?;
    let offsets = corrections.joints.iter().map(|joint| (joint.name.clone(), joint.position.offset));
    let gain = |joint: &JointCorrection| {
        let position = &joint.position;
        format!("{}: position_gain {} {}/{}", joint.name, float(position.gain), position.unit, position.reading_unit)
    };
    let mut comment = head(export, &CONVENTION, &corrections.remarks);
    comment.extend(corrections.joints.iter().map(gain));
    let inertias: Vec<(String, BodyInertia)> = export
        .estimate
        .inertias
        .iter()
        .flatten()
        .map(|own| (own.link.clone(), BodyInertia::about_center(own.mass_kg, own.center_of_mass_m, own.tensor_kg_m2)))
        .collect();
    let correction = UrdfCorrection {
        gravity: corrections.gravity.map(|gravity| (base, gravity)),
        offsets: &offsets.collect::<Vec<_>>(),
        inertias: &inertias,
        comment: &comment,
    };
    Ok(Exported { text: correction.apply(urdf)?, remarks: corrections.remarks.clone() })
}
