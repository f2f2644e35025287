//! Every solver on the problems with published solutions: tables in Markdown.
//!
//! ```sh
//! cargo run --release -p gravcal-benches --bin published                       # everything
//! cargo run --release -p gravcal-benches --bin published -- \
//!     --detail levenberg-marquardt --readme crates/gravcal-solvers/README.md   # brings the README up to date
//! ```

mod certified;
mod inactive_bound;
mod minima;
mod readme;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use gravcal_benches::program::ended;
use gravcal_estimation::Solver;
use gravcal_estimation::published::{more_garbow_hillstrom, nist};
use gravcal_solvers::SolverName;

use certified::CertifiedRuns;
use inactive_bound::InactiveBound;
use minima::MinimumRuns;

/// Runs every solver on NIST's certified regressions and on the problems of Moré, Garbow and Hillstrom.
#[derive(Parser)]
struct Arguments {
    /// The folder with NIST's files, `Misra1a.dat` and so on.
    #[arg(long, default_value = "../shared/data/nist_strd")]
    nist: PathBuf,
    /// The solvers whose runs are shown one by one; without it, all.
    #[arg(long)]
    detail: Vec<SolverName>,
    /// Writes the tables between the markers of this file instead of printing them.
    #[arg(long)]
    readme: Option<PathBuf>,
}

fn main() -> ExitCode {
    ended(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let data_sets = nist::read(&arguments.nist).map_err(|e| e.to_string())?;
    let problems = more_garbow_hillstrom();
    let all = SolverName::ALL.into_iter().map(SolverName::build);
    let runs: Vec<(&str, CertifiedRuns<'_>, MinimumRuns<'_>)> = all
        .chain([Box::new(InactiveBound::default()) as Box<dyn Solver>])
        .map(|solver| {
            let certified = CertifiedRuns::new(&*solver, &data_sets)?;
            Ok((solver.name(), certified, MinimumRuns::new(&*solver, &problems)?))
        })
        .collect::<Result<_, String>>()?;
    let mut text = summary(&runs);
    for (solver, certified, minima) in &runs {
        if arguments.detail.is_empty() || arguments.detail.iter().any(|detail| detail.as_str() == *solver) {
            text +=
                &format!("\n### {solver} on NIST\n\n{certified}\n### {solver} on Moré-Garbow-Hillstrom\n\n{minima}");
        }
    }
    match &arguments.readme {
        Some(path) => readme::replace(path, &text),
        None => {
            print!("{text}");
            Ok(())
        }
    }
}

fn summary(runs: &[(&str, CertifiedRuns<'_>, MinimumRuns<'_>)]) -> String {
    let mut text = String::from(
        "| solver | NIST: certified values reached | fewest digits of a parameter there | iterations, median and most \
         | Moré-Garbow-Hillstrom: minima reached | problems from every start |\n|---|---|---|---|---|---|\n",
    );
    for (solver, certified, minima) in runs {
        text += &format!("| {solver} | {} | {} |\n", certified.summary(), minima.summary());
    }
    text
}
