use std::collections::BTreeMap;

use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;

use super::*;
use crate::conditions::{ConditionColumns, FurtherColumn};
use crate::mapping::{PositionColumn, ReadingColumn};
use crate::rows::Row;
use crate::unit::{PositionUnit, TorqueUnit};

/// Rows that stand in memory.
struct Given {
    columns: Vec<String>,
    rows: std::vec::IntoIter<Vec<f64>>,
    number: u64,
}

impl Rows for Given {
    fn columns(&self) -> &[String] {
        &self.columns
    }

    fn read(&mut self, row: &mut Row) -> Result<bool, ReadError> {
        let Some(cells) = self.rows.next() else { return Ok(false) };
        self.number += 1;
        *row = Row { number: self.number, cells };
        Ok(true)
    }

    fn source(&self) -> crate::rows::Source {
        crate::rows::Source::default()
    }

    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }

    fn metadata(&self) -> BTreeMap<String, String> {
        BTreeMap::new()
    }

    fn progress(&self) -> f64 {
        0.0
    }
}

/// An arm of two joints that stands at places for a time each, and moves smoothly between them.
#[derive(Clone, Debug)]
struct Recording {
    rate: f64,
    /// Places of both joints, and for how long they stand, s.
    stands: Vec<([f64; 2], f64)>,
    /// Time of each motion, s.
    motion: f64,
    /// Noise of a sample: of positions, of torques.
    noise: [f64; 2],
    /// Of first-order noise from sample to sample.
    correlation: f64,
    /// Steps of positions and of torques.
    step: [f64; 2],
    /// Of the torques after each motion, and its time constant, s.
    settling: (f64, f64),
    seed: u64,
}

impl Default for Recording {
    fn default() -> Recording {
        let places = [[0.0, 0.5], [0.4, 0.5], [0.4, -0.3], [1.0, 0.2], [0.7, 0.9], [-0.5, 0.0], [0.1, 0.1], [0.3, 0.6]];
        Recording {
            rate: 1000.0,
            stands: places.map(|place| (place, 0.4)).into(),
            motion: 0.3,
            noise: [1e-4, 0.5],
            correlation: 0.0,
            step: [0.0, 0.0],
            settling: (0.0, 0.05),
            seed: 1,
        }
    }
}

/// First and last time of a true standstill, and the noiseless readings in it.
type Truth = ([f64; 2], [f64; 4]);

impl Recording {
    /// Readings without noise where the joints are.
    fn readings(at: [f64; 2]) -> [f64; 4] {
        [at[0], at[1], 30.0 * at[0].sin(), 10.0 * at[1].cos() + 2.0]
    }

    fn rows(&self) -> (Vec<Vec<f64>>, Vec<Truth>) {
        let mut random = Pcg64::seed_from_u64(self.seed);
        let mut noise = [0.0; 4];
        let (mut rows, mut truths, mut time) = (Vec::new(), Vec::new(), 0.0);
        let mut from = self.stands[0].0;
        for (place, duration) in &self.stands {
            let arrival = time + self.motion;
            let end = arrival + duration;
            while time < end {
                let share = ((time - arrival + self.motion) / self.motion).clamp(0.0, 1.0);
                let smooth = share.powi(3) * (10.0 - 15.0 * share + 6.0 * share * share);
                let at = [0, 1].map(|joint| from[joint] + smooth * (place[joint] - from[joint]));
                let mut cells = vec![time];
                for (channel, reading) in Recording::readings(at).into_iter().enumerate() {
                    let kind = channel / 2;
                    let white: f64 = random.sample(StandardNormal);
                    noise[channel] = self.correlation * noise[channel]
                        + (1.0 - self.correlation.powi(2)).sqrt() * self.noise[kind] * white;
                    let settling = if kind == 1 && time > arrival && !truths.is_empty() {
                        self.settling.0 * (-(time - arrival) / self.settling.1).exp()
                    } else {
                        0.0
                    };
                    let value = reading + noise[channel] + settling;
                    let step = self.step[kind];
                    cells.push(if step > 0.0 { step * (value / step).round() } else { value });
                }
                rows.push(cells);
                time = rows.len() as f64 / self.rate;
            }
            // The arm stands from the beginning.
            let begin = if truths.is_empty() { 0.0 } else { arrival };
            truths.push(([begin, end], Recording::readings(*place)));
            from = *place;
        }
        (rows, truths)
    }

