//! The paper's procedure, recorded in motion at 1 kHz and calibrated from the files alone, beside the table of perfect poses.

use gravcal_calibration::SolveEnvironment;
use gravcal_calibration::joint::{self, Signals, Solved, State};
use gravcal_robot_model::Session;
use gravcal_session::read_session;
use gravcal_session::simulation::{Approach, Dirt, Motion, Simulation, record, write_session};
use gravcal_solvers::LevenbergMarquardt;
use gravcal_study::measured_quantities;

/// Noise of a sample: a thousandth of the range of a converter of 12 bits.
const SAMPLE_STD: f64 = 4.096;
/// Of a position sample, rad.
const POSITION_STD: f64 = 1e-4;
/// Of the deflection of standing joints, which position sensors see, rad.
const DEFLECTION: f64 = 0.003;
const SAMPLES: usize = 200;

pub(crate) fn motion() -> Motion {
    Motion {
        rate: 1000.0,
        samples: SAMPLES,
        moving: 0.4,
        settling: 0.2,
        vibration: 20.0,
        settling_time: 0.03,
        correlation: 0.0,
        approach: Approach::Any,
        friction: None,
        hysteresis: None,
        creep: None,
        walk: Vec::new(),
        harmonic: None,
        sweeping: None,
        dirt: Dirt::default(),
    }
}

pub(crate) fn procedure(simulation: &Simulation) -> Simulation {
    let mut simulation = super::recorded(simulation);
    let of_mean = |std: f64| std / (SAMPLES as f64).sqrt();
    simulation.disturbance.torque_std.fill(of_mean(SAMPLE_STD));
    simulation.disturbance.position_std.fill(of_mean(POSITION_STD));
    simulation.disturbance.deflection.hold_std = DEFLECTION;
    simulation.disturbance.deflection.seen = true;
    simulation.motion = Some(motion());
    simulation
}

pub(crate) fn run(simulation: &Simulation) -> Result<(), String> {
    let clean = procedure(simulation);
    let mut dirty = clean.clone();
    let dirt = Dirt { outliers: 0.01, dropped: 0.05, touched: 1 };
    dirty.motion = Some(Motion { dirt, ..motion() });
    let perfect = record::<()>(&clean, &motion(), 0, &mut |_, _| Ok(())).map_err(|()| "no rows".to_owned())?;
    let of_perfect = Answer::of(perfect.session)?;
    let of_clean = Answer::of(from_files(&clean)?)?;
    let of_dirty = Answer::of(from_files(&dirty)?)?;
    println!(
        "The paper's procedure recorded in motion: joint estimate from perfect poses, from the recording, and from a dirty"
    );
    println!(
        "recording (1 % outliers, 5 % lost messages, one touch); differences in standard deviations of the recording's"
    );
    println!(
        "{:22} {:>12} {:>12} {:>10} {:>10} {:>10} {:>10}",
        "parameter", "truth", "perfect", "± ", "recorded", "± ratio", "dirty"
    );
    let mut largest = [0.0f64; 3];
    for quantity in measured_quantities(&of_clean.session) {
        let of = |answer: &Answer| (quantity.of(&answer.found), quantity.std(&answer.solved));
        let (perfect, recorded, dirty) = (of(&of_perfect), of(&of_clean), of(&of_dirty));
        let truth = quantity.of(&clean.truth);
        let [change, ratio, dirt] =
            [(recorded.0 - perfect.0) / perfect.1, recorded.1 / perfect.1, (dirty.0 - recorded.0) / recorded.1];
        for (largest, value) in largest.iter_mut().zip([change.abs(), ratio, dirt.abs()]) {
            *largest = largest.max(value);
        }
        println!(
            "{:22} {truth:>12.5} {:>12.5} {:>10.1e} {change:>+10.2} {ratio:>10.2} {dirt:>+10.2}",
            quantity.name(&of_clean.session),
            perfect.0,
            perfect.1
        );
    }
    println!("{:59} {:>10.2} {:>10.2} {:>10.2}", "largest", largest[0], largest[1], largest[2]);
    for (name, answer) in [("perfect", &of_perfect), ("recorded", &of_clean), ("dirty", &of_dirty)] {
        let rejected: Vec<String> = answer
            .session
            .searched
            .iter()
            .flat_map(|s| &s.standstills)
            .flat_map(|s| &s.rejected)
            .map(ToString::to_string)
            .collect();
        println!("{name}: {} poses, {}", answer.session.poses.len(), answer.misfit());
        rejected.iter().for_each(|rejected| println!("  rejected: {rejected}"));
    }
    println!();
    Ok(())
}

/// The session of recordings written to files and read from them.
pub(crate) fn from_files(simulation: &Simulation) -> Result<Session, String> {
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let files = write_session(simulation, 0, folder.path(), false).map_err(|error| error.to_string())?;
    read_session(&files[0]).map_err(|error| error.to_string())
}

struct Answer {
    session: Session,
    solved: Solved,
    found: State,
}

impl Answer {
    fn of(session: Session) -> Result<Answer, String> {
        let (solver, quiet) = (LevenbergMarquardt::default(), |_: &str| {});
        let readings = joint::select(&session, Signals::All);
        let solved = joint::solve(&session, &readings, None, &SolveEnvironment::new(&solver, &quiet));
        let solved = solved.map_err(|error| error.to_string())?;
        let found = solved.state(&State::nominal(&session));
        Ok(Answer { session, solved, found })
    }

    fn misfit(&self) -> String {
        let readings: usize = self.session.poses.iter().map(|pose| pose.torque.iter().flatten().count()).sum();
        format!("χ² {:.1} of {readings} readings", 2.0 * self.solved.estimate.cost)
    }
}
