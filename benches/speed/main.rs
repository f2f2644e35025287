//! Speed of the joint estimate of seven joints, on one thread, beside the same problem in Ceres and in SciPy, beside other methods, and
//! beside two threads.
//!
//! `cargo run --release -p gravcal-benches --bin speed`, and `-- --position-errors` with seven more unknowns a pose
//!
//! `benches/README.md` says what is measured and how.

mod cores;
mod exchange;
mod methods;
mod model;
mod peers;
mod product;
mod table;

use std::process::ExitCode;

use clap::Parser;
use gravcal_benches::clock::{median_seconds, microseconds};
use gravcal_benches::program::ended;
use gravcal_benches::seven_joints::{POSITION_ERROR, SevenJoints};
use gravcal_estimation::{Estimate, Problem, RankAnalysis, SolveContext, Solver, Values};
use gravcal_solvers::{LevenbergMarquardt, StoppingRules};

use peers::Peer;
use table::{Row, print_table};

/// Columns of the joint problem, counted by hand: gravity 2, torque gains and biases 14, position gains 7 and offsets 5,
/// masses and moments 28, placement 3, direction of the displacement 2.
const COLUMNS: usize = 61;
/// Largest |cosine| between the residual and a column of J with which a solution passes.
pub(crate) const COSINE: f64 = 1e-8;

/// Times the joint problem of seven joints on one thread, beside Ceres and SciPy, beside other methods, and beside two threads.
#[derive(Parser)]
struct Arguments {
    /// Numbers of poses.
    #[arg(long, value_delimiter = ',', default_value = "300,2000,20000", value_parser = clap::value_parser!(u32).range(30..))]
    poses: Vec<u32>,
    /// The error of every joint's position in every pose is one more unknown. SciPy, which eliminates none, is left out.
    #[arg(long)]
    position_errors: bool,
    /// Leave Ceres and SciPy out.
    #[arg(long)]
    without_peers: bool,
}

fn main() -> ExitCode {
    ended(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let pools = [cores::pool(1)?, cores::pool(2)?];
    let [one_thread, two_threads] = [&pools[0], &pools[1]];
    let mut peers = if arguments.without_peers { Vec::new() } else { peers::available() };
    if arguments.position_errors {
        peers.retain(|peer| peer.eliminates);
        for poses in &arguments.poses {
            let seven_joints = SevenJoints::simulate(*poses as usize)?;
            let (problem, initial) = seven_joints.with_position_errors(true)?;
            one_thread.install(|| with_position_errors(&seven_joints, (&problem, &initial), &peers))?;
            cores::compare(&problem, &initial, [one_thread, two_threads])?;
        }
        return Ok(());
    }
    let peak = product::peak();
    println!("peak of one thread, the best of square products in cache: {:.1} GFLOP/s", peak * 1e-9);
    for poses in &arguments.poses {
        let problem = SevenJoints::simulate(*poses as usize)?;
        one_thread.install(|| measure(&problem, &peers, peak))?;
        cores::compare(&problem.built.problem, &problem.built.initial, [one_thread, two_threads])?;
    }
    Ok(())
}

/// One number of poses: solves, prints what the time is made of, and compares with the peers and with other methods.
fn measure(problem: &SevenJoints, peers: &[Peer], peak: f64) -> Result<(), String> {
    describe(problem)?;
    let (joint, initial) = (&problem.built.problem, &problem.built.initial);
    // The peers have no reference.
    let ours = solved(&LevenbergMarquardt { stopping: stopping() }, &joint.without_reference(), initial)?;
    print_shares(problem, &ours, peak)?;
    let folder = exchange::write(problem)?;
    let theirs = peers.iter().map(|peer| (peer.name, peer.run(folder.path(), None)));
    print_table(problem.poses(), &ours, theirs.collect());
    methods::compare(problem.poses(), joint, initial)
}

/// The same with an error of every position as one more unknown, of which the peers are told the standard deviation.
fn with_position_errors(
    problem: &SevenJoints,
    (joint, initial): (&Problem, &Values),
    peers: &[Peer],
) -> Result<(), String> {
    println!("\n{} poses: {} readings, {} columns", problem.poses(), 7 * problem.poses(), joint.columns().len());
    let ours = solved(&LevenbergMarquardt { stopping: stopping() }, joint, initial)?;
    let folder = exchange::write(problem)?;
    let theirs = peers.iter().map(|peer| (peer.name, peer.run(folder.path(), Some(POSITION_ERROR))));
    print_table(problem.poses(), &ours, theirs.collect());
    Ok(())
}

/// When methods end.
fn stopping() -> StoppingRules {
    StoppingRules { cosine_tolerance: COSINE, ..StoppingRules::default() }
}

fn describe(problem: &SevenJoints) -> Result<(), String> {
    let joint = &problem.built.problem;
    let columns = joint.columns().len();
    if columns != COLUMNS {
        return Err(format!("the problem has {columns} columns, expected {COLUMNS}"));
    }
    let rank = RankAnalysis::new(joint, &problem.built.initial).map_err(|e| e.to_string())?.rank();
    println!("\n{} poses: {} readings, {columns} columns of rank {rank}", problem.poses(), joint.rows());
    Ok(())
}

/// Solves, and again and again for the time.
fn solved(solver: &dyn Solver, problem: &Problem, initial: &Values) -> Result<Row, String> {
    let run = || solver.solve(problem, initial, &mut SolveContext::default());
    let estimate: Estimate = run().map_err(|e| e.to_string())?;
    let (Some(first), Some(last)) = (estimate.iterations.first(), estimate.iterations.last()) else {
        return Err("the solver recorded no iteration".into());
    };
    Ok(Row {
        seconds: median_seconds(run),
        iterations: estimate.iterations.len() - 1,
        initial_cost: first.cost,
        cost: estimate.cost,
        cosine: last.cosine,
    })
}

/// What a pose and iteration consists of.
fn print_shares(problem: &SevenJoints, ours: &Row, peak: f64) -> Result<(), String> {
    let model = model::time(problem)?;
    println!("  model: {} µs a pose, with Jacobian: {} µs", microseconds(model.residual), microseconds(model.jacobian));
    let product = product::time(problem);
    let poses = problem.poses() as f64;
    // One product at the start and one after every iteration.
    let share = product.seconds * (ours.iterations + 1) as f64 / ours.seconds;
    println!(
        "  product JᵀJ: {} µs a pose, {:.0} % of the solve; {:.1} GFLOP/s, {:.0} % of the peak",
        microseconds(product.seconds / poses),
        100.0 * share,
        product.rate() * 1e-9,
        100.0 * product.rate() / peak,
    );
    Ok(())
}