    fn found(&self) -> (Standstills, Vec<Truth>) {
        let (rows, truths) = self.rows();
        (found_in(rows), truths)
    }
}

fn mapping() -> PoseMapping {
    let position = |name: &str| PositionColumn::new(name, PositionUnit::Radian);
    let torque = |name: &str| {
        Some((ReadingColumn { column: name.to_owned(), ..ReadingColumn::default() }, TorqueUnit::NewtonMeter))
    };
    PoseMapping {
        positions: ["p", "q"].map(position).into(),
        torques: ["x", "y"].map(torque).into(),
        ..PoseMapping::default()
    }
}

fn find(rows: Vec<Vec<f64>>, mapping: &PoseMapping, stillness: &Stillness) -> Result<Standstills, ReadError> {
    let columns = ["time_s", "p", "q", "x", "y", "oil"].map(str::to_owned).into();
    let mut given = Given { columns, rows: rows.into_iter(), number: 0 };
    static_poses(Path::new("a.mcap"), &mut given, mapping, stillness)
}

fn found_in(rows: Vec<Vec<f64>>) -> Standstills {
    find(rows, &mapping(), &Stillness::default()).unwrap()
}

/// All means and standard errors of a pose with the noiseless ones.
fn compared(standstill: &Standstill, truth: &Truth) -> Vec<(f64, f64)> {
    let positions = standstill.pose.position.iter().zip(&standstill.position).map(|(mean, spread)| (*mean, spread));
    let torques = standstill.pose.torque.iter().zip(&standstill.torque);
    let torques = torques.map(|(reading, spread)| (reading.unwrap().value, spread.as_ref().unwrap()));
    positions.chain(torques).zip(truth.1).map(|((mean, spread), truth)| (mean - truth, spread.standard_error)).collect()
}

#[track_caller]
fn assert_all_found(found: &Standstills, truths: &[Truth]) {
    assert_eq!(found.found.len(), truths.len(), "{:?}\n{:#?}", found.rejected, found.found);
    for (standstill, truth) in found.found.iter().zip(truths) {
        let [from, until] = standstill.interval;
        assert!(truth.0[0] - 0.01 <= from && until <= truth.0[1], "{:?} {:?}", standstill.interval, truth.0);
        for (error, std) in compared(standstill, truth) {
            assert!(error.abs() <= 4.5 * std, "{error} ± {std} in {truth:?}");
        }
    }
}

#[test]
fn every_standstill_is_found_without_options() {
    let (found, truths) = Recording::default().found();
    assert_all_found(&found, &truths);
    assert_eq!(found.rejected, []);
    let directions: Vec<&[f64]> = found.found.iter().map(|found| &found.pose.conditions.direction[..]).collect();
    assert_eq!(directions[..4], [[0.0, 0.0], [1.0, 0.0], [1.0, -1.0], [1.0, 1.0]]);
}

/// Means of equal numbers differ by rounding errors, of which no noise tells the size.
#[test]
fn a_joint_that_says_one_number_stands() {
    let held = -std::f64::consts::FRAC_PI_2;
    let stands: Vec<([f64; 2], f64)> = (0..19).map(|k| ([0.1 * f64::from(k), held], 0.377)).collect();
    for seed in 0..10 {
        let recording = Recording { stands: stands.clone(), noise: [0.0, 0.5], seed, ..Recording::default() };
        let (found, truths) = recording.found();
        assert_eq!(found.rejected, []);
        assert_eq!(found.found.len(), truths.len());
        assert!(found.found.iter().all(|found| (found.pose.position[1] - held).abs() < 1e-14));
    }
}

