//! Bodies that hang many arm lengths away from what carries them: lengths in millimetres, or moments in N·mm.

use super::robot::lengths;
use crate::session::instrument::{AuxiliarySensor, AuxiliarySensorKind};
use crate::session::{Load, Session};

/// What a link or a wrist sensor carries is within so many lengths of the arm, and within this, m, where there is no arm or a short one.
const ARM_LENGTHS: f64 = 2.0;
const LEAST: f64 = 2.0;
/// Forces that vary by less than this, N, do not tell how far away something hangs.
const LEAST_FORCE: f64 = 1.0;

/// A sentence or two for each.
pub(super) fn doubts(session: &Session) -> Vec<String> {
    let far = LEAST.max(ARM_LENGTHS * lengths(session).into_iter().sum::<f64>());
    let loads = session.loads.iter().filter_map(|load| of_load(session, load, far));
    let wrist = session.instruments.iter().filter(|instrument| instrument.kind == AuxiliarySensorKind::ForceTorque);
    loads.chain(wrist.filter_map(|wrist| of_wrist(session, wrist, far))).collect()
}

fn of_load(session: &Session, load: &Load, far: f64) -> Option<String> {
    let distance = load.position?.iter().map(|component| component * component).sum::<f64>().sqrt();
    let link = &session.robot.chain.links().get(load.link)?.name;
    (distance > far).then(|| {
        format!(
            "Load `{}` is stated {distance:.0} m away from {link}, which carries it: is position_m in mm? State its centre of mass in m, \
             in the frame of {link}.",
            load.name
        )
    })
}

/// A weight w at a distance makes forces that vary by ±w, and moments that vary by as much times the distance.
fn of_wrist(session: &Session, wrist: &AuxiliarySensor, far: f64) -> Option<String> {
    let most = |axes: std::ops::Range<usize>| {
        axes.map(|axis| half_range(session, wrist, axis))
            .collect::<Option<Vec<f64>>>()
            .map(|all| all.into_iter().fold(0.0, f64::max))
    };
    let (force, moment) = (most(0..3)?, most(3..6)?);
    let distance = moment / force;
    (force > LEAST_FORCE && distance > far).then(|| {
        format!(
            "As declared, moments of {0} vary by ±{moment:.0} N·m and its forces by ±{force:.1} N, as if what it carries were {distance:.0} m \
             away: are the moments in N·mm? Divide them by 1000 in the file, or say unit = [\"N\", \"N\", \"N\", \"count\", \"count\", \
             \"count\"] in readings of {0}, and moment_gain = {{ nominal = 1000, unit = \"count/(N·m)\" }}.",
            wrist.name
        )
    })
}

/// Half of the range of what an axis reads, N or N·m by its nominal gain; `None` where it does not read just what it senses.
fn half_range(session: &Session, wrist: &AuxiliarySensor, axis: usize) -> Option<f64> {
    let gains = wrist.gains.iter().zip(wrist.gain_parameters());
    let mut of_axis = gains.filter(|((reading, _), _)| *reading == axis);
    let (_, parameter) = of_axis.find(|((_, sensed), _)| *sensed == axis)?;
    let gain = session.further.get(parameter)?.prior.nominal;
    let readings = session.poses.iter().filter_map(|pose| pose.instruments.get(wrist.first_reading + axis)?.as_ref());
    let ends = [f64::INFINITY, f64::NEG_INFINITY];
    let [low, high] = readings.fold(ends, |[low, high], reading| [reading.value.min(low), reading.value.max(high)]);
    (high >= low).then(|| (0.5 * (high - low) / gain).abs())
}
