//! Time of the inverse dynamics of seven joints, its regressor and all its derivatives, a sample: one at a time, and four at once.
//!
//! `cargo run --release -p gravcal-benches --bin dynamics`
//!
//! Beside Pinocchio where `python3` has it (`benches/peers/pinocchio`), called from Python.

use std::collections::HashMap;
use std::path::Path;
use std::process::{Command, ExitCode};

use clap::Parser;
use gravcal_benches::clock::{median_seconds, microseconds};
use gravcal_benches::program::ended;
use gravcal_benches::seven_joints::SevenJoints;
use gravcal_dynamics::{
    Arithmetic, BodyInertia, Chain, DynamicParameters, InverseDynamics, JointMotion, LANES, Single, Vectorized,
};
use pulp::{Arch, Simd, WithSimd};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const SAMPLES: usize = 4096;
const JOINTS: usize = 7;
const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];
const PEER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/peers/pinocchio/dynamics.py");

/// Shows what the inverse dynamics of seven joints take.
#[derive(Parser)]
struct Arguments {
    /// Leave Pinocchio out.
    #[arg(long)]
    without_peers: bool,
}

/// What is computed of a sample.
#[derive(Clone, Copy)]
enum Part {
    Torque,
    Regressor,
    All,
}

/// Coordinates, velocities and accelerations.
type Sample<L> = [[L; JOINTS]; 3];

fn main() -> ExitCode {
    ended(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let arm = Arm { chain: SevenJoints::simulate(30)?.session.robot.chain, links: links() };
    let samples = samples();
    let four: Vec<Sample<[f64; LANES]>> = samples.chunks_exact(LANES).map(batch).collect();
    let peer = if arguments.without_peers { HashMap::new() } else { pinocchio() };
    println!("| µs a sample | one at a time | four at once | Pinocchio, from Python |");
    println!("|---|---|---|---|");
    for (name, part, key) in [
        ("torque", Part::Torque, "torque"),
        ("regressor", Part::Regressor, "regressor"),
        ("torque, regressor, all derivatives", Part::All, "derivatives"),
    ] {
        let mut out = InverseDynamics::new(&arm.chain);
        let single = median_seconds(|| samples.iter().for_each(|sample| arm.compute(Single, sample, part, &mut out)));
        let mut lanes = InverseDynamics::new(&arm.chain);
        let arch = Arch::new();
        let mut able = true;
        let together = median_seconds(|| {
            for sample in &four {
                able &= arch.dispatch(Together { arm: &arm, sample, part, out: &mut lanes });
            }
        });
        let reported = |seconds: f64| microseconds(seconds / SAMPLES as f64);
        let together = if able { reported(together) } else { "–".into() };
        let theirs = peer.get(key).map_or_else(|| "–".into(), |time: &f64| format!("{time:.2}"));
        println!("| {name} | {} | {together} | {theirs} |", reported(single));
    }
    if let Some(call) = peer.get("call") {
        println!(
            "\nA call from Python takes about {call:.2} µs. Pinocchio's derivatives are those by the state, without regressor."
        );
    }
    Ok(())
}

struct Arm {
    chain: Chain,
    links: Vec<f64>,
}

impl Arm {
    #[inline(always)]
    fn compute<A: Arithmetic>(
        &self,
        on: A,
        [coordinates, velocities, accelerations]: &Sample<A::Stored>,
        part: Part,
        out: &mut InverseDynamics<A::Stored>,
    ) {
        let sample = JointMotion { coordinates, velocities, accelerations };
        let parameters = DynamicParameters { links: &self.links, rotor_inertia: &[0.1; JOINTS] };
        match part {
            Part::Torque => self.chain.inverse_dynamics(on, sample, GRAVITY, parameters, out),
            Part::Regressor => self.chain.inverse_dynamics_regressor(on, sample, GRAVITY, out),
            Part::All => self.chain.linearize_inverse_dynamics(on, sample, GRAVITY, parameters, out),
        }
    }
}

struct Together<'a> {
    arm: &'a Arm,
    sample: &'a Sample<[f64; LANES]>,
    part: Part,
    out: &'a mut InverseDynamics<[f64; LANES]>,
}

impl WithSimd for Together<'_> {
    /// Whether there are instructions for so many lanes.
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Some(on) = Vectorized::new(simd) else { return false };
        self.arm.compute(on, self.sample, self.part, self.out);
        true
    }
}

/// Rods of 3 kg.
fn links() -> Vec<f64> {
    let rod = BodyInertia::about_center(3.0, [0.0, -0.1, 0.05], [0.02, 0.0, 0.01, 0.0, 0.001, 0.02]);
    rod.parameters().repeat(JOINTS)
}

fn samples() -> Vec<Sample<f64>> {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let mut number = |_| random.random_range(-3.0..3.0);
    (0..SAMPLES).map(|_| std::array::from_fn(|_| std::array::from_fn(&mut number))).collect()
}

fn batch(samples: &[Sample<f64>]) -> Sample<[f64; LANES]> {
    std::array::from_fn(|part| std::array::from_fn(|joint| std::array::from_fn(|lane| samples[lane][part][joint])))
}

/// Its times, µs; none where it cannot be run, with a word about it.
fn pinocchio() -> HashMap<String, f64> {
    let one_thread = [("OPENBLAS_NUM_THREADS", "1"), ("OMP_NUM_THREADS", "1")];
    let output = Command::new("python3").arg(Path::new(PEER)).envs(one_thread).output();
    let printed = output.ok().filter(|output| output.status.success());
    let times = printed.and_then(|output| serde_json::from_slice(&output.stdout).ok());
    times.unwrap_or_else(|| {
        println!("Pinocchio is left out: python3 could not run {PEER}\n  to install it: pip install pin numpy\n");
        HashMap::new()
    })
}
