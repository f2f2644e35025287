//! What columns may mean, by their names and ranges.

use std::f64::consts::PI;

use serde::Serialize;

use crate::iso8601::ISO_8601;
use crate::rows::joint_state::{ColumnName, Quantity, TIME};
use crate::unit::{PositionUnit, TorqueUnit};

/// What a column may mean.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Guess {
    /// What kind of reading it is; `None` where the name does not tell.
    pub meaning: Option<Meaning>,
    /// Of which axis of a force-torque sensor (`fx` to `nz`), which part of a quaternion (`x` to `w`), or which entry of a rotation matrix (`r11` to `r33`).
    pub axis: Option<&'static str>,
    /// Of which joint: its name in messages, else what is left of the column's name.
    pub joint: Option<String>,
    /// Its unit; `None` where neither name nor range tells.
    pub unit: Option<&'static str>,
    /// Whether the name tells the unit.
    pub unit_named: bool,
    /// Whether the name says that it is what was asked of the joint, and no reading of a sensor.
    pub commanded: bool,
    /// Whether `joint` is the one of a robot whose name stands in that of the column, among other words
    /// ([`Inspection::with_joint_names`](super::Inspection::with_joint_names)).
    #[serde(skip)]
    pub by_part: bool,
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
    /// Of a motor's current, which stands for its torque where nothing else does.
    Current,
    /// Of an axis of a force-torque sensor.
    #[serde(rename = "force-torque")]
    ForceTorque,
    /// Part of a quaternion, or of a rotation matrix, that tells how a body stood.
    Orientation,
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

const TIME_UNITS: [TimeUnit; 6] = [
    TimeUnit { name: "s", per_second: 1.0 },
    TimeUnit { name: "ms", per_second: 1e3 },
    TimeUnit { name: "µs", per_second: 1e6 },
    TimeUnit { name: "ns", per_second: 1e9 },
    TimeUnit { name: "min", per_second: 1.0 / 60.0 },
    TimeUnit { name: "h", per_second: 1.0 / 3600.0 },
];

/// That of a clock which holds dates with times: they are read as seconds.
pub(super) const DATES: TimeUnit = TimeUnit { name: ISO_8601, per_second: 1.0 };

/// Words for the kinds of readings, as they stand in names of columns.
const WORDS: [(Meaning, &[&str]); 5] = [
    (Meaning::Velocity, &["qd", "dq", "qdot", "vel", "velocity", "speed", "omega"]),
    (Meaning::Torque, &["tau", "torque", "effort", "trq", "moment"]),
    (Meaning::Current, &["current", "currents"]),
    (Meaning::Position, &["q", "pos", "position", "angle", "theta"]),
    (Meaning::Temperature, &["temp", "temperature"]),
];

/// Words for what was asked of a joint, and for what a sensor read.
const COMMANDED: [&str; 12] = [
    "desired",
    "des",
    "commanded",
    "command",
    "cmd",
    "target",
    "goal",
    "reference",
    "ref",
    "setpoint",
    "expected",
    "demand",
];
const MEASURED: [&str; 6] = ["measured", "meas", "actual", "act", "sensed", "msr"];

/// Words for the axes of a force-torque sensor, and for such a sensor, of which a word is an axis.
const WRENCH_AXES: [(&str, &[&str]); 6] = [
    ("fx", &["fx"]),
    ("fy", &["fy"]),
    ("fz", &["fz"]),
    ("nx", &["tx", "mx", "nx"]),
    ("ny", &["ty", "my", "ny"]),
    ("nz", &["tz", "mz", "nz"]),
];
const WRENCH: [&str; 6] = ["wrench", "ft", "tcp", "wrist", "force", "fts"];

/// Words for the parts of a quaternion, and for a quaternion, of which a word is a part.
const QUATERNION_PARTS: [(&str, &str); 4] = [("x", "qx"), ("y", "qy"), ("z", "qz"), ("w", "qw")];
/// Letters of a rotation matrix whose entries are counted from 1, and its entries row by row.
const MATRIX: [&str; 3] = ["r", "rot", "rotation"];
const MATRIX_ENTRIES: [(&str, &str); 9] = [
    ("r11", "11"),
    ("r12", "12"),
    ("r13", "13"),
    ("r21", "21"),
    ("r22", "22"),
    ("r23", "23"),
    ("r31", "31"),
    ("r32", "32"),
    ("r33", "33"),
];
const QUATERNION: [&str; 4] = ["quat", "quaternion", "orientation", "attitude"];

