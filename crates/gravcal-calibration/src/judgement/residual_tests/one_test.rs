//! The result of one test, with its size in a unit.

use gravcal_dynamics::JointKind;
use gravcal_recording::file_name;
use gravcal_robot_model::parameter::ParameterId;

use super::candidate::{Candidate, Tested};
use super::columns::Term;
use super::friction_curve;
use super::of_torque::per_torque;
use super::score::{Score, dot};
use super::search::Search;
use crate::result::{ResidualTest, ResidualTestKind};

impl Search<'_> {
    /// Of one term of a channel.
    pub fn report(&self, channel: usize, term: &Term, scored: Score) -> Tested {
        let Score { statistic, degrees_of_freedom, blocks, p_value, p_of_noise, coefficients, in_noise, gain } = scored;
        let unit = self.session.channel_unit(channel);
        let amplitude = dot(&coefficients, &coefficients).sqrt();
        let first = coefficients.first().copied().unwrap_or(0.0);
        let each = if self.columns.in_time() { "s" } else { "pose" };
        let (kind, size, unit) = match term {
            Term::Trend => (ResidualTestKind::Trend, first, format!("{unit}/{each}")),
            Term::TrendCurve => (ResidualTestKind::TrendCurve, first, unit),
            Term::TrendInTables => (ResidualTestKind::TrendInTables, first, format!("{unit}/{each}")),
            Term::TorqueHarmonic(order) => (ResidualTestKind::TorqueHarmonic { order: *order }, amplitude, unit),
            Term::PositionHarmonic(order) => {
                (ResidualTestKind::PositionHarmonic { order: *order }, amplitude, "rad".to_owned())
            }
            Term::Spring => {
                let [ahead, behind] = [1.0, -1.0].map(|at| dot(&coefficients, &[at, 1.0]));
                (ResidualTestKind::Spring, if ahead.abs() > behind.abs() { ahead } else { behind }, unit)
            }
            Term::StatedSensor(parameter) => {
                let id = ParameterId::Sensor(channel, *parameter);
                let parameter = self.session.parameter_name(id);
                (ResidualTestKind::StatedSensor { parameter }, first, self.session.parameter(id).unit)
            }
            Term::Compliance => (ResidualTestKind::Compliance, first, "rad/(N·m)".to_owned()),
            Term::Velocity => (ResidualTestKind::Velocity, first, self.by_motion(channel, &unit, "s")),
            Term::Acceleration => (ResidualTestKind::Acceleration, first, self.by_motion(channel, &unit, "s²")),
            Term::Direction => (ResidualTestKind::Direction, first, unit),
            Term::Presliding => (ResidualTestKind::Presliding, first, unit),
            Term::TorqueLag => (ResidualTestKind::TorqueLag, first, "s".to_owned()),
            Term::TorqueFilter => (ResidualTestKind::TorqueFilter, first, "s²".to_owned()),
            Term::Tables => {
                let (file, size) = self.farthest(&self.columns.tables(channel), &coefficients);
                (ResidualTestKind::Tables { file }, size, unit)
            }
            Term::TorqueGains => {
                let (file, size) = self.farthest(&self.columns.tables(channel), &coefficients);
                (ResidualTestKind::TorqueGain { file }, 100.0 * size, "%".to_owned())
            }
            Term::TorqueGainTrend => (ResidualTestKind::TorqueGainTrend, 100.0 * first, format!("%/{each}")),
            Term::TorqueNonlinearity => (ResidualTestKind::TorqueNonlinearity, amplitude, unit),
            Term::Crosstalk => {
                let (other, size) = self.columns.shows_most(channel, &coefficients).unwrap_or((channel, 0.0));
                let joint = self.session.channel_name(other);
                let unit = match channel < self.session.joints.len() {
                    true => per_torque(self.session, channel, other, ""),
                    false => format!("{unit}/({})", self.session.channel_unit(other)),
                };
                (ResidualTestKind::Crosstalk { joint }, size, unit)
            }
            Term::LoadFriction => (ResidualTestKind::LoadFriction, 100.0 * first.abs(), "%".to_owned()),
            Term::FrictionTrend => (ResidualTestKind::FrictionTrend, 100.0 * first, format!("%/{each}")),
            Term::FrictionCurve => {
                let (size, share) = friction_curve::seen_most(&coefficients).unwrap_or_default();
                let speed = share * self.columns.highest_speed(channel);
                (ResidualTestKind::FrictionCurve { speed }, size, unit)
            }
            Term::PositionOffsets => {
                let (file, size) = self.farthest(&self.columns.tables_of_all(), &coefficients);
                (ResidualTestKind::PositionOffset { file }, size, "rad".to_owned())
            }
            Term::PositionJump { from } => {
                let (file, line) = self.session.row_of(self.columns.pose_at(*from));
                (ResidualTestKind::PositionJump { file, line }, first, "rad".to_owned())
            }
            Term::Gravity => {
                let (file, size) = self.most_turned(&coefficients);
                (ResidualTestKind::Gravity { file }, size, "rad".to_owned())
            }
            Term::LoadMass(load) => (ResidualTestKind::LoadMass { load: self.load(*load) }, first, "kg".to_owned()),
            Term::LoadPlacement(load) => {
                (ResidualTestKind::LoadPlacement { load: self.load(*load) }, amplitude, "m".to_owned())
            }
            Term::LoadDistance(distance) => {
                let [load, other] = self.session.load_distances[*distance].between.map(|load| self.load(load));
                (ResidualTestKind::LoadDistance { load, other }, first, "m".to_owned())
            }
            Term::BaseGivesWay => (ResidualTestKind::BaseGivesWay, first, "rad".to_owned()),
            Term::ClockRate => (ResidualTestKind::ClockRate, 100.0 * first, "%".to_owned()),
            Term::Pull => (ResidualTestKind::Pull, amplitude, "N".to_owned()),
            Term::JointTilt(link) => {
                let joint = self.session.robot.chain.movers()[*link].name.clone();
                (ResidualTestKind::JointTilt { joint }, amplitude, "rad".to_owned())
            }
            Term::JointPlacement(placement) => {
                let joint = self.columns.placed(*placement).to_owned();
                (ResidualTestKind::JointPlacement { joint }, amplitude, "m".to_owned())
            }
        };
        let test = ResidualTest {
            channel: self.session.channel_name(channel),
            kind,
            statistic,
            degrees_of_freedom,
            blocks,
            p_value,
            corrected_p_value: p_value,
            size,
            unit,
            in_noise,
            named: false,
            spoils_intervals: false,
        };
        Tested { test, candidate: Candidate::Term(channel, term.clone()), gain, p_of_noise, coefficients }
    }

    fn load(&self, load: usize) -> String {
        self.session.loads[load].name.clone()
    }

    fn by_motion(&self, joint: usize, unit: &str, time: &str) -> String {
        let slides = self.session.robot.chain.joints()[joint].kind == JointKind::Prismatic;
        format!("{unit}/({}/{time})", if slides { "m" } else { "rad" })
    }

    /// The file that is farthest from the mean one, and by how much; `coefficients` are those of all tables but the first.
    fn farthest(&self, tables: &[usize], coefficients: &[f64]) -> (String, f64) {
        let mean = coefficients.iter().sum::<f64>() / tables.len() as f64;
        let apart =
            tables.iter().zip(std::iter::once(&0.0).chain(coefficients)).map(|(table, own)| (*table, own - mean));
        let (table, size) = apart.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or((0, 0.0));
        (file_name(&self.session.tables[table].path), size)
    }

    /// The file in which gravity is turned most against the first, and by how much, rad.
    fn most_turned(&self, coefficients: &[f64]) -> (String, f64) {
        let turns = coefficients.as_chunks::<2>().0.iter().map(|[a, b]| a.hypot(*b));
        let tables = self.columns.tables_of_all().into_iter().skip(1);
        let (table, size) = tables.zip(turns).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0));
        (file_name(&self.session.tables[table].path), size)
    }
}
