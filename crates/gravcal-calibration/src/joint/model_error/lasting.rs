//! Errors that last as long as a joint stands: one unknown of each stay.
//!
//! ```text
//!     y_i = k τ_i + b + e_s + ε_i,      e_s ~ N(0, v)      s: the stay of the joint in which pose i is
//! ```
//!
//! Where poses differ in some joints only, the others stand: what static friction holds in them stays the same until they move. Counted anew in each
//! row, an error of many rows would pass for many. So where residuals of rows of one stay are alike by more than chance, each stay of several
//! rows has an unknown, whose variance `v` is that of its joint. It is found as noise is, by what is left of it when the unknowns have taken up
//! their part (restricted likelihood's fixed point: Harville, *Journal of the American Statistical Association* 72, 1977, on Henderson's mixed-model equations):
//!
//! ```text
//!     v = Σ ê² / Σ (1 − c/v)            c: variance of ê that is left, with its prior v
//! ```
//!
//! A row that is a stay by itself has `ê = ρ r`, `1 − c/v = ρ (1 − h)` with `ρ = v/(v + σ²)`, residual r, leverage h and the variance σ² of its noise.

use std::sync::Arc;

use gravcal_estimation::{Block, BlockId, EvaluateError, Loss, ProblemBuilder, Residual, Values};
use gravcal_identification::{ChannelNoise, ReadingResidual, RowResidual, noise_by_median, noise_by_squares};
use gravcal_robot_model::number::significant;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::residuals::{Shift, Shifted};
use gravcal_robot_model::session::{ReadingId, Session};

use crate::joint::measurement_set::MeasurementSet;
use crate::joint::model_error::sides_by_order::stands_still;
use crate::joint::order::Order;
use crate::joint::solved::Solved;
use crate::joint::solving::noise::errors_found;
use crate::joint::stays::{Lasting, Stay};
use crate::joint::variables::VariableIndex;

/// More stays have no unknowns: all are in one piece with the rest, and time grows with their cube.
const MOST: usize = 400;
/// A residual counts as so many standard deviations at most: outliers that are all to one side are alike in any stay.
const CLIPPED: f64 = 2.0;
/// Fewest pairs of rows of one stay that say whether their residuals are alike.
const LEAST_PAIRS: usize = 10;
/// Standard deviations of chance beyond which they are.
const BEYOND_CHANCE: f64 = 4.0;
/// Errors with less of the variance of their joint's noise are none.
const NEGLIGIBLE: f64 = 1e-3;
/// What has more than this share of its prior's variance left, other unknowns took up: it tells nothing.
const NOTHING_LEFT: f64 = 0.99;
/// The part of the variance of residuals that begins as that of errors that last, and at most. What residuals of one stay have in common is less than
/// their errors have, since unknowns have taken it up; from no variance none would be found.
const FIRST_PART: f64 = 0.5;
const MOST_PART: f64 = 0.95;

impl Stay {
    /// Whether the joint still stands in this pose: one that left may be back, from the other side.
    fn goes_on(&self, session: &Session, pose: usize) -> bool {
        let side = |pose: usize| session.poses[pose].conditions.direction.get(self.joint);
        let first = self.poses[0];
        stands_still(session, self.joint, [first, pose]) && side(first) == side(pose)
    }
}

/// Degrees of freedom of the sum of two variances, each with its own (Satterthwaite, *Biometrics Bulletin* 2, 1946):
///
/// ```text
///     ν = (a + b)² / (a²/ν_a + b²/ν_b)
/// ```
fn freedom_together([a, of_a]: [f64; 2], [b, of_b]: [f64; 2]) -> f64 {
    (a + b).powi(2) / (a * a / of_a + b * b / of_b)
}

/// What is left of an error that lasts when the unknowns have taken up their part.
pub(in crate::joint) struct LastingError {
    pub joint: usize,
    /// Before any reading, unit of the torque reading.
    pub std: f64,
    /// `ê²`.
    squared: f64,
    /// `1 − c/v`.
    pub freedom: f64,
}

