//! From the sections of instruments to instruments.

use std::path::Path;

use gravcal_recording::PoseMapping;
use gravcal_robot_model::robot::Robot;
use gravcal_robot_model::session::{AuxiliarySensor, AuxiliarySensorKind, Drift};

use super::found::Instruments;
use super::section::Section;
use super::tables::{AccelerometerTable, ForceTorqueTable, Frame};
use crate::document::{Document, Field, FileError};
use crate::file::context::Context;

/// The instruments that a document declares for a robot; `tables`: how many tables of poses there are.
pub(crate) fn read_instruments(
    document: &Document,
    robot: &Robot,
    robot_path: &Path,
    (force_torque, accelerometers): (&[ForceTorqueTable], &[AccelerometerTable]),
    tables: usize,
) -> Result<Instruments, FileError> {
    resolve(&Context::new(document, robot, robot_path), force_torque, accelerometers, tables)
}

/// What both sections come to; `tables`: how many tables of poses there are.
pub fn resolve(
    context: &Context<'_>,
    force_torque: &[ForceTorqueTable],
    accelerometers: &[AccelerometerTable],
    tables: usize,
) -> Result<Instruments, FileError> {
    check_names(context, force_torque, accelerometers)?;
    let mut all = Instruments::default();
    for (index, table) in force_torque.iter().enumerate() {
        let field = Field::new("force_torque_sensor").at(index);
        let link = wrist_link(context, &field, table.link.as_deref())?;
        let groups = [(&table.force_gain, &table.force_bias), (&table.moment_gain, &table.moment_bias)];
        let section =
            Section { context, field, kind: AuxiliarySensorKind::ForceTorque, name: &table.name, sign: table.sign };
        let biases = table.biases.sets(tables);
        section.add(&mut all, (link, table.mounting), &table.readings, (table.gains, biases, &groups))?;
        section.add_drifts(&mut all, &table.sensor_models)?;
        if table.frame == Frame::Base {
            section.enter_in_base(&mut all)?;
        }
        let moments = [&table.tool_moment_x, &table.tool_moment_y, &table.tool_moment_z];
        section.add_tool(&mut all, &table.tool_mass, moments)?;
    }
    for (index, table) in accelerometers.iter().enumerate() {
        let field = Field::new("accelerometer").at(index);
        let link = accelerometer_link(context, &field, table.link.as_deref())?;
        let groups = [(&table.gain, &table.bias)];
        let section =
            Section { context, field, kind: AuxiliarySensorKind::Accelerometer, name: &table.name, sign: table.sign };
        let biases = table.biases.sets(tables);
        section.add(&mut all, (link, table.mounting), &table.readings, (table.gains, biases, &groups))?;
        section.add_drifts(&mut all, &table.sensor_models)?;
        section.add_rotation(&mut all, table.mounting_std_deg)?;
    }
    Ok(all)
}

/// Sees to it that the tables say what the instruments' biases drift with. `recorded`: whether they are recordings, which tell the
/// time by themselves.
pub fn check_conditions(
    document: &Document,
    instruments: &[AuxiliarySensor],
    mapping: &PoseMapping,
    recorded: bool,
) -> Result<(), FileError> {
    let drifts = || instruments.iter().flat_map(|instrument| &instrument.drifts);
    let timeless = mapping.conditions.time.is_none() && !recorded;
    if timeless && drifts().any(|drift| *drift == Drift::Time) {
        let message = "a bias that drifts with time (bias-in-time) needs the time of every pose: name its column, readings.time = \
                       { column = \"...\", unit = \"s\" }";
        return Err(document.error(&Field::new("readings").key("time"), message));
    }
    let unknown = |drift: &Drift| match drift {
        Drift::Time => false,
        Drift::Temperature { place, .. } => *place >= mapping.conditions.temperature.len(),
    };
    if drifts().any(unknown) {
        let message = "a bias that drifts with temperature (bias-with-temperature) needs that of the instrument: name one column for \
                       all sensors, readings.temperature = { columns = \"...\", unit = \"degC\" }";
        return Err(document.error(&Field::new("readings").key("temperature"), message));
    }
    Ok(())
}

/// The last link that a wrist sensor is on: it need not be said where there is but one.
fn wrist_link(context: &Context<'_>, sensor: &Field, written: Option<&str>) -> Result<usize, FileError> {
    let last: Vec<usize> = context.robot.chain.last_links().collect();
    let names: Vec<&str> = last.iter().map(|link| context.link_names[*link]).collect();
    match (written, last.as_slice()) {
        (None, [only]) => Ok(*only),
        (None, _) => {
            let message = format!("on which link is it? add link = \"…\", one of {}", names.join(", "));
            Err(context.document.error(sensor, message))
        }
        (Some(link), _) => Ok(last[context.document.lookup(&sensor.key("link"), "last link", link, &names)?]),
    }
}

/// The link that an accelerometer is on: it need not be said where there is but one.
fn accelerometer_link(context: &Context<'_>, sensor: &Field, written: Option<&str>) -> Result<usize, FileError> {
    match (written, context.link_names.as_slice()) {
        (None, [_]) => Ok(0),
        (None, names) => {
            let message = format!("on which link is it? add link = \"…\", one of {}", names.join(", "));
            Err(context.document.error(sensor, message))
        }
        (Some(link), names) => context.document.lookup(&sensor.key("link"), "link", link, names),
    }
}

/// Results are told by name, so an instrument may not be called like a joint or another instrument.
fn check_names(
    context: &Context<'_>,
    force_torque: &[ForceTorqueTable],
    accelerometers: &[AccelerometerTable],
) -> Result<(), FileError> {
    let field = |place: usize| match place.checked_sub(force_torque.len()) {
        None => Field::new("force_torque_sensor").at(place).key("name"),
        Some(place) => Field::new("accelerometer").at(place).key("name"),
    };
    let names = force_torque.iter().map(|t| t.name.as_str()).chain(accelerometers.iter().map(|t| t.name.as_str()));
    context.document.check_names(names.clone(), field)?;
    let taken = |name: &str| context.joint_names.contains(&name) || context.link_names.contains(&name);
    match names.enumerate().find(|(_, name)| taken(name)) {
        None => Ok(()),
        Some((place, name)) => {
            let message = format!("`{name}` is a joint or link of the robot: give the instrument a name of its own");
            Err(context.document.error(&field(place), message))
        }
    }
}
