//! Time of a message of seven joints: iterated by the mcap crate alone, read as rows, and searched for standstills.

use std::path::Path;

use gravcal_benches::clock::median_seconds;
use gravcal_recording::{
    Heading, PoseMapping, PositionColumn, ReadingColumn, Row, Stillness, create, open, static_poses,
};
use gravcal_session::simulation::{Simulation, write_session};

const JOINTS: usize = 7;

pub(crate) fn run(simulation: &Simulation) -> Result<(), String> {
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let path = folder.path().join("seven.mcap");
    let messages = seven_joints(simulation, folder.path(), &path)? as f64;
    let bytes = std::fs::read(&path).map_err(|error| error.to_string())?;
    let iterated = median_seconds(|| iterate(&bytes));
    let read = median_seconds(|| read(&path));
    let searched = median_seconds(|| searched(&path));
    println!("Time of a message of {JOINTS} joints with position, velocity and effort, µs ({messages} messages)");
    for (what, seconds) in [
        ("iterated by the mcap crate alone", iterated),
        ("read as rows", read),
        ("read and searched for standstills", searched),
    ] {
        println!("{what:36} {:>8.3} {:>8.2} times the first", seconds / messages * 1e6, seconds / iterated);
    }
    Ok(())
}

/// A recording of seven joints out of one of three: its numbers over and over. Gives the number of messages.
fn seven_joints(simulation: &Simulation, folder: &Path, path: &Path) -> Result<u64, String> {
    let reported = |error: &dyn std::fmt::Display| error.to_string();
    let mut simulation = super::paper::procedure(simulation);
    simulation.template.tables.truncate(2);
    simulation.runs.truncate(2);
    let files = write_session(&simulation, 0, folder, false).map_err(|error| reported(&error))?;
    let mut columns = vec!["time_s".to_owned()];
    for quantity in ["position", "velocity", "effort"] {
        columns.extend((1..=JOINTS).map(|joint| format!("j{joint}.{quantity}")));
    }
    let heading = Heading { columns, ..Heading::default() };
    let mut writer = create(path, &heading, false).map_err(|error| reported(&error))?;
    let mut count = 0;
    for file in &files[1..=2] {
        let mut rows = open(file).map_err(|error| reported(&error))?;
        let mut row = Row::default();
        while rows.read(&mut row).map_err(|error| reported(&error))? {
            let place = |name: &str| rows.columns().iter().position(|column| column == name);
            let (Some(time), Some(q), Some(y)) = (place("time_s"), place("joint1.position"), place("joint1.effort"))
            else {
                return Err("the recording has other columns".to_owned());
            };
            let step = if q < y { 1 } else { 2 };
            let cell = |first: usize, joint: usize| row.cells[(first + step * (joint % 3)).min(row.cells.len() - 1)];
            let mut cells = vec![row.cells[time]];
            cells.extend((0..JOINTS).map(|joint| cell(q, joint)));
            cells.extend((0..JOINTS).map(|_| 0.0));
            cells.extend((0..JOINTS).map(|joint| cell(y, joint)));
            writer.write(&cells).map_err(|error| reported(&error))?;
            count += 1;
        }
    }
    writer.finish().map_err(|error| reported(&error))?;
    Ok(count)
}

fn iterate(bytes: &[u8]) -> Result<u64, String> {
    let messages = mcap::MessageStream::new(bytes).map_err(|error| error.to_string())?;
    let mut total = 0;
    for message in messages {
        total += message.map_err(|error| error.to_string())?.data.len() as u64;
    }
    Ok(total)
}

fn read(path: &Path) -> Result<f64, String> {
    let mut rows = open(path).map_err(|error| error.to_string())?;
    let (mut row, mut sum) = (Row::default(), 0.0);
    while rows.read(&mut row).map_err(|error| error.to_string())? {
        sum += row.cells[0];
    }
    Ok(sum)
}

fn searched(path: &Path) -> Result<usize, String> {
    let reported = |error: &dyn std::fmt::Display| error.to_string();
    let position =
        |joint: usize| Ok(PositionColumn::new(format!("j{joint}.position"), "rad".parse().map_err(|e| reported(&e))?));
    let torque = |joint: usize| {
        let column = ReadingColumn { column: format!("j{joint}.effort"), ..ReadingColumn::default() };
        Ok(Some((column, "count".parse().map_err(|e| reported(&e))?)))
    };
    let mapping = PoseMapping {
        positions: (1..=JOINTS).map(position).collect::<Result<_, String>>()?,
        torques: (1..=JOINTS).map(torque).collect::<Result<_, String>>()?,
        ..PoseMapping::default()
    };
    let mut rows = open(path).map_err(|error| reported(&error))?;
    let found = static_poses(path, rows.as_mut(), &mapping, &Stillness::default()).map_err(|error| reported(&error))?;
    Ok(found.found.len())
}