impl Lasting {
    /// The stays of the readings that enter; no variance as yet.
    fn of(session: &Session, readings: &MeasurementSet) -> Lasting {
        let stays = stays(session, readings);
        let mut of_pose = vec![Vec::new(); session.poses.len()];
        for (place, stay) in stays.iter().enumerate() {
            stay.poses.iter().for_each(|pose| of_pose[*pose].push(place));
        }
        Lasting { variance: vec![0.0; session.joints.len()], stays: stays.into(), of_pose: of_pose.into() }
    }

    /// The residual of a pose with the unknowns of its stays around it.
    pub(in crate::joint) fn around(
        &self,
        (variables, stored): (&VariableIndex, &Values),
        pose: usize,
        inner: Arc<dyn Residual>,
    ) -> Arc<dyn Residual> {
        let bias = |joint: usize| variables.sensors[joint][SensorParameter::TorqueBias as usize];
        let unknown = self.of_pose.get(pose).into_iter().flatten().filter_map(|place| {
            Some((Shift::of_scalar(bias(self.stays[*place].joint), 1.0), (*variables.lasting.get(*place)?)?))
        });
        let (shifted, shifts): (Vec<Shift>, Vec<BlockId>) = unknown.unzip();
        match shifts.is_empty() {
            true => inner,
            false => Arc::new(Shifted::by_blocks(inner, |id| stored.get(id).len(), &shifted, &shifts)),
        }
    }
}

/// The stays from which several readings of a joint enter, joint by joint.
fn stays(session: &Session, readings: &MeasurementSet) -> Vec<Stay> {
    runs(session, readings).into_iter().filter(|stay| stay.poses.len() > 1).collect()
}

/// The same with those of one reading.
fn runs(session: &Session, readings: &MeasurementSet) -> Vec<Stay> {
    let mut all: Vec<Stay> = Vec::new();
    for joint in 0..session.joints.len() {
        for pose in (0..session.poses.len()).filter(|pose| readings.used[*pose].contains(&joint)) {
            // Friction that is left while others sweep in a recording is an unknown already.
            let of_sweep = session.swept_in_recording(&session.poses[pose]).is_some();
            if of_sweep || session.poses[pose].course.is_some() {
                continue;
            }
            match all.last_mut().filter(|stay| stay.joint == joint && stay.goes_on(session, pose)) {
                Some(stay) => stay.poses.push(pose),
                None => all.push(Stay { joint, poses: vec![pose] }),
            }
        }
    }
    all
}

impl MeasurementSet {
    /// Variance of the lasting errors of a channel.
    pub(crate) fn lasting_variance(&self, channel: usize) -> f64 {
        self.lasting.as_ref().map_or(0.0, |lasting| lasting.variance_of(channel))
    }

    /// Variance of the lasting error of a reading that no other has.
    pub(in crate::joint) fn lasting_alone(&self, id: ReadingId) -> f64 {
        if self.lasts_with_others(id) { 0.0 } else { self.lasting_variance(id.channel) }
    }

    /// Whether a reading's lasting error is that of others, too.
    pub(in crate::joint) fn lasts_with_others(&self, id: ReadingId) -> bool {
        self.lasting.as_ref().is_some_and(|lasting| lasting.variance_of(id.channel) > 0.0 && lasting.stay(id).is_some())
    }

    /// The same errors in other poses, each by itself.
    pub(in crate::joint) fn lasting_elsewhere(&self) -> Option<Lasting> {
        let alone = |lasting: &Lasting| Lasting { stays: Arc::default(), of_pose: Arc::default(), ..lasting.clone() };
        self.lasting.as_ref().map(alone)
    }

