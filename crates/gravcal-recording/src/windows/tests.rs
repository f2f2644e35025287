//! Windows of motions that are known.

use std::f64::consts::PI;
use std::fs;
use std::path::PathBuf;

use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;

use super::*;
use crate::mapping::{PositionColumn, ReadingColumn};
use crate::rows::open;
use crate::unit::{PositionUnit, TorqueUnit};

const RATE: f64 = 200.0;

fn mapping() -> PoseMapping {
    PoseMapping {
        positions: vec![PositionColumn::new("q", PositionUnit::Radian)],
        torques: vec![Some((
            ReadingColumn { column: "tau".to_owned(), ..ReadingColumn::default() },
            TorqueUnit::NewtonMeter,
        ))],
        ..PoseMapping::default()
    }
}

fn rule() -> WindowRule {
    WindowRule {
        length: 0.32,
        moving: vec![0.02],
        presliding: Vec::new(),
        turn: vec![Some(2.0 * PI)],
        torque_lag: 0.0,
        recorded_filter: None,
        part: Part::default(),
    }
}

/// Rows of time, position and torque.
fn windows_of(rows: impl Iterator<Item = [f64; 3]>) -> Result<MotionWindows, ReadError> {
    windows_by(&rule(), rows)
}

fn windows_by(rule: &WindowRule, rows: impl Iterator<Item = [f64; 3]>) -> Result<MotionWindows, ReadError> {
    windows_as(&mapping(), rule, rows)
}

fn windows_as(
    mapping: &PoseMapping,
    rule: &WindowRule,
    rows: impl Iterator<Item = [f64; 3]>,
) -> Result<MotionWindows, ReadError> {
    let folder = tempfile::tempdir().unwrap();
    let path: PathBuf = folder.path().join("motion.csv");
    let text: String = rows.map(|[t, q, tau]| format!("{t:.17},{q:.17},{tau:.17}\n")).collect();
    fs::write(&path, format!("time_s,q,tau\n{text}")).unwrap();
    motion_windows(&path, &mut *open(&path).unwrap(), mapping, rule)
}

