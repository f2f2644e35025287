//! Sensor models, and the conditions that they need, in sessions from files.

use gravcal_robot_model::session::{PriorKind, Session};

use super::tests::{assert_refused, changed, read};

const ELBOW: &str = "torque_sign = \"reversed\"";
const TORQUE: &str = "torque = { columns = [\"y1\", \"y2\"], unit = \"count\", std = 0.8 }";

fn with_models(models: &str) -> String {
    format!("{ELBOW}\nsensor_models = [{models}]")
}

fn names(session: &Session) -> Vec<String> {
    session.further.iter().map(|parameter| format!("{} {}", parameter.name(), parameter.unit)).collect()
}

#[test]
fn models_name_their_parameters() {
    let models = "{ kind = 'torque-gain-polynomial' }, { kind = 'torque-crosstalk' }, \
                  { kind = 'position-harmonics', orders = [1, 2] }";
    let session = changed(ELBOW, &with_models(models));
    let expected = [
        "elbow.torque_gain_2 count/(N·m)^2",
        "elbow.torque_gain_3 count/(N·m)^3",
        "elbow.torque_crosstalk_shoulder count/(N·m)",
        "elbow.position_sine_1 rad",
        "elbow.position_cosine_1 rad",
        "elbow.position_sine_2 rad",
        "elbow.position_cosine_2 rad",
    ];
    assert_eq!(names(&session), expected);
    let reported: Vec<String> = session.parameters().iter().map(|id| session.parameter_name(*id)).collect();
    assert_eq!(
        (reported[7].as_str(), reported[8].as_str(), reported.len()),
        ("elbow.position_offset", "elbow.torque_gain_2", 15)
    );
}

#[test]
fn what_is_known_of_a_parameter_is_read_with_its_unit() {
    let known = |said: &str| {
        let models =
            format!("{{ kind = 'position-harmonics', orders = [1], parameters = {{ position_sine_1 = {said} }} }}");
        changed(ELBOW, &with_models(&models)).further[0].clone()
    };
    let stated = known("{ nominal = 1, std = 0.5, unit = 'deg' }");
    assert_eq!(stated.prior.nominal, 1f64.to_radians());
    assert_eq!(stated.prior.kind, PriorKind::Gaussian { std: 0.5f64.to_radians() });
    assert_eq!((known("{ fixed = 0.01, unit = 'rad' }").fixed, stated.fixed), (Some("given as exact"), None));
}

#[test]
fn a_further_parameter_may_be_dropped_from_what_is_asked() {
    let models = with_models("{ kind = 'torque-crosstalk' }");
    let drop = "drop = [\"shoulder.torque_bias\", \"gravity\"]";
    let dropped = "drop = [\"elbow.torque_crosstalk_shoulder\"]";
    let session = read(&[("session.toml", ELBOW, &models), ("session.toml", drop, dropped)]).unwrap();
    assert!(!session.asks("elbow.torque_crosstalk_shoulder") && session.asks("elbow.torque_gain"));
}

#[test]
fn a_model_that_is_wrong_is_refused_by_name() {
    let refused = |models: &str, expected: &str| assert_refused(ELBOW, &with_models(models), expected);
    let field = "15: joint[0].sensor_models[0]";
    refused(
        "{ kind = 'hysteresis' }",
        &format!("{field}.kind: there is no sensor model `hysteresis`; known: torque-bias-in-time, torque-bias-with"),
    );
    refused(
        "{ kind = 'torque-crosstalk', degree = 2 }",
        &format!("{field}.degree: torque-crosstalk has no such option: delete it"),
    );
    refused("{ kind = 'torque-gain-polynomial', degree = 4 }", &format!("{field}.degree: 4 is no degree"));
    refused("{ kind = 'torque-crosstalk', from = ['elbow'] }", &format!("{field}.from: `elbow` is not another joint"));
    refused("{ kind = 'position-harmonics' }", &format!("{field}.orders: how many periods a turn? add orders"));
    refused("{ kind = 'position-harmonics', orders = [2, 2] }", &format!("{field}.orders: 2 is zero or stands twice"));
    refused(
        "{ kind = 'torque-crosstalk', parameters = { crosstalk = { fixed = 0, unit = 'count' } } }",
        &format!("{field}.parameters.crosstalk: there is no parameter `crosstalk`; known: `torque_crosstalk_shoulder`"),
    );
    refused(
        "{ kind = 'torque-crosstalk', parameters = { torque_crosstalk_shoulder = { fixed = 0, unit = 'count' } } }",
        &format!(
            "{field}.parameters.torque_crosstalk_shoulder.unit: the unit `count` does not fit: expected `count/(N·m)`"
        ),
    );
    refused(
        "{ kind = 'torque-crosstalk' }, { kind = 'torque-crosstalk' }",
        "15: joint[0].sensor_models[1].kind: `torque-crosstalk` is already joint[0].sensor_models[0].kind",
    );
}

