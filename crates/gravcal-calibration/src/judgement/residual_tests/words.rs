//! What a test says, and what to do about it.

use gravcal_dynamics::JointKind;
use gravcal_robot_model::number::significant;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::Session;

use super::columns::ALL_JOINTS;
use super::delayed::{cut_off, half_square};
use super::of_instruments::of_axis;
use super::of_torque::per_torque;
use super::order::sides_by_order;
use super::score::MATTERS;
use super::too_large::{SOMETHING_ELSE, is_too_large};
use super::words_of_stated::{of_like, of_stated, of_stated_sensor};
use crate::result::{ResidualTest, ResidualTestKind};

/// What becomes of intervals where a term spoils them.
const WIDENED: &str = "Each interval is widened by the shift that this effect causes. Do not rely on the intervals until the model includes it.";

/// What is said of other sensors where something is named that is seldom alone.
const OTHERS_DRIFT: &str =
    "The zeros of the other sensors may drift, too: their intervals include the drift that their own residuals allow.";
const OTHER_GAINS: &str = "The gains of the other torque sensors may have changed, too: their intervals include the change that their own residuals allow.";
const OTHER_OFFSETS: &str = "The zeros of the other position sensors may have changed, too: their intervals include the change that their own residuals allow.";

/// What is named, in sentences; neighbours that are alike, friction at rest and joints that give way once for all channels.
pub(crate) fn in_words(session: &Session, tests: &[ResidualTest]) -> Vec<String> {
    let of_kind = |kind: &ResidualTestKind| -> Vec<&ResidualTest> {
        tests.iter().filter(|test| test.named && test.kind == *kind).collect()
    };
    let others = tests.iter().filter(|test| test.named && !reported_once(&test.kind));
    others
        .map(|test| of_one(session, test))
        .chain(by_unit(of_kind(&ResidualTestKind::Direction)).iter().filter_map(|tests| of_direction(session, tests)))
        .chain(of_compliance(session, &of_kind(&ResidualTestKind::Compliance)))
        .chain(of_recorder(session, &of_kind(&ResidualTestKind::TorqueLag)))
        .chain(of_recorder(session, &of_kind(&ResidualTestKind::TorqueFilter)))
        .chain(of_neighbours(session, &of_kind(&ResidualTestKind::Neighbours)))
        .chain(of_others(session, tests).into_iter().map(str::to_owned))
        .collect()
}

/// What is said of other sensors, as something that is seldom alone widens intervals.
fn of_others(session: &Session, tests: &[ResidualTest]) -> Vec<&'static str> {
    let of_test = |test: &ResidualTest| match test.kind {
        ResidualTestKind::Trend | ResidualTestKind::TrendCurve | ResidualTestKind::TrendInTables => Some(OTHERS_DRIFT),
        ResidualTestKind::TorqueGain { .. } | ResidualTestKind::TorqueGainTrend => Some(OTHER_GAINS),
        ResidualTestKind::PositionOffset { .. } => Some(OTHER_OFFSETS),
        _ => None,
    };
    let of_test =
        |test: &ResidualTest| of_like(session, &test.kind).or(of_test(test).filter(|_| test.channel != ALL_JOINTS));
    let widens = |test: &&ResidualTest| test.named && test.spoils_intervals;
    let mut said: Vec<&'static str> = tests.iter().filter(widens).filter_map(of_test).collect();
    said.sort_unstable();
    said.dedup();
    said
}

fn reported_once(kind: &ResidualTestKind) -> bool {
    use ResidualTestKind::{Compliance, Direction, Neighbours, TorqueFilter, TorqueLag};
    matches!(kind, Neighbours | Direction | Compliance | TorqueLag | TorqueFilter)
}

/// Joints that turn and joints that slide apart.
fn by_unit(tests: Vec<&ResidualTest>) -> Vec<Vec<&ResidualTest>> {
    let mut groups: Vec<Vec<&ResidualTest>> = Vec::new();
    for test in tests {
        match groups.iter_mut().find(|group| group[0].unit == test.unit) {
            Some(group) => group.push(test),
            None => groups.push(vec![test]),
        }
    }
    groups
}

