//! What is done to the files of a session before it is calibrated.

use std::fs;
use std::path::Path;

use gravcal_session::read_session;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;

/// Standard deviation of the masses in the robot's file, as a share.
const MASSES: f64 = 0.2;

/// Hands the session a robot whose links' masses and tensors are each off by a fifth, as files of robots are.
pub fn misjudge_masses(session: &Path, urdf: &Path, seed: u64) -> Result<(), String> {
    let text = fs::read_to_string(urdf).map_err(|error| error.to_string())?;
    let mut random = Pcg64::seed_from_u64(seed);
    let mut factor = 1.0;
    let lines = text.lines().map(|line| {
        if line.contains("<mass ") {
            factor = (1.0 + MASSES * random.sample::<f64, _>(StandardNormal)).max(0.2);
        }
        match line.contains("<mass ") || line.contains("<inertia ") {
            true => multiplied(line, factor),
            false => line.to_owned(),
        }
    });
    let text = lines.collect::<Vec<_>>().join("\n");
    let folder = session.parent().unwrap_or(Path::new("."));
    fs::write(folder.join("robot.urdf"), text).map_err(|error| error.to_string())?;
    let said = fs::read_to_string(session).map_err(|error| error.to_string())?;
    let lines = said.lines().map(|line| if line.starts_with("urdf = ") { "urdf = \"robot.urdf\"" } else { line });
    fs::write(session, lines.collect::<Vec<_>>().join("\n")).map_err(|error| error.to_string())
}

/// A line of XML with every number in quotes multiplied.
fn multiplied(line: &str, factor: f64) -> String {
    let part = |(place, part): (usize, &str)| match (place % 2, part.trim().parse::<f64>()) {
        (1, Ok(number)) => (factor * number).to_string(),
        _ => part.to_owned(),
    };
    line.split('"').enumerate().map(part).collect::<Vec<_>>().join("\"")
}

/// Writes the positions of all recordings of a folder in degrees instead of radians.
pub fn write_degrees(folder: &Path) -> Result<(), String> {
    let said = |error: std::io::Error| error.to_string();
    let files = fs::read_dir(folder).map_err(said)?.collect::<Result<Vec<_>, _>>().map_err(said)?;
    let is_recording = |path: &Path| path.extension().is_some_and(|extension| extension == "csv");
    for path in files.into_iter().map(|file| file.path()).filter(|path| is_recording(path)) {
        let text = fs::read_to_string(&path).map_err(said)?;
        let mut lines = text.lines().skip_while(|line| line.starts_with('#'));
        let heading = lines.next().ok_or("a recording without rows")?;
        let positions: Vec<bool> = heading.split(',').map(|column| column.ends_with(".position")).collect();
        let cell = |(cell, position): (&str, &bool)| match cell.parse::<f64>() {
            Ok(angle) if *position => angle.to_degrees().to_string(),
            _ => cell.to_owned(),
        };
        let row = |row: &str| row.split(',').zip(&positions).map(cell).collect::<Vec<_>>().join(",");
        let rows: Vec<String> = lines.map(row).collect();
        fs::write(&path, format!("{heading}\n{}\n", rows.join("\n"))).map_err(said)?;
    }
    Ok(())
}

/// Puts tables of the standstills' means in the place of the recordings, which say nothing of noise.
pub fn tabulate(path: &Path) -> Result<(), String> {
    let session = read_session(path).map_err(|error| error.to_string())?;
    let mut text = fs::read_to_string(path).map_err(|error| error.to_string())?.replace("[readings.still]\n", "");
    let columns = |of: &str| {
        session.robot.chain.joints().iter().map(move |joint| format!("{}.{of}", joint.name)).collect::<Vec<_>>()
    };
    let heading = [columns("position"), columns("effort")].concat().join(",");
    for (index, table) in session.tables.iter().enumerate() {
        let row = |pose: &gravcal_robot_model::session::Pose| {
            let torques =
                pose.torque.iter().map(|reading| reading.map_or_else(String::new, |reading| reading.value.to_string()));
            pose.position.iter().map(f64::to_string).chain(torques).collect::<Vec<_>>().join(",")
        };
        let rows = session.poses.iter().filter(|pose| pose.table == index).map(row);
        let means = table.path.with_extension("means.csv");
        let all: Vec<String> = std::iter::once(heading.clone()).chain(rows).collect();
        fs::write(&means, all.join("\n") + "\n").map_err(|error| error.to_string())?;
        let name = |path: &Path| format!("file = {:?}", path.file_name().unwrap_or_default().to_string_lossy());
        text = text.replacen(&name(&table.path), &name(&means), 1);
    }
    // Noise of positions cannot be told from torques' noise of unknown size.
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with("std = [")).collect();
    fs::write(path, lines.join("\n")).map_err(|error| error.to_string())
}