/// Position, velocity and acceleration of a smooth motion.
fn motion(t: f64) -> [f64; 3] {
    let part = |amplitude: f64, hz: f64, phase: f64| {
        let (w, angle) = (2.0 * PI * hz, 2.0 * PI * hz * t + phase);
        [amplitude * angle.sin(), amplitude * w * angle.cos(), -amplitude * w * w * angle.sin()]
    };
    let (a, b) = (part(0.8, 0.3, 0.1), part(0.2, 0.9, 1.0));
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn times(count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(|k| k as f64 / RATE)
}

#[test]
fn a_window_of_an_arm_that_stands_is_its_static_pose() {
    let found = windows_of(times(400).map(|t| [t, 0.7, 12.5])).unwrap();
    assert_eq!(found.found.len(), 34);
    for window in &found.found {
        assert!((window.pose.torque[0].unwrap().value - 12.5).abs() < 1e-12);
        assert!((window.pose.position[0] - 0.7).abs() < 1e-12);
        let weights: f64 = window.course.moments().map(|(weight, _)| weight).sum();
        assert!((weights - 1.0).abs() < 1e-12);
        for (_, sample) in window.course.moments() {
            assert_eq!((sample.velocity[0], sample.acceleration[0]), (0.0, 0.0));
            assert!((sample.position[0] - 0.7).abs() < 1e-15);
        }
        assert!((window.resting[0] - 1.0).abs() < 1e-12);
    }
}

/// A torque of 2 N·m that goes up and down slowly, read by a sensor that ends at 1 N·m, below or above.
#[test]
fn a_window_that_holds_a_reading_at_either_end_of_the_range_has_no_torque() {
    for side in [1.0, -1.0] {
        let torque = |t: f64| side * (2.0 * (PI * t).sin()).min(1.0);
        let mut ending = mapping();
        let (column, _) = ending.torques[0].as_mut().unwrap();
        if side > 0.0 {
            column.highest = Some(1.0)
        } else {
            column.lowest = Some(-1.0)
        }
        let found = windows_as(&ending, &rule(), times(1600).map(|t| [t, motion(t)[0], torque(t)])).unwrap().found;
        let (with, without): (Vec<_>, Vec<_>) = found.iter().partition(|window| window.pose.torque[0].is_some());
        assert!(with.len() > 20 && without.len() > 20, "{} {}", with.len(), without.len());
        assert!(without.iter().all(|window| window.pose.saturated == [0]));
        let reaches = |window: &&&MotionWindow| {
            let [from, until] = window.interval.map(|t| (t * RATE).round() as usize);
            (from + 2..until - 1).any(|row| side * torque(row as f64 / RATE) >= 1.0)
        };
        assert_eq!((with.iter().filter(reaches).count(), side), (0, side));
    }
}

/// The model is asked at the same moments, and how it moves there is kept once.
#[test]
fn windows_that_overlap_share_their_moments() {
    let found = windows_of(times(400).map(|t| [t, motion(t)[0], 0.0])).unwrap().found;
    for pair in found.windows(2) {
        let [before, after] = [0, 1].map(|place| &pair[place].course.stretches);
        let shared = |stretch: &&WeighedStretch| before.iter().any(|own| Arc::ptr_eq(&own.moments, &stretch.moments));
        let count = after.iter().filter(shared).count();
        assert!(count + 1 >= after.len().min(before.len()), "{count} of {}", after.len());
    }
}

/// Both sides of `y = q + q̇ + q̈`.
fn error_of_the_means(noise: f64) -> f64 {
    let mut random = Pcg64::seed_from_u64(3);
    let rows = times(4000).map(|t| {
        let [q, v, a] = motion(t);
        let drawn: f64 = random.sample(StandardNormal);
        [t, q + noise * drawn, q + v + a]
    });
    let found = windows_of(rows).unwrap();
    assert_eq!(found.clock, Clock::Stamps);
    difference(&found)
}

/// Root mean square of what both sides differ by.
fn difference(found: &MotionWindows) -> f64 {
    let squares = found.found.iter().map(|window| {
        let of = |(weight, sample): (f64, &MotionSample)| {
            weight * (sample.position[0] + sample.velocity[0] + sample.acceleration[0])
        };
        let model: f64 = window.course.moments().map(of).sum();
        (model - window.pose.torque[0].unwrap().value).powi(2)
    });
    (squares.sum::<f64>() / found.found.len() as f64).sqrt()
}

#[test]
fn both_sides_of_a_motion_agree() {
    let error = error_of_the_means(0.0);
    assert!(error < 1e-4, "{error}");
}

/// Rows that were held up for 0.2 s every other second, and came all at once, are those of the time before; where they are missing, the clock
/// is interrupted.
#[test]
fn a_recorder_that_stalls_is_waited_for() {
    let late = |row: usize| row % 400 < 40 && row > 400;
    let row = |(row, t): (usize, f64)| {
        let [q, v, a] = motion(t);
        let end = (row - row % 400 + 40) as f64 / RATE;
        [if late(row) { end + 2e-5 * (row % 400) as f64 } else { t + 1e-3 }, q, q + v + a]
    };
    let stalled = windows_of(times(4000).enumerate().map(row)).unwrap();
    assert_eq!(stalled.clock, Clock::Even);
    assert!(difference(&stalled) < 1e-3, "{}", difference(&stalled));
    let whole = windows_of(times(4000).map(|t| [t, motion(t)[0], 0.0])).unwrap();
    assert_eq!(stalled.found.len(), whole.found.len());
    let missing = windows_of(times(4000).enumerate().filter(|(place, _)| !late(*place)).map(row)).unwrap();
    assert!(missing.found.len() < whole.found.len() - 40, "{}", missing.found.len());
    assert!(difference(&missing) < 1e-3, "{}", difference(&missing));
}

/// Messages without content say nothing, and are counted; an arm that passes zero says that.
#[test]
fn empty_rows_are_left_out() {
    let row = |(row, t): (usize, f64)| {
        let [q, v, a] = motion(t);
        if row % 300 == 150 { [t, 0.0, 0.0] } else { [t, q, q + v + a] }
    };
    let found = windows_of(times(4000).enumerate().map(row)).unwrap();
    assert_eq!((found.empty, found.repeated), (13, 0));
    assert!(difference(&found) < 2e-3, "{}", difference(&found));
    let standing = windows_of(times(400).map(|t| [t, 0.0, 0.0])).unwrap();
    assert_eq!(standing.empty, 0);
}

#[test]
fn noise_of_an_encoder_is_smoothed_away() {
    let error = error_of_the_means(3e-4);
    assert!(error < 0.02, "{error}");
}

#[test]
fn stamps_that_jitter_are_not_believed() {
    let mut random = Pcg64::seed_from_u64(4);
    let rows: Vec<[f64; 3]> = times(2000)
        .map(|t| {
            let late: f64 = random.random_range(0.0..0.002);
            [t + late, motion(t)[0], 0.0]
        })
        .collect();
    let even = windows_of(rows.iter().copied()).unwrap();
    assert!(matches!(even.clock, Clock::Even | Clock::Rounded), "{:?}", even.clock);
    // Where rows were lost besides, they are a whole number of steps apart.
    let lost = windows_of(rows.iter().copied().enumerate().filter(|(k, _)| k % 37 != 5).map(|(_, row)| row)).unwrap();
    assert_eq!(lost.clock, Clock::Rounded);
    assert!((lost.interval - 1.0 / RATE).abs() < 1e-4, "{}", lost.interval);
}

#[test]
fn repeated_rows_are_left_out() {
    let rows = times(4000).enumerate().map(|(k, t)| {
        let sampled = (k / 2 * 2) as f64 / RATE;
        [t, motion(sampled)[0], motion(sampled)[1]]
    });
    let found = windows_of(rows).unwrap();
    // Nothing shows that the second row repeats the first: the arm may stand.
    assert_eq!(found.repeated, 1999);
    let window = &found.found[50];
    let [begin, end] = window.interval;
    // The window by its definition, of the motion itself.
    let mean = |part: usize| {
        let at = |step: usize| f64::from(u16::try_from(step).unwrap()) / 1000.0;
        let weighed =
            |step: usize| (1.0 - (2.0 * PI * at(step)).cos()) * motion(begin + at(step) * (end - begin))[part];
        (0..1000).map(weighed).sum::<f64>() / 1000.0
    };
    let modelled = |of: fn(&MotionSample) -> f64| window.course.moments().map(|(w, m)| w * of(m)).sum::<f64>();
    let (q, v) = (modelled(|moment| moment.position[0]), modelled(|moment| moment.velocity[0]));
    assert!((q - mean(0)).abs() < 1e-4 && (v - mean(1)).abs() < 1e-3, "{q} {} {v} {}", mean(0), mean(1));
}

/// A recorder that was late for 50 ms wrote ten rows at once, of one stamp: none is lost, and none is later than it was.
#[test]
fn rows_that_are_written_at_once_under_one_stamp_all_count() {
    let late = |t: f64| if (4.0..4.05).contains(&(t % 5.0)) { t - t % 5.0 + 4.05 } else { t };
    let found = windows_of(times(4000).map(|t| [late(t), motion(t)[0], motion(t)[1]])).unwrap();
    assert_eq!((found.repeated, found.interruptions), (0, 0));
    let plain = windows_of(times(4000).map(|t| [t, motion(t)[0], motion(t)[1]])).unwrap();
    assert_eq!(found.found.len(), plain.found.len());
    let means = |windows: &MotionWindows| -> Vec<f64> {
        windows
            .found
            .iter()
            .flat_map(|window| [window.pose.position[0], window.pose.torque[0].unwrap().value])
            .collect()
    };
    let apart = means(&found).iter().zip(means(&plain)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-2, "{apart}");
}

/// Two recordings in one file: the joint is elsewhere by a radian from one row to the next.
#[test]
fn a_joint_that_jumps_by_less_than_half_a_turn_is_refused_and_one_bad_row_is_not() {
    let jumps = |from: usize, until: usize| {
        let rows = times(2000).enumerate().map(move |(row, t)| {
            let more = if (from..until).contains(&row) { 1.0 } else { 0.0 };
            [t, motion(t)[0] + more, motion(t)[1]]
        });
        windows_of(rows).map(|found| found.found.len()).map_err(|error| error.to_string())
    };
    let refused = jumps(1000, 2000).unwrap_err();
    assert!(refused.contains("row 1002: `q` jumps by 0.16 of a turn"), "{refused}");
    assert!(jumps(1000, 1001).is_ok());
}

/// A reading that is off by a radian would move a joint that far and back within 20 ms.
#[test]
fn a_row_in_which_a_joint_is_elsewhere_has_its_position_from_those_beside_and_is_told() {
    let read = |off: f64| {
        let rows = times(2000)
            .enumerate()
            .map(|(row, t)| [t, motion(t)[0] + if row == 1000 { off } else { 0.0 }, motion(t)[1]]);
        windows_of(rows).unwrap()
    };
    let (right, stray) = (read(0.0), read(-1.0));
    assert_eq!(right.strays, []);
    let [Stray { joint: 0, row: 1002, turns }] = stray.strays[..] else { panic!("{:?}", stray.strays) };
    assert!((turns + 1.0 / (2.0 * PI)).abs() < 0.01, "{turns}");
    let fastest = |windows: &MotionWindows| {
        windows
            .found
            .iter()
            .flat_map(|window| window.course.moments())
            .map(|(_, at)| at.acceleration[0].abs())
            .fold(0.0, f64::max)
    };
    assert!((fastest(&stray) / fastest(&right) - 1.0).abs() < 0.01, "{} {}", fastest(&stray), fastest(&right));
    // Two recorders in one file are for others to tell.
    let alternating = times(2000).enumerate().map(|(row, t)| [t, if row % 2 == 0 { 0.3 } else { 1.0 }, 0.0]);
    assert_eq!(windows_of(alternating).unwrap().strays, []);
}

#[test]
fn a_part_beyond_the_end_is_refused_with_how_long_the_recording_is() {
    let beyond = WindowRule { part: Part { from: Some(1e6), until: None }, ..rule() };
    let refused = windows_by(&beyond, times(401).map(|t| [t, motion(t)[0], 0.0])).unwrap_err().to_string();
    let lasts = format!("it lasts {:.3} s", 400.0 / RATE);
    assert!(refused.contains(&lasts) && refused.contains("from_s = 1000000"), "{refused}");
}

#[test]
fn no_window_goes_over_a_gap() {
    let rows = times(2000).filter(|t| !(4.0..4.5).contains(t)).map(|t| [t, motion(t)[0], 0.0]);
    let found = windows_of(rows).unwrap();
    assert_eq!(found.interruptions, 1);
    assert!(found.found.iter().all(|window| window.interval[1] < 4.0 || window.interval[0] > 4.49));
}

#[test]
fn clocks_that_run_backwards_and_slow_recordings_are_refused() {
    let rows = times(400).map(|t| [if t > 1.0 { t - 0.5 } else { t }, motion(t)[0], 0.0]);
    let error = windows_of(rows).unwrap_err().to_string();
    assert!(error.contains("row 203: the clock `time_s` runs backwards, from 1.000000 to 0.505000 s"), "{error}");
    let rows = (0..100).map(|k| [f64::from(k) / 5.0, motion(f64::from(k) / 5.0)[0], 0.0]);
    let error = windows_of(rows).unwrap_err().to_string();
    let slow = "by its clock `time_s` rows come at 5 Hz, too seldom for windows of 0.32 s; record at 25 Hz or more, or take longer windows";
    assert!(error.contains(slow) && error.contains("window_s = 1.60"), "{error}");
    let error = windows_of(times(30).map(|t| [t, motion(t)[0], 0.0])).unwrap_err().to_string();
    assert!(error.contains("it has no 0.32 s without an interruption"), "{error}");
}

/// A recorder that stamps ten rows when it gets them, one after the other.
#[test]
fn rows_in_bursts_are_told_with_their_clock() {
    let stamp = |k: u32| 0.1 * f64::from(k / 10) + 1e-5 * f64::from(k % 10);
    let rows = (0..1000).map(|k| [stamp(k), motion(f64::from(k) / 100.0)[0], 0.0]);
    let error = windows_of(rows).unwrap_err().to_string();
    let bursts = "by its clock `time_s` rows come in bursts of about 10, 0.100 s apart (100 Hz in all)";
    assert!(
        error.contains(bursts) && error.contains("name a column with the times at which they were measured"),
        "{error}"
    );
}

/// The same at once, under one stamp: rows are as far apart as they were sampled, and all are as late.
#[test]
fn bursts_of_one_stamp_are_as_good_as_the_times_of_their_rows() {
    let sampled = |k: u32| f64::from(k) / 100.0;
    let windows = |stamp: &dyn Fn(u32) -> f64| {
        windows_of((0..1000).map(|k| [stamp(k), motion(sampled(k))[0], torque(sampled(k))])).unwrap()
    };
    let (bursts, plain) = (windows(&|k| 0.1 * f64::from(k / 10)), windows(&sampled));
    assert_eq!((bursts.found.len(), bursts.repeated), (plain.found.len(), 0));
    for (burst, plain) in bursts.found.iter().zip(&plain.found) {
        let [a, b] = [burst, plain].map(|window| (window.pose.torque[0].unwrap().value, window.pose.position[0]));
        // A row at the edge of a window falls to either side of it: torques reach 8.
        assert!((a.0 - b.0).abs() < 1e-2 && (a.1 - b.1).abs() < 1e-3, "{a:?} {b:?}");
        assert!((burst.interval[0] - plain.interval[0] + 0.09).abs() < 1e-9);
    }
}

/// What an arm in motion reads of `y = q + q̇ + q̈`.
fn torque(t: f64) -> f64 {
    motion(t).iter().sum()
}

#[test]
fn torques_that_come_late_are_asked_for_later() {
    for lag in [0.05, -0.03] {
        let rows = || times(4000).map(move |t| [t, motion(t)[0], torque(t - lag)]);
        let of = |torque_lag: f64| windows_by(&WindowRule { torque_lag, ..rule() }, rows()).unwrap();
        assert!(difference(&of(0.0)) > 0.05, "{}", difference(&of(0.0)));
        assert!(difference(&of(lag)) < 1e-4, "{}", difference(&of(lag)));
        // Nothing of it lies outside of the recording.
        let [first, last] = [of(lag).found.first().cloned().unwrap(), of(lag).found.last().cloned().unwrap()];
        assert!(first.interval[0] >= 0.0 && last.interval[1] <= 20.0, "{:?} {:?}", first.interval, last.interval);
        assert!((first.interval[1] - first.interval[0] - 0.32 - lag.abs()).abs() < 1e-12);
    }
}

#[test]
fn torques_that_a_recorder_filtered_meet_a_model_that_is_filtered_alike() {
    // A Hann window of 0.8 s passes half of the power at 0.9 Hz.
    let filtered = |t: f64| {
        let part = |step: usize| {
            let share = step as f64 / 64.0;
            (1.0 - (2.0 * PI * share).cos()) / 64.0 * torque(t + 0.8 * (share - 0.5))
        };
        (0..64).map(part).sum::<f64>()
    };
    let rows = || times(4000).map(|t| [t, motion(t)[0], filtered(t)]);
    let of = |cut_off: Option<f64>| windows_by(&WindowRule { recorded_filter: cut_off, ..rule() }, rows()).unwrap();
    let (without, with) = (difference(&of(None)), difference(&of(Some(FILTER_LENGTH / 0.8))));
    assert!(without > 0.5 && with < 1e-3, "{without} {with}");
    let weights: f64 = of(Some(0.9)).found[3].course.moments().map(|(weight, _)| weight).sum();
    assert!((weights - 1.0).abs() < 1e-12);
}

#[test]
fn angles_that_wrap_go_on() {
    let turning = |t: f64| 2.5 * t + 0.3 * (3.0 * t).sin();
    let wrapped = |q: f64| (q + PI).rem_euclid(2.0 * PI) - PI;
    let found = windows_of(times(2000).map(|t| [t, wrapped(turning(t)), 0.0])).unwrap();
    assert_eq!(found.wraps, [4]);
    let plain = windows_of(times(2000).map(|t| [t, turning(t), 0.0])).unwrap();
    assert_eq!(plain.wraps, [0]);
    assert_eq!(found.found.len(), plain.found.len());
    for (a, b) in found.found.iter().zip(&plain.found) {
        assert!((a.pose.position[0] - b.pose.position[0]).abs() < 1e-9);
        for ((_, a), (_, b)) in a.course.moments().zip(b.course.moments()) {
            assert!((a.acceleration[0] - b.acceleration[0]).abs() < 1e-4);
        }
    }
    // A joint that slides has no turn.
    let slides = WindowRule { turn: vec![None], ..rule() };
    assert_eq!(windows_by(&slides, times(2000).map(|t| [t, 4.0 * (t > 1.0) as u8 as f64, 0.0])).unwrap().wraps, [0]);
}

#[test]
fn joints_that_jump_are_refused() {
    let rows = times(1000).enumerate().map(|(k, t)| [t, motion(t)[0] + if k == 500 { 4.5 } else { 0.0 }, 0.0]);
    let error = windows_of(rows).unwrap_err().to_string();
    assert!(error.contains("row 502: `q` jumps by 0.7") && error.contains("delete the row"), "{error}");
}

#[test]
fn recordings_without_a_clock_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("motion.csv");
    fs::write(&path, "q,tau\n1,2\n1,3\n").unwrap();
    let error = motion_windows(&path, &mut *open(&path).unwrap(), &mapping(), &rule()).unwrap_err().to_string();
    assert!(error.contains("there is no column `time_s`, and without a clock"), "{error}");
    assert!(error.contains("readings.time = {") && error.contains("the columns are `q`, `tau`"), "{error}");
}

/// Friction keeps its sign until a joint stands, and turns in the middle of a rest.
#[test]
fn the_sign_of_a_motion_lasts_while_a_joint_rests() {
    let way = |t: f64| if t < 2.0 { t - 2.0 } else { f64::max(0.0, t - 3.0) };
    let found = windows_of(times(1000).map(|t| [t, way(t).abs().powi(3) / 3.0, t])).unwrap();
    let near = |t: f64| {
        let distance = |window: &&MotionWindow| ((window.interval[0] + 0.16 - t).abs() * 1e6) as u64;
        found.found.iter().min_by_key(distance).unwrap()
    };
    for (time, sign) in [(1.0, -1.0), (2.2, -1.0), (2.8, 1.0)] {
        let direction = near(time).pose.conditions.direction[0];
        assert!((direction - sign).abs() < 1e-9, "{time}: {direction}");
    }
    assert!(near(2.5).pose.conditions.direction[0].abs() < 0.4);
    assert!(near(2.5).resting[0] > 0.99 && near(4.0).resting[0] < 0.01);
}
