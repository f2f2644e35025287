use std::fs;
use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;

use super::*;
use crate::mapping::{PositionColumn, ReadingColumn};
use crate::rows::open;
use crate::unit::{PositionUnit, TorqueUnit};

const FRICTION: f64 = 0.7;
const NOISE: f64 = 0.05;

fn rule() -> SweepRule {
    SweepRule {
        bin: 1f64.to_radians(),
        acceleration: 0.05,
        travel: vec![Travel::Turns(1.0); 2],
        ..SweepRule::default()
    }
}

fn mapping() -> PoseMapping {
    let position = |column: &str| PositionColumn::new(column, PositionUnit::Radian);
    let torque = |column: &str| {
        Some((ReadingColumn { column: column.to_owned(), ..ReadingColumn::default() }, TorqueUnit::NewtonMeter))
    };
    PoseMapping {
        positions: vec![position("q"), position("p")],
        torques: vec![torque("y"), torque("z")],
        ..PoseMapping::default()
    }
}

/// What the torque sensors read at rest.
fn at_rest(q: f64) -> [f64; 2] {
    [12.0 * (q + 0.3).cos() + 2.0, 5.0 * (q - 0.2).sin() - 1.0]
}

struct Recorder {
    text: String,
    time: f64,
    random: Pcg64,
    /// Noise of the last sample, its size, and its correlation with the next.
    noise: [f64; 2],
    /// From sample to sample, s.
    step: f64,
    size: f64,
    correlation: f64,
}

impl Recorder {
    fn new(seed: u64, correlation: f64) -> Recorder {
        let random = Pcg64::seed_from_u64(seed);
        Recorder {
            text: "time_s,q,p,y,z\n".to_owned(),
            time: 0.0,
            random,
            noise: [0.0; 2],
            step: 2e-3,
            size: NOISE,
            correlation,
        }
    }

    fn normal(&mut self) -> f64 {
        self.random.sample(StandardNormal)
    }

    fn row(&mut self, q: f64, p: f64, friction: f64) {
        let [y, z] = at_rest(q);
        for channel in 0..2 {
            let fresh = self.normal();
            self.noise[channel] =
                self.correlation * self.noise[channel] + (1.0 - self.correlation.powi(2)).sqrt() * self.size * fresh;
        }
        let (y, z) = (y + friction + self.noise[0], z + self.noise[1]);
        let [q, p] = [q, p].map(|at| at + 1e-5 * self.normal());
        self.text += &format!("{},{q},{p},{y},{z}\n", self.time);
        self.time += self.step;
    }

    /// From one angle to another at this speed, rad/s, with a second of acceleration at either end.
    fn stroke(&mut self, from: f64, to: f64, speed: f64, p: f64) {
        let (way, distance) = ((to - from).signum(), (to - from).abs());
        let lasts = distance / speed + 1.0;
        let steps = (lasts / self.step) as u32;
        for step in 0..=steps {
            let t = f64::from(step) * self.step;
            let ramp = |t: f64| if t < 1.0 { 0.5 * t * t } else { t - 0.5 };
            let gone = speed * if t < 0.5 * lasts { ramp(t) } else { distance / speed - ramp(lasts - t) };
            self.row(from + way * gone, p, way * FRICTION);
        }
    }

    fn sweeps(&self, rule: &SweepRule) -> Sweeps {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        fs::write(&path, &self.text).unwrap();
        slow_sweeps(Path::new("a.csv"), open(&path).unwrap().as_mut(), &mapping(), rule).unwrap()
    }
}

/// Root mean square of the errors of the readings of all poses in units of their standard errors, by channel.
fn errors(sweeps: &Sweeps) -> [f64; 2] {
    let poses: Vec<_> = sweeps.found.iter().flat_map(|sweep| sweep.poses(false)).collect();
    assert!(poses.len() > 100, "{}", poses.len());
    [0, 1].map(|channel: usize| {
        let error = |pose: &crate::StaticPose| {
            let reading = pose.torque[channel].unwrap();
            (reading.value - at_rest(pose.position[0])[channel]) / reading.std.unwrap()
        };
        (poses.iter().map(|pose| error(pose).powi(2)).sum::<f64>() / poses.len() as f64).sqrt()
    })
}

