//! Values that came out so far from what was known of them beforehand that rather something else is wrong: a load's mass or a reading in
//! another unit than declared, a load at another place than stated.
//!
//! The fit says nothing of such mistakes: a load ten times too heavy makes all torque gains a tenth, and explains the readings as well.

use std::f64::consts::FRAC_PI_4;

use gravcal_dynamics::JointKind;
use gravcal_recording::PositionUnit;
use gravcal_robot_model::number::significant;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{Load, Session};

use super::gains_of_instruments;
use crate::result::{EstimatorResult, ParameterResult, deciding};

/// No torque sensor is so many times more sensitive than it should be, or less.
const FAR: f64 = 3.0;
/// No position sensor is mounted so far from where it should be, rad.
const FAR_TURNED: f64 = FRAC_PI_4;
/// So far turned, rad, is what gravity upside down or a load on the wrong poses makes of an offset.
const HALF_TURN: f64 = 0.9 * std::f64::consts::PI;
/// Gains that differ by less than this share have one factor.
const ONE_FACTOR: f64 = 0.2;
/// Gains are off by one factor where its logarithm is so many times the scatter of theirs.
const BEYOND_SCATTER: f64 = 3.0;
/// Sensors that read the torque itself, all off by one factor beyond this: rather the load's mass is, than all of them alike.
const FAR_TOGETHER: f64 = 1.3;
/// Where they are off by one factor beyond this share, that is worth a remark if they are so many at least.
const REMARKABLE: f64 = 0.03;
const FEWEST: usize = 3;

/// What the values of the estimator that decides make doubtful of the session, in sentences; see [`Session::doubts`] for what is doubtful
/// before anything is solved.
pub fn doubts_of_results(session: &Session, results: &[EstimatorResult]) -> Vec<String> {
    deciding(results).map_or_else(Vec::new, |result| far_off(session, &result.parameters))
}

/// What these values make doubtful of the session.
pub(crate) fn far_off(session: &Session, parameters: &[ParameterResult]) -> Vec<String> {
    let instruments = gains_of_instruments::doubts(session, parameters);
    gains(session, parameters).into_iter().chain(offsets(session, parameters)).chain(instruments).collect()
}

/// A torque gain that was found, beside its nominal value.
struct Gain {
    joint: usize,
    ratio: f64,
    far: bool,
    /// Far enough, if all others are off by the same factor.
    together: bool,
}

fn gains(session: &Session, parameters: &[ParameterResult]) -> Vec<String> {
    let all: Vec<Gain> = (0..session.joints.len())
        .filter_map(|joint| {
            let reported = Reported::of(session, parameters, joint, SensorParameter::TorqueGain)?;
            let [one, other] = [0, 1].map(|end| reported.interval[end] / reported.nominal);
            let far = one.min(other) > FAR || one.max(other) < 1.0 / FAR;
            let together =
                reads_torque(session, joint) && (one.min(other) > FAR_TOGETHER || one.max(other) < 1.0 / FAR_TOGETHER);
            let alike = reported.value * reported.nominal > 0.0;
            Some(Gain {
                joint,
                ratio: reported.value / reported.nominal,
                far: far && alike,
                together: (far || together) && alike,
            })
        })
        .collect();
    let (most, least) =
        all.iter().fold((0.0_f64, f64::MAX), |(most, least), gain| (most.max(gain.ratio), least.min(gain.ratio)));
    let alike = most < (1.0 + ONE_FACTOR) * least || are_off_together(&ratios(&all));
    let one_factor = all.iter().all(|gain| gain.together) && alike;
    if all.len() > 1 && (one_factor || all.iter().all(|gain| gain.far) && most < FAR * least) {
        return vec![of_all(session, least, most)];
    }
    all.iter().filter(|gain| gain.far).map(|gain| of_one(session, gain)).collect()
}

