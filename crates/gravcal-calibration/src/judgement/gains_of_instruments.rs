//! Gains of instruments that no sound instrument has, mounted and read as the session says: rather an axis is dead, its unit another, or its direction.
//!
//! The fit says nothing of such mistakes: with a free gain it explains the readings as well.

use std::ops::RangeInclusive;

use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::{AuxiliarySensor, AuxiliarySensorKind, Session};

use crate::result::ParameterResult;

/// No instrument is so many times more sensitive than it should be, or less.
const FAR: f64 = 3.0;
/// An axis that feels no larger share of what it should, and maybe nothing, is dead.
const DEAD: f64 = 0.1;
/// What a gain is in g where m/s² are declared: 1/9.8, to within what such sensors are off.
const IN_G: RangeInclusive<f64> = 0.09..=0.115;

/// What is wrong of a gain.
#[derive(Clone, Copy, PartialEq)]
enum Wrong {
    Dead,
    Reversed,
    Far,
}

/// The gain of an axis, beside its nominal value.
struct Gain<'a> {
    name: &'a str,
    ratio: f64,
    wrong: Wrong,
}

/// One sentence for what is alike of an instrument.
pub(super) fn doubts(session: &Session, parameters: &[ParameterResult]) -> Vec<String> {
    session.instruments.iter().flat_map(|instrument| of_instrument(session, instrument, parameters)).collect()
}

fn of_instrument(session: &Session, instrument: &AuxiliarySensor, parameters: &[ParameterResult]) -> Vec<String> {
    // Of a matrix the diagonal: what an axis reads of its own direction, where it is read.
    let own = instrument.gains.iter().zip(instrument.gain_parameters());
    let own = own.filter(|((read, sensed), _)| read == sensed && instrument.units[*read].is_some());
    let gains: Vec<Option<Gain<'_>>> = own.map(|(_, place)| gain(&session.further[place].name(), parameters)).collect();
    let all = |wrong: Wrong| {
        !gains.is_empty() && gains.iter().all(|gain| gain.as_ref().is_some_and(|gain| gain.wrong == wrong))
    };
    let name = &instrument.name;
    if all(Wrong::Reversed) {
        return vec![format!(
            "All gains of {name} are negative: it reads the opposite of what is declared. Say so (sign = \"reversed\")."
        )];
    }
    let in_g = |gain: &Gain<'_>| instrument.kind == AuxiliarySensorKind::Accelerometer && IN_G.contains(&gain.ratio);
    if all(Wrong::Far) && gains.iter().flatten().all(in_g) {
        return vec![format!(
            "All gains of {name} are about 0.1 times their nominal values: its readings seem to be in g (unit = \"g\" in its readings)."
        )];
    }
    gains.iter().flatten().map(|gain| words(instrument, gain)).collect()
}

/// Nothing of a gain that is as it should be, or that is open, or was fixed.
fn gain<'a>(name: &str, parameters: &'a [ParameterResult]) -> Option<Gain<'a>> {
    let found = parameters.iter().find(|parameter| parameter.name == name && parameter.held.is_none())?;
    let (value, interval, nominal) = (found.value?, found.ci95?, found.nominal);
    let [one, other] = interval.map(|end| end / nominal);
    let (least, most) = (one.min(other), one.max(other));
    let wrong = if (-DEAD..=0.0).contains(&least) && (0.0..DEAD).contains(&most) {
        Wrong::Dead
    } else if most < 0.0 {
        Wrong::Reversed
    } else if least > FAR || most < 1.0 / FAR {
        Wrong::Far
    } else {
        return None;
    };
    Some(Gain { name: &found.name, ratio: value / nominal, wrong })
}

fn words(instrument: &AuxiliarySensor, Gain { name, ratio, wrong }: &Gain<'_>) -> String {
    let times = significant(*ratio, 2);
    match wrong {
        Wrong::Dead => format!(
            "{name} is {times} times its nominal value: this axis hardly feels what it should. Is the sensor dead there, or its column another quantity? Name \
             the right one, or say \"\" for it."
        ),
        Wrong::Reversed => format!(
            "{name} is {times} times its nominal value: this axis points the other way than declared. Is the mounting as stated (mounting.rpy_deg), and is its \
             column the right one?"
        ),
        Wrong::Far => format!(
            "{name} is {times} times its nominal value: is the unit of its readings as stated? If it is, say which gain the sensor has ({} = {{ nominal = …, \
             unit = … }}).",
            key(instrument, name)
        ),
    }
}

/// The key that states a gain.
fn key(instrument: &AuxiliarySensor, name: &str) -> &'static str {
    match instrument.kind {
        AuxiliarySensorKind::Accelerometer => "gain",
        AuxiliarySensorKind::ForceTorque if name.contains(".gain_n") => "moment_gain",
        AuxiliarySensorKind::ForceTorque => "force_gain",
    }
}

#[cfg(test)]
mod tests {
    use gravcal_robot_model::parameter::ParameterId;

    use super::*;
    use crate::testing::sarcos_with_instruments;

    /// Gains of the wrist sensor found at so many times their nominal values, by place, ± 1 %; all else as it is nominal.
    fn told(times: impl Fn(usize) -> f64) -> Vec<String> {
        let session = sarcos_with_instruments().session(0);
        let gains = session.instruments[0].gain_parameters();
        let found = |id: ParameterId| {
            let blank = ParameterResult::blank(&session, id);
            let place = gains.clone().position(|place| ParameterId::Further(place) == id);
            let value = place.map_or(1.0, &times) * blank.nominal;
            let half = 0.01 * blank.nominal.abs();
            ParameterResult { value: Some(value), ci95: Some([value - half, value + half]), held: None, ..blank }
        };
        let parameters: Vec<ParameterResult> = session.parameters().into_iter().map(found).collect();
        doubts(&session, &parameters)
    }

    #[test]
    fn a_gain_is_doubted_that_is_dead_reversed_or_of_another_unit() {
        assert_eq!(told(|_| 1.2), Vec::<String>::new());
        let one = |factor: f64| {
            let told = told(|place| if place == 0 { factor } else { 1.0 });
            assert_eq!(told.len(), 1, "{factor}: {told:?}");
            told[0].clone()
        };
        assert!(one(0.001).contains("hardly feels") && one(-1.0).contains("points the other way"));
        assert!(one(0.02).contains("say which gain the sensor has (force_gain") && one(1000.0).contains("unit"));
        let reversed = told(|_| -1.0);
        assert!(reversed.len() == 1 && reversed[0].contains("sign = \"reversed\""), "{reversed:?}");
    }
}
