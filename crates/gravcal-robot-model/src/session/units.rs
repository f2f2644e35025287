//! Units of sensor parameters as they stand in files.
//!
//! ```text
//!     reading = gain · torque + bias          gain in count/(N·m), bias in count
//!     coordinate = gain · reading + offset    gain in deg/count,   offset in deg
//! ```
//!
//! Each function takes the unit as it is written, `None` where it is missing, and refuses both a missing and an unknown
//! unit with the list of those that may stand there.

use std::str::FromStr;

use gravcal_dynamics::JointKind;
use gravcal_recording::{PositionUnit, TorqueUnit};

use crate::session::AuxiliarySensorKind;

/// A unit that is missing, or does not fit its quantity.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: expected {expected}{}", described(.found.as_deref()), reported(.turned.as_deref()))]
pub struct UnitError {
    found: Option<String>,
    expected: String,
    /// What was written, the right way round.
    turned: Option<String>,
}

impl UnitError {
    /// The same of a gain of this `value` that may be written the other way round: torque a reading, not reading a torque. `fits` tells
    /// whether a unit may stand there.
    pub fn of_gain(mut self, value: Option<f64>, fits: impl Fn(&str) -> bool) -> UnitError {
        self.turned = value.zip(self.found.as_deref()).and_then(|(value, unit)| turned(value, unit, fits));
        self
    }
}

/// A gain that fits when it is turned round: `12 N·m/A is 0.0833 A/(N·m)`.
fn turned(value: f64, unit: &str, fits: impl Fn(&str) -> bool) -> Option<String> {
    let (numerator, denominator) = unit.split_once('/')?;
    let bracketed = |unit: &str| match unit.chars().all(|letter| letter.is_alphanumeric() || letter == '%') {
        true => unit.to_owned(),
        false => format!("({unit})"),
    };
    let turned = format!("{}/{}", without_brackets(denominator), bracketed(without_brackets(numerator)));
    let inverse = format!("{:.2e}", 1.0 / value).parse::<f64>().ok().filter(|inverse| inverse.is_normal())?;
    fits(&turned).then(|| format!("{value} {unit} is {inverse} {turned}"))
}

fn reported(turned: Option<&str>) -> String {
    turned.map_or_else(String::new, |turned| format!("; {turned}"))
}

fn described(found: Option<&str>) -> String {
    match found {
        Some(found) => format!("the unit `{found}` does not fit"),
        None => "the unit is missing".to_owned(),
    }
}

/// The unit of a position gain: a coordinate a reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PositionGainUnit {
    /// Of the coordinate: an angle or a length.
    pub coordinate: PositionUnit,
    /// Of the reading.
    pub reading: PositionUnit,
}

impl PositionGainUnit {
    /// What a gain is multiplied with to be in rad (or m) a unit of the reading in SI.
    pub fn to_si(self) -> f64 {
        self.coordinate.to_si() / self.reading.to_si()
    }
}

/// The SI unit of what a joint exerts: the only one a torque gain may be counted in.
pub fn effort(kind: JointKind) -> TorqueUnit {
    match kind {
        JointKind::Revolute => TorqueUnit::NewtonMeter,
        JointKind::Prismatic => TorqueUnit::Newton,
    }
}

/// The SI unit of a joint's coordinate.
pub fn si_coordinate(kind: JointKind) -> PositionUnit {
    match kind {
        JointKind::Revolute => PositionUnit::Radian,
        JointKind::Prismatic => PositionUnit::Meter,
    }
}

/// Unit of a position reading, such as `deg`.
pub fn position_reading(written: Option<&str>) -> Result<PositionUnit, UnitError> {
    parse(written, || format!("a unit of position, one of {}", listed(&PositionUnit::ALL)))
}

/// Unit of a torque reading, such as `count`.
pub fn torque_reading(written: Option<&str>) -> Result<TorqueUnit, UnitError> {
    parse(written, || format!("a unit of torque readings, one of {}", listed(&TorqueUnit::ALL)))
}

