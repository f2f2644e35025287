//! How fast recordings are read, beside the `mcap` crate that only iterates over their messages, and in how much memory.
//!
//! `cargo run --release -p gravcal-benches --bin recordings -- --megabytes 2000`
//!
//! A recording of seven joints at 1 kHz (positions, velocities and efforts with noise) is written into a temporary folder as messages of
//! `sensor_msgs/JointState` in MCAP. It is read three times: by `gravcal_recording::open`, which decodes each message, checks each
//! chunk's check sum and gives rows; by `gravcal_recording::inspect`, which also looks at every reading; and by the `mcap` crate alone,
//! which gives messages as bytes. One thread, time on the processor.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use cpu_time::ProcessTime;
use gravcal_benches::program::ended;
use gravcal_recording::{Heading, Row, create, inspect, open};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Joints of the recorded arm.
const JOINTS: usize = 7;

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
    println!("{:28} {:>10} {:>12} {:>9} {:>12}", "", "s", "messages/s", "MB/s", "peak MB");
    let report = |what: &str, seconds: f64| {
        let [rate, speed] = [messages as f64, size as f64 * 1e-6].map(|amount| amount / seconds);
        println!("{what:28} {seconds:>10.2} {rate:>12.0} {speed:>9.1} {:>12}", peak());
    };
    let (ours, count) = timed(|| read(&path))?;
    report("gravcal, rows", ours);
    let (inspected, rows) = timed(|| inspect(&path, &|_| {}).map(|found| found.rows).map_err(|e| e.to_string()))?;
    report("gravcal inspect", inspected);
    let (alone, messages_alone) = timed(|| iterate(&path))?;
    report("mcap alone, messages", alone);
    if [count, rows, messages_alone] != [messages; 3] {
        return Err(format!("of {messages} messages, {count}, {rows} and {messages_alone} were read"));
    }
    println!("rows are read at {:.2} of the speed of the mcap crate alone", alone / ours);
    Ok(())
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
        for (joint, cell) in cells[1..].iter_mut().enumerate() {
            *cell = (1e-4 * message as f64 + joint as f64).sin() + 1e-3 * random.random::<f64>();
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

/// Seconds on the processor, and the answer.
fn timed<T>(run: impl FnOnce() -> Result<T, String>) -> Result<(f64, T), String> {
    let start = ProcessTime::now();
    let answer = run()?;
    Ok((start.elapsed().as_secs_f64(), answer))
}

/// Largest memory of this program so far, MB, where the operating system tells it.
fn peak() -> String {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let kilobytes =
        status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix("kB")?.trim().parse().ok());
    kilobytes.map_or_else(|| "-".to_owned(), |kilobytes: f64| format!("{:.0}", kilobytes / 1024.0))
}
