//! What sensor models of one's own cost: time of one linearization a pose, with torque ripple `a sin(n q + φ)` of one joint or of all seven,
//! by hand, by dual numbers and as a formula, beside affine sensors.
//!
//! `cargo run --release -p gravcal-benches --bin sensor_terms`
//!
//! The problem is that of `speed` (see `benches/README.md`), on one thread. Each term adds three columns; what these cost in the products of
//! normal equations is in the times. `term` is one evaluation alone, with its derivatives.

use std::hint::black_box;
use std::path::Path;
use std::process::ExitCode;

use gravcal_benches::clock::median_seconds;
use gravcal_benches::program::ended;
use gravcal_calibration::joint::{Signals, State, build_problem, select};
use gravcal_estimation::Number;
use gravcal_recording::Conditions;
use gravcal_robot_model::Registry;
use gravcal_robot_model::parameter::Limit;
use gravcal_robot_model::sensors::{
    Declared, Differentiated, Moment, Options, ParameterSpec, Partials, Reads, RefusedOption, SensorFormula,
    SensorModel, SensorTerm, Site,
};
use gravcal_session::document::Document;
use gravcal_session::simulation::{Run, Simulation};

const SIMULATION: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../experiments/seven-joints-tilted/simulation.toml");
const POSES: usize = 2000;
const JOINTS: usize = 7;
const NAMES: [&str; 3] = ["amplitude", "order", "phase"];
const NOMINAL: [f64; 3] = [0.1, 6.0, 0.2];
const FORMULA: &str = "adds = \"amplitude * sin(order * position + phase)\", unknowns = { \
                       amplitude = { unit = \"N·m\", nominal = 0.1, limit = 0.1 }, \
                       order = { unit = \"1/rad\", nominal = 6, limit = 0.1 }, \
                       phase = { unit = \"rad\", nominal = 0.2, limit = 0.2 } }, ";

/// Ripple over the position of a joint, with derivatives by hand.
#[derive(Debug)]
struct ByHand(usize);

/// The same without.
#[derive(Debug)]
struct ByDual(usize);

impl SensorTerm for ByHand {
    fn reads(&self) -> Reads {
        Reads::positions()
    }

    fn value(&self, at: &Moment<'_>, x: &[f64], partials: Option<Partials<'_>>) -> f64 {
        let position = at.position(self.0);
        let (sine, cosine) = (x[1] * position + x[2]).sin_cos();
        if let Some(partials) = partials {
            partials.by_parameter.copy_from_slice(&[sine, x[0] * cosine * position, x[0] * cosine]);
        }
        x[0] * sine
    }
}

impl SensorFormula for ByDual {
    fn reads(&self) -> Reads {
        Reads::positions()
    }

    fn value<N: Number>(&self, at: &Moment<'_, N>, x: &[N]) -> N {
        x[0] * (x[1] * at.position(self.0) + x[2]).sin()
    }
}

/// Ripple as a model; `dual`: by dual numbers.
#[derive(Debug)]
struct Ripple {
    name: &'static str,
    dual: bool,
}

impl SensorModel for Ripple {
    fn name(&self) -> &str {
        self.name
    }

    fn help(&self) -> &str {
        "torque ripple over the position"
    }

    fn declare(&self, site: &Site<'_>, _options: &Options) -> Result<Vec<Declared>, RefusedOption> {
        let parameter = |(name, nominal)| ParameterSpec::new(name, "1", Limit::Absolute(0.1)).starting_at(nominal);
        let parameters: Vec<ParameterSpec> = NAMES.into_iter().zip(NOMINAL).map(parameter).collect();
        Ok(vec![match self.dual {
            true => Declared::new(parameters, Differentiated::new(ByDual(site.joint()))),
            false => Declared::new(parameters, ByHand(site.joint())),
        }])
    }
}

fn main() -> ExitCode {
    ended(run())
}