/// Unit of a joint's coordinate, such as `deg`.
pub fn coordinate(written: Option<&str>, kind: JointKind) -> Result<PositionUnit, UnitError> {
    let expected = || format!("one of {}, as the joint is {}", listed(&coordinates(kind)), adjective(kind));
    let unit: PositionUnit = parse(written, expected)?;
    if coordinates(kind).contains(&unit) { Ok(unit) } else { Err(refused(written, expected())) }
}

/// Unit of a torque gain, such as `count/(N·m)`; gives that of the reading, as the joint's kind fixes the other.
pub fn torque_gain(written: Option<&str>, kind: JointKind) -> Result<TorqueUnit, UnitError> {
    let denominator = effort(kind);
    let shown = if kind == JointKind::Revolute { format!("({denominator})") } else { denominator.to_string() };
    let expected = || {
        let units = TorqueUnit::ALL.map(|reading| format!("{reading}/{shown}")).join(", ");
        format!("one of {units}, as the joint is {}", adjective(kind))
    };
    match ratio::<TorqueUnit>(written) {
        Some((reading, unit)) if unit == denominator => Ok(reading),
        _ => Err(refused(written, expected())),
    }
}

/// Unit of a position gain, such as `deg/count`.
pub fn position_gain(written: Option<&str>, kind: JointKind) -> Result<PositionGainUnit, UnitError> {
    match ratio::<PositionUnit>(written) {
        Some((coordinate, reading)) if coordinates(kind).contains(&coordinate) => {
            Ok(PositionGainUnit { coordinate, reading })
        }
        _ => {
            let expected = format!(
                "<coordinate>/<reading>, such as {}/count, with a coordinate in {} (the joint is {}) and a reading in {}",
                si_coordinate(kind),
                listed(&coordinates(kind)),
                adjective(kind),
                listed(&PositionUnit::ALL)
            );
            Err(refused(written, expected))
        }
    }
}

/// Unit of a reading of an instrument's axis: that of what it senses, or the sensor's own.
pub fn sensed_reading(written: Option<&str>, kind: AuxiliarySensorKind, axis: usize) -> Result<String, UnitError> {
    let si = kind.sensed_unit(axis).trim_matches(['(', ')']);
    let known: &[&str] = match kind {
        AuxiliarySensorKind::ForceTorque => &[si, "count", "V"],
        AuxiliarySensorKind::Accelerometer => &[si, "g", "count", "V"],
    };
    let found = known.iter().find(|unit| same(written, unit).is_ok());
    found.map(|unit| (*unit).to_owned()).ok_or_else(|| {
        let axis = kind.axes()[axis];
        refused(written, format!("a unit of readings of axis {axis}, one of {}", known.join(", ")))
    })
}

/// The same where one unit is written for all axes: with forces in N go moments in N·m.
pub fn sensed_by_all(written: Option<&str>, kind: AuxiliarySensorKind, axis: usize) -> Result<String, UnitError> {
    if kind == AuxiliarySensorKind::Accelerometer {
        return sensed_reading(written, kind, axis);
    }
    let newtons = same(written, "N").is_ok();
    let unit = if newtons && axis >= 3 { Some("N·m") } else { written };
    sensed_reading(unit, kind, axis).map_err(|_| {
        let each = "[\"N\", \"N\", \"N\", \"N·m\", \"N·m\", \"N·m\"]";
        refused(
            written,
            format!("one of N (of forces, with N·m of moments), count, V, or one for each axis, such as {each}"),
        )
    })
}

/// Unit of the gain of such an axis, such as `count/(N·m)`.
pub fn gain_of(reading: &str, sensed: &str) -> String {
    if reading.contains('/') { format!("({reading})/{sensed}") } else { format!("{reading}/{sensed}") }
}

/// Gain of a reading whose unit says it all.
pub fn natural_gain(reading: &str, sensed: &str) -> Option<f64> {
    match reading {
        "g" => Some(1.0 / STANDARD_GRAVITY),
        _ => (reading == sensed.trim_matches(['(', ')'])).then_some(1.0),
    }
}

/// The acceleration `g` of an accelerometer's data sheet, m/s².
const STANDARD_GRAVITY: f64 = 9.80665;

