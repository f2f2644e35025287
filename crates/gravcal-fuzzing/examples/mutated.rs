//! Hands the corpus of targets to them over and over, mutated at random: what can be tried with a stable toolchain, where libFuzzer's
//! knowledge of the branches that are taken is not to be had.
//!
//! ```text
//! cargo run --release -p gravcal-fuzzing --example mutated -- SEED RUNS TARGET...
//! ```
//!
//! An input that makes a target panic, or takes it longer than ten seconds, is written into the working directory. Where the program is
//! ended instead (no more memory: `ulimit -v`), the input is the file that it left in the folder for temporary files.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use gravcal_fuzzing as targets;
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// What takes bytes as if they were a file.
type Target = fn(&[u8]);

const TARGETS: [(&str, Target); 13] = [
    ("csv", targets::csv),
    ("mcap", targets::mcap),
    ("parquet", targets::parquet),
    ("sqlite", targets::sqlite),
    ("joint_state", targets::joint_state),
    ("urdf", targets::urdf),
    ("session", targets::session),
    ("robot", targets::robot),
    ("calibration", targets::calibration),
    ("simulation", targets::simulation),
    ("study", targets::study),
    ("study_folder", targets::study_folder),
    ("study_table", targets::study_table),
];
const LONG: Duration = Duration::from_secs(10);
/// Ways of mutating, and how many of them shift nothing.
const KINDS: usize = 9;
const IN_PLACE: usize = 3;
/// Mutations of one input at most.
const MUTATIONS: usize = 6;
/// What numbers in a text become.
const NUMBERS: [&str; 12] = [
    "0",
    "-1",
    "1e308",
    "-1e-308",
    "1e17",
    "9223372036854775807",
    "4294967296",
    "nan",
    "inf",
    "1_000",
    "0x10",
    "\"a\"",
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (Some(Ok(seed)), Some(Ok(runs))) = (arguments.first().map(|s| s.parse()), arguments.get(1).map(|r| r.parse()))
    else {
        eprintln!("expected SEED RUNS TARGET...");
        return ExitCode::from(2);
    };
    let wanted = |name: &str| arguments[2..].is_empty() || arguments[2..].iter().any(|wanted| wanted == name);
    let chosen = TARGETS.iter().filter(|(name, _)| wanted(name));
    let troubles: u64 = chosen.map(|(name, target)| run(name, *target, seed, runs)).sum();
    if troubles == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Runs one target, and tells how many inputs it did not stand.
fn run(name: &str, target: fn(&[u8]), seed: u64, runs: u64) -> u64 {
    let corpus = corpus(name);
    let mut random = Pcg64::seed_from_u64(seed);
    let (begun, mut longest, mut troubles) = (Instant::now(), Duration::ZERO, 0);
    for run in 0..runs {
        let input = mutated(&corpus, &mut random);
        let at = Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(|| target(&input)));
        longest = longest.max(at.elapsed());
        if outcome.is_err() || at.elapsed() > LONG {
            troubles += 1;
            let path = format!("{name}-{seed}-{run}");
            println!("{path}: {}", if outcome.is_err() { "it panicked" } else { "it took long" });
            if let Err(error) = fs::write(&path, &input) {
                println!("{path}: {error}");
            }
        }
    }
    println!("{name}: {runs} runs in {:.0?}, the longest {longest:.0?}, {troubles} troubles", begun.elapsed());
    troubles
}

fn corpus(name: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(name);
    let entries = fs::read_dir(&folder).into_iter().flatten().flatten();
    let mut files: Vec<_> = entries.map(|entry| entry.path()).collect();
    files.sort();
    let read: Vec<Vec<u8>> = files.iter().filter_map(|file| fs::read(file).ok()).collect();
    if read.is_empty() { vec![Vec::new()] } else { read }
}

fn mutated(corpus: &[Vec<u8>], random: &mut impl Rng) -> Vec<u8> {
    let mut bytes = corpus[random.random_range(0..corpus.len())].clone();
    let other = &corpus[random.random_range(0..corpus.len())];
    // Of most binary files that anything was shifted in, nothing but their beginning is read.
    let kinds = if random.random() { IN_PLACE } else { KINDS };
    for _ in 0..random.random_range(1..=MUTATIONS) {
        mutate(&mut bytes, other, kinds, random);
    }
    bytes
}

/// One change somewhere.
fn mutate(bytes: &mut Vec<u8>, other: &[u8], kinds: usize, random: &mut impl Rng) {
    let at = random.random_range(0..=bytes.len());
    let end = (at + random.random_range(0..=32)).min(bytes.len());
    match random.random_range(0..kinds) {
        0 if at < bytes.len() => bytes[at] ^= 1 << random.random_range(0..8),
        1 if at < bytes.len() => bytes[at] = random.random(),
        2 => {
            // A length or a place of a binary file.
            let number = [0, 1, 0x7F, 0xFF, 0xFFFF, 0x7FFF_FFFF, 0xFFFF_FFFF, u64::MAX][random.random_range(0..8)];
            let width = [1, 2, 4, 8][random.random_range(0..4)];
            let places = bytes[at..].iter_mut().zip(number.to_le_bytes()).take(width);
            places.for_each(|(byte, new)| *byte = new);
        }
        3 => drop(bytes.drain(at..end)),
        4 => {
            let copy = bytes[at..end].to_vec();
            drop(bytes.splice(at..at, copy));
        }
        5 => {
            let from = random.random_range(0..=other.len());
            let to = (from + random.random_range(0..=64)).min(other.len());
            drop(bytes.splice(at..end, other[from..to].iter().copied()));
        }
        6 => bytes.truncate(at),
        _ => mutate_number(bytes, at, random),
    }
}

/// Another number in the place of the next one in a text.
fn mutate_number(bytes: &mut Vec<u8>, at: usize, random: &mut impl Rng) {
    let is_part = |byte: &u8| byte.is_ascii_digit() || b".-+e".contains(byte);
    let Some(begin) = bytes[at..].iter().position(u8::is_ascii_digit).map(|place| at + place) else { return };
    let length = bytes[begin..].iter().take_while(|byte| is_part(byte)).count();
    let number = NUMBERS[random.random_range(0..NUMBERS.len())];
    drop(bytes.splice(begin..begin + length, number.bytes()));
}
