//! How a reading goes with what its sensor senses: a gain that is another in another table or drifts, a reading that does not grow in proportion to what is
//! sensed, or shows what other sensors sense.

use std::ops::Range;

use gravcal_robot_model::session::{AuxiliarySensorKind, Session};

use super::lacked::{Found, Lacked, Words};
use super::units::per_torque;
use crate::judgement::residual_tests::columns::{ALL_JOINTS, Columns, MOST_RECORDINGS};
use crate::judgement::residual_tests::score::dot;
use crate::judgement::residual_tests::wording::{formula, joint_of, shown, shown_amount};
use crate::result::{ResidualTest, ResidualTestKind};

/// Powers of what is sensed that a reading may go with.
const POWERS: [i32; 2] = [2, 3];
/// Fewer readings of an instrument's axis, of which gain, bias and what five other axes sense take up seven, hardly tell chance from what they share.
const FEWEST_OF_AXIS: usize = 12;

/// What is said of other sensors.
const OTHER_GAINS: &str = "The gains of the other torque sensors may have changed, too: their intervals include the change that their own residuals allow.";

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SensorGain {
    /// In share of the gain, of each table but the first.
    InTables,
    /// In share of the gain.
    Trend,
    /// In the unit of the reading, at the largest.
    Nonlinearity,
    /// Where the largest reading, or the smallest, may be an end of the sensor's range, in the unit of the reading: how far on the mean the true ones are beyond.
    Saturation { highest: bool },
    /// Of all other joints that are read, in the unit of the reading for each N·m; of an instrument, of its other axes in their units.
    Crosstalk,
}

impl SensorGain {
    /// Those that are looked for in a channel.
    pub fn of_channel(of: &Columns, channel: usize) -> Vec<SensorGain> {
        use SensorGain::{Crosstalk, InTables, Nonlinearity, Saturation, Trend};
        let mut terms = match of.is_joint(channel) {
            true => vec![InTables, Trend, Nonlinearity, Crosstalk],
            false if of.read(channel) >= FEWEST_OF_AXIS => vec![Nonlinearity, Crosstalk],
            false => Vec::new(),
        };
        let ends = of.session.clipped_ends(channel).into_iter();
        terms.extend(ends.map(|end| Saturation { highest: end.is_highest }));
        terms
    }
}

impl Lacked for SensorGain {
    fn columns(&self, of: &Columns, channel: usize) -> Vec<Vec<f64>> {
        let reads = |value: &dyn Fn(usize) -> f64| of.reading(channel, value);
        match (self, of.is_joint(channel)) {
            (SensorGain::InTables, _) => of.apart(&of.tables(channel), MOST_RECORDINGS, |within| {
                vec![reads(&|pose| f64::from(within(pose)) * of.predicted.reading(pose, channel))]
            }),
            (SensorGain::Trend, _) => vec![of.times_reading(channel, of.trend(channel, |_| 0))],
            (SensorGain::Nonlinearity, true) => {
                POWERS.map(|power| reads(&|pose| of.predicted.power(pose, channel, power))).into()
            }
            (SensorGain::Nonlinearity, false) => {
                POWERS.map(|power| reads(&|pose| of.of_axes.power(pose, channel, power))).into()
            }
            (SensorGain::Saturation { highest }, _) => {
                let ends = of.session.clipped_ends(channel).into_iter().filter(|end| end.is_highest == *highest);
                ends.map(|end| reads(&|pose| f64::from(of.read_at(pose, channel) == Some(end.at)))).collect()
            }
            (SensorGain::Crosstalk, true) => {
                let others = of.predicted.others(channel).into_iter();
                others.map(|other| reads(&|pose| of.predicted.torque(pose, other))).collect()
            }
            (SensorGain::Crosstalk, false) => {
                let others = of.of_axes.others(channel).into_iter();
                others.map(|other| reads(&|pose| of.of_axes.reading(pose, other))).collect()
            }
        }
    }