/// What many recordings of varied noise and speed come to.
#[derive(Debug, Default)]
struct Tally {
    truths: usize,
    found: usize,
    wrong: usize,
    /// Squares of errors over standard errors, of positions and of torques.
    squares: [f64; 2],
    rejected: usize,
}

fn varied(seed: u64) -> Recording {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut between = |low: f64, high: f64| low * (high / low).powf(random.random_range(0.0..1.0));
    let noise = [between(1e-5, 1e-3), between(0.05, 1.0)];
    let rate = between(100.0, 2000.0);
    let stand = between(0.4, 1.5) * (1000.0 / rate).max(1.0).sqrt();
    let motion = between(0.2, 2.0);
    let correlation = if seed.is_multiple_of(3) { (-1.0 / (rate * between(0.0005, 0.004))).exp() } else { 0.0 };
    let step = if seed.is_multiple_of(2) { [between(1e-6, 1e-3), between(0.01, 1.0)] } else { [0.0; 2] };
    let settling = (between(0.1, 20.0), between(0.01, 0.05));
    let stands = (0..12).map(|_| ([random.random_range(-1.5..1.5), random.random_range(-1.5..1.5)], stand)).collect();
    Recording { rate, stands, motion, noise, correlation, step, settling, seed }
}

fn tallied(recordings: impl Iterator<Item = Recording>) -> Tally {
    let mut tally = Tally::default();
    for recording in recordings {
        let (found, truths) = recording.found();
        tally.truths += truths.len();
        tally.rejected += found.rejected.len();
        for standstill in &found.found {
            let [from, until] = standstill.interval;
            let shared = |truth: &&Truth| until.min(truth.0[1]) - from.max(truth.0[0]) > 0.5 * (until - from);
            let Some(truth) = truths.iter().find(shared) else {
                tally.wrong += 1;
                continue;
            };
            tally.found += 1;
            for (index, (error, std)) in compared(standstill, truth).into_iter().enumerate() {
                tally.squares[index / 2] += 0.5 * (error / std).powi(2);
            }
        }
    }
    tally
}

/// White and correlated noise, with and without converters, from 100 Hz to 2 kHz, slow and fast, settling more or less.
#[test]
fn of_varied_recordings_nearly_all_standstills_are_found_with_true_standard_errors() {
    let tally = tallied((0..150).map(varied));
    assert!(tally.found as f64 > 0.99 * tally.truths as f64 && tally.wrong == 0, "{tally:?}");
    let rms = tally.squares.map(|sum| (sum / tally.found as f64).sqrt());
    assert!(rms.iter().all(|rms| (0.9..1.1).contains(rms)), "{rms:?}");
}

/// Means and standard errors of all poses, pose by pose.
fn means(found: &Standstills) -> Vec<Vec<(f64, f64)>> {
    let zero = ([0.0; 2], [0.0; 4]);
    found.found.iter().map(|standstill| compared(standstill, &zero)).collect()
}

/// By how many of its standard errors a mean changes at most.
#[track_caller]
fn largest_change(a: &Standstills, b: &Standstills) -> f64 {
    assert_eq!(a.found.len(), b.found.len(), "{:?}", b.rejected);
    let (a, b) = (means(a), means(b));
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.map(|((a, std), (b, _))| (a - b).abs() / std).fold(0.0, f64::max)
}