    /// The unknowns, and one standard deviation of each, unit of the torque reading.
    pub(in crate::joint) fn lasting_unknowns(
        &self,
        session: &Session,
        variables: &VariableIndex,
    ) -> Vec<(f64, BlockId)> {
        let Some(lasting) = &self.lasting else { return Vec::new() };
        let unknown = lasting.stays.iter().zip(&variables.lasting);
        unknown.filter_map(|(stay, block)| Some((self.std_of_stay(session, lasting, stay), (*block)?))).collect()
    }

    fn std_of_stay(&self, session: &Session, lasting: &Lasting, stay: &Stay) -> f64 {
        (lasting.variance_of(stay.joint) + self.variance_of_unknown_side(session, stay.first())).sqrt()
    }
}

/// Adds the unknowns of joints that have such errors, from zero; by stay.
pub(in crate::joint) fn add_unknowns(
    session: &Session,
    readings: &MeasurementSet,
    builder: &mut ProblemBuilder,
) -> Vec<Option<BlockId>> {
    let Some(lasting) = &readings.lasting else { return Vec::new() };
    let unknown = |stay: &Stay| {
        (lasting.variance_of(stay.joint) > 0.0).then(|| {
            let (file, line) = session.row_of(stay.poses[0]);
            let name = format!("lasting_error[{}, {file}:{line}]", session.channel_name(stay.joint));
            builder.add_block(Block::scalar(name, session.channel_unit(stay.joint)).linear(), &[0.0])
        })
    };
    lasting.stays.iter().map(unknown).collect()
}

impl Solved {
    /// The readings with unknowns for errors that last, where residuals show any; nothing where they do not, the readings have them already, or residuals
    /// are so large that they contradict the model.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated.
    pub(in crate::joint) fn with_lasting_errors(
        &self,
        session: &Session,
    ) -> Result<Option<MeasurementSet>, EvaluateError> {
        let readings = self.readings();
        if readings.lasting.is_some() || readings.order != Order::Together || session.has_windows() {
            return Ok(None);
        }
        let lasting = Lasting::of(session, readings);
        if lasting.stays.is_empty() || lasting.stays.len() > MOST {
            return Ok(None);
        }
        let found = errors_found(session);
        let alike = self.alike_in_stays(session, &lasting)?;
        let of_found = || alike.iter().zip(&found).filter(|(_, found)| **found).map(|(alike, _)| alike);
        let shown = of_found().any(Alike::beyond_chance) || Alike::of_all(of_found()).beyond_chance();
        if !shown || self.contradicts_model(session)? {
            return Ok(None);
        }
        let mut with = readings.clone();
        let mut variance = lasting.variance.clone();
        for (joint, alike) in alike.iter().enumerate().filter(|(joint, _)| found[*joint]) {
            if alike.pairs == 0 {
                continue;
            }
            let part = alike.part().clamp(FIRST_PART, MOST_PART);
            variance[joint] = part * self.noise_of(session, joint);
            with.unexplained[joint] = (readings.unexplained[joint] - variance[joint]).max(0.0);
            if session.noise_estimated()[joint] {
                with.noise[joint] *= (1.0 - part).sqrt();
            }
        }
        let any = variance.iter().any(|variance| *variance > 0.0);
        with.lasting = Some(Lasting { variance, ..lasting });
        Ok(any.then_some(with))
    }

    /// By joint, how much the residuals of rows of one stay are alike.
    fn alike_in_stays(&self, session: &Session, lasting: &Lasting) -> Result<Vec<Alike>, EvaluateError> {
        let mut of_stay: Vec<Vec<f64>> = vec![Vec::new(); lasting.stays.len()];
        for (id, row) in self.built.rows.iter().zip(self.row_residuals()?) {
            if let Some(place) = lasting.stay(*id).filter(|_| row.leverage < 1.0) {
                of_stay[place].push(row.freed().clamp(-CLIPPED, CLIPPED));
            }
        }
        let mut alike = vec![Alike::default(); session.joints.len()];
        for (stay, residuals) in lasting.stays.iter().zip(of_stay) {
            alike[stay.joint].add(&residuals);
        }
        Ok(alike)
    }