    fn as_modelled(&self, of: &Columns, channel: usize) -> Vec<Vec<f64>> {
        match self {
            SensorGain::Trend => vec![of.times_reading(channel, of.time_since(channel, |_| 0))],
            _ => self.columns(of, channel),
        }
    }

    fn found(&self, of: &Columns, channel: usize, coefficients: &[f64]) -> Found {
        match self {
            SensorGain::InTables => {
                let (file, size) = of.farthest(&of.tables(channel), coefficients);
                Found::new(ResidualTestKind::TorqueGain { file }, 100.0 * size, "%")
            }
            SensorGain::Trend => {
                let first = coefficients.first().copied().unwrap_or(0.0);
                Found::new(ResidualTestKind::TorqueGainTrend, 100.0 * first, format!("%/{}", of.unit_of_time()))
            }
            SensorGain::Nonlinearity => {
                let amplitude = dot(coefficients, coefficients).sqrt();
                Found::new(ResidualTestKind::TorqueNonlinearity, amplitude, of.session.channel_unit(channel))
            }
            SensorGain::Saturation { .. } => {
                let first = coefficients.first().copied().unwrap_or(0.0);
                Found::new(ResidualTestKind::Saturation, first, of.session.channel_unit(channel))
            }
            SensorGain::Crosstalk => shows_most(of, channel, coefficients),
        }
    }

    /// Warmth changes all gains about the same.
    fn is_alike_in_all_joints(&self, of: &Columns) -> bool {
        match self {
            SensorGain::Trend => true,
            SensorGain::InTables => of.tables_of_all().len() == 2,
            SensorGain::Nonlinearity | SensorGain::Saturation { .. } | SensorGain::Crosstalk => false,
        }
    }

    /// A sensor at an end of its range reads too little there.
    fn may_be(&self, _of: &Columns, _channel: usize, coefficients: &[f64]) -> bool {
        match self {
            SensorGain::Saturation { highest: true } => coefficients.iter().all(|size| *size <= 0.0),
            SensorGain::Saturation { highest: false } => coefficients.iter().all(|size| *size >= 0.0),
            _ => true,
        }
    }
}

/// The joint whose torque, or the axis whose reading, shows most in the reading of another.
fn shows_most(of: &Columns, channel: usize, coefficients: &[f64]) -> Found {
    let session = of.session;
    let most = match of.is_joint(channel) {
        true => of.predicted.shows_most(channel, coefficients),
        false => of.of_axes.shows_most(channel, coefficients),
    };
    let (other, size) = most.unwrap_or((channel, 0.0));
    let unit = match of.is_joint(channel) {
        true => per_torque(session, channel, other, ""),
        false => {
            let (own, other) = (session.channel_unit(channel), session.channel_unit(other));
            if other.contains('·') { format!("{own}/({other})") } else { format!("{own}/{other}") }
        }
    };
    Found::new(ResidualTestKind::Crosstalk { joint: session.channel_name(other) }, size, unit)
}

pub fn of_tables(test: &ResidualTest, file: &str) -> Words {
    let channel = &test.channel;
    let whose = match channel == ALL_JOINTS {
        true => "torque gains of all joints are",
        false => &format!("torque gain of {channel} is"),
    };
    Words::new(
        format!("The residuals show that the {whose} different in {file}, by {}.", shown(test)),
        "Either the arm was warmer, an amplifier was set anew, or a load is not as stated. Record all tables in one go with a warm arm, or \
         calibrate those before and after by themselves.",
    )
    .beside(others_change(channel))
}

pub fn of_trend(session: &Session, test: &ResidualTest) -> Words {
    let channel = &test.channel;
    let joint = joint_of(session, channel);
    let whose = match channel == ALL_JOINTS {
        true => "torque gains of all joints drift",
        false => &format!("torque gain of {channel} drifts"),
    };
    let drift = [("drift", per_torque(session, joint, joint, "·s"), "limit = 0.01".into())];
    Words::new(
        format!("The residuals show that the {whose}, by {}.", shown(test)),
        format!(
            "Let the arm warm up before it is recorded; or estimate a steady drift (times are needed): {}.",
            formula(channel, "drift * torque * time", &drift)
        ),
    )
    .beside(others_change(channel))
}