/// The straight lines alone are off by a twelfth of a bin's square, times half the second derivative: 1.2e-3 here, of bins of 2.8°.
#[test]
fn what_readings_bend_within_a_bin_is_taken_off() {
    let mut recorder = Recorder { size: 1e-9, ..Recorder::new(1, 0.0) };
    recorder.stroke(-1.0, 1.2, 0.09, 0.4);
    recorder.stroke(1.2, -1.0, 0.09, 0.4);
    let sweeps = recorder.sweeps(&SweepRule { bin: 0.05, ..rule() });
    let poses: Vec<_> = sweeps.found.iter().flat_map(|sweep| sweep.poses(false)).collect();
    assert!(poses.len() > 30, "{}", poses.len());
    for pose in poses {
        let off = pose.torque[0].unwrap().value - at_rest(pose.position[0])[0];
        assert!(off.abs() < 1.2e-4, "{off} at {}", pose.position[0]);
    }
}

#[test]
fn friction_cancels_in_the_mean_and_stands_in_the_half_difference() {
    for (seed, correlation) in [(1, 0.0), (2, 0.9)] {
        let mut recorder = Recorder::new(seed, correlation);
        for _ in 0..2 {
            recorder.stroke(-1.0, 1.2, 0.09, 0.4);
            recorder.stroke(1.2, -1.0, 0.07, 0.4);
        }
        let sweeps = recorder.sweeps(&rule());
        assert_eq!((sweeps.found.len(), sweeps.rejected.len()), (1, 0), "{:?}", sweeps.rejected);
        let sweep = &sweeps.found[0];
        assert_eq!((sweep.joint, sweep.strokes), (0, [2, 2]));
        for rms in errors(&sweeps) {
            assert!((0.8..1.3).contains(&rms), "{rms}, correlation {correlation}");
        }
        let (friction, scatter) = sweep.half_difference().unwrap();
        assert!((friction.value - FRICTION).abs() < 5.0 * friction.std.unwrap(), "{friction:?}");
        assert!(scatter < 0.05, "{scatter}");
        // None of the other joint, which stands.
        let other =
            sweep.bins.iter().map(|bin| bin.half_difference(1).unwrap()).map(|half| half.value / half.std.unwrap());
        assert!(other.map(f64::abs).fold(0.0, f64::max) < 6.0);
    }
}

#[test]
fn apart_each_way_has_its_friction_direction_and_speed() {
    let mut recorder = Recorder::new(3, 0.0);
    recorder.stroke(-0.5, 0.5, 0.09, 0.4);
    recorder.stroke(0.5, -0.5, 0.09, 0.4);
    let sweeps = recorder.sweeps(&rule());
    let poses: Vec<_> = sweeps.found[0].poses(true).collect();
    assert_eq!(poses.len(), 2 * sweeps.found[0].bins.len());
    for pose in &poses {
        let (direction, reading) = (pose.conditions.direction[0], pose.torque[0].unwrap());
        assert!(
            (reading.value - at_rest(pose.position[0])[0] - direction * FRICTION).abs() < 5.0 * reading.std.unwrap()
        );
        assert!((pose.conditions.velocity[0] / (direction * 0.09) - 1.0).abs() < 0.05, "{:?}", pose.conditions);
        assert_eq!(pose.conditions.velocity[1], 0.0);
    }
    assert_eq!(sweeps.found[0].poses(false).next().unwrap().conditions.direction[0], 0.0);
}