/// Only that of all joints, where there is one: it says what others say of some.
fn of_all_or_each<'t>(tests: &'t [&'t ResidualTest]) -> &'t [&'t ResidualTest] {
    let all = tests.iter().position(|test| test.channel == ALL_JOINTS);
    all.map_or(tests, |place| &tests[place..=place])
}

/// The channels of some tests, their sizes from least to most, and the largest of their p-values.
fn together(tests: &[&ResidualTest]) -> Option<(String, [f64; 2], f64)> {
    let sizes = || tests.iter().map(|test| test.size.abs());
    let channels: Vec<&str> = tests.iter().map(|test| test.channel.as_str()).collect();
    let p = tests.iter().map(|test| test.corrected_p_value).fold(0.0, f64::max);
    Some((channels.join(", "), [sizes().reduce(f64::min)?, sizes().reduce(f64::max)?], p))
}

/// The least and the most of several tests.
fn from_to(least: f64, most: f64, tests: &[&ResidualTest]) -> String {
    let most = significant(most, 2);
    if tests.len() > 1 { format!("{} to {most}", significant(least, 2)) } else { most }
}

/// Friction that is left at rest; tests of one unit.
fn of_direction(session: &Session, tests: &[&ResidualTest]) -> Option<String> {
    let (channels, [least, most], p) = together(tests)?;
    let size = from_to(least, most, tests);
    let unit = &tests.first()?.unit;
    let by_order = !sides_by_order(session).is_empty();
    let taken = if by_order { ", as the order of the rows tells it" } else { "" };
    let (consequence, cure) = match tests.iter().any(|test| test.spoils_intervals) {
        true if by_order => (
            WIDENED,
            "Come to each pose from both sides, say from which (direction in [readings]), and estimate it (sensor_models = [{ kind = \"coulomb-friction\" }] in the \
             joint's [[joint]]).",
        ),
        true => (
            WIDENED,
            "Estimate it (sensor_models = [{ kind = \"coulomb-friction\" }] in the joint's [[joint]]), and come to each pose from both sides.",
        ),
        false => ("Intervals allow for it.", "To halve it, come to each pose from both sides."),
    };
    Some(format!(
        "The residual of {channels} depends on the direction of approach{taken} (±{size} {unit}): friction. ({}, all tests counted.) {consequence} {cure}",
        chance(p)
    ))
}

fn of_neighbours(session: &Session, tests: &[&ResidualTest]) -> Option<String> {
    let (channels, [least, most], p) = together(tests)?;
    let correlation = if tests.len() > 1 { format!("{least:.2} to {most:.2}") } else { format!("{most:.2}") };
    let consequence = match tests.iter().any(|test| test.spoils_intervals) {
        true => {
            "The intervals are too narrow: take standard deviations from blocks of poses ([uncertainty] kind = \"jackknife\")."
        }
        false => "Intervals are hardly touched by it, or already allow for it.",
    };
    if session.has_windows() {
        return Some(format!(
            "The residuals of {channels} are alike in neighbouring windows (correlation {correlation}), as windows overlap and what the model \
             lacks lasts longer. ({}, all tests counted.) {consequence}",
            chance(p)
        ));
    }
    Some(format!(
        "The residuals of {channels} are alike in neighbouring poses (correlation {correlation}): errors are not noise, and more poses nearby tell \
         less than they seem to. ({}, all tests counted.) {consequence} Visit poses in another order, far from each other.",
        chance(p)
    ))
}

/// What a recorder did to torques: tests of one kind.
fn of_recorder(session: &Session, tests: &[&ResidualTest]) -> Option<String> {
    let tests = of_all_or_each(tests);
    let (channels, _, p) = together(tests)?;
    let mut sizes: Vec<f64> = tests.iter().map(|test| test.size).collect();
    sizes.sort_by(f64::total_cmp);
    let (least, most, middle) = (*sizes.first()?, *sizes.last()?, sizes[sizes.len() / 2]);
    let range = |of: &dyn Fn(f64) -> f64| match (significant(of(least), 2), significant(of(most), 2)) {
        (low, high) if low == high => low,
        (low, high) => format!("{low} to {high}"),
    };
    let spoilt = tests.iter().any(|test| test.spoils_intervals);
    let allowed = session.searched.iter().find_map(|searched| searched.windows.as_ref());
    let (what, cure) = match tests.first()?.kind {
        ResidualTestKind::TorqueLag => {
            let lag = significant(allowed.map_or(0.0, |windows| windows.torque_lag) + middle, 2);
            (
                match middle < 0.0 {
                    false => {
                        format!("The torques of {channels} come {} s later than the positions.", range(&|lag| lag))
                    }
                    true => {
                        format!("The torques of {channels} come {} s earlier than the positions.", range(&|lag| -lag))
                    }
                },
                format!(
                    "Look at how the recorder stamps them. If all joints show about as much, say torque_lag_s = {lag} in readings.motion; \
                     if only some do, it is friction that changes its sign late, or a gear that gives way."
                ),
            )
        }
        _ => {
            let allowed = allowed.and_then(|windows| windows.recorded_filter).map(half_square);
            let what = match (middle > 0.0, allowed) {
                (true, None) => format!("The torques of {channels} are smoother than their motion: as if by a filter"),
                (true, Some(_)) => format!("The torques of {channels} are smoother still: as if by another filter"),
                (false, _) => format!("The motion of {channels} is smoother than the torques: as if by a filter"),
            };
            (format!("{what} of {} Hz.", range(&cut_off)), of_filter(allowed.unwrap_or(0.0) + middle))
        }
    };
    let said = format!("{what} ({}, all tests counted.)", chance(p));
    Some(match spoilt {
        true => format!("{said} {WIDENED} {cure}"),
        false => format!("{said} It is real but small beside the noise, and changes no verdict."),
    })
}

/// What to do about a filter of which so much is seen in all, s².
fn of_filter(in_all: f64) -> String {
    if in_all > 0.0 {
        return format!(
            "If the recorder filtered torques and not positions, say recorded_filter_hz = {} in readings.motion, and look at what is left.",
            significant(cut_off(in_all), 2)
        );
    }
    "Positions were filtered before they were recorded, or are so noisy or coarse that smoothing them takes motion away, or their clock is wrong: \
     record both raw, or take longer windows (window_s in readings.motion)."
        .into()
}

/// Joints that bend.
fn of_compliance(session: &Session, tests: &[&ResidualTest]) -> Option<String> {
    let tests = of_all_or_each(tests);
    let (channels, [least, most], p) = together(tests)?;
    let size = from_to(least, most, tests);
    let spoilt = tests.iter().any(|test| test.spoils_intervals);
    let in_fit = !spoilt && tests.iter().any(|test| test.in_noise >= MATTERS);
    let consequence = match in_fit {
        _ if spoilt => WIDENED,
        true => "It is an unknown of the estimate, and intervals allow for it.",
        false => "It is real but small beside the noise, and changes no verdict.",
    };
    // What gives way moves instruments, which only deflections of unknown cause can say.
    let cure = match session.instruments.is_empty() {
        true if in_fit => "Heavier loads tell it from position gains.".into(),
        true if session.has_windows() => {
            "Only standstills tell how joints give way: record them (readings.still), and calibrate them by themselves with [deflection].".into()
        }
        true => format!("Estimate it: [deflection] compliance_std_rad_per_newton_metre = {most:.0e}."),
        false => "Allow for it: [deflection] hold_std_deg, by how much a standing joint bends.".into(),
    };
    Some(format!(
        "The residuals show that {channels} give way under their torque, by {size} rad/(N·m), which position sensors do not see. ({}, all \
         tests counted.) {consequence} {cure}",
        chance(p)
    ))
}

fn of_one(session: &Session, test: &ResidualTest) -> String {
    let ResidualTest { channel, size, unit, in_noise, corrected_p_value, .. } = test;
    let of_joint = session.robot.chain.joints().iter().any(|joint| joint.name == *channel);
    let size = significant(*size, 2);
    let (what, cure) = match &test.kind {
        ResidualTestKind::Trend if channel == ALL_JOINTS => (
            format!("The residuals of all joints together show that zeros drift, by up to {size} {unit}."),
            drift(true),
        ),
        ResidualTestKind::Trend => {
            (format!("The residual of {channel} drifts by {size} {unit}: its zero creeps."), drift(of_joint))
        }
        ResidualTestKind::TrendCurve => (
            format!("The residual of {channel} is not linear in time, by {size} {unit} from the middle to the ends: its zero drifts, and the drift settles or grows."),
            "A sensor that warms up does so. Let it warm up before it is read, or leave the first minutes out (from_s in [[poses]]); \
             torque-bias-in-time is a linear drift."
                .into(),
        ),
        ResidualTestKind::TrendInTables => (
            format!("The residual of {channel} drifts by {size} {unit} within each table: its zero creeps, and is read anew between them."),
            "Let the sensor warm up before it is read, and visit some poses twice in each table: at its beginning and its end.".into(),
        ),
        ResidualTestKind::Neighbours => return of_neighbours(session, &[test]).unwrap_or_default(),
        ResidualTestKind::Direction => return of_direction(session, &[test]).unwrap_or_default(),
        ResidualTestKind::Compliance => return of_compliance(session, &[test]).unwrap_or_default(),
        ResidualTestKind::TorqueLag | ResidualTestKind::TorqueFilter => return of_recorder(session, &[test]).unwrap_or_default(),
        ResidualTestKind::TorqueHarmonic { order } => (
            format!("The residual of {channel} goes with its own angle, {}, by {size} {unit}.", periods(*order)),
            "A cable, a gear or a sensor that is loaded from the side does so: look at what pulls at the joint; spread the poses over its whole range.".into(),
        ),
        ResidualTestKind::Spring => (
            format!("The residual of {channel} goes with its own position as if a spring pulled at the joint: by up to {size} {unit}."),
            of_spring(session, test),
        ),
        ResidualTestKind::PositionHarmonic { order } => (
            format!("The residuals show a coordinate of {channel} that runs unevenly, {}, by {size} rad.", periods(*order)),
            format!("Estimate it: sensor_models = [{{ kind = \"position-harmonics\", orders = [{order}] }}] in its [[joint]]."),
        ),
        ResidualTestKind::Velocity => (
            format!("The residual of {channel} goes with its speed: {size} {unit}."),
            "This is viscous friction (sensor_models = [{ kind = \"viscous-friction\" }]) or what comes with speed: drive slower, and both ways.".into(),
        ),
        ResidualTestKind::Acceleration => (
            format!("The residual of {channel} goes with its acceleration: {size} {unit}. This is inertia."),
            of_inertia(session, test),
        ),
        ResidualTestKind::Presliding => (
            format!("The residual of {channel} shows friction that builds up after each reversal: {size} {unit} of it are not there at once."),
            "Where the torque sensor is behind the gear this is pre-sliding: say kind = \"presliding-friction\" instead of \"coulomb-friction\"."
                .into(),
        ),
        ResidualTestKind::Gravity { file } => (
            format!(
                "The residuals of all joints show gravity turned by {}° in {file} against the other tables.",
                significant(test.size.to_degrees(), 2)
            ),
            "Either the base stood otherwise, or a load is not as stated (mass_kg, position_m). Record all tables with the base where it is, or \
             calibrate those before and after by themselves."
                .into(),
        ),
        ResidualTestKind::StatedSensor { parameter } => of_stated_sensor(session, test, parameter),
        ResidualTestKind::LoadMass { .. }
        | ResidualTestKind::LoadPlacement { .. }
        | ResidualTestKind::LoadDistance { .. }
        | ResidualTestKind::JointPlacement { .. }
        | ResidualTestKind::JointTilt { .. } => of_stated(session, test),
        ResidualTestKind::PositionOffset { file } => (
            format!("The residuals show that the zero of the position sensor of {channel} is another in {file}, by {size} rad."),
            "Either it was homed anew between the tables, or the load is not where position_m says, the joint gives way under it, or lengths of the robot are others. Record all \
             tables after one homing, or calibrate those before and after by themselves."
                .into(),
        ),
        ResidualTestKind::PositionJump { file, line } => (
            format!(
                "The residuals show that the zero of the position sensor of {channel} changes by {size} rad, about row {line} of {file}."
            ),
            "The sensor slipped, or was homed anew. What is told lies between both zeros: calibrate the readings before and after by themselves."
                .into(),
        ),
        ResidualTestKind::TorqueGain { .. }
        | ResidualTestKind::TorqueGainTrend
        | ResidualTestKind::TorqueNonlinearity
        | ResidualTestKind::Crosstalk { .. }
        | ResidualTestKind::LoadFriction => of_axis(session, test).unwrap_or_else(|| of_torque(session, test)),
        ResidualTestKind::FrictionTrend => (
            format!("The residuals show that friction of {channel} changes with time, by {size} {unit} of it."),
            "Gears that warm up do so: move the arm until it is warm, and record it then; or leave the first minutes out (from_s in [[poses]])."
                .into(),
        ),
        ResidualTestKind::Pull => (
            format!("The residuals of all joints look as if something pulled at the last link, by {size} {unit}."),
            "A hose, a cable or an air line does so: take it off, or let it hang so that it does not pull, and record all again.".into(),
        ),
        ResidualTestKind::BaseGivesWay => (
            format!(
                "The residuals of all joints look as if the base gave way under the arm, by up to {}°.",
                significant(test.size.abs().to_degrees(), 2)
            ),
            "Bolt it to a floor or table that does not, and record all again. Gravity is told as the base sees it on the mean of the poses.".into(),
        ),
        ResidualTestKind::ClockRate => (
            format!(
                "The residuals of all joints look as if the clock ran {}, by {} {unit}: torques of inertia are off by twice that.",
                if test.size > 0.0 { "fast" } else { "slow" },
                significant(test.size.abs(), 2)
            ),
            "Times must be seconds of the controller that sampled the readings, not numbers of rows at a rate that is written down.".into(),
        ),
        ResidualTestKind::FrictionCurve { speed } => of_friction_curve(session, test, *speed),
        ResidualTestKind::Tables { file } => (
            format!("The residual of {channel} is another in each table: in {file} by {size} {unit}."),
            tables(of_joint),
        ),
    };
    let cure = if is_too_large(&test.kind, test.size) { SOMETHING_ELSE.to_owned() } else { cure };
    let consequence = match test.spoils_intervals {
        true => WIDENED,
        false => "It is real but small beside the noise, and changes no verdict.",
    };
    let p = chance(*corrected_p_value);
    format!(
        "{what} ({p}, {} times the noise of a reading, all tests counted.) {consequence} {cure}",
        significant(*in_noise, 2)
    )
}

/// What to do about what pulls at a joint like a spring.
fn of_spring(session: &Session, test: &ResidualTest) -> String {
    let channel = &test.channel;
    let joint = session.robot.chain.joints().iter().position(|joint| joint.name == *channel).unwrap_or(0);
    let limit = || format!("limit = {}", significant(test.size.abs(), 1));
    let by = |power: &str| format!("{}/{}{power}", session.channel_unit(joint), session.joints[joint].position_unit);
    let unknowns = [("stiffness", by(""), limit()), ("bend", by("²"), limit())];
    format!(
        "A cable, a hose or a balancer that is bent or stretched as the joint moves does so: take it off, or estimate it: {}.",
        formula(channel, "stiffness * position + bend * position^2", &unknowns)
    )
}

/// What goes with torques, and what to do about it.
fn of_torque(session: &Session, test: &ResidualTest) -> (String, String) {
    let ResidualTest { channel, unit, .. } = test;
    let size = significant(test.size, 2);
    // Where it is of all joints, units are those of the first.
    let joint = session.robot.chain.joints().iter().position(|joint| joint.name == *channel).unwrap_or(0);
    let by_torque = |with: &str| per_torque(session, joint, joint, with);
    match &test.kind {
        ResidualTestKind::TorqueGain { file } => {
            let whose = if channel == ALL_JOINTS {
                "torque gains of all joints are"
            } else {
                &format!("torque gain of {channel} is")
            };
            (
                format!("The residuals show that the {whose} different in {file}, by {size} {unit}."),
                "Either the arm was warmer, an amplifier was set anew, or a load is not as stated. Record all tables in one go with a warm arm, or \
                 calibrate those before and after by themselves."
                    .into(),
            )
        }
        ResidualTestKind::TorqueGainTrend => {
            let whose = if channel == ALL_JOINTS {
                "torque gains of all joints drift"
            } else {
                &format!("torque gain of {channel} drifts")
            };
            (
                format!("The residuals show that the {whose}, by {size} {unit}."),
                format!(
                    "Let the arm warm up before it is recorded; or estimate a steady drift (times are needed): {}.",
                    formula(channel, "drift * torque * time", &[("drift", by_torque("·s"), "limit = 0.01".into())])
                ),
            )
        }
        ResidualTestKind::Crosstalk { joint } => (
            format!(
                "The reading of {channel} goes with torques of other joints, most with that of {joint}: {size} {unit}."
            ),
            format!(
                "Estimate it: sensor_models = [{{ kind = \"torque-crosstalk\", from = [\"{joint}\"] }}] in its [[joint]]."
            ),
        ),
        ResidualTestKind::LoadFriction => (
            format!("The friction of {channel} grows with its torque: by {size} {unit} of it."),
            format!(
                "Estimate it: {}.",
                formula(channel, "share * abs(torque) * direction", &[("share", by_torque(""), "limit = 0.01".into())])
            ),
        ),
        _ => (
            format!(
                "The reading of {channel} is not proportional to its torque: it is off by about {size} {unit} at the largest."
            ),
            "Estimate it: sensor_models = [{ kind = \"torque-gain-polynomial\" }] in its [[joint]].".into(),
        ),
    }
}

/// Friction that is no line over the speed, and how to estimate what it is more or less.
fn of_friction_curve(session: &Session, test: &ResidualTest, speed: f64) -> (String, String) {
    let ResidualTest { channel, unit, size, .. } = test;
    let joint = session.robot.chain.joints().iter().position(|joint| joint.name == *channel).unwrap_or(0);
    let coordinate = if session.robot.chain.joints()[joint].kind == JointKind::Prismatic { "m" } else { "rad" };
    // Friction takes a torque of the motion's sign; both sensors may read the other way.
    let gain = |gain| session.nominal(ParameterId::Sensor(joint, gain));
    let sign = gain(SensorParameter::TorqueGain) * gain(SensorParameter::PositionGain);
    let more = if size * sign > 0.0 { "more" } else { "less" };
    let (size, by, speed) = (significant(*size, 1), significant(size.abs(), 1), significant(speed, 1));
    let unknowns = [
        ("extra", unit.clone(), format!("nominal = {size}, limit = {by}")),
        ("speed", format!("{coordinate}/s"), format!("nominal = {speed}, limit = {speed}")),
    ];
    (
        format!(
            "The friction of {channel} is no line over its speed: it is about {by} {unit} {more} where the joint hardly moves, which falls to a third \
             at {speed} {coordinate}/s."
        ),
        format!("Estimate it: {}.", formula(channel, "extra * direction * exp(-abs(velocity) / speed)", &unknowns)),
    )
}

/// What to do about inertia that the model lacks.
fn of_inertia(session: &Session, test: &ResidualTest) -> String {
    let joint = session.robot.chain.joints().iter().position(|joint| joint.name == test.channel);
    let Some(joint) = joint.filter(|_| session.has_windows()) else {
        return "Leave accelerated rows out ([readings.select]), let joints stand ([readings.still]), or drive steadily.".into();
    };
    let gain = session.nominal(ParameterId::Sensor(joint, SensorParameter::TorqueGain));
    // A rotor takes torque to speed up; what gives it is none.
    if test.size * gain > 0.0 && session.rotors.get(joint).copied().flatten().is_none() {
        return "If torque is measured by motor current, it includes the torque that accelerates the rotor: say rotor_inertia = \"unknown\" in \
                the joint's [[joint]]."
            .into();
    }
    "No rotor does so: look at what the recorder did to torques (torque_lag_s and recorded_filter_hz in readings.motion), at the clock, and \
     at friction that changes its sign late."
        .into()
}

/// A p-value; digits far out in a tail mean nothing.
fn chance(p: f64) -> String {
    if p < 1e-6 { "p < 1e-6".into() } else { format!("p = {}", significant(p, 2)) }
}

fn drift(of_joint: bool) -> String {
    let kind = if of_joint { "torque-bias-in-time" } else { "bias-in-time" };
    format!(
        "Let the sensor warm up before it is read; or estimate a steady drift: sensor_models = [{{ kind = \"{kind}\" }}], with the \
         poses in an order that has nothing to do with their angles."
    )
}

fn tables(of_joint: bool) -> String {
    let zero = if of_joint { "or a shifted zero" } else { "or a shifted zero (let each table have a bias of its own)" };
    format!(
        "Possible causes: a load mounted elsewhere than stated, a moved cable, {zero}. Look at what changed between the tables."
    )
}

/// How to add a formula to the torque reading of a channel, or of all joints; of each unknown its name, unit, and what else is said of it.
fn formula(channel: &str, adds: &str, unknowns: &[(&str, String, String)]) -> String {
    let place = if channel == ALL_JOINTS { "[joints]" } else { "its [[joint]]" };
    let unknowns = unknowns.iter().map(|(name, unit, said)| format!("{name} = {{ unit = \"{unit}\", {said} }}"));
    let unknowns: Vec<String> = unknowns.collect();
    format!(
        "sensor_models = [{{ kind = \"formula\", adds = \"{adds}\", unknowns = {{ {} }} }}] in {place}",
        unknowns.join(", ")
    )
}

fn periods(order: u32) -> String {
    match order {
        1 => "once a turn".into(),
        2 => "twice a turn".into(),
        _ => format!("{order} times a turn"),
    }
}
