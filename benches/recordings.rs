//! How fast recordings are read, beside the `mcap` crate that only iterates over their messages, and in how much memory.
//!
//! `cargo run --release -p gravcal-benches --bin recordings -- --megabytes 2000`
//!
//! A recording of seven joints at 1 kHz (positions, velocities and efforts with noise), which stand for half of the time, is written into a
//! temporary folder as messages of `sensor_msgs/JointState` in MCAP. It is read four times: by the `mcap` crate alone, which gives messages
//! as bytes; by `gravcal_recording::open`, which decodes each message, checks each chunk's check sum and gives rows; by
//! `gravcal_recording::inspect`, which also looks at every reading; and by `gravcal_recording::static_poses`, which finds the standstills
//! for `gravcal calibrate`. Time by the clock, and on the processor.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use cpu_time::ProcessTime;
use gravcal_benches::program::ended;
use gravcal_recording::{
    Heading, PoseMapping, PositionColumn, PositionUnit, ReadingColumn, Row, Stillness, TorqueUnit, create, inspect,
    open, static_poses,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Joints of the recorded arm.
const JOINTS: usize = 7;
/// Messages during which it moves, and then stands.
const STRETCH: u64 = 3000;

/// Measures how fast recordings are read, and in how much memory.
#[derive(Parser)]
struct Arguments {
    /// Size of the recording as it lies on the disk, MB.
    #[arg(long, default_value_t = 200)]
    megabytes: u64,
}

fn main() -> ExitCode {
    ended(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let path = folder.path().join("recording.mcap");
    let messages = write(&path, arguments.megabytes * 1_000_000)?;
    let size = fs::metadata(&path).map_err(|error| error.to_string())?.len();
    println!("{messages} messages, {:.0} MB", size as f64 * 1e-6);
    println!("{:24} {:>8} {:>12} {:>8} {:>12} {:>9}", "", "s", "processor s", "MB/s", "of mcap's", "peak MB");
    let mut alone = None;
    let mut measured = |what: &str, read: &dyn Fn() -> Result<u64, String>| {
        let (clock, processor) = (Instant::now(), ProcessTime::now());
        let count = read()?;
        let (seconds, processor) = (clock.elapsed().as_secs_f64(), processor.elapsed().as_secs_f64());
        let share = *alone.get_or_insert(seconds) / seconds;
        let speed = size as f64 * 1e-6 / seconds;
        println!("{what:24} {seconds:>8.2} {processor:>12.2} {speed:>8.1} {share:>12.2} {:>9}", peak());
        match count == messages {
            true => Ok(()),
            false => Err(format!("of {messages} messages, {count} were read")),
        }
    };
    measured("mcap alone, messages", &|| iterate(&path))?;
    measured("gravcal, rows", &|| read(&path))?;
    measured("inspect", &|| inspect(&path, &|_| {}).map(|found| found.rows).map_err(|e| e.to_string()))?;
    measured("standstills", &|| standstills(&path))
}

/// Writes a recording of about this size; how many messages it has.
fn write(path: &Path, bytes: u64) -> Result<u64, String> {
    let joints = (1..=JOINTS).map(|joint| format!("joint{joint}"));
    let names: Vec<String> = joints.collect();
    let quantities = ["position", "velocity", "effort"];
    let readings = quantities.iter().flat_map(|quantity| names.iter().map(move |name| format!("{name}.{quantity}")));
    let columns = ["time_s".to_owned()].into_iter().chain(readings).collect();
    let heading = Heading { columns, metadata: BTreeMap::new() };
    let mut writer = create(path, &heading, false).map_err(|error| error.to_string())?;
    let mut random = Pcg64Mcg::seed_from_u64(1);
    // Noise does not become smaller by compression: of the 8 bytes of a number about 7.
    let messages = bytes / (7 * 3 * JOINTS as u64 + 24);
    let mut cells = vec![0.0; 1 + 3 * JOINTS];
    for message in 0..messages {
        cells[0] = 1e-3 * message as f64;
        let moved = message / (2 * STRETCH) * STRETCH + (message % (2 * STRETCH)).min(STRETCH);
        for (joint, cell) in cells[1..].iter_mut().enumerate() {
            *cell = (1e-4 * moved as f64 + joint as f64).sin() + 1e-3 * random.random::<f64>();
        }
        writer.write(&cells).map_err(|error| error.to_string())?;
    }
    writer.finish().map_err(|error| error.to_string())?;
    Ok(messages)
}

fn read(path: &Path) -> Result<u64, String> {
    let mut rows = open(path).map_err(|error| error.to_string())?;
    let (mut row, mut count) = (Row::default(), 0);
    while rows.read(&mut row).map_err(|error| error.to_string())? {
        count += 1;
        std::hint::black_box(&row);
    }
    Ok(count)
}

fn iterate(path: &Path) -> Result<u64, String> {
    let file = BufReader::new(File::open(path).map_err(|error| error.to_string())?);
    let mut count = 0;
    for message in mcap::io::MessageReader::new(file) {
        std::hint::black_box(message.map_err(|error| error.to_string())?);
        count += 1;
    }
    Ok(count)
}

/// Finds the standstills; how many rows there are.
fn standstills(path: &Path) -> Result<u64, String> {
    let name = |joint: usize, quantity: &str| format!("joint{joint}.{quantity}");
    let position = |joint| PositionColumn::new(name(joint, "position"), PositionUnit::Radian);
    let torque = |joint| ReadingColumn { column: name(joint, "effort"), ..ReadingColumn::default() };
    let mapping = PoseMapping {
        positions: (1..=JOINTS).map(position).collect(),
        torques: (1..=JOINTS).map(|joint| Some((torque(joint), TorqueUnit::NewtonMeter))).collect(),
        ..PoseMapping::default()
    };
    let mut rows = open(path).map_err(|error| error.to_string())?;
    let found = static_poses(path, rows.as_mut(), &mapping, &Stillness::default()).map_err(|e| e.to_string())?;
    match found.found.is_empty() {
        true => Err("no standstill was found".to_owned()),
        false => Ok(found.rows),
    }
}

/// Largest memory of this program so far, MB, where the operating system tells it.
fn peak() -> String {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let kilobytes =
        status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix("kB")?.trim().parse().ok());
    kilobytes.map_or_else(|| "-".to_owned(), |kilobytes: f64| format!("{:.0}", kilobytes / 1024.0))
}
