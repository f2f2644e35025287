//! What columns may mean, by their names and ranges.

use std::f64::consts::PI;

use serde::Serialize;

use crate::rows::joint_state::{ColumnName, Quantity, TIME};

/// What a column may mean.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Guess {
    /// What kind of reading it is; `None` where the name does not tell.
    pub meaning: Option<Meaning>,
    /// Of which joint: its name in messages, else what is left of the column's name.
    pub joint: Option<String>,
    /// Its unit; `None` where neither name nor range tells.
    pub unit: Option<&'static str>,
}

/// Kinds of readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Meaning {
    /// Of a position sensor.
    Position,
    /// Of a joint's speed.
    Velocity,
    /// Of a torque sensor.
    Torque,
    /// Of a thermometer.
    Temperature,
}

/// A unit of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TimeUnit {
    pub(super) name: &'static str,
    /// How many of it are a second.
    pub(super) per_second: f64,
}

const TIME_UNITS: [TimeUnit; 4] = [
    TimeUnit { name: "s", per_second: 1.0 },
    TimeUnit { name: "ms", per_second: 1e3 },
    TimeUnit { name: "µs", per_second: 1e6 },
    TimeUnit { name: "ns", per_second: 1e9 },
];

/// Words for the kinds of readings, as they stand in names of columns.
const WORDS: [(Meaning, &[&str]); 4] = [
    (Meaning::Velocity, &["qd", "dq", "qdot", "vel", "velocity", "speed", "omega"]),
    (Meaning::Torque, &["tau", "torque", "effort", "trq", "moment"]),
    (Meaning::Position, &["q", "pos", "position", "angle", "theta"]),
    (Meaning::Temperature, &["temp", "temperature"]),
];

/// Words for units.
const UNITS: [(&str, &str); 12] = [
    ("rad", "rad"),
    ("deg", "deg"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("mm", "mm"),
    ("m", "m"),
    ("nm", "N·m"),
    ("count", "count"),
    ("counts", "count"),
    ("v", "V"),
    ("volt", "V"),
    ("degc", "degC"),
];

/// The column that is a clock, if one is.
pub(super) fn clock(columns: &[String]) -> Option<usize> {
    let is_clock = |column: &String| {
        let words = words(column);
        matches!(words.first().map(String::as_str), Some("t" | "time" | "timestamp" | "stamp" | "zeit"))
    };
    let named = columns.iter().position(|column| column == TIME);
    named.or_else(|| columns.iter().position(is_clock))
}

/// The unit of a clock, by the end of its name, else by its usual step: robots are sampled every tenth of a millisecond to every tenth
/// of a second.
pub(super) fn time_unit(column: &str, step: f64) -> TimeUnit {
    let last = words(column).pop().unwrap_or_default();
    let said = match last.as_str() {
        "sec" | "secs" | "seconds" => Some("s"),
        "us" | "usec" => Some("µs"),
        "msec" => Some("ms"),
        "nsec" => Some("ns"),
        other => TIME_UNITS.iter().map(|unit| unit.name).find(|name| *name == other),
    };
    let by_step = TIME_UNITS.into_iter().find(|unit| step / unit.per_second < 0.5);
    let by_name = TIME_UNITS.into_iter().find(|unit| Some(unit.name) == said);
    by_name.or(by_step).unwrap_or(TIME_UNITS[0])
}

/// What a column may mean.
pub(super) fn guess(column: &str, lowest: f64, highest: f64, whole: bool) -> Guess {
    let (meaning, joint, said) = match ColumnName::parse(column) {
        Some(name) => {
            let meaning = match name.quantity {
                Quantity::Position => Meaning::Position,
                Quantity::Velocity => Meaning::Velocity,
                Quantity::Effort => Meaning::Torque,
            };
            (Some(meaning), Some(name.joint.to_owned()), None)
        }
        None => by_words(column),
    };
    let largest = lowest.abs().max(highest.abs());
    let by_range = || match meaning? {
        _ if whole && largest > 20.0 => Some("count"),
        Meaning::Position if largest > 4.0 * PI => Some("deg"),
        Meaning::Position => Some("rad"),
        Meaning::Velocity if largest > 8.0 * PI => Some("deg/s"),
        Meaning::Velocity => Some("rad/s"),
        Meaning::Torque => Some("N·m"),
        Meaning::Temperature if lowest > 200.0 => Some("K"),
        Meaning::Temperature => Some("degC"),
    };
    Guess { meaning, joint, unit: said.or_else(by_range) }
}

/// Meaning, joint and unit of a name such as `q1_deg`, `joint1_position_rad`, `tau1_Nm`, `qd1_rad_per_s`.
fn by_words(column: &str) -> (Option<Meaning>, Option<String>, Option<&'static str>) {
    let words = words(column);
    let meaning_of =
        |word: &String| WORDS.iter().find(|(_, names)| names.contains(&word.as_str())).map(|(meaning, _)| *meaning);
    let Some(meaning) = words.iter().find_map(meaning_of) else { return (None, None, None) };
    let is_rate = words.iter().any(|word| word == "per");
    let unit_of = |word: &String| UNITS.iter().find(|(name, _)| name == word).map(|(_, unit)| *unit);
    let unit = words.iter().skip(1).filter(|word| meaning_of(word).is_none()).find_map(unit_of);
    let unit = match (unit, is_rate) {
        (Some("rad"), true) => Some("rad/s"),
        (Some("deg"), true) => Some("deg/s"),
        (Some("m"), true) => Some("m/s"),
        (Some("mm"), true) => Some("mm/s"),
        (unit, _) => unit,
    };
    let left = words.iter().enumerate().filter(|(place, word)| {
        meaning_of(word).is_none()
            && !(*place > 0 && (unit_of(word).is_some() || ["per", "s"].contains(&word.as_str())))
    });
    let joint: String = left.map(|(_, word)| word.as_str()).collect();
    (Some(meaning), (!joint.is_empty()).then_some(joint), unit)
}

/// The words and numbers of a name in lower case: `qd1_rad` is `qd`, `1`, `rad`.
fn words(name: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut last = ' ';
    for letter in name.chars() {
        let begins = !last.is_alphanumeric() || last.is_ascii_digit() != letter.is_ascii_digit();
        if letter.is_alphanumeric() {
            if begins {
                words.push(String::new());
            }
            if let Some(word) = words.last_mut() {
                word.extend(letter.to_lowercase());
            }
        }
        last = letter;
    }
    words
}