/// Sees to it that a unit is the expected one, however it is spelled.
pub fn same(written: Option<&str>, expected: &str) -> Result<(), UnitError> {
    let plain = |unit: &str| {
        let unit: String = unit.chars().filter(|c| !c.is_whitespace() && !"()".contains(*c)).collect();
        unit.replace('*', "·").replace("Nm", "N·m").replace("kgm", "kg·m").replace("^2", "²").replace("s2", "s²")
    };
    match written {
        Some(unit) if plain(unit) == plain(expected) => Ok(()),
        _ => Err(refused(written, expected.to_owned())),
    }
}

fn parse<U: FromStr>(written: Option<&str>, expected: impl Fn() -> String) -> Result<U, UnitError> {
    written.and_then(|unit| unit.parse().ok()).ok_or_else(|| refused(written, expected()))
}

/// The two units of `a/b` or `a/(b)`.
fn ratio<U: FromStr>(written: Option<&str>) -> Option<(U, U)> {
    let (numerator, denominator) = written?.split_once('/')?;
    Some((without_brackets(numerator).parse().ok()?, without_brackets(denominator).parse().ok()?))
}

fn without_brackets(unit: &str) -> &str {
    let unit = unit.trim();
    unit.strip_prefix('(').and_then(|unit| unit.strip_suffix(')')).unwrap_or(unit)
}

fn refused(written: Option<&str>, expected: String) -> UnitError {
    UnitError { found: written.map(str::to_owned), expected, turned: None }
}

fn coordinates(kind: JointKind) -> [PositionUnit; 2] {
    match kind {
        JointKind::Revolute => [PositionUnit::Radian, PositionUnit::Degree],
        JointKind::Prismatic => [PositionUnit::Meter, PositionUnit::Millimeter],
    }
}

fn adjective(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Revolute => "revolute",
        JointKind::Prismatic => "prismatic",
    }
}