    /// The errors that last as this solution shows them, and by which share the largest change of a variance is beside its joint's noise.
    pub(in crate::joint) fn lasting_anew(&self, session: &Session, rows: &[RowResidual]) -> (Option<Lasting>, f64) {
        let Some(lasting) = &self.readings().lasting else { return (None, 0.0) };
        let noise: Vec<f64> = (0..lasting.variance.len()).map(|joint| self.noise_of(session, joint)).collect();
        let found = self.lasting_found(session, rows);
        let variance = variance_anew(session, &lasting.variance, &found, &noise);
        let changes = variance.iter().zip(&lasting.variance).enumerate();
        let changed =
            changes.map(|(joint, (new, old))| (new - old).abs() / (2.0 * (old + noise[joint]))).fold(0.0, f64::max);
        (Some(Lasting { variance, ..lasting.clone() }), changed)
    }

    /// Mean square of the errors of a joint's readings but for those that last.
    fn noise_of(&self, session: &Session, joint: usize) -> f64 {
        let own = self.built.rows.iter().filter(|id| id.channel == joint);
        let squares: Vec<f64> = own.map(|id| self.readings().own_std(session, *id).powi(2)).collect();
        squares.iter().sum::<f64>() / squares.len().max(1) as f64 + self.readings().unexplained[joint]
    }

    /// By joint, one standard deviation of these errors and how many degrees of freedom tell it; what joints have in common counts as it does for noise.
    pub(in crate::joint) fn lasting_found(&self, session: &Session, rows: &[RowResidual]) -> Vec<Option<ChannelNoise>> {
        let errors = self.lasting_errors(session, rows);
        let groups: Vec<Option<usize>> = (0..session.joints.len())
            .map(|joint| errors.iter().any(|error| error.joint == joint).then_some(0))
            .collect();
        let as_residual = |error: &LastingError| ReadingResidual {
            channel: error.joint,
            std: 1.0,
            row: RowResidual { whitened: error.squared.sqrt(), leverage: 1.0 - error.freedom },
        };
        let residuals: Vec<ReadingResidual> = errors.iter().map(as_residual).collect();
        if self.built.loss == Loss::None {
            return noise_by_squares(&residuals, &groups);
        }
        let own = |joint: usize| errors.iter().filter(|error| error.joint == joint).map(|error| error.freedom).sum();
        let robust = noise_by_median(&residuals, groups.len()).into_iter().enumerate();
        robust.map(|(joint, std)| std.map(|std| ChannelNoise { std, own: own(joint), freedom: own(joint) })).collect()
    }

    /// By joint, how many degrees of freedom tell its noise and its errors that last together, where `of_noise` tell its noise, and none fewer than all where that is stated;
    /// nothing of joints without such errors.
    pub(in crate::joint) fn freedom_with_lasting(
        &self,
        session: &Session,
        rows: &[RowResidual],
        of_noise: &[Option<f64>],
    ) -> Vec<Option<f64>> {
        let found = self.lasting_found(session, rows).into_iter().enumerate();
        let together = |(joint, found): (usize, Option<ChannelNoise>)| {
            let of_lasting = [self.lasts_over(joint) * self.readings().lasting_variance(joint), found?.freedom];
            let of_noise = [self.noise_of(session, joint), of_noise[joint].unwrap_or(f64::INFINITY)];
            Some(freedom_together(of_noise, of_lasting).min(of_noise[1]))
        };
        found.map(together).collect()
    }

    /// How many readings have a reading's lasting error, in the mean over a joint's readings.
    fn lasts_over(&self, joint: usize) -> f64 {
        let Some(lasting) = &self.readings().lasting else { return 1.0 };
        let own = self.built.rows.iter().filter(|id| id.channel == joint);
        let over = |id: &ReadingId| lasting.stay(*id).map_or(1, |place| lasting.stays[place].poses.len());
        let counts: Vec<f64> = own.map(|id| over(id) as f64).collect();
        counts.iter().sum::<f64>() / counts.len().max(1) as f64
    }