/// Words for a clock.
const CLOCK: [&str; 5] = ["t", "time", "timestamp", "stamp", "zeit"];
/// Words that stand behind `T` where it is a temperature.
const OF_TEMPERATURES: [&str; 16] = [
    "winding",
    "motor",
    "amb",
    "ambient",
    "env",
    "oil",
    "case",
    "coil",
    "board",
    "room",
    "temp",
    "temperature",
    "gear",
    "drive",
    "housing",
    "cpu",
];

/// Words for units.
const UNITS: [(&str, &str); 19] = [
    ("rad", "rad"),
    ("deg", "deg"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("mm", "mm"),
    ("m", "m"),
    ("nm", "N·m"),
    ("mnm", "mN·m"),
    ("nmm", "mN·m"),
    ("ma", "mA"),
    ("amp", "A"),
    ("amps", "A"),
    ("ampere", "A"),
    ("percent", "%"),
    ("count", "count"),
    ("counts", "count"),
    ("v", "V"),
    ("volt", "V"),
    ("degc", "degC"),
];

/// The column that is a clock, if one is; `t1` beside `t2` is none, as each is of a joint.
pub(super) fn clock(columns: &[String]) -> Option<usize> {
    let numbered = |column: &str| match words(column).as_slice() {
        [word, number, ..] if number.parse::<u64>().is_ok() => Some(word.clone()),
        _ => None,
    };
    let of_joint = |column: &str| {
        numbered(column)
            .is_some_and(|word| columns.iter().filter(|other| numbered(other).as_ref() == Some(&word)).count() > 1)
    };
    let is_clock = |column: &String| {
        let (head, unit) = without_unit(column);
        let words = words(&head);
        let named = words.split_first().is_some_and(|(first, others)| {
            let is_number = |word: &str| word.parse::<u64>().is_ok_and(|number| number > 0);
            let of_temperature = |word: &String| OF_TEMPERATURES.contains(&word.as_str()) || is_number(word);
            CLOCK.contains(&first.as_str()) && !(first == "t" && others.iter().any(of_temperature))
        });
        named && unit.and_then(meaning_of_unit).is_none() && !of_joint(column)
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
        "mins" | "minutes" => Some("min"),
        "hours" => Some("h"),
        other => TIME_UNITS.iter().map(|unit| unit.name).find(|name| *name == other),
    };
    let by_step = TIME_UNITS.into_iter().find(|unit| step / unit.per_second < 0.5);
    let by_name = TIME_UNITS.into_iter().find(|unit| Some(unit.name) == said);
    by_name.or(by_step).unwrap_or(TIME_UNITS[0])
}

/// Whether a column tells where a joint is or how fast it moves, as its sensors read.
pub(super) fn meaning_of_motion(column: &str) -> Option<Meaning> {
    let Guess { meaning, commanded, .. } = guess(column, 0.0, 0.0, false);
    meaning.filter(|meaning| !commanded && matches!(meaning, Meaning::Position | Meaning::Velocity))
}

/// What a column may mean.
pub(super) fn guess(column: &str, lowest: f64, highest: f64, whole: bool) -> Guess {
    guess_of(column, None, [lowest, highest], whole)
}

/// The same of a column of which something else than the words of its name tells the meaning.
pub(super) fn with_meaning(column: &str, meaning: Meaning, range: [f64; 2], whole: bool) -> Guess {
    guess_of(column, Some(meaning), range, whole)
}

fn guess_of(column: &str, otherwise: Option<Meaning>, [lowest, highest]: [f64; 2], whole: bool) -> Guess {
    let (head, bracketed) = without_unit(column);
    let reported = match ColumnName::parse(&head) {
        Some(name) => {
            let meaning = match name.quantity {
                Quantity::Position => Meaning::Position,
                Quantity::Velocity => Meaning::Velocity,
                Quantity::Effort => Meaning::Torque,
            };
            let commanded = name.topic.is_some_and(|topic| words(topic).iter().any(|word| is_commanded(word)));
            Reported { meaning: Some(meaning), joint: Some(name.joint.to_owned()), commanded, ..Reported::default() }
        }
        None => by_words(&head, otherwise.or(bracketed.and_then(meaning_of_unit))),
    };
    let (said, meaning) = (bracketed.or(reported.unit), reported.meaning);
    let largest = lowest.abs().max(highest.abs());
    let by_range = || match meaning? {
        _ if whole && largest > 20.0 => Some("count"),
        Meaning::Position if largest > 4.0 * PI => Some("deg"),
        Meaning::Position => Some("rad"),
        Meaning::Velocity if largest > 8.0 * PI => Some("deg/s"),
        Meaning::Velocity => Some("rad/s"),
        Meaning::Torque => Some("N·m"),
        Meaning::Current if largest > 100.0 => Some("mA"),
        Meaning::Current => Some("A"),
        Meaning::ForceTorque if reported.axis?.starts_with('f') => Some("N"),
        Meaning::ForceTorque => Some("N·m"),
        Meaning::Orientation => None,
        Meaning::Temperature if lowest > 200.0 => Some("K"),
        Meaning::Temperature => Some("degC"),
    };
    Guess {
        meaning,
        unit: said.or_else(by_range),
        axis: reported.axis,
        joint: reported.joint,
        unit_named: said.is_some(),
        commanded: reported.commanded,
        by_part: false,
    }
}

/// The name without a unit that stands in brackets of any kind, or at its end behind a space or `_` where words do not tell it.
pub(super) fn without_unit(column: &str) -> (String, Option<&'static str>) {
    for brackets in [['[', ']'], ['(', ')'], ['{', '}'], ['<', '>']] {
        let parts =
            column.split_once(brackets[0]).and_then(|(before, rest)| Some((before, rest.split_once(brackets[1])?)));
        if let Some((before, (within, after))) = parts
            && let Some(unit) = unit(within)
        {
            return (format!("{}{}", before.trim_end(), after.trim_end()), Some(unit));
        }
    }
    let end = column.trim_end();
    let signs = ["N·m", "N⋅m", "N*m", "°", "%"];
    let at = signs.iter().filter(|sign| end.ends_with(**sign)).map(|sign| end.len() - sign.len()).next();
    let at = at.map(|at| at - usize::from(end[..at].ends_with('m') && end[at..].starts_with('N')));
    match at.and_then(|at| Some((&end[..at], unit(&end[at..])?))) {
        Some((head, unit)) => (head.trim_end_matches([' ', '_']).to_owned(), Some(unit)),
        None => (column.to_owned(), None),
    }
}

/// A unit of a position, a torque, a speed or a temperature, as it is written.
fn unit(written: &str) -> Option<&'static str> {
    let written = written.trim();
    let position = |text: &str| text.parse::<PositionUnit>().map(PositionUnit::name).ok();
    let speed = |(unit, per): (&str, &str)| match (position(unit)?, per) {
        ("rad", "s") => Some("rad/s"),
        ("deg", "s") => Some("deg/s"),
        ("m", "s") => Some("m/s"),
        ("mm", "s") => Some("mm/s"),
        _ => None,
    };
    let temperature = || match written {
        "°C" | "degC" | "C" => Some("degC"),
        "K" => Some("K"),
        _ => None,
    };
    position(written)
        .or_else(|| written.parse::<TorqueUnit>().map(TorqueUnit::name).ok())
        .or_else(|| written.split_once('/').and_then(speed))
        .or_else(temperature)
        .or_else(|| UNITS.iter().find(|(name, _)| *name == written).map(|(_, unit)| *unit))
}

