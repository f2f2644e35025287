//! Random arms: how often the joint estimator finds the global optimum.
//!
//! `cargo run --release -p gravcal-benches --bin random_arms`
//!
//! Parts of a long table are made by `--first` and `--arms`: each arm depends on the seed and its number only, so their counts add up.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use clap::{Parser, ValueEnum};
use gravcal_solvers::LevenbergMarquardt;
use gravcal_study::random_arms::{Knowing, Tally, Trial, random_arms};

/// Calibrates simulated arms of every shape, from nominal values and from none, and counts how often the global optimum is
/// found. Prints tables in Markdown.
#[derive(Parser)]
struct Arguments {
    /// How many arms.
    #[arg(long, default_value_t = 10_000)]
    arms: u64,
    /// Number of the first one.
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Where to start from; both by default.
    #[arg(long)]
    from: Option<From>,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// What a session says beforehand.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum From {
    /// Nominal values.
    Nominal,
    /// Nothing.
    Nothing,
}

fn main() {
    let arguments = Arguments::parse();
    let both =
        [(From::Nominal, Knowing::Nominal, "From nominal values"), (From::Nothing, Knowing::Nothing, "From nothing")];
    for (from, knowing, title) in both {
        if arguments.from.is_some_and(|only| only != from) {
            continue;
        }
        let numbers = arguments.first..arguments.first + arguments.arms;
        let so_far = Mutex::new(Tally::default());
        let watch = |trial: &Trial| {
            let mut so_far = so_far.lock().unwrap_or_else(PoisonError::into_inner);
            so_far.count(trial);
            print_progress(title, *so_far, arguments.arms);
        };
        let (tallies, apart) = random_arms(arguments.seed, numbers, knowing, &LevenbergMarquardt::default(), &watch);
        print_table(title, &tallies);
        apart.iter().for_each(print_trial);
        println!();
    }
}

/// After each hundredth of the arms, on the standard error: the table goes elsewhere.
fn print_progress(title: &str, so_far: Tally, arms: u64) {
    if so_far.arms.is_multiple_of(arms.div_ceil(100).max(1)) || so_far.arms == arms {
        let Tally { arms: done, ill_conditioned, global, lower, elsewhere, misleading } = so_far;
        eprintln!(
            "{title}: {done} of {arms} arms; {ill_conditioned} ill-conditioned, {global} at the global optimum, {lower} lower, \
             {elsewhere} elsewhere, {misleading} of these misleading"
        );
    }
}

fn print_table(title: &str, tallies: &BTreeMap<usize, Tally>) {
    println!("{title}:\n");
    println!(
        "| joints | arms | ill-conditioned | global optimum | lower than from the truth | elsewhere | of these misleading |"
    );
    println!("|---|---|---|---|---|---|---|");
    let all = tallies.values().fold(Tally::default(), |sum, tally| sum.plus(*tally));
    let rows = tallies.iter().map(|(joints, tally)| (joints.to_string(), *tally));
    for (joints, tally) in rows.chain([("all".to_owned(), all)]) {
        let judged = (tally.arms - tally.ill_conditioned).max(1);
        println!(
            "| {joints} | {} | {} | {} ({:.2} %) | {} | {} | {} |",
            tally.arms,
            tally.ill_conditioned,
            tally.global,
            100.0 * tally.global as f64 / judged as f64,
            tally.lower,
            tally.elsewhere,
            tally.misleading,
        );
    }
}

fn print_trial(trial: &Trial) {
    let Trial { number, joints, condition, ending, costs: [own, from_truth], termination } = trial;
    println!(
        "\narm {number} ({joints} joints, condition {condition:.1e}): {ending:?}, cost {own:.6}, from the truth \
         {from_truth:.6}; {termination}"
    );
}
