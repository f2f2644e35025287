//! `[readings.motion]`: the tables are recordings of an arm in motion, and every moment counts: windows over it are fitted by the whole dynamics.

use std::f64::consts::TAU;

use gravcal_recording::{Part, PoseMapping, Travel, WindowRule};
use gravcal_robot_model::session::travel::travels;
use gravcal_robot_model::session::{InertiaPrior, JointPriors, Pose, Session};
use serde::Deserialize;

use super::context::Context;
use super::recordings::InMotion;
use super::still::refuse_said_twice;
use crate::document::{Field, FileError};

/// Length of a window where nothing is said, s: a cut-off of 5 Hz.
const LENGTH: f64 = 0.32;
/// Speeds above which a joint moves, rad/s and m/s.
const TURNS: f64 = 0.02;
const SLIDES: f64 = 0.005;
/// A lag is shorter, s.
const LONGEST_LAG: f64 = 1.0;

/// `[readings.motion]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct MotionWindowsTable {
    /// How long a window is over which the model and the readings are averaged.
    ///
    /// Default: 0.32, a cut-off of 5 Hz.
    /// Example: `window_s = 0.8`
    window_s: Option<f64>,
    /// By how much torques come later than positions; negative where positions do. It is never estimated: residuals that show such a lag are told.
    ///
    /// Default: 0.
    /// Example: `torque_lag_s = 0.012`
    torque_lag_s: Option<f64>,
    /// Cut-off (−3 dB) of a low-pass filter that the recorder passed torques through and not positions. The model is filtered alike. It delays nothing there: what a causal filter delays (one of first order by 1/(2π f)) say in `torque_lag_s`.
    ///
    /// Unit: Hz.
    /// Default: none.
    /// Example: `recorded_filter_hz = 2`
    recorded_filter_hz: Option<f64>,
}

fn field() -> Field {
    Field::new("readings").key("motion")
}

/// What it comes to.
pub(super) fn resolve(
    context: &Context<'_>,
    table: &MotionWindowsTable,
    mapping: &PoseMapping,
    joints: &[JointPriors],
) -> Result<WindowRule, FileError> {
    refuse_said_twice(context, &field(), mapping)?;
    let positive = |key: &str, value: Option<f64>, what: &str, unit: &str| {
        value.map(|value| context.document.positive(&field().key(key), value, what, unit)).transpose()
    };
    let length = positive("window_s", table.window_s, "a length", "s")?.unwrap_or(LENGTH);
    let recorded_filter = positive("recorded_filter_hz", table.recorded_filter_hz, "a cut-off", "Hz")?;
    let torque_lag = table.torque_lag_s.unwrap_or(0.0);
    if torque_lag.is_nan() || torque_lag.abs() > LONGEST_LAG {
        let message = format!("{torque_lag} s is no lag of a recorder: expected less than {LONGEST_LAG} s either way");
        return Err(context.document.error(&field().key("torque_lag_s"), message));
    }
    let travels = travels(&context.robot.chain, joints);
    let turn = |travel: &Travel| match travel {
        Travel::Turns(scale) => Some(TAU / scale),
        Travel::Slides(_) => None,
    };
    let speed = |travel: &Travel| match travel {
        Travel::Turns(scale) => TURNS / scale,
        Travel::Slides(scale) => SLIDES / scale,
    };
    Ok(WindowRule {
        length,
        moving: travels.iter().map(speed).collect(),
        presliding: Vec::new(),
        turn: travels.iter().map(turn).collect(),
        torque_lag,
        recorded_filter,
        part: Part::default(),
    })
}

/// Has windows follow the friction of these joints.
pub(super) fn follow_friction(motion: &mut InMotion, followed: Vec<usize>) {
    if let Some(windows) = &mut motion.windows {
        windows.presliding = followed;
    }
}

/// Refuses slow sweeps beside windows: what a joint passes slowly is in windows, too. (Windows leave standstills out that count by themselves.)
pub(super) fn check_beside(context: &Context<'_>, found: &InMotion) -> Result<(), FileError> {
    if found.windows.is_none() || found.sweeps.is_none() {
        return Ok(());
    }
    let message = "with readings.sweeps every row of a slow sweep would count twice, as windows of readings.motion hold it, too: delete one \
                   of both; readings.still may stand beside either";
    Err(context.document.error(&field(), message))
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
            session.inertia == InertiaPrior::Sweep,
            "moments by sweep are those of a standing arm: delete description in [inertia]",
        ),
        (
            gives_way,
            "how far joints give way in motion is an unknown by itself, and other deflections are those of a standing arm: delete \
             [deflection], or say that joints do not bend (compliance_std_rad_per_newton_metre = 0)",
        ),
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
