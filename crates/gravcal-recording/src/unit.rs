//! Units that can stand at the border of the program, and their factor to what is used inside.

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

/// Unit of a position reading: an angle, a length, or a sensor's own number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PositionUnit {
    /// Angle, `rad`.
    Radian,
    /// Angle, `deg`.
    Degree,
    /// Length of a prismatic joint, `m`.
    Meter,
    /// Length of a prismatic joint, `mm`.
    Millimeter,
    /// Number of a converter or encoder, `count`.
    Count,
    /// Voltage of a potentiometer, `V`.
    Volt,
}

impl PositionUnit {
    /// Every unit, in the order in which messages list them.
    pub const ALL: [PositionUnit; 6] = [
        PositionUnit::Radian,
        PositionUnit::Degree,
        PositionUnit::Meter,
        PositionUnit::Millimeter,
        PositionUnit::Count,
        PositionUnit::Volt,
    ];

    /// What a reading is multiplied with to be in rad or m. A sensor's own unit (count, V) stays: 1.
    pub fn to_si(self) -> f64 {
        match self {
            PositionUnit::Degree => PI / 180.0,
            PositionUnit::Millimeter => 1e-3,
            PositionUnit::Radian | PositionUnit::Meter => 1.0,
            PositionUnit::Count | PositionUnit::Volt => 1.0,
        }
    }

    /// Whether it is a sensor's own number, which only a gain turns into an angle or a length.
    pub fn is_sensors_own(self) -> bool {
        matches!(self, PositionUnit::Count | PositionUnit::Volt)
    }

    /// The unit that a reading has after multiplication with [`to_si`](Self::to_si).
    #[must_use]
    pub fn si(self) -> PositionUnit {
        match self {
            PositionUnit::Degree => PositionUnit::Radian,
            PositionUnit::Millimeter => PositionUnit::Meter,
            other => other,
        }
    }

    /// The name that stands in files, such as `deg`.
    pub fn name(self) -> &'static str {
        match self {
            PositionUnit::Radian => "rad",
            PositionUnit::Degree => "deg",
            PositionUnit::Meter => "m",
            PositionUnit::Millimeter => "mm",
            PositionUnit::Count => "count",
            PositionUnit::Volt => "V",
        }
    }
}

impl fmt::Display for PositionUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for PositionUnit {
    type Err = UnknownUnit;

    /// Takes the names as [`Display`](fmt::Display) writes them (upper and lower case differ), and other spellings of some.
    fn from_str(text: &str) -> Result<Self, UnknownUnit> {
        match text.trim() {
            "rad" | "radian" | "radians" => Ok(PositionUnit::Radian),
            // The last is U+00BA (ordinal indicator), which looks the same.
            "deg" | "degree" | "degrees" | "°" | "º" => Ok(PositionUnit::Degree),
            "m" => Ok(PositionUnit::Meter),
            "mm" => Ok(PositionUnit::Millimeter),
            "count" => Ok(PositionUnit::Count),
            "V" => Ok(PositionUnit::Volt),
            _ => Err(UnknownUnit {
                quantity: "position",
                found: text.to_owned(),
                accepted: "rad, deg (also °, degrees), m, mm, count, V",
            }),
        }
    }
}

/// Unit of a torque reading (a force, at a prismatic joint). A motor's current, or its share of some full load, is one too: what a
/// N·m is of it the gain says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TorqueUnit {
    /// Torque, `N·m`.
    NewtonMeter,
    /// Torque, `mN·m`.
    MillinewtonMeter,
    /// Force of a prismatic joint, `N`.
    Newton,
    /// Current of a motor, `A`.
    Ampere,
    /// Current of a motor, `mA`.
    Milliampere,
    /// Share of a full load, `%`.
    Percent,
    /// Number of a converter, `count`.
    Count,
    /// Voltage of a bridge amplifier, `V`.
    Volt,
}

impl TorqueUnit {
    /// Every unit, in the order in which messages list them.
    pub const ALL: [TorqueUnit; 8] = [
        TorqueUnit::NewtonMeter,
        TorqueUnit::MillinewtonMeter,
        TorqueUnit::Newton,
        TorqueUnit::Ampere,
        TorqueUnit::Milliampere,
        TorqueUnit::Percent,
        TorqueUnit::Count,
        TorqueUnit::Volt,
    ];

    /// What a reading is multiplied with when it is read: 1. Torque readings stay in their unit, and the gain has the rest.
    pub fn to_si(self) -> f64 {
        1.0
    }

    /// How many of it a unit of `effort` is (N·m or N), where units alone tell: else it is the sensor's own, and only a gain tells.
    pub fn of(self, effort: TorqueUnit) -> Option<f64> {
        match (self, effort) {
            (TorqueUnit::MillinewtonMeter, TorqueUnit::NewtonMeter) => Some(1e3),
            (own, effort) => (own == effort).then_some(1.0),
        }
    }

    /// Whether it is a sensor's own number, which only a gain turns into a torque or a force.
    pub fn is_sensors_own(self) -> bool {
        !matches!(self, TorqueUnit::NewtonMeter | TorqueUnit::MillinewtonMeter | TorqueUnit::Newton)
    }

