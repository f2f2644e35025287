//! How often 95 % intervals of a nonlinear problem hold the truth, with right and with wrong noise: one table.
//!
//! `cargo run --release -p gravcal-benches --bin coverage`

mod decay;
mod errors;
mod simulate;
#[cfg(test)]
mod tests;

use std::process::ExitCode;

use clap::Parser;
use gravcal_benches::program::progress;
use gravcal_estimation::{Loss, LossName};

use decay::NAMES;
use errors::{BLOCK, Errors, SAMPLES};
use simulate::{Failure, Method, Scenario, simulate};

/// Simulates y = a exp(-b t) + c many times, and prints how often the 95 % intervals of a, b and c hold the truth.
#[derive(Parser)]
struct Arguments {
    /// How many draws.
    #[arg(long, default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(1..))]
    draws: u32,
    /// How many draws of the bootstrap, which solves each anew so often.
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..))]
    bootstrap_draws: u32,
    /// How many replicates of each of these.
    #[arg(long, default_value_t = 400, value_parser = clap::value_parser!(u32).range(100..))]
    replicates: u32,
    /// How many recordings the samples make.
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=60))]
    recordings: u32,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Failure> {
    println!("{SAMPLES} samples, blocks of {BLOCK}; per cent of the draws whose 95 % interval holds the truth");
    print!("{:16}  {:13}  {:20}  {:>6}", "errors", "loss", "uncertainty", "draws");
    NAMES.iter().for_each(|name| print!("  {name:>5}"));
    println!("  {:>5}", "± mc");
    let each = SAMPLES / arguments.recordings as usize;
    for scenario in scenarios(each, arguments.replicates as usize) {
        let draws = match scenario.method {
            Method::Bootstrap(_) => arguments.bootstrap_draws,
            _ => arguments.draws,
        };
        let bar = progress(draws.into(), "draws");
        let coverage = simulate(scenario, draws as usize, &|| bar.inc(1))?;
        bar.finish_and_clear();
        print!(
            "{:16}  {:13}  {:20}  {draws:>6}",
            scenario.errors.as_str(),
            loss(scenario.loss),
            method(scenario.method)
        );
        coverage.shares().iter().for_each(|share| print!("  {:>5.1}", 100.0 * share));
        println!("  {:>5.1}", 100.0 * coverage.noise());
    }
    Ok(())
}

/// Every kind of error with what should hold and what should fail.
fn scenarios(each: usize, replicates: usize) -> Vec<Scenario> {
    let (stated, relative) = (Method::Stated, Method::Relative);
    let (sandwich, jackknife) = (Method::Sandwich, Method::Jackknife);
    let bootstrap = Method::Bootstrap(replicates);
    let mut scenarios = Vec::new();
    let mut add = |errors, loss, methods: &[Method]| {
        scenarios.extend(methods.iter().map(|method| Scenario { each, errors, loss, method: *method }));
    };
    add(Errors::Normal, Loss::None, &[stated, relative, sandwich, jackknife, bootstrap]);
    add(Errors::Unequal, Loss::None, &[stated, relative, sandwich, jackknife, bootstrap]);
    add(Errors::Shared, Loss::None, &[stated, relative, sandwich, jackknife, bootstrap]);
    add(Errors::Autocorrelated, Loss::None, &[stated, relative, sandwich, jackknife]);
    add(Errors::Outliers, Loss::None, &[stated, relative, sandwich, jackknife]);
    let huber = LossName::Huber.efficient();
    add(Errors::Normal, huber, &[stated, sandwich, jackknife]);
    add(Errors::Shared, huber, &[stated, sandwich, jackknife]);
    add(Errors::Outliers, huber, &[stated, sandwich, jackknife, bootstrap]);
    for name in [LossName::Cauchy, LossName::Tukey, LossName::GemanMcClure] {
        add(Errors::Outliers, name.efficient(), &[stated, sandwich, jackknife]);
    }
    scenarios
}

fn loss(loss: Loss) -> String {
    match loss {
        Loss::None => "-".into(),
        some => some.name().to_string(),
    }
}

fn method(method: Method) -> String {
    match method {
        Method::Stated => "stated noise".into(),
        Method::Relative => "noise from residuals".into(),
        Method::Sandwich => "sandwich".into(),
        Method::Jackknife => "jackknife".into(),
        Method::Bootstrap(replicates) => format!("bootstrap of {replicates}"),
    }
}