#[test]
fn a_formula_that_is_wrong_is_refused_by_its_column() {
    let field = "15: joint[0].sensor_models[0]";
    let refused = |said: &str, expected: &str| {
        assert_refused(ELBOW, &with_models(&format!("{{ kind = 'formula', {said} }}")), &format!("{field}.{expected}"));
    };
    let a = "unknowns = { a = { unit = 'count', limit = 1 } }";
    refused(a, "adds: what does it add? write a formula, such as");
    refused("adds = 3", "adds: expected a text, found a number (3)");
    refused(
        &format!("adds = 'a * sin(positon)', {a}"),
        "adds: column 9: `positon` has no meaning (did you mean `position`?)",
    );
    refused(&format!("adds = 'a +', {a}"), "adds: column 4: expected a number, a name, `-` or `(`, found the end");
    refused(&format!("adds = '2 * torque', {a}"), "unknowns.a: the formula does not have it");
    refused("adds = 'a', unknowns = { a = 3 }", "unknowns.a: expected a table, found a number (3)");
    refused("adds = 'a', unknowns = { a = { unit = 'count' } }", "unknowns.a.limit: how uncertain may it be");
    refused("adds = 'a', unknowns = { a = { limit = 1 } }", "unknowns.a.unit: in which unit is it?");
    refused("adds = 'a', unknowns = { a = { unit = 'count', limit = 1, std = 1 } }", "unknowns.a.std: expected one of");
    refused("adds = 'sin', unknowns = { sin = { unit = 'count', limit = 1 } }", "unknowns.sin: the name has a meaning");
    refused(&format!("adds = 'a * time', {a}"), "kind: formula needs the time of each pose");
    refused(&format!("add = 'a', {a}"), "add: formula has no such option: did you mean `adds`?");
    let bias = "adds = 'torque_bias', unknowns = { torque_bias = { unit = 'count', limit = 1 } }";
    refused(bias, "kind: the model names a parameter `torque_bias`: every sensor has a parameter of this name already");
    let twice = format!("{{ kind = 'formula', adds = 'a', {a} }}, {{ kind = 'formula', adds = 'a * position', {a} }}");
    let expected = "15: joint[0].sensor_models[1]: another model of this joint has a parameter `a` already";
    assert_refused(ELBOW, &with_models(&twice), expected);
    let position = "{ kind = 'position-formula', adds = 'torque' }";
    assert_refused(
        ELBOW,
        &with_models(position),
        &format!("{field}.kind: a model of a position sensor reads positions"),
    );
}

#[test]
fn a_formula_may_read_a_further_column() {
    let said = "{ kind = 'formula', adds = 'a * further[oil]', unknowns = { a = { unit = 'count', limit = 1 } } }";
    let none =
        "adds: column 13: there is no further column `oil`; the session names none: add readings.further = { oil = ";
    assert_refused(ELBOW, &with_models(said), &format!("15: joint[0].sensor_models[0].{none}"));
    let with_models = with_models(said);
    let further = |column: &str| format!("{TORQUE}\nfurther = {{ oil = '{column}' }}");
    let session = read(&[("session.toml", TORQUE, &further("q1")), ("session.toml", ELBOW, &with_models)]).unwrap();
    assert_eq!(session.poses[1].conditions.further, [90.0]);
    let missing = read(&[("session.toml", TORQUE, &further("p")), ("session.toml", ELBOW, &with_models)]).unwrap_err();
    assert!(missing.to_string().contains("there is no column `p`"), "{missing}");
}

#[test]
fn a_formula_names_its_unknowns_and_what_is_known_of_them() {
    let said = "{ kind = 'formula', adds = 'a * sin(n * position[shoulder])', \
                unknowns = { n = { unit = '1/rad', nominal = 6, limit = 0.1 }, a = { unit = 'count', limit = 1 } }, \
                parameters = { a = { nominal = 2, std = 1, unit = 'count' } } }";
    let session = changed(ELBOW, &with_models(said));
    assert_eq!(names(&session), ["elbow.a count", "elbow.n 1/rad"]);
    let nominal: Vec<f64> = session.further.iter().map(|parameter| parameter.prior.nominal).collect();
    assert_eq!(nominal, [2.0, 6.0]);
    assert_eq!(session.further[0].convention, "reading = ... + a * sin(n * position[shoulder])");
}