#[test]
fn outliers_and_dropped_messages_change_no_mean_by_its_standard_error() {
    let (rows, _) = Recording::default().rows();
    let mut random = Pcg64::seed_from_u64(7);
    let mut dirty = rows.clone();
    for row in &mut dirty {
        for cell in &mut row[1..] {
            if random.random_range(0.0..1.0) < 0.01 {
                *cell += random.random_range(-5.0..5.0);
            }
        }
    }
    dirty.retain(|_| random.random_range(0.0..1.0) > 0.05);
    let change = largest_change(&found_in(rows), &found_in(dirty));
    assert!(change < 1.0, "{change}");
}

#[test]
fn a_touched_standstill_is_rejected_with_the_reason() {
    let (mut rows, truths) = Recording::default().rows();
    let [from, _] = truths[3].0;
    let touched = |row: &&mut Vec<f64>| (from + 0.2..from + 0.25).contains(&row[0]);
    rows.iter_mut().filter(touched).for_each(|row| row[3] += 3.0);
    let found = found_in(rows);
    assert_eq!(found.found.len(), truths.len() - 1);
    let [Rejected { reason: Reason::Touched { column, at }, .. }] = &found.rejected[..] else {
        panic!("{:?}", found.rejected)
    };
    assert_eq!(column, "x");
    assert!((at - from - 0.2).abs() < 0.05, "{at} {from}");
    assert!(found.rejected[0].reason.to_string().contains("as if the arm were touched"));
}

#[test]
fn a_pushed_joint_that_comes_back_is_rejected() {
    let (mut rows, truths) = Recording::default().rows();
    let [from, _] = truths[3].0;
    let pushed = |row: &&mut Vec<f64>| (from + 0.18..from + 0.22).contains(&row[0]);
    rows.iter_mut().filter(pushed).for_each(|row| row[1] += 0.01);
    let found = found_in(rows);
    assert_eq!(found.found.len(), truths.len() - 1, "{:?}", found.rejected);
    assert!(
        found
            .rejected
            .iter()
            .any(|rejected| matches!(&rejected.reason, Reason::Touched { column, .. } if column == "p"))
    );
}

#[test]
fn what_settles_is_cut_off_and_what_creeps_to_the_end_is_rejected() {
    let settling = Recording { settling: (20.0, 0.03), ..Recording::default() };
    let (found, truths) = settling.found();
    assert_all_found(&found, &truths);
    assert!(found.found[1..].iter().zip(&truths[1..]).all(|(found, truth)| found.interval[0] > truth.0[0] + 0.08));
    let creeping = Recording { settling: (20.0, 0.4), ..Recording::default() };
    let (found, _) = creeping.found();
    assert_eq!(found.found.len(), 1, "only the first, before anything moved: {found:#?}");
    assert_eq!(found.rejected.len(), 7, "{:?}", found.rejected);
}

#[test]
fn a_slow_motion_is_no_standstill_and_a_slow_drift_of_a_sensor_is_one() {
    let (mut rows, truths) = Recording::default().rows();
    let mut drifting = rows.clone();
    // A degree a second is plain motion; a ninth of that has to be looked at; a tenth of the noise a second is a sensor's.
    rows.iter_mut().for_each(|row| row[1] += 0.017 * row[0]);
    let found = found_in(rows);
    assert_eq!((found.found, found.rejected), (Vec::new(), Vec::new()));
    for seed in 1..=12 {
        let (mut creeping, _) = Recording { seed, ..Recording::default() }.rows();
        creeping.iter_mut().for_each(|row| row[1] += 2e-3 * row[0]);
        let found = found_in(creeping);
        // The noise hides the slope of a tenth of a second now and then, and never that of the 0.4 s that the arm stands.
        assert!(found.found.iter().all(|found| found.interval[1] - found.interval[0] < 0.15), "{seed}: {found:#?}");
        let moves = |rejected: &Rejected| matches!(&rejected.reason, Reason::Moving { column } if column == "p");
        assert!(!found.rejected.is_empty() && found.rejected.iter().all(moves), "{seed}: {found:#?}");
        assert!(found.found.is_empty() || seed != 2, "{found:#?}");
    }
    drifting.iter_mut().for_each(|row| row[3] += 0.05 * row[0]);
    assert_eq!(found_in(drifting).found.len(), truths.len());
}