fn run() -> Result<(), String> {
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|e| e.to_string())?;
    one_thread.install(|| {
        let (by_hand, by_dual) = (alone(&ByHand(1)), alone(&Differentiated::new(ByDual(1))));
        println!("term alone: by hand {by_hand:.1} ns, by dual numbers {by_dual:.1} ns");
        let affine = linearization("", 0)?;
        println!("sensors             joints  columns  µs a pose  beside affine");
        report("affine", 0, affine, affine.0);
        for (what, kind) in [
            ("by hand", "kind = \"by-hand\", "),
            ("by dual numbers", "kind = \"by-dual\", "),
            ("formula", &format!("kind = \"formula\", {FORMULA}")),
        ] {
            for joints in [1, JOINTS] {
                report(what, joints, linearization(kind, joints)?, affine.0);
            }
        }
        Ok(())
    })
}

fn report(what: &str, joints: usize, (seconds, columns): (f64, usize), affine: f64) {
    println!("{what:18} {joints:7} {columns:8} {:10.3} {:+13.1} %", 1e6 * seconds, 100.0 * (seconds / affine - 1.0));
}

/// Time of one evaluation with derivatives, ns.
fn alone(term: &dyn SensorTerm) -> f64 {
    const REPETITIONS: usize = 100_000;
    let conditions = Conditions::default();
    let seconds = median_seconds(|| {
        let mut sum = 0.0;
        for k in 0..REPETITIONS {
            let position = [0.0, 1e-4 * k as f64];
            let at = Moment::new(&[1.0, 2.0], &[0.1, 0.2], &position, &conditions);
            let (mut by_parameter, mut by_torque, mut by_coordinate) = ([0.0; 3], [0.0; 2], [0.0; 2]);
            let partials = Partials {
                by_parameter: &mut by_parameter,
                by_torque: &mut by_torque,
                by_coordinate: &mut by_coordinate,
            };
            sum += term.value(&at, black_box(&NOMINAL), Some(partials)) + by_parameter[1];
        }
        sum
    });
    1e9 * seconds / REPETITIONS as f64
}

/// Seconds a pose, and columns, where so many joints have this model.
fn linearization(kind: &str, joints: usize) -> Result<(f64, usize), String> {
    let path = Path::new(SIMULATION);
    let mut text = std::fs::read_to_string(path).map_err(|e| e.to_string())?;
    let truth: Vec<String> = NAMES
        .into_iter()
        .zip(["N·m", "1/rad", "rad"])
        .zip(NOMINAL)
        .map(|((name, unit), value)| {
            let unit = if kind.contains("formula") { unit } else { "1" };
            format!("{name} = {{ value = {value}, unit = \"{unit}\" }}")
        })
        .collect();
    for joint in 1..=joints {
        let name = format!("name = \"joint{joint}\"\n");
        let models = format!("sensor_models = [{{ {kind}parameters = {{ {} }} }}]\n", truth.join(", "));
        text = text.replacen(&name, &(name.clone() + &models), 1);
    }
    let registry = Registry::standard()
        .with_sensor_model(Ripple { name: "by-hand", dual: false })
        .with_sensor_model(Ripple { name: "by-dual", dual: true });
    let document = Document::of(path, text).map_err(|e| e.to_string())?;
    let mut simulation = Simulation::of(&document, &registry).map_err(|e| e.to_string())?;
    let tables = simulation.runs.len();
    simulation.runs.iter_mut().for_each(|run| *run = Run::Random { poses: POSES / tables, moving: None });
    let session = simulation.session(0);
    let built = build_problem(&session, &select(&session, Signals::All), &State::nominal(&session))
        .map_err(|e| e.to_string())?;
    let count = session.poses.len();
    built.problem.linearize(&built.initial).map_err(|e| e.to_string())?;
    let seconds = median_seconds(|| built.problem.linearize(&built.initial).map(|linear| linear.cost()).ok());
    Ok((seconds / count as f64, built.problem.columns().len()))
}