#[test]
fn a_condition_that_no_column_gives_is_named_with_its_cure() {
    let needs = [
        ("torque-bias-in-time", "", "the time of each pose: add readings.time = { column ="),
        (
            "torque-bias-with-temperature",
            ", reference_degC = 25",
            "the temperature of each pose: add readings.temperature = { columns =",
        ),
        ("viscous-friction", "", "the velocity of each joint: add readings.velocity = { columns ="),
        ("coulomb-friction", "", "to know from which side the joints came: add readings.direction = { columns ="),
        (
            "presliding-friction",
            "",
            "the motion of the joint from moment to moment: record the arm in motion and say readings.motion",
        ),
    ];
    for (kind, options, need) in needs {
        let expected = format!("15: joint[0].sensor_models[0].kind: {kind} needs {need}");
        assert_refused(ELBOW, &with_models(&format!("{{ kind = '{kind}'{options} }}")), &expected);
    }
}

#[test]
fn conditions_are_read_with_their_units() {
    let readings = format!(
        "{TORQUE}\ntime = {{ column = 'q1', unit = 'min' }}\ntemperature = {{ columns = 'y1', unit = 'K' }}\n\
         velocity = {{ columns = ['q1', 'q2'], unit = 'deg/s' }}"
    );
    let session = changed(TORQUE, &readings);
    let conditions = &session.poses[1].conditions;
    assert_eq!(conditions.time, Some(90.0 * 60.0));
    assert!((conditions.temperature[1] - (2001.0 - 273.15)).abs() < 1e-9);
    assert_eq!(conditions.velocity, [90f64.to_radians(), 180f64.to_radians()]);
    assert_refused(
        TORQUE,
        &format!("{TORQUE}\ntime = {{ column = 'q1', unit = 'days' }}"),
        "11: readings.time.unit: the unit `days` does not fit: expected one of s, ms, µs, ns, min, h",
    );
    assert_refused(
        TORQUE,
        &format!("{TORQUE}\ndirection = {{ columns = ['q1'] }}"),
        "11: readings.direction.columns: expected 2 entries, one for each joint (shoulder, elbow), found 1",
    );
}

#[test]
fn readings_at_an_end_of_the_range_are_left_out() {
    let ranged = TORQUE.replace("std = 0.8", "std = 0.8, lowest = 5, highest = [4000, 2100]");
    let session = changed(TORQUE, &ranged);
    assert_eq!(session.saturated, [1, 1]);
    assert_eq!(session.poses[0].torque[1], None);
    let turned = TORQUE.replace("std = 0.8", "std = 0.8, lowest = 5, highest = 5");
    assert_refused(
        TORQUE,
        &turned,
        "10: readings.torque.highest: column `y1`: the range of readings must go from lower",
    );
}

/// A formula of the elbow and one of the shoulder, which share the force of a spring.
fn shared(elbow: &str, shoulder: &str) -> Result<Session, String> {
    let formula = |said: &str| format!("{{ kind = 'formula', adds = 'spring * cos(position)', {said} }}");
    let shoulder =
        format!("[[joint]]\nname = \"shoulder\"\nsensor_models = [{}]\n\n[[load_distance]]", formula(shoulder));
    read(&[("session.toml", ELBOW, &with_models(&formula(elbow))), ("session.toml", "[[load_distance]]", &shoulder)])
}

#[test]
fn formulas_of_several_joints_share_an_unknown() {
    const SPRING: &str = "unknowns = { spring = { unit = 'count', nominal = 3, limit = 0.5, shared = 'compensator' } }";
    let known = format!("{SPRING}, parameters = {{ spring = {{ nominal = 4, std = 1, unit = 'count' }} }}");
    let session = shared(&known, SPRING).unwrap();
    assert_eq!(names(&session), ["compensator.spring count"; 2]);
    assert_eq!((session.further[0].same_as, session.further[1].same_as), (None, Some(0)));
    assert_eq!(session.further[1].prior, session.further[0].prior);
    let reported: Vec<String> = session.parameters().iter().map(|id| session.parameter_name(*id)).collect();
    assert_eq!((reported.len(), reported.last().unwrap().as_str()), (9, "compensator.spring"));

    let refused = |shoulder: &str, expected: &str| {
        let message = shared(SPRING, shoulder).unwrap_err();
        assert!(message.contains(expected), "{message}");
    };
    refused(&SPRING.replace("'count'", "'V'"), "compensator.spring is shared, and in count where it stands first");
    refused(&SPRING.replace("0.5", "0.6"), "compensator.spring is shared, and its limit is another");
    refused(&known, "what is known of compensator.spring is said where it stands first: delete this");
    refused(&SPRING.replace("compensator", "elbow"), "`elbow` is a joint or link of the robot");
}