/// One that creeps hardly moves for a moment and then moves on, all the time; one that stands does not, and neither does one in plain motion.
#[test]
fn a_joint_that_creeps_moves_on_many_times() {
    for seed in 1..=6 {
        let (rows, truths) = Recording { seed, ..Recording::default() }.rows();
        let moved_on = |speeds: [f64; 2]| {
            let mut rows = rows.clone();
            rows.iter_mut().for_each(|row| (0..2).for_each(|joint| row[1 + joint] += speeds[joint] * row[0]));
            let found = found_in(rows);
            (found.found.len(), [found.moved_on[0], found.moved_on[1]])
        };
        assert_eq!(moved_on([0.0; 2]), (truths.len(), [0, 0]), "{seed}");
        let (found, [first, second]) = moved_on([0.01, 0.0]);
        assert!(found == 0 && first > 20 && second < 5, "{seed}: {found} {first} {second}");
        let (found, [first, second]) = moved_on([0.0, 0.01]);
        assert!(found == 0 && first < 5 && second > 20, "{seed}: {found} {first} {second}");
        let (_, in_motion) = moved_on([0.05, 0.05]);
        assert!(in_motion[0] + in_motion[1] < 5, "{seed}: {in_motion:?}");
    }
}

#[test]
fn repeated_rows_missing_cells_and_a_jumping_clock_do_no_harm() {
    let (rows, truths) = Recording::default().rows();
    let clean = found_in(rows.clone());
    let repeated: Vec<Vec<f64>> = rows.iter().flat_map(|row| [row.clone(), row.clone()]).collect();
    let found = found_in(repeated);
    assert_eq!((found.repeated as usize, &found.found.len()), (rows.len(), &clean.found.len()));
    assert!(largest_change(&clean, &found) < 0.5);

    let mut missing = rows.clone();
    missing.iter_mut().step_by(3).for_each(|row| row[4] = f64::NAN);
    missing.iter_mut().step_by(50).for_each(|row| row[0] = f64::NAN);
    let found = found_in(missing);
    assert_eq!(found.without_time as usize, rows.len().div_ceil(50));
    assert_all_found(&found, &truths);
    assert!(found.found[0].torque[1].unwrap().samples < 0.7 * found.found[0].torque[0].unwrap().samples);

    // An hour back in the middle of a standstill: two poses.
    let middle = 0.5 * (truths[2].0[0] + truths[2].0[1]);
    let mut jumping = rows;
    jumping.iter_mut().filter(|row| row[0] > middle).for_each(|row| row[0] -= 3600.0);
    let found = found_in(jumping);
    assert_eq!((found.interruptions, found.found.len()), (1, truths.len() + 1), "{:?}", found.rejected);
}

#[test]
fn joints_may_be_in_different_messages_and_appear_midway() {
    let (rows, truths) = Recording::default().rows();
    // Joint q and its torque are in messages of their own, a fifth as often, and begin in the middle of the third standstill.
    let begin = truths[2].0[0] + 0.2;
    let mut split = Vec::new();
    for (index, row) in rows.iter().enumerate() {
        split.push(vec![row[0], row[1], f64::NAN, row[3], f64::NAN]);
        if index % 5 == 0 && row[0] > begin {
            split.push(vec![row[0] + 2e-4, f64::NAN, row[2], f64::NAN, row[4]]);
        }
    }
    let found = found_in(split);
    assert_eq!(found.found.len(), truths.len() - 2, "{:?}", found.rejected);
    assert!(
        found.rejected.iter().all(|r| r.reason == Reason::NoPosition { column: "q".to_owned() }),
        "{:?}",
        found.rejected
    );
    let [fast, slow] = [0, 1].map(|joint| found.found[3].torque[joint].unwrap().samples);
    assert!((fast / slow - 5.0).abs() < 0.8, "{fast} {slow}");
}