/// What has a unit that nothing else of an arm has.
pub(super) fn meaning_of_unit(unit: &str) -> Option<Meaning> {
    match unit {
        "rad" | "deg" => Some(Meaning::Position),
        "N·m" | "mN·m" => Some(Meaning::Torque),
        _ => None,
    }
}

/// The unit that is the last word of a name, such as `deg` of `elbow_joint_deg`.
pub(super) fn unit_at_end(column: &str) -> Option<&'static str> {
    let words = words(column);
    let (last, before) = words.split_last()?;
    let is_rate = before.iter().any(|word| word == "per");
    UNITS.iter().find(|(name, _)| name == last && !before.is_empty() && !is_rate).map(|(_, unit)| *unit)
}

/// One, or several: a topic is called `/joint_commands`.
fn is_commanded(word: &str) -> bool {
    COMMANDED.contains(&word) || word.strip_suffix('s').is_some_and(|one| COMMANDED.contains(&one))
}

/// What a name tells.
#[derive(Default)]
struct Reported {
    meaning: Option<Meaning>,
    axis: Option<&'static str>,
    joint: Option<String>,
    unit: Option<&'static str>,
    commanded: bool,
}

/// Meaning, joint and unit of a name such as `q1_deg`, `joint1_position_rad`, `tau1_Nm`, `qd1_rad_per_s`; the meaning that its unit
/// has, where no word tells one.
fn by_words(column: &str, by_unit: Option<Meaning>) -> Reported {
    let words = words(column);
    let commanded = words.iter().any(|word| is_commanded(word));
    let is_rate = words.iter().any(|word| word == "per");
    let unit_of = |word: &String| UNITS.iter().find(|(name, _)| name == word).map(|(_, unit)| *unit);
    if let Some(part) = quaternion_part(&words).or_else(|| matrix_entry(&words)) {
        return Reported { meaning: Some(Meaning::Orientation), axis: Some(part), commanded, ..Reported::default() };
    }
    if is_of_wrench(&words) {
        let unit = words.iter().skip(1).find_map(unit_of);
        let axis = wrench_axis(&words);
        return Reported { meaning: Some(Meaning::ForceTorque), axis, unit, commanded, ..Reported::default() };
    }
    let meaning_of =
        |word: &String| WORDS.iter().find(|(_, names)| names.contains(&word.as_str())).map(|(meaning, _)| *meaning);
    let Some(meaning) = words.iter().find_map(meaning_of).or(by_unit) else {
        return Reported { commanded, ..Reported::default() };
    };
    let of_current = |word: &String| (meaning == Meaning::Current && word == "a").then_some("A");
    let unit_of = |word: &String| unit_of(word).or_else(|| of_current(word));
    let unit = words.iter().skip(1).filter(|word| meaning_of(word).is_none()).find_map(unit_of);
    let unit = match (unit, is_rate) {
        (Some("rad"), true) => Some("rad/s"),
        (Some("deg"), true) => Some("deg/s"),
        (Some("m"), true) => Some("m/s"),
        (Some("mm"), true) => Some("mm/s"),
        (unit, _) => unit,
    };
    let qualifies = |word: &str| is_commanded(word) || MEASURED.contains(&word);
    let left = words.iter().enumerate().filter(|(place, word)| {
        meaning_of(word).is_none()
            && !qualifies(word)
            && !(*place > 0 && (unit_of(word).is_some() || ["per", "s"].contains(&word.as_str())))
    });
    let joint: String = left.map(|(_, word)| word.as_str()).collect();
    Reported { meaning: Some(meaning), joint: (!joint.is_empty()).then_some(joint), unit, commanded, axis: None }
}