/// Whether gains are off by one factor, and each by a little of its own.
fn are_off_together(ratios: &[f64]) -> bool {
    let logarithms = || ratios.iter().map(|ratio| ratio.ln());
    let count = ratios.len() as f64;
    let mean = logarithms().sum::<f64>() / count;
    let scatter = (logarithms().map(|own| (own - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0)).sqrt();
    mean.abs() > BEYOND_SCATTER * scatter
}

fn ratios(gains: &[Gain]) -> Vec<f64> {
    gains.iter().map(|gain| gain.ratio).collect()
}

/// What gains of sensors that read the torque itself say where all are off by nearly one factor, which is too near to 1 to leave all in doubt: if sensors are as
/// nominal, the loads are not as heavy as stated.
pub(crate) fn off_together(session: &Session, parameters: &[ParameterResult]) -> Option<String> {
    let is_read = |joint: &usize| session.poses.iter().any(|pose| pose.torque[*joint].is_some());
    let read: Vec<usize> = (0..session.joints.len()).filter(is_read).collect();
    let found: Vec<Reported> = read
        .iter()
        .filter(|joint| reads_torque(session, **joint))
        .filter_map(|joint| Reported::of(session, parameters, *joint, SensorParameter::TorqueGain))
        .filter(|reported| reported.value * reported.nominal > 0.0)
        .collect();
    // A gain that is not told, or not known, may contradict the others.
    if found.len() < read.len() || !far_off(session, parameters).is_empty() {
        return None;
    }
    let ends = || found.iter().flat_map(|reported| reported.interval.map(|end| end / reported.nominal));
    let beyond = ends().all(|end| end > 1.0 + REMARKABLE) || ends().all(|end| end < 1.0 - REMARKABLE);
    let mut ratios: Vec<f64> = found.iter().map(|reported| reported.value / reported.nominal).collect();
    let carried = carried_loads(session);
    if ratios.len() < FEWEST || !beyond || carried.is_empty() || !are_off_together(&ratios) {
        return None;
    }
    ratios.sort_by(f64::total_cmp);
    let mean = (ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len() as f64).exp();
    let masses: Vec<String> = carried
        .iter()
        .map(|load| format!("{} {} kg and not {} kg", load.name, significant(mean * load.mass, 3), load.mass))
        .collect();
    Some(format!(
        "All torque gains are {} to {} times what is nominal, as if the sensors were right and each load had another mass than stated: {}. Weigh again.",
        significant(ratios[0], 4),
        significant(ratios[ratios.len() - 1], 4),
        masses.join(", ")
    ))
}

/// Loads that any pose carries, and whose masses are stated.
fn carried_loads(session: &Session) -> Vec<&Load> {
    let carried = session.loads.iter().enumerate().filter(|(_, load)| !load.is_unknown());
    let carried = carried.filter(|(load, _)| session.poses.iter().any(|pose| pose.load == Some(*load)));
    carried.map(|(_, load)| load).collect()
}

/// Whether the sensor's nominal gain is what its unit says, and no rough guess.
fn reads_torque(session: &Session, joint: usize) -> bool {
    session.joints[joint].torque_unit.is_some_and(|unit| !unit.is_sensors_own())
}

fn of_all(session: &Session, least: f64, most: f64) -> String {
    let times = match most < (1.0 + ONE_FACTOR) * least {
        true => significant((least * most).sqrt(), 2),
        false => format!("{} to {}", significant(least, 2), significant(most, 2)),
    };
    let masses: Vec<String> =
        carried_loads(session).iter().map(|load| format!("{} {} kg", load.name, load.mass)).collect();
    let likely = match masses.as_slice() {
        [] => "are the stated masses in kg?".to_owned(),
        [only] => format!("is the load's mass in kg (mass_kg: {only})?"),
        several => format!("are the loads' masses in kg (mass_kg: {})?", several.join(", ")),
    };
    format!(
        "All torque gains are {times} times what is nominal: {likely} All gains are measured against it. If it is right, look at \
         the unit of the torque readings, and at the nominal gains."
    )
}

fn of_one(session: &Session, gain: &Gain) -> String {
    let name = session.parameter_name(ParameterId::Sensor(gain.joint, SensorParameter::TorqueGain));
    let unit = session.joints[gain.joint].torque_unit.map_or_else(String::new, |unit| unit.to_string());
    format!(
        "{name} is {} times its nominal value: is the unit of its readings {unit}? State what it is in [readings] torque, or the \
         gain that the sensor has (torque_gain = {{ nominal = …, unit = … }}).",
        significant(gain.ratio, 2)
    )
}

fn offsets(session: &Session, parameters: &[ParameterResult]) -> Vec<String> {
    let turns = |joint: &usize| session.robot.chain.joints()[*joint].kind == JointKind::Revolute;
    let reported = |joint: usize| {
        let reported = Reported::of(session, parameters, joint, SensorParameter::PositionOffset)?;
        // Where zero of a counter lies nobody knows.
        let known = session.joints[joint].position_unit.si() == PositionUnit::Radian || reported.nominal != 0.0;
        let off = (reported.value - reported.nominal + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
            - std::f64::consts::PI;
        let half = 0.5 * (reported.interval[1] - reported.interval[0]);
        (known && off.abs() - half > FAR_TURNED).then(|| of_offset(session, joint, off))
    };
    (0..session.joints.len()).filter(turns).filter_map(reported).collect()
}

fn of_offset(session: &Session, joint: usize, off: f64) -> String {
    let name = session.parameter_name(ParameterId::Sensor(joint, SensorParameter::PositionOffset));
    let placed: Vec<&str> = session
        .loads
        .iter()
        .filter(|load| load.position.is_some() && session.robot.chain.moves(joint, load.link))
        .map(|load| load.name.as_str())
        .collect();
    let place = match placed.as_slice() {
        [] => String::new(),
        names => format!("the place of {} (position_m), or ", names.join(", ")),
    };
    let turned = match off.abs() > HALF_TURN {
        true => "[gravity] hemisphere, the load of each [[poses]], ",
        false => "",
    };
    format!(
        "{name} is {:.0}° from its nominal value: is {place}{turned}the sensor's sign or zero as stated? If the sensor is mounted so, say \
         position_offset = {{ nominal = …, unit = \"deg\" }} in its [[joint]].",
        off.to_degrees()
    )
}

/// A parameter that was found, in its unit.
struct Reported {
    value: f64,
    interval: [f64; 2],
    nominal: f64,
}

impl Reported {
    /// Nothing where it has no value, or was fixed.
    fn of(
        session: &Session,
        parameters: &[ParameterResult],
        joint: usize,
        quantity: SensorParameter,
    ) -> Option<Reported> {
        let name = session.parameter_name(ParameterId::Sensor(joint, quantity));
        let reported = parameters.iter().find(|parameter| parameter.name == name && parameter.held.is_none())?;
        let (value, interval) = (reported.value?, reported.ci95?);
        Some(Reported { value, interval, nominal: reported.nominal })
    }
}

#[cfg(test)]
mod tests {
    use gravcal_recording::TorqueUnit;
    use gravcal_robot_model::parameter::SensorParameter;
    use gravcal_robot_model::session::Session;

    use super::doubts_of_results;
    use crate::result::Verdict;
    use crate::testing::sarcos_shoulder;
    use crate::testing::sensor_models::estimate;

    fn doubts(session: &Session) -> (Verdict, Vec<String>) {
        let result = estimate(session);
        (result.verdict, doubts_of_results(session, &[result]))
    }

    /// The reference protocol, every torque asked for and told.
    fn right() -> Session {
        sarcos_shoulder().session(0)
    }

    #[test]
    fn what_is_near_its_nominal_value_is_not_doubted() {
        assert_eq!(doubts(&right()), (Verdict::Determined, vec![]));
    }

    #[test]
    fn a_load_ten_times_too_heavy_makes_all_gains_a_tenth_and_is_asked_for() {
        let mut session = right();
        session.loads.iter_mut().for_each(|load| load.mass *= 10.0);
        let (verdict, doubts) = doubts(&session);
        assert_eq!(verdict, Verdict::PartlyDetermined);
        assert!(
            doubts.len() == 1
                && doubts[0].starts_with("All torque gains are 0.098 times")
                && doubts[0].contains("are the loads' masses in kg (mass_kg: plate-a 17.24 kg, plate-b 17.24 kg)?"),
            "{doubts:?}"
        );
    }

    /// 2.2 pounds are a kilogram. Of sensors with a rough nominal gain that may as well be their gain.
    #[test]
    fn a_load_in_pounds_is_asked_for_where_sensors_read_torques() {
        let mut session = right();
        session.loads.iter_mut().for_each(|load| load.mass *= 2.2);
        assert_eq!(doubts(&session), (Verdict::Determined, vec![]));
        session.joints.iter_mut().for_each(|joint| joint.torque_unit = Some(TorqueUnit::NewtonMeter));
        let (verdict, doubts) = doubts(&session);
        assert_eq!(verdict, Verdict::PartlyDetermined);
        assert!(doubts.len() == 1 && doubts[0].starts_with("All torque gains are 0.44 times"), "{doubts:?}");
        // Sensors that differ by a tenth themselves.
        let mut scattered = session.clone();
        for (joint, share) in scattered.joints.iter_mut().zip([0.88, 1.0, 1.12]) {
            joint.parameters[SensorParameter::TorqueGain as usize].nominal *= share;
        }
        let (_, of_scattered) = self::doubts(&scattered);
        assert!(of_scattered.len() == 1 && of_scattered[0].starts_with("All torque gains are 0.3"), "{of_scattered:?}");
        session.loads.iter_mut().for_each(|load| load.mass /= 2.2 / 1.1);
        assert_eq!(self::doubts(&session), (Verdict::Determined, vec![]), "a tenth is calibration");
        let remark = |session: &Session| estimate(session).notes.into_iter().find(|note| note.contains("Weigh"));
        // Sensors as they are said to be, but for a hundredth, and a load that is said to be a tenth heavier than it is.
        let gain = |joint: usize| sarcos_shoulder().truth.sensors[joint][SensorParameter::TorqueGain as usize];
        for (joint, share) in [0.99, 1.0, 1.01].into_iter().enumerate() {
            session.joints[joint].parameters[SensorParameter::TorqueGain as usize].nominal = share * gain(joint);
        }
        let told = remark(&session).unwrap();
        assert!(told.contains("plate-a 1.73 kg and not 1.89"), "{told}");
        session.loads.iter_mut().for_each(|load| load.mass /= 1.1);
        assert_eq!(remark(&session), None);
    }

    #[test]
    fn one_column_in_another_unit_is_named() {
        let mut session = right();
        for reading in session.poses.iter_mut().filter_map(|pose| pose.torque[1].as_mut()) {
            reading.value /= 1000.0;
            reading.std = reading.std.map(|std| std / 1000.0);
        }
        let (verdict, doubts) = doubts(&session);
        assert_eq!(verdict, Verdict::PartlyDetermined);
        assert!(
            doubts.len() == 1
                && doubts[0].starts_with(
                    "joint2.torque_gain is 0.00089 times its nominal value: is the unit of its readings count?"
                ),
            "{doubts:?}"
        );
    }

    #[test]
    fn an_offset_far_from_nominal_is_named_and_one_of_a_counter_is_not() {
        let mut session = right();
        session.joints[1].parameters[3].nominal -= 1.0;
        let (verdict, reported) = doubts(&session);
        assert_eq!(verdict, Verdict::PartlyDetermined);
        assert!(
            reported.len() == 1 && reported[0].starts_with("joint2.position_offset is 57° from its nominal value"),
            "{reported:?}"
        );
        session.joints[1].position_unit = gravcal_recording::PositionUnit::Count;
        session.joints[1].parameters[3].nominal = 0.0;
        assert_eq!(doubts(&session).1, [""; 0]);
    }
}