    /// What is left of each, but where friction to an unknown side is in it. `rows`: the solution's own.
    pub(in crate::joint) fn lasting_errors(&self, session: &Session, rows: &[RowResidual]) -> Vec<LastingError> {
        let readings = self.readings();
        let Some(lasting) = &readings.lasting else { return Vec::new() };
        let shared = lasting.stays.iter().zip(&self.built.variables.lasting).filter_map(|(stay, block)| {
            if readings.variance_of_unknown_side(session, stay.first()) > 0.0 {
                return None;
            }
            let std = readings.std_of_stay(session, lasting, stay);
            let column = self.built.problem.columns_of((*block)?).next()?;
            let left = self.covariance().std(column) / std;
            if left * left > NOTHING_LEFT {
                return None;
            }
            let squared = self.estimate.values.scalar((*block)?).powi(2);
            Some(LastingError { joint: stay.joint, std, squared, freedom: (1.0 - left * left).max(0.0) })
        });
        let alone = self.built.rows.iter().zip(rows).filter_map(|(id, row)| {
            let variance = readings.lasting_alone(*id);
            if variance == 0.0 || readings.of_unknown_side(session, *id) > 0.0 {
                return None;
            }
            let std = readings.std(session, *id);
            let share = variance / (std * std);
            Some(LastingError {
                joint: id.channel,
                std,
                squared: (share * row.whitened * std).powi(2),
                freedom: share * (1.0 - row.leverage).max(0.0),
            })
        });
        shared.chain(alone).collect()
    }

    /// Says of which joints errors last.
    pub(in crate::joint) fn errors_that_last(&self, session: &Session) -> Option<String> {
        let lasting = self.readings().lasting.as_ref()?;
        let lasts = |joint: &usize| lasting.variance[*joint] > 0.0 && lasting.stays.iter().any(|s| s.joint == *joint);
        let told = |joint: usize| {
            let size = significant(lasting.variance[joint].sqrt(), 2);
            format!("{} {size} {}", session.channel_name(joint), session.channel_unit(joint))
        };
        let told: Vec<String> = (0..lasting.variance.len()).filter(lasts).map(told).collect();
        (!told.is_empty()).then(|| {
            format!(
                "Errors stay the same from row to row while a joint stands, as static friction does ({}, one standard deviation each). Each stay counts as one error, \
                 however many rows it has: poses in which all joints move tell more.",
                told.join(", ")
            )
        })
    }
}

/// The variances of joints, by what was `found`: none where that is nothing beside the `noise`; that of the nearest joint where its readings tell nothing, as
/// of one that hardly ever moves.
fn variance_anew(session: &Session, old: &[f64], found: &[Option<ChannelNoise>], noise: &[f64]) -> Vec<f64> {
    let lasts = |found: ChannelNoise, joint: usize| found.std * found.std > NEGLIGIBLE * noise[joint];
    let told = |joint: usize| found[joint].filter(|found| lasts(*found, joint)).map_or(0.0, |found| found.std);
    let told: Vec<f64> = (0..old.len()).map(told).collect();
    let variance = |joint: usize| match (old[joint] > 0.0, found[joint]) {
        (true, None) => session.of_nearest(&told, joint).powi(2),
        (true, Some(_)) => told[joint].powi(2),
        (false, _) => 0.0,
    };
    (0..old.len()).map(variance).collect()
}

/// How much residuals of rows of one stay are alike, over all pairs of them.
#[derive(Clone, Copy, Debug, Default)]
struct Alike {
    /// `Σ r r'`.
    products: f64,
    /// `Σ (r r')²`.
    squares: f64,
    /// How many pairs there are.
    pairs: usize,
}

impl Alike {
    /// Adds the pairs of one stay: `Σ_{i<j} a_i a_j = ½ ((Σ a)² − Σ a²)`.
    fn add(&mut self, residuals: &[f64]) {
        let sum = |power: i32| residuals.iter().map(|residual| residual.powi(power)).sum::<f64>();
        self.products += 0.5 * (sum(1).powi(2) - sum(2));
        self.squares += 0.5 * (sum(2).powi(2) - sum(4));
        self.pairs += residuals.len() * residuals.len().saturating_sub(1) / 2;
    }

