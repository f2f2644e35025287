//! How joints' axes are tilted against the robot's description: unknowns where the session says how well axes are known.
//!
//! A joint that is tilted by `ε` (rad, about two axes across its own) takes along all that hangs on it. Readings are linear in `ε` but for its square, so
//! that they are those of [`gravcal_robot_model::residuals::Displaced`].

use gravcal_dynamics::Chain;
use gravcal_estimation::ProblemBuilder;
use gravcal_robot_model::session::Session;
use nalgebra::Vector3;

use crate::joint::building::sweep_moments::by_sweep;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::variables::{JointDisplacements, State};

/// The links whose joint's axis may be tilted: all. None where moments are described by sweep, and of a body without joints.
pub(in crate::joint) fn tilted_links(session: &Session) -> Vec<usize> {
    if by_sweep(session) || session.joints.is_empty() {
        Vec::new()
    } else {
        (0..session.robot.chain.link_count()).collect()
    }
}

/// Adds the unknown, from where `start` has it; nothing where axes are exact, or it is not yet known what tilts do.
pub(in crate::joint) fn add_unknown(
    session: &Session,
    readings: &MeasurementSet,
    start: &State,
    builder: &mut ProblemBuilder,
) -> Option<JointDisplacements> {
    let std = session.axis_std.filter(|_| readings.displaced.is_some())?;
    let links = tilted_links(session);
    JointDisplacements::add(session, ("axes", "rad"), (links, &["tilt_1", "tilt_2"]), (std, &start.axes), builder)
}

/// Two axes perpendicular to that of the joint which moves a link, in its frame.
pub(in crate::joint) fn across(chain: &Chain, link: usize) -> [Vector3<f64>; 2] {
    let own = Vector3::from(chain.movers()[link].axis);
    let across = own.cross(&Vector3::ith(own.iamin(), 1.0)).normalize();
    [across, own.cross(&across)]
}