#[test]
fn saturated_readings_are_none_and_single_outliers_at_an_end_do_not_saturate() {
    let (rows, _) = Recording::default().rows();
    let mut mapped = mapping();
    // Only the fourth place needs more than 21 N·m.
    mapped.torques[0].as_mut().unwrap().0.highest = Some(21.0);
    let mut cut = rows;
    cut.iter_mut().for_each(|row| row[3] = row[3].min(21.0));
    cut.iter_mut().step_by(211).for_each(|row| row[3] = 21.0);
    let found = find(cut, &mapped, &Stillness::default()).unwrap();
    let saturated: Vec<usize> = (0..8).filter(|pose| !found.found[*pose].pose.saturated.is_empty()).collect();
    assert_eq!(saturated, [3]);
    assert_eq!(found.found[3].pose.torque[0], None);
}

#[test]
fn only_the_part_that_is_asked_for_is_looked_at_and_short_standstills_may_be_left_out() {
    let (rows, truths) = Recording::default().rows();
    let part = Part { from: Some(truths[2].0[0]), until: Some(truths[5].0[1]) };
    let stillness = Stillness { part, ..Stillness::default() };
    assert_eq!(find(rows.clone(), &mapping(), &stillness).unwrap().found.len(), 4);
    let longer = Stillness { least_duration: Some(0.6), ..Stillness::default() };
    assert_eq!(find(rows, &mapping(), &longer).unwrap().found.len(), 1);
}

/// Where joints turn round an arm stands for a moment, and holds the friction of motion: that is no pose, unless such are asked for.
#[test]
fn moments_in_which_joints_turn_round_are_left_out() {
    let mut turning = Recording::default();
    turning.stands.iter_mut().for_each(|stand| stand.1 = 1.2);
    turning.stands.insert(3, ([0.45, -0.3], 0.25));
    turning.stands.insert(6, ([0.75, 0.25], 0.25));
    let (rows, _) = turning.rows();
    let found = find(rows.clone(), &mapping(), &Stillness::default()).unwrap();
    let brief = found.rejected.iter().filter(|one| matches!(one.reason, Reason::Brief { usual } if usual > 0.9));
    assert_eq!((found.found.len(), brief.count()), (8, 2), "{:?}", found.rejected);
    assert!(found.rejected.iter().any(|one| one.to_string().contains("for a moment only")), "{:?}", found.rejected);
    let stated = Stillness { least_duration: Some(0.1), ..Stillness::default() };
    assert_eq!(find(rows, &mapping(), &stated).unwrap().found.len(), 10);
}

#[test]
fn what_is_missing_is_reported() {
    let (rows, _) = Recording::default().rows();
    let mut wrong = mapping();
    wrong.positions[1].column = "r".to_owned();
    let error = find(rows, &wrong, &Stillness::default()).unwrap_err().to_string();
    assert!(error.starts_with("a.mcap: there is no column `r`"), "{error}");
    let error = find(Vec::new(), &mapping(), &Stillness::default()).unwrap_err().to_string();
    assert_eq!(
        error,
        "a.mcap: no two rows have readings and different times by its clock `time_s`, so that neither rates nor motion can be told; name the \
         column of the times (readings.time = { column = \"…\", unit = \"s\" }), or record them"
    );
}