/// `fx`, `ft_sensor_tz`, `wrench.force.x`, `tcp_torque_y`.
fn is_of_wrench(words: &[String]) -> bool {
    let any = |of: &[&str]| words.iter().any(|word| of.contains(&word.as_str()));
    WRENCH_AXES.iter().any(|(_, names)| any(names)) || any(&WRENCH) && any(&["x", "y", "z"])
}

/// Which axis of it, where the name tells a force from a moment.
fn wrench_axis(words: &[String]) -> Option<&'static str> {
    let any = |of: &[&str]| words.iter().any(|word| of.contains(&word.as_str()));
    let along = ["x", "y", "z"].iter().position(|letter| any(&[letter]));
    let named = WRENCH_AXES.iter().position(|(_, names)| any(names));
    let place = named.or_else(|| match (any(&["torque", "moment"]), any(&["force"])) {
        (true, _) => Some(3 + along?),
        (false, true) => along,
        (false, false) => None,
    });
    place.map(|place| WRENCH_AXES[place].0)
}

/// `qx`, `tool_qw`, `pose.orientation.x`.
fn quaternion_part(words: &[String]) -> Option<&'static str> {
    let any = |of: &[&str]| words.iter().any(|word| of.contains(&word.as_str()));
    let is_part = |(part, name): &&(&str, &str)| any(&[name]) || any(&QUATERNION) && any(&[part]);
    QUATERNION_PARTS.iter().find(is_part).map(|(part, _)| *part)
}

/// `r11`, `R_23`, `tool.rot33`.
fn matrix_entry(words: &[String]) -> Option<&'static str> {
    let [.., letter, number] = words else { return None };
    let entry = MATRIX_ENTRIES.iter().find(|(_, entry)| entry == number).filter(|_| MATRIX.contains(&letter.as_str()));
    entry.map(|(name, _)| *name)
}

/// A name without what writers of tables change in it.
pub(super) fn plain(name: &str) -> String {
    name.chars().filter(|letter| letter.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// The words and numbers of a name in lower case: `qd1_rad` is `qd`, `1`, `rad`.
pub(super) fn words(name: &str) -> Vec<String> {
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
