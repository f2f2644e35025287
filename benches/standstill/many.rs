//! Many recordings of varied noise, rate and speed: how many standstills are found, and how true their standard errors are.

use gravcal_benches::program::progress;
use gravcal_recording::Standstill;
use gravcal_session::simulation::{Approach, Converter, Dirt, Motion, Run, Simulation, TrueStandstill, record};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::paper::from_files;

/// Standstills of each recording.
const POSES: usize = 15;

/// What many recordings come to.
#[derive(Default)]
struct Tally {
    recordings: usize,
    truths: usize,
    found: usize,
    wrong: usize,
    rejected: usize,
    /// Squares of errors over standard errors, and their number: of positions, of torques.
    squares: [(f64, usize); 2],
}

pub(crate) fn run(simulation: &Simulation, recordings: u64) -> Result<(), String> {
    let kinds = ["white noise", "converter of 10 to 14 bits", "correlated noise", "outliers, lost messages"];
    let mut tallies: Vec<Tally> = kinds.iter().map(|_| Tally::default()).collect();
    let bar = progress(recordings, "recordings");
    for trial in 0..recordings {
        let kind = (trial % kinds.len() as u64) as usize;
        let varied = varied(simulation, trial, kind);
        let motion = varied.motion.clone().ok_or("no recording")?;
        let perfect = record::<()>(&varied, &motion, 0, &mut |_, _| Ok(())).map_err(|()| "no rows".to_owned())?;
        let exact = exact(&varied, &motion)?;
        let session = from_files(&varied)?;
        let found: Vec<&Standstill> =
            session.searched.iter().flat_map(|s| &s.standstills).flat_map(|s| &s.found).collect();
        let rejected = session.searched.iter().flat_map(|s| &s.standstills).map(|s| s.rejected.len()).sum::<usize>();
        tallies[kind].take(&perfect.standstills, &exact, &found, rejected);
        bar.inc(1);
    }
    bar.finish_and_clear();
    println!(
        "{recordings} recordings of varied noise, rate (200 Hz to 2 kHz), duration and speed, {POSES} standstills each"
    );
    println!(
        "{:28} {:>10} {:>9} {:>9} {:>9} {:>22} {:>22}",
        "", "standstills", "found", "false", "rejected", "rms error / std, pos.", "rms error / std, torque"
    );
    for (name, tally) in kinds.iter().zip(&tallies) {
        tally.print(name);
    }
    tallies.iter().fold(Tally::default(), Tally::join).print("all");
    println!();
    Ok(())
}

/// A recording of random poses; everything else is drawn.
fn varied(simulation: &Simulation, trial: u64, kind: usize) -> Simulation {
    let mut random = Pcg64::seed_from_u64(trial);
    let mut between = |low: f64, high: f64| low * (high / low).powf(random.random_range(0.0..1.0));
    let mut varied = super::recorded(simulation);
    varied.seed = trial;
    varied.template.tables.truncate(1);
    varied.template.load_distances.clear();
    varied.template.tables[0].load = None;
    varied.runs = vec![Run::Random { poses: POSES, moving: None }];
    let rate = between(200.0, 2000.0);
    let samples = (rate * between(0.25, 1.5)).max(100.0);
    let root = samples.sqrt();
    varied.disturbance.torque_std.fill(between(0.5, 20.0) / root);
    varied.disturbance.position_std.fill(between(1e-5, 1e-3) / root);
    let bits = between(10.0, 14.99) as u32;
    varied.disturbance.converter = (kind == 1).then_some(Converter { bits, range: [0.0, 4096.0] });
    varied.motion = Some(Motion {
        rate,
        samples: samples as usize,
        moving: between(0.3, 3.0),
        settling: 0.35,
        vibration: between(1.0, 50.0),
        settling_time: between(0.01, 0.05),
        correlation: if kind == 2 { between(0.0005, 0.003) } else { 0.0 },
        approach: Approach::Any,
        friction: None,
        hysteresis: None,
        creep: None,
        walk: Vec::new(),
        harmonic: None,
        sweeping: None,
        dirt: if kind == 3 { Dirt { outliers: 0.01, dropped: 0.05, touched: 0 } } else { Dirt::default() },
    });
    varied
}

/// Positions and torques of each standstill without noise.
fn exact(simulation: &Simulation, motion: &Motion) -> Result<Vec<[Vec<f64>; 2]>, String> {
    let mut quiet = simulation.clone();
    quiet.disturbance.torque_std.fill(0.0);
    quiet.disturbance.position_std.fill(0.0);
    quiet.disturbance.converter = None;
    let still = Motion { vibration: 0.0, dirt: Dirt::default(), ..motion.clone() };
    let recorded = record::<()>(&quiet, &still, 0, &mut |_, _| Ok(())).map_err(|()| "no rows".to_owned())?;
    let readings = |pose: &gravcal_robot_model::session::Pose| {
        [pose.position.clone(), pose.torque.iter().flatten().map(|reading| reading.value).collect()]
    };
    Ok(recorded.session.poses.iter().map(readings).collect())
}

impl Tally {
    fn take(&mut self, truths: &[TrueStandstill], exact: &[[Vec<f64>; 2]], found: &[&Standstill], rejected: usize) {
        self.recordings += 1;
        self.truths += truths.len();
        self.rejected += rejected;
        let mut seen = vec![false; truths.len()];
        for standstill in found {
            let [from, until] = standstill.interval;
            let shared = |truth: &TrueStandstill| {
                until.min(truth.interval[1]) - from.max(truth.interval[0]) > 0.5 * (until - from)
            };
            let place = truths.iter().position(|truth| shared(truth) && !truth.touched);
            let Some(place) = place.filter(|place| !std::mem::replace(&mut seen[*place], true)) else {
                self.wrong += 1;
                continue;
            };
            self.found += 1;
            self.compare(standstill, &exact[place]);
        }
    }

    fn compare(&mut self, standstill: &Standstill, exact: &[Vec<f64>; 2]) {
        let positions = standstill.pose.position.iter().zip(&standstill.position);
        let positions = positions.map(|(mean, spread)| (*mean, spread.standard_error));
        let torques = standstill.pose.torque.iter().flatten().filter_map(|reading| Some((reading.value, reading.std?)));
        let mut add = |kind: usize, means: Vec<(f64, f64)>| {
            for ((mean, std), exact) in means.into_iter().zip(&exact[kind]) {
                self.squares[kind].0 += ((mean - exact) / std).powi(2);
                self.squares[kind].1 += 1;
            }
        };
        add(0, positions.collect());
        add(1, torques.collect());
    }

    fn join(self, other: &Tally) -> Tally {
        let add =
            |kind: usize| (self.squares[kind].0 + other.squares[kind].0, self.squares[kind].1 + other.squares[kind].1);
        Tally {
            recordings: self.recordings + other.recordings,
            truths: self.truths + other.truths,
            found: self.found + other.found,
            wrong: self.wrong + other.wrong,
            rejected: self.rejected + other.rejected,
            squares: [add(0), add(1)],
        }
    }

    fn print(&self, name: &str) {
        let per_cent = |count: usize| 100.0 * count as f64 / self.truths as f64;
        let [position, torque] = self.squares.map(|(sum, count)| (sum / count as f64).sqrt());
        println!(
            "{name:28} {:>10} {:>8.2}% {:>8.3}% {:>9} {position:>22.3} {torque:>22.3}",
            self.truths,
            per_cent(self.found),
            per_cent(self.wrong),
            self.rejected
        );
    }
}
