//! `[readings.motion]`: the tables are recordings of an arm in motion, and every moment counts: windows over it are fitted by the whole dynamics.

use gravcal_recording::{Part, PoseMapping, Travel, WindowRule};
use gravcal_robot_model::session::travel::travels;
use gravcal_robot_model::session::{InertiaKnowledge, JointKnowledge, Pose, Session};
use serde::Deserialize;

use super::context::Context;
use super::still::refuse_said_twice;
use crate::document::{Field, FileError};

/// Length of a window where nothing is said, s: a cut-off of 5 Hz.
const LENGTH: f64 = 0.32;
/// Speeds above which a joint moves, rad/s and m/s.
const TURNS: f64 = 0.02;
const SLIDES: f64 = 0.005;

/// `[readings.motion]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct MotionWindowsTable {
    /// How long a window is over which the model and the readings are averaged.
    ///
    /// Default: 0.32, a cut-off of 5 Hz.
    /// Example: `window_s = 0.8`
    window_s: Option<f64>,
}

fn field() -> Field {
    Field::new("readings").key("motion")
}

/// What it comes to.
pub(super) fn resolve(
    context: &Context<'_>,
    table: &MotionWindowsTable,
    mapping: &PoseMapping,
    joints: &[JointKnowledge],
) -> Result<WindowRule, FileError> {
    refuse_said_twice(context, &field(), mapping)?;
    let length =
        table.window_s.map(|length| context.document.positive(&field().key("window_s"), length, "a length", "s"));
    let speed = |travel: &Travel| match travel {
        Travel::Turns(scale) => TURNS / scale,
        Travel::Slides(scale) => SLIDES / scale,
    };
    let moving = travels(&context.robot.chain, joints).iter().map(speed).collect();
    Ok(WindowRule { length: length.transpose()?.unwrap_or(LENGTH), moving, part: Part::default() })
}

/// Refuses what the model of an arm in motion does not hold.
pub(super) fn check(context: &Context<'_>, session: &Session) -> Result<(), FileError> {
    if !session.has_windows() {
        return Ok(());
    }
    let deflection = &session.deflection;
    let gives_way = !session.compliances().is_empty() || deflection.hold_std.is_some() || deflection.pose_std.is_some();
    let refused = [
        (
            session.inertia == InertiaKnowledge::Sweep,
            "moments by sweep are those of a standing arm: delete description in [inertia]",
        ),
        (gives_way, "joints that give way are those of a standing arm: delete [deflection]"),
        (deflection.reading_std.iter().any(|std| *std > 0.0), "positions are smoothed: delete readings.position.std"),
        (
            session.terms.of_positions().next().is_some(),
            "position-harmonics are known of a standing arm only: leave the model out",
        ),
        (
            !session.instruments.is_empty(),
            "wrist sensors and accelerometers are read of a standing arm only: record them with readings.still",
        ),
    ];
    match refused.into_iter().find(|(found, _)| *found) {
        Some((_, message)) => Err(context.document.error(&field(), message)),
        None => Ok(()),
    }
}

/// What friction, gears and the model leave is larger than any noise: where the arm moves, a standstill counts as much as a window, and how
/// well either is explained tells how noisy both are.
pub(super) fn count_alike(poses: &mut [Pose]) {
    if poses.iter().any(|pose| pose.course.is_some()) {
        poses.iter_mut().flat_map(|pose| &mut pose.torque).flatten().for_each(|reading| reading.std = None);
    }
}