pub fn of_crosstalk(session: &Session, test: &ResidualTest, other: &str) -> Words {
    let (channel, size) = (&test.channel, shown(test));
    match instrument_of(session, channel) {
        None => Words::new(
            format!("The reading of {channel} goes with torques of other joints, most with that of {other}: {size}."),
            format!(
                "Estimate it: sensor_models = [{{ kind = \"torque-crosstalk\", from = [\"{other}\"] }}] in its [[joint]]."
            ),
        ),
        Some(kind) => {
            let known = match kind {
                AuxiliarySensorKind::Accelerometer => ", or say how well its mounting is known (mounting_std_deg)",
                AuxiliarySensorKind::ForceTorque => "",
            };
            Words::new(
                format!("The reading of {channel} goes with what other axes sense, most with {other}: {size}."),
                format!(
                    "Measure the instrument's mounting (mounting.rpy_deg){known}; or let each axis have a gain for what each other one senses (gains = \"matrix\")."
                ),
            )
        }
    }
}

pub fn of_nonlinearity(session: &Session, test: &ResidualTest) -> Words {
    let (channel, size) = (&test.channel, shown(test));
    match instrument_of(session, channel) {
        None => Words::new(
            format!(
                "The reading of {channel} is not proportional to its torque: it is off by about {size} at the largest."
            ),
            "Estimate it: sensor_models = [{ kind = \"torque-gain-polynomial\" }] in its [[joint]].",
        ),
        Some(_) => Words::new(
            format!(
                "The reading of {channel} is not proportional to what it senses: it is off by about {size} at the largest."
            ),
            "If it is at an end of its range, say where that is (lowest, highest in its readings); else use it where it is straight, or correct its readings before.",
        ),
    }
}

/// A sensor at an end of its range reads too little beyond its largest reading, and too much beyond its smallest.
pub fn of_saturation(session: &Session, test: &ResidualTest) -> Words {
    let channel = &test.channel;
    let place = (0..session.channel_count()).find(|one| session.channel_name(*one) == *channel).unwrap_or(0);
    let ends = session.clipped_ends(place);
    let Some(end) = ends.into_iter().find(|end| end.is_highest == (test.size < 0.0)) else {
        return Words::new(format!("The reading of {channel} is at an end of its range."), "Say where that is.");
    };
    let [which, key] = end.words();
    // A number for each; of the others one that no reading comes to.
    let none = if end.is_highest { "1e9" } else { "-1e9" };
    let alike = channels_of_its_table(session, place);
    let numbers = alike.map(|one| if one == place { end.at.to_string() } else { none.to_owned() });
    let numbers: Vec<String> = numbers.collect();
    Words::new(
        format!(
            "The {which} reading of {channel}, which is the same in {} poses, is an end of its range: the true ones are beyond it, on the mean by {}.",
            end.poses,
            shown_amount(test)
        ),
        format!(
            "Say so: {key} = [{}] in {}. Its readings there are left out then.",
            numbers.join(", "),
            session.readings_table(place)
        ),
    )
}

/// Channels whose readings a session states beside those of one: of all joints, or of all axes of its instrument.
fn channels_of_its_table(session: &Session, channel: usize) -> Range<usize> {
    let joints = session.joints.len();
    session.axis(channel).map_or(0..joints, |(instrument, _)| {
        let readings = session.instruments[instrument].readings();
        joints + readings.start..joints + readings.end
    })
}

/// What kind of instrument a channel is an axis of; nothing of a joint.
fn instrument_of(session: &Session, channel: &str) -> Option<AuxiliarySensorKind> {
    let place = (session.joints.len()..session.channel_count()).find(|one| session.channel_name(*one) == channel)?;
    let (instrument, _) = session.axis(place)?;
    Some(session.instruments[instrument].kind)
}

fn others_change(channel: &str) -> Option<&'static str> {
    (channel != ALL_JOINTS).then_some(OTHER_GAINS)
}