/// An encoder that loses its count while the arm stands: no mean goes over the jump, and all else is found as without it.
#[test]
fn a_count_that_jumps_parts_a_standstill_and_nothing_else() {
    let (mut rows, truths) = Recording::default().rows();
    let jump = 0.5 * (truths[3].0[0] + truths[3].0[1]);
    rows.iter_mut().filter(|row| row[0] >= jump).for_each(|row| row[1] += 2.5);
    let found = found_in(rows);
    let over = |standstill: &&Standstill| standstill.interval[0] < jump && jump < standstill.interval[1];
    assert_eq!(found.found.iter().filter(over).count(), 0);
    for (index, truth) in truths.iter().enumerate().filter(|(index, _)| *index != 3) {
        let within = |s: &&Standstill| s.interval[0] >= truth.0[0] - 0.02 && s.interval[1] <= truth.0[1] + 0.02;
        let same = found.found.iter().find(within).unwrap_or_else(|| panic!("{index}: {:?}", found.rejected));
        let expected = truth.1[0] + if index > 3 { 2.5 } else { 0.0 };
        assert!((same.pose.position[0] - expected).abs() < 1e-4, "{index}");
    }
}

/// Torques come in rows of their own, 33 a second beside 100 of positions: the arm stands too short for them, and that is said, not that it
/// moves.
#[test]
fn a_stand_too_short_for_the_slower_column_is_told_as_that() {
    let stands = (0..8).map(|place| ([0.1 * f64::from(place), 0.5], 0.9)).collect();
    let (rows, _) = Recording { rate: 100.0, stands, motion: 1.0, ..Recording::default() }.rows();
    let mut split = Vec::new();
    for (index, row) in rows.iter().enumerate() {
        split.push(vec![row[0], row[1], row[2], f64::NAN, f64::NAN]);
        if index % 3 == 0 {
            split.push(vec![row[0] + 2e-4, f64::NAN, f64::NAN, row[3], row[4]]);
        }
    }
    let found = found_in(split);
    let is_short = |rejected: &&Rejected| matches!(&rejected.reason, Reason::Short { samples, .. } if *samples < 40);
    let short: Vec<&Rejected> = found.rejected.iter().filter(is_short).collect();
    assert!(short.len() > 4 && short[0].to_string().contains("let the arm stand for 1."), "{found:#?}");
    assert!(!found.rejected.iter().any(|rejected| matches!(rejected.reason, Reason::Moving { .. })), "{found:#?}");
    let (column, rate) = found.clock.seldom.unwrap();
    assert!(["x", "y"].contains(&column.as_str()) && (rate - 33.3).abs() < 1.0, "{column} {rate}");
}

/// A further column on a topic of its own, with a clock of its own and a row every two seconds.
#[test]
fn a_further_column_that_comes_seldom_is_as_it_was_last() {
    let further = vec![FurtherColumn { name: "oil".into(), column: "oil".into(), may_be_empty: false }];
    let mapping = PoseMapping { conditions: ConditionColumns { further, ..Default::default() }, ..mapping() };
    let (rows, truths) = Recording::default().rows();
    let nothing = f64::NAN;
    let alone: Vec<Vec<f64>> = rows.iter().map(|cells| [&cells[..], &[nothing]].concat()).collect();
    let mut both = Vec::new();
    for (index, cells) in alone.iter().enumerate() {
        if index % 2000 == 1000 {
            both.push(vec![1e9 + cells[0], nothing, nothing, nothing, nothing, index as f64]);
        }
        both.push(cells.clone());
    }
    let found = find(both, &mapping, &Stillness::default()).unwrap();
    assert_all_found(&found, &truths);
    assert!(found.clock.doubt().is_none() && found.interruptions == 0, "{:?}", found.clock);
    for standstill in &found.found {
        // At 1 kHz; nothing before the first, and the mean where a new one comes.
        let rows = standstill.interval.map(|time| 1000.0 * time);
        let last = rows.map(|row| ((row - 1000.0) / 2000.0).floor() * 2000.0 + 1000.0);
        let oil = standstill.pose.conditions.further[0];
        match rows[1] < 1000.0 {
            true => assert!(oil.is_nan()),
            false => assert!(oil <= last[1] + 1.0 && (oil >= last[0] - 1.0 || rows[0] < 1000.0), "{oil} {rows:?}"),
        }
    }
}