    /// The name that messages and reports use, such as `N·m`.
    pub fn name(self) -> &'static str {
        match self {
            TorqueUnit::NewtonMeter => "N·m",
            TorqueUnit::MillinewtonMeter => "mN·m",
            TorqueUnit::Newton => "N",
            TorqueUnit::Ampere => "A",
            TorqueUnit::Milliampere => "mA",
            TorqueUnit::Percent => "%",
            TorqueUnit::Count => "count",
            TorqueUnit::Volt => "V",
        }
    }
}

impl fmt::Display for TorqueUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for TorqueUnit {
    type Err = UnknownUnit;

    /// Takes the names as [`Display`](fmt::Display) writes them, and the newton metre with any sign for the product, or none.
    fn from_str(text: &str) -> Result<Self, UnknownUnit> {
        // The second is U+22C5 (dot operator), which looks the same.
        let plain = text.trim().replace(['·', '⋅', '*', '.', ' '], "");
        match plain.as_str() {
            "Nm" => Ok(TorqueUnit::NewtonMeter),
            "mNm" | "Nmm" => Ok(TorqueUnit::MillinewtonMeter),
            "N" => Ok(TorqueUnit::Newton),
            "A" => Ok(TorqueUnit::Ampere),
            "mA" => Ok(TorqueUnit::Milliampere),
            "%" | "percent" => Ok(TorqueUnit::Percent),
            "count" => Ok(TorqueUnit::Count),
            "V" => Ok(TorqueUnit::Volt),
            _ => Err(UnknownUnit {
                quantity: "torque",
                found: text.to_owned(),
                accepted: "N·m (also Nm, N*m), mN·m (also N·mm), N, A, mA, %, count, V",
            }),
        }
    }
}

/// A text that names no unit of the quantity.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{found}` is no unit of {quantity}; accepted are {accepted}")]
pub struct UnknownUnit {
    quantity: &'static str,
    found: String,
    accepted: &'static str,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_position_unit_is_read_as_it_is_written() {
        for unit in PositionUnit::ALL {
            assert_eq!(unit.to_string().parse(), Ok(unit));
        }
    }

    #[test]
    fn every_torque_unit_is_read_as_it_is_written() {
        for unit in TorqueUnit::ALL {
            assert_eq!(unit.to_string().parse(), Ok(unit));
            assert_eq!(unit.to_si(), 1.0);
        }
    }

    #[test]
    fn newton_metre_has_spellings_for_every_keyboard() {
        for spelling in ["N·m", "N⋅m", "Nm", "N*m", "N m", "N.m", " Nm "] {
            assert_eq!(spelling.parse(), Ok(TorqueUnit::NewtonMeter));
        }
        for spelling in ["mNm", "mN·m", "Nmm", "N·mm"] {
            assert_eq!(spelling.parse(), Ok(TorqueUnit::MillinewtonMeter));
        }
        assert_eq!(["°", "degrees", "deg"].map(str::parse), std::array::from_fn(|_| Ok(PositionUnit::Degree)));
    }

    #[test]
    fn units_tell_how_many_of_one_are_another() {
        let of = |unit: TorqueUnit| unit.of(TorqueUnit::NewtonMeter);
        assert_eq!((of(TorqueUnit::NewtonMeter), of(TorqueUnit::MillinewtonMeter)), (Some(1.0), Some(1000.0)));
        for unit in TorqueUnit::ALL {
            assert_eq!(unit.is_sensors_own(), of(unit).is_none() && unit.of(TorqueUnit::Newton).is_none(), "{unit}");
        }
    }

    #[test]
    fn factors_lead_to_radian_and_metre() {
        assert_eq!(180.0 * PositionUnit::Degree.to_si(), PI);
        assert_eq!(250.0 * PositionUnit::Millimeter.to_si(), 0.25);
        for unit in PositionUnit::ALL.map(PositionUnit::si) {
            assert_eq!(unit.to_si(), 1.0);
            assert_eq!(unit.si(), unit);
        }
    }

    #[test]
    fn unknown_units_list_every_accepted_name() {
        let message = "gon".parse::<PositionUnit>().unwrap_err().to_string();
        assert_eq!(message, "`gon` is no unit of position; accepted are rad, deg (also °, degrees), m, mm, count, V");
        for unit in PositionUnit::ALL {
            assert!(message.contains(unit.name()));
        }

        let message = "kNm".parse::<TorqueUnit>().unwrap_err().to_string();
        let accepted = "N·m (also Nm, N*m), mN·m (also N·mm), N, A, mA, %, count, V";
        assert_eq!(message, format!("`kNm` is no unit of torque; accepted are {accepted}"));
        for unit in TorqueUnit::ALL {
            assert!(message.contains(unit.name()));
        }
    }

    #[test]
    fn upper_and_lower_case_differ() {
        // `M` or `MM` would be mega-something; better an error than a guess.
        assert!("MM".parse::<PositionUnit>().is_err());
        assert!("v".parse::<TorqueUnit>().is_err());
    }
}