    fn of_all<'a>(all: impl Iterator<Item = &'a Alike>) -> Alike {
        all.fold(Alike::default(), |sum, own| Alike {
            products: sum.products + own.products,
            squares: sum.squares + own.squares,
            pairs: sum.pairs + own.pairs,
        })
    }

    fn beyond_chance(&self) -> bool {
        self.pairs >= LEAST_PAIRS && self.products > BEYOND_CHANCE * self.squares.sqrt()
    }

    /// The part of the variance that rows of one stay have in common.
    fn part(&self) -> f64 {
        if self.pairs == 0 { 0.0 } else { self.products / self.pairs as f64 }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use gravcal_session::read_session;
    use gravcal_session::simulation::{Simulation, write_session};
    use nalgebra::{DMatrix, DVector};
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_pcg::Pcg64;

    use super::*;
    use crate::joint::{Signals, select, solve};
    use crate::testing::{TWO_JOINTS, sarcos_shoulder, with_environment};

    const SIMULATION: &str = r#"
robot = "robot.toml"
seed = 5
[gravity]
direction = [0, 1, -3]
magnitude_m_per_s2 = 9.81
[torque]
unit = "N·m"
std = 0.002
[position]
unit = "rad"
[[load]]
name = "plate"
mass_kg = 1
link = "forearm"
position_m = [0.1, 0, 0]
[[random]]
file = "bare.csv"
poses = 30
moving = 1
[[random]]
file = "loaded.csv"
poses = 30
moving = 1
load = "plate"
"#;

    /// A table in which one joint moves at a time, without stated noise; each stay has an error of this standard deviation.
    fn one_at_a_time(lasting: f64) -> Session {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("robot.toml"), TWO_JOINTS).unwrap();
        fs::write(folder.path().join("simulation.toml"), SIMULATION).unwrap();
        let simulation = Simulation::read(&folder.path().join("simulation.toml")).unwrap();
        let files = write_session(&simulation, 0, folder.path(), false).unwrap();
        let mut session = read_session(&files[0]).unwrap();
        session.poses.iter_mut().flat_map(|pose| pose.torque.iter_mut().flatten()).for_each(|read| read.std = None);
        let mut random = Pcg64::seed_from_u64(3);
        for Stay { joint, poses } in runs(&session, &select(&session, Signals::All)) {
            let error = lasting * random.sample::<f64, _>(StandardNormal);
            poses.iter().for_each(|pose| session.poses[*pose].torque[joint].as_mut().unwrap().value += error);
        }
        session
    }

    fn solved(session: &Session) -> Solved {
        with_environment(|environment| solve(session, &select(session, Signals::All), None, environment)).unwrap()
    }

    /// What is a thousandth of the noise takes no degree of freedom from it, and what is a thousand times as large leaves only its own.
    #[test]
    fn the_larger_of_two_variances_has_the_say_of_how_well_both_are_known() {
        let near = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
        near(freedom_together([1.0, 100.0], [1e-3, 1.5]), 100.0);
        near(freedom_together([1e-3, 100.0], [1.0, 1.5]), 1.5);
        near(freedom_together([1.0, 20.0], [1.0, 20.0]), 40.0);
        near(freedom_together([1.0, f64::INFINITY], [1.0, 5.0]), 20.0);
    }

    #[test]
    fn a_joint_stays_until_it_moves_or_comes_from_the_other_side_or_another_table_begins() {
        let mut session = sarcos_shoulder().session(0);
        session.poses.truncate(8);
        for (place, pose) in session.poses.iter_mut().enumerate() {
            pose.table = usize::from(place > 4);
            pose.position = vec![place as f64, if place < 3 { 0.0 } else { 1.0 }, [0.0, 0.3, 0.0, 0.0][place % 4]];
            pose.conditions.direction = vec![0.0, if place == 6 { -1.0 } else { 1.0 }, 0.0];
        }
        let found = stays(&session, &select(&session, Signals::All));
        let found: Vec<(usize, Vec<usize>)> = found.into_iter().map(|stay| (stay.joint, stay.poses)).collect();
        let expected = [(1, vec![0, 1, 2]), (1, vec![3, 4]), (2, vec![2, 3, 4]), (2, vec![6, 7])];
        assert_eq!(found, expected);
    }

    #[test]
    fn residuals_of_one_stay_are_alike_beyond_chance() {
        let mut alike = Alike::default();
        alike.add(&[1.0, 2.0, -1.0]);
        assert_eq!((alike.products, alike.squares, alike.pairs), (2.0 - 1.0 - 2.0, 4.0 + 1.0 + 4.0, 3));
        let of = |value: f64| {
            let mut alike = Alike::default();
            (0..20).for_each(|stay| alike.add(&[1.0, if stay % 2 == 0 { 1.0 } else { value }]));
            alike
        };
        // 20 √20, and none.
        assert!(of(1.0).beyond_chance() && !of(-1.0).beyond_chance());
        assert_eq!((of(1.0).part(), of(-1.0).part(), Alike::default().part()), (1.0, 0.0, 0.0));
        let mut few = Alike::default();
        (0..9).for_each(|_| few.add(&[1.0, 1.0]));
        assert!(!few.beyond_chance());
    }

    #[test]
    fn a_joint_that_tells_nothing_has_what_the_nearest_has() {
        let session = sarcos_shoulder().session(0);
        let gain = |joint: usize| session.joints[joint].of(SensorParameter::TorqueGain).nominal.abs();
        let found = |std: f64| Some(ChannelNoise { std, own: 5.0, freedom: 5.0 });
        let anew = |old: [f64; 3], found: [Option<ChannelNoise>; 3]| variance_anew(&session, &old, &found, &[1.0; 3]);
        assert_eq!(
            anew([1.0; 3], [found(2.0), found(0.01), found(3.0)]),
            [4.0, 0.0, 9.0],
            "a hundredth of the noise is none"
        );
        assert_eq!(anew([0.0, 1.0, 1.0], [found(2.0), None, found(3.0)])[0], 0.0, "of one without");
        let nearest = anew([1.0; 3], [None, found(2.0), found(3.0)])[0];
        assert!((nearest.sqrt() / (2.0 * gain(0) / gain(1)) - 1.0).abs() < 1e-12, "{nearest}");
        assert_eq!(anew([1.0; 3], [None; 3]), [0.0; 3]);
    }

    #[test]
    fn what_does_not_last_has_no_unknown() {
        let solved = solved(&one_at_a_time(0.0));
        assert!(solved.readings().lasting.is_none() && solved.built.variables.lasting.is_empty());
    }

    /// Restricted likelihood of residuals and derivatives by differences, without any unknown of a stay, at its variance and noise and beside them.
    #[test]
    fn the_variance_that_is_found_is_the_likeliest() {
        let session = one_at_a_time(0.02);
        let solved = solved(&session);
        let lasting = solved.readings().lasting.as_ref().unwrap();
        assert!(lasting.variance.iter().all(|variance| (variance.sqrt() / 0.02 - 1.0).abs() < 0.4), "{lasting:?}");
        let minus_log_likelihood = restricted_likelihood(&session, &solved, lasting);
        let here = minus_log_likelihood(1.0, 1.0);
        for [of_lasting, of_noise] in [[0.8, 1.0], [1.25, 1.0], [1.0, 0.8], [1.0, 1.25]] {
            assert!(minus_log_likelihood(of_lasting, of_noise) > here + 0.05, "{of_lasting} {of_noise}");
        }
    }

    /// `½ (ln|V| + ln|Xᵀ V⁻¹ X| + rᵀ P r)` with variances so many times as large, of what lasts and of the noise.
    fn restricted_likelihood(session: &Session, solved: &Solved, lasting: &Lasting) -> impl Fn(f64, f64) -> f64 {
        let (problem, readings) = (&solved.built.problem, solved.readings().clone());
        let of_stays: Vec<BlockId> = solved.built.variables.lasting.iter().flatten().copied().collect();
        let mut values = solved.estimate.values.clone();
        of_stays.iter().for_each(|block| values.set(*block, &[0.0]));
        let residuals = DVector::from_vec(problem.residuals(&values).unwrap());
        let mut derivatives: Vec<DVector<f64>> = Vec::new();
        for block in problem.block_ids().filter(|block| !of_stays.contains(block)) {
            let (at, basis) = (values.get(block).to_vec(), problem.tangent_basis(&values, block));
            let width = problem.columns_of(block).len();
            for place in 0..width {
                let beside = |step: f64| {
                    let mut beside = values.clone();
                    let moved: Vec<f64> =
                        at.iter().enumerate().map(|(row, x)| x + step * basis[row * width + place]).collect();
                    beside.set(block, &moved);
                    DVector::from_vec(problem.residuals(&beside).unwrap())
                };
                derivatives.push((beside(1e-5) - beside(-1e-5)) / 2e-5);
            }
        }
        // What they span: some unknowns of this arm cannot be told apart.
        let svd = DMatrix::from_columns(&derivatives).svd(true, false);
        let spanned = svd.singular_values.iter().filter(|value| **value > 1e-7 * svd.singular_values[0]).count();
        let derivatives = svd.u.unwrap().columns(0, spanned).into_owned();
        let ids = solved.built.rows.clone();
        let stds: Vec<f64> = ids.iter().map(|id| readings.std(session, *id)).collect();
        let stays: Vec<Option<usize>> = ids.iter().map(|id| lasting.stay(*id)).collect();
        let noise: Vec<f64> = ids.iter().map(|id| readings.own_std(session, *id).powi(2)).collect();
        let own: Vec<f64> = ids.iter().map(|id| lasting.variance_of(id.channel)).collect();
        // Rows of the stays' own priors say nothing without them.
        let count = residuals.len() - of_stays.len();
        move |of_lasting: f64, of_noise: f64| {
            let variance = |i: usize, j: usize| match (i < stds.len() && j < stds.len(), i == j) {
                (true, same) => {
                    let shared = same || (stays[i].is_some() && stays[i] == stays[j]);
                    let lasts = if shared { of_lasting * own[i] } else { 0.0 };
                    (lasts + if same { of_noise * noise[i] } else { 0.0 }) / (stds[i] * stds[j])
                }
                (false, same) => f64::from(u8::from(same)),
            };
            let kept = kept_rows(residuals.len(), stds.len(), count, &derivatives);
            let v = DMatrix::from_fn(kept.len(), kept.len(), |i, j| variance(kept[i], kept[j]));
            let factor = v.cholesky().unwrap();
            let x = derivatives.select_rows(&kept);
            let r = residuals.select_rows(&kept);
            let weighed = factor.solve(&x);
            let information = x.tr_mul(&weighed).cholesky().unwrap();
            let left = &r - &x * information.solve(&weighed.tr_mul(&r));
            let log = |diagonal: DVector<f64>| 2.0 * diagonal.map(f64::ln).sum();
            0.5 * (log(factor.l().diagonal()) + log(information.l().diagonal()) + left.dot(&factor.solve(&left)))
        }
    }

    /// Rows of readings, and of those priors that any other unknown has.
    fn kept_rows(rows: usize, readings: usize, count: usize, derivatives: &DMatrix<f64>) -> Vec<usize> {
        let felt = |row: &usize| *row < readings || derivatives.row(*row).iter().any(|entry| *entry != 0.0);
        let kept: Vec<usize> = (0..rows).filter(felt).collect();
        assert_eq!(kept.len(), count);
        kept
    }
}