#[test]
fn turning_points_and_stops_are_left_out() {
    let mut recorder = Recorder::new(4, 0.0);
    recorder.stroke(-0.5, 0.0, 0.09, 0.4);
    (0..2000).for_each(|_| recorder.row(0.0, 0.4, 0.0)); // it stops, and friction lets go
    recorder.stroke(0.0, 0.5, 0.09, 0.4);
    recorder.stroke(0.5, -0.5, 0.09, 0.4);
    let sweeps = recorder.sweeps(&rule());
    let at: Vec<f64> = sweeps.found[0].bins.iter().map(|bin| bin.sides[0].position[0]).collect();
    assert!(at.iter().all(|at| at.abs() > 0.5f64.to_radians() && at.abs() < 0.5 - 1f64.to_radians()), "{at:?}");
    assert!(at.len() > 40);
    for bin in &sweeps.found[0].bins {
        let half = bin.half_difference(0).unwrap();
        assert!((half.value - FRICTION).abs() < 5.0 * half.std.unwrap(), "{half:?}");
    }
}

#[test]
fn what_is_no_slow_sweep_is_reported() {
    let reasons = |recorder: &Recorder, rule: &SweepRule| {
        let sweeps = recorder.sweeps(rule);
        (sweeps.found.len(), sweeps.rejected.iter().map(|rejected| rejected.reason).collect::<Vec<_>>())
    };
    let mut one_way = Recorder::new(5, 0.0);
    one_way.stroke(-0.5, 0.5, 0.09, 0.4);
    assert_eq!(reasons(&one_way, &rule()), (0, vec![StrokeReason::OneWay]));
    // The other joint is elsewhere on the way back.
    one_way.stroke(0.5, -0.5, 0.09, 0.6);
    assert_eq!(reasons(&one_way, &rule()), (0, vec![StrokeReason::OneWay; 2]));
    let mut fast = Recorder::new(6, 0.0);
    fast.stroke(-0.5, 0.5, 0.4, 0.4);
    fast.stroke(0.5, -0.5, 0.4, 0.4);
    assert_eq!(reasons(&fast, &rule()), (0, vec![StrokeReason::Unsteady; 2]));
    let narrow = SweepRule { bin: 0.1f64.to_radians(), ..rule() };
    assert_eq!(reasons(&fast, &narrow), (0, vec![StrokeReason::Unsteady; 2]));
    let sliding = SweepRule { travel: vec![Travel::Slides(1.0), Travel::Turns(1.0)], ..rule() };
    assert_eq!(reasons(&one_way, &sliding), (0, vec![]));
}

/// A clock that begins anew within a stroke, and a count that jumps within another: what is whole is used, and nothing goes over them.
#[test]
fn clocks_and_counts_that_jump_do_no_harm() {
    let mut recorder = Recorder::new(7, 0.0);
    recorder.stroke(-0.6, 0.6, 0.09, 0.4);
    recorder.stroke(0.6, 0.0, 0.09, 0.4);
    recorder.time = 0.0;
    recorder.stroke(0.0, -0.6, 0.09, 0.4);
    recorder.stroke(-0.6, 0.6, 0.09, 0.4);
    recorder.stroke(0.6, -0.6, 0.09, 0.4);
    let whole = recorder.text.clone();
    let sweeps = recorder.sweeps(&rule());
    assert_eq!((sweeps.interruptions, sweeps.found.len()), (1, 2), "{:?}", sweeps.rejected);
    errors_are_small(&sweeps);
    // The other joint's count jumps in the last stroke, where joints seem to be elsewhere from then on.
    let lines: Vec<String> = whole.lines().map(str::to_owned).collect();
    let at = lines.len() - 3000;
    let jumped = lines.iter().enumerate().map(|(line, text)| {
        let mut cells: Vec<String> = text.split(',').map(str::to_owned).collect();
        if line > at {
            cells[2] = (cells[2].parse::<f64>().unwrap() + 1.0).to_string();
        }
        cells.join(",") + "\n"
    });
    recorder.text = jumped.collect();
    let sweeps = recorder.sweeps(&rule());
    assert_eq!(sweeps.found.len(), 2);
    errors_are_small(&sweeps);
    for bin in sweeps.found.iter().flat_map(|sweep| &sweep.bins).flat_map(|bin| &bin.sides) {
        assert!((bin.position[1] - 0.4).abs() < 1e-4, "{:?}", bin.position);
    }
}