fn listed<U: ToString>(units: &[U]) -> String {
    units.iter().map(U::to_string).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use JointKind::{Prismatic, Revolute};

    #[test]
    fn gains_of_torque_have_the_unit_of_their_reading() {
        for spelling in ["count/(N·m)", "count/N·m", "count/Nm", "count / (N*m)"] {
            assert_eq!(torque_gain(Some(spelling), Revolute), Ok(TorqueUnit::Count), "{spelling}");
        }
        assert_eq!(torque_gain(Some("(N·m)/(N·m)"), Revolute), Ok(TorqueUnit::NewtonMeter));
        assert_eq!(torque_gain(Some("V/N"), Prismatic), Ok(TorqueUnit::Volt));
        let own = ["A/Nm", "mA/(N·m)", "%/(N*m)", "mNm/Nm"].map(|unit| torque_gain(Some(unit), Revolute));
        let units = [TorqueUnit::Ampere, TorqueUnit::Milliampere, TorqueUnit::Percent, TorqueUnit::MillinewtonMeter];
        assert_eq!(own, units.map(Ok));
    }

    #[test]
    fn gains_of_position_lead_to_si() {
        let factor = |unit: &str, kind| position_gain(Some(unit), kind).unwrap().to_si();
        assert_eq!(factor("deg/deg", Revolute), 1.0);
        assert_eq!(factor("mm/mm", Prismatic), 1.0);
        assert_eq!(factor("deg/count", Revolute), PI / 180.0);
        assert_eq!(factor("mm/V", Prismatic), 1e-3);
        assert_eq!(factor("rad/deg", Revolute), 180.0 / PI);
    }

    #[test]
    fn axes_of_instruments_have_units_of_their_own() {
        let force = |unit, axis| sensed_reading(unit, AuxiliarySensorKind::ForceTorque, axis);
        assert_eq!(force(Some("N"), 0), Ok("N".to_owned()));
        assert_eq!(force(Some("Nm"), 3), Ok("N·m".to_owned()));
        let message = force(Some("N"), 3).unwrap_err().to_string();
        assert_eq!(message, "the unit `N` does not fit: expected a unit of readings of axis nx, one of N·m, count, V");
        let acceleration = sensed_reading(Some("m/s^2"), AuxiliarySensorKind::Accelerometer, 1).unwrap();
        assert_eq!(gain_of(&acceleration, "(m/s²)"), "(m/s²)/(m/s²)");
        assert!(same(Some("m/s2/(m/s2)"), "(m/s²)/(m/s²)").is_ok() && same(Some("count/N"), "count/(N·m)").is_err());
        assert_eq!(natural_gain("N·m", "(N·m)"), Some(1.0));
        assert_eq!(natural_gain("count", "N"), None);
        assert!((natural_gain("g", "(m/s²)").unwrap() * 9.80665 - 1.0).abs() < 1e-15);
    }

    #[test]
    fn one_unit_of_a_wrist_sensor_is_that_of_its_forces() {
        let unit = |written, axis| sensed_by_all(written, AuxiliarySensorKind::ForceTorque, axis);
        assert_eq!([0, 2, 3, 5].map(|axis| unit(Some("N"), axis).unwrap()), ["N", "N", "N·m", "N·m"]);
        assert_eq!(unit(Some("count"), 4), Ok("count".to_owned()));
        for written in [None, Some("Nm"), Some("kg")] {
            let message = unit(written, 0).unwrap_err().to_string();
            assert!(message.contains("such as [\"N\", \"N\", \"N\", \"N·m\", \"N·m\", \"N·m\"]"), "{message}");
        }
        assert_eq!(sensed_by_all(Some("g"), AuxiliarySensorKind::Accelerometer, 2), Ok("g".to_owned()));
    }

    #[test]
    fn a_gain_that_is_written_the_other_way_round_is_reported_the_right_way() {
        let reported = |value, unit: &str| {
            let error = torque_gain(Some(unit), Revolute).unwrap_err();
            error.of_gain(Some(value), |turned| torque_gain(Some(turned), Revolute).is_ok()).to_string()
        };
        assert!(reported(12.0, "N·m/A").ends_with("; 12 N·m/A is 0.0833 A/(N·m)"), "{}", reported(12.0, "N·m/A"));
        assert!(
            reported(0.5, "Nm/(count)").ends_with("; 0.5 Nm/(count) is 2 count/Nm"),
            "{}",
            reported(0.5, "Nm/(count)")
        );
        for (value, unit) in [(12.0, "N·m"), (12.0, "kg/A"), (0.0, "N·m/A"), (f64::INFINITY, "N·m/A")] {
            assert!(reported(value, unit).ends_with("as the joint is revolute"), "{}", reported(value, unit));
        }
    }

    #[test]
    fn missing_and_unknown_units_are_reported_with_the_accepted_ones() {
        let message = |error: Result<TorqueUnit, UnitError>| error.unwrap_err().to_string();
        assert_eq!(
            message(torque_gain(None, Revolute)),
            "the unit is missing: expected one of N·m/(N·m), mN·m/(N·m), N/(N·m), A/(N·m), mA/(N·m), %/(N·m), count/(N·m), V/(N·m), as the joint is revolute"
        );
        assert_eq!(
            message(torque_gain(Some("count/(N·m)"), Prismatic)),
            "the unit `count/(N·m)` does not fit: expected one of N·m/N, mN·m/N, N/N, A/N, mA/N, %/N, count/N, V/N, as the joint is prismatic"
        );
        assert_eq!(
            message(torque_reading(Some("ticks"))),
            "the unit `ticks` does not fit: expected a unit of torque readings, one of N·m, mN·m, N, A, mA, %, count, V"
        );
        assert_eq!(
            position_reading(None).unwrap_err().to_string(),
            "the unit is missing: expected a unit of position, one of rad, deg, m, mm, count, V"
        );
        for unit in [None, Some("m"), Some("count"), Some("gon")] {
            assert!(
                coordinate(unit, Revolute)
                    .unwrap_err()
                    .to_string()
                    .ends_with("one of rad, deg, as the joint is revolute")
            );
        }
        for unit in [None, Some("count"), Some("m/count"), Some("count/deg"), Some("rad/deg/s")] {
            let message = position_gain(unit, Revolute).unwrap_err().to_string();
            assert!(
                message.contains("such as rad/count, with a coordinate in rad, deg (the joint is revolute) and"),
                "{message}"
            );
        }
    }
}