fn errors_are_small(sweeps: &Sweeps) {
    for pose in sweeps.found.iter().flat_map(|sweep| sweep.poses(false)) {
        let reading = pose.torque[0].unwrap();
        assert!((reading.value - at_rest(pose.position[0])[0]).abs() < 5.0 * reading.std.unwrap(), "{pose:?}");
    }
}

/// Strokes of 8°/s at 100 Hz pass 1° in three blocks of four samples, which is one too few.
#[test]
fn bins_widen_until_they_hold_enough_samples() {
    let widening = SweepRule { widest: WIDEST_BIN, ..rule() };
    for (step, bin_deg) in [(5e-3, 1.0), (0.01, 2.0), (0.02, 4.0)] {
        let mut recorder = Recorder { step, ..Recorder::new(8, 0.0) };
        for _ in 0..3 {
            recorder.stroke(-1.0, 1.2, 8f64.to_radians(), 0.4);
            recorder.stroke(1.2, -1.0, 7f64.to_radians(), 0.4);
        }
        let sweeps = recorder.sweeps(&widening);
        assert_eq!((sweeps.found.len(), sweeps.rejected.len()), (1, 0), "{step} s: {:?}", sweeps.rejected);
        let sweep = &sweeps.found[0];
        assert!((sweep.bin.to_degrees() - bin_deg).abs() < 1e-9, "{step} s: {}", sweep.bin.to_degrees());
        assert!(sweep.bins.len() as f64 > 110.0 / bin_deg, "{step} s: {} bins", sweep.bins.len());
        let (friction, _) = sweep.half_difference().unwrap();
        assert!((friction.value - FRICTION).abs() < 5.0 * friction.std.unwrap(), "{friction:?}");
        errors_are_small(&sweeps);
    }
}

/// Nor do wide bins bend what is read: by a 25,000th at most, as they are believed to.
#[test]
fn the_widest_bins_are_as_right_as_narrow_ones() {
    let mut recorder = Recorder { step: 0.02, size: 1e-9, ..Recorder::new(9, 0.0) };
    recorder.stroke(-1.0, 1.2, 8f64.to_radians(), 0.4);
    recorder.stroke(1.2, -1.0, 8f64.to_radians(), 0.4);
    let sweeps = recorder.sweeps(&SweepRule { widest: WIDEST_BIN, ..rule() });
    let poses: Vec<_> = sweeps.found.iter().flat_map(|sweep| sweep.poses(false)).collect();
    assert!(poses.len() > 25, "{}", poses.len());
    for pose in poses {
        let off = pose.torque[0].unwrap().value - at_rest(pose.position[0])[0];
        assert!(off.abs() < 12.0 / 25_000.0, "{off} at {}", pose.position[0]);
    }
}

#[test]
fn bins_of_a_stated_width_stay_and_what_would_do_is_named() {
    let reported = |step: f64, rule: &SweepRule| {
        let mut recorder = Recorder { step, ..Recorder::new(10, 0.0) };
        recorder.stroke(-1.0, 1.2, 8f64.to_radians(), 0.4);
        recorder.stroke(1.2, -1.0, 8f64.to_radians(), 0.4);
        let sweeps = recorder.sweeps(rule);
        assert_eq!(sweeps.found.len(), 0);
        sweeps.rejected[0].to_string()
    };
    // Steps that are powers of two, so that blocks hold four samples each.
    let stated = reported(1.0 / 64.0, &SweepRule { bin: 1f64.to_radians(), widest: 1f64.to_radians(), ..rule() });
    assert!(stated.contains("the stroke of `q` has too few samples in a bin: at 8.0 deg/s and 64 Hz"), "{stated}");
    assert!(stated.contains("one of 1 deg holds 8, and 16 are needed; set readings.sweeps.bin_deg = 2.2"), "{stated}");
    let rare = reported(1.0 / 16.0, &SweepRule { widest: WIDEST_BIN, ..rule() });
    let needed = "at 8.0 deg/s and 16 Hz, one of 4 deg holds 8, and 16 are needed; move at 3.5 deg/s or less, or record at 36 Hz or more";
    assert!(rare.contains(needed), "{rare}");
}
