//! What the model may lack: columns of terms that are looked for in the residuals of a channel.

use std::collections::{BTreeMap, BTreeSet};

use gravcal_dynamics::JointKind;
use gravcal_estimation::{EvaluateError, in_parallel};
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::sensors::Need;
use gravcal_robot_model::session::{Pose, PriorKind, Session};

use super::base::TurnedGravity;
use super::clock_rate::fast_clock;
use super::delayed;
use super::friction_curve;
use super::loads::{StatedLoad, stated_distances, stated_loads};
use super::of_instruments::PredictedAxes;
use super::of_torque::PredictedTorques;
use super::order::sides_by_order;
use super::pull::pulled;
use super::rows::ReadingRow;
use super::uneven_friction::{modelled_friction, sliding_friction};
use crate::joint::{DisplacedJoints, Solved};

/// The channel of what all joints do.
pub const ALL_JOINTS: &str = "all joints";
/// Harmonics that are looked for.
const ORDERS: std::ops::RangeInclusive<u32> = 1..=4;
/// More tables are not compared: by a bias of each; by gains, gravity and zeros of encoders, which change between recordings and not between sweeps.
const MOST_TABLES: usize = 40;
const MOST_RECORDINGS: usize = 6;
/// Powers of the torque that a reading may go with.
const POWERS: [i32; 2] = [2, 3];
/// Rows of a table that can be told to drift.
const DRIFTING: usize = 4;
/// A zero that changes on the way is looked for behind each but the last of so many parts of the poses, if there are so many poses.
const PARTS: usize = 8;
const FEWEST_PARTED: usize = 24;
/// Fewer readings of an instrument's axis, of which gain, bias and what five other axes sense take up seven, hardly tell chance from what they share.
const FEWEST_OF_AXIS: usize = 12;
/// Travel over which friction is taken to build up where that is looked for, rad or m: that of most gears.
const TRAVEL: f64 = 1e-3;

/// A term that is looked for.
#[derive(Clone, Debug, PartialEq)]
pub enum Term {
    Trend,
    /// In the unit of the reading, from the middle of the time to its ends.
    TrendCurve,
    TrendInTables,
    TorqueHarmonic(u32),
    PositionHarmonic(u32),
    Compliance,
    Velocity,
    Acceleration,
    Direction,
    /// Of the size of a friction that is there at once.
    Presliding,
    TorqueLag,
    TorqueFilter,
    Tables,
    /// In share of the gain.
    TorqueGains,
    /// In share of the gain.
    TorqueGainTrend,
    /// Of a joint's own position reading and its square, in the unit of the torque reading at the ends of what it moves.
    Spring,
    /// In the unit of the reading, at the largest.
    TorqueNonlinearity,
    /// Of all other joints that are read, in the unit of the reading for each N·m; of an instrument, of its other axes in their units.
    Crosstalk,
    /// Of an arm in motion, in share of the reading.
    LoadFriction,
    /// Of friction that the model has, in share of it.
    FrictionTrend,
    /// Of an arm in motion, in the unit of the reading.
    FrictionCurve,
    /// Of a joint's coordinate.
    PositionOffsets,
    /// Of a joint's coordinate: another zero from this pose on, in the order of their times.
    PositionJump {
        /// Place of the pose in that order.
        from: usize,
    },
    /// Of a joint's sensor: what the session states of it, in its unit.
    StatedSensor(SensorParameter),
    /// Of all channels: two coefficients for each table but the first, rad about axes perpendicular to gravity.
    Gravity,
    /// Of all channels: the stated mass of a load, kg.
    LoadMass(usize),
    /// Of all channels: the stated place of a load, m along the axes of its link.
    LoadPlacement(usize),
    /// Of all channels: the stated distance of two loads, m; its number.
    LoadDistance(usize),
    /// Of all channels: something that pulls at the last link, N along the axes of the base.
    Pull,
    /// Of all channels: a base that gives way, rad under the largest moment of the arm.
    BaseGivesWay,
    /// Of all channels: the rate of the clock, in share of it.
    ClockRate,
    /// Of all channels: where a joint sits on the link before it, m along the axes of that link; its number among those that can be told.
    JointPlacement(usize),
    /// Of all channels: how a joint is tilted on the link before it, rad about two axes perpendicular to its own; the link that it moves.
    JointTilt(usize),
}

impl Term {
    /// Whether it is where a joint sits, or how it is tilted, on the link before it.
    pub fn is_of_description(&self) -> bool {
        matches!(self, Term::JointPlacement(_) | Term::JointTilt(_))
    }
}

/// Makes columns: what a unit of a term's coefficient does to the whitened residuals.
pub struct Columns<'a> {
    session: &'a Session,
    solved: &'a Solved,
    rows: usize,
    /// By channel.
    readings: Vec<Vec<ReadingRow>>,
    /// By joint, what a step of its coordinate does to the whitened residuals; empty of joints that slide.
    slopes: Vec<Vec<f64>>,
    /// What a turn of gravity does to the whitened residuals, rad⁻¹, about two axes perpendicular to it.
    turned_gravity: [Vec<f64>; 2],
    /// What a base does that gives way.
    leaning: Vec<Vec<f64>>,
    /// What is stated of each load.
    loads: Vec<StatedLoad>,
    /// What a metre more of each stated distance does to the whitened residuals; empty of one that is known with a standard deviation.
    distances: Vec<Vec<Vec<f64>>>,
    /// What a newton at the last link does.
    pulled: Vec<Vec<f64>>,
    /// What a clock does that is fast by its own rate.
    fast_clock: Vec<Vec<f64>>,
    /// Joints whose place or axis is taken as exact.
    displaced: DisplacedJoints,
    /// What a radian does about each axis of instruments whose mounting is.
    turned_instruments: Vec<Vec<f64>>,
    /// By pose and joint, the torque under which the joint gives way: the model's own, as errors of a reading are in its residual, too.
    torques: Vec<Vec<f64>>,
    predicted: PredictedTorques,
    of_axes: PredictedAxes,
    /// By pose, when it was read, s; nothing where any pose does not tell.
    times: Option<Vec<f64>>,
    /// The poses that are read, in the order of their times.
    in_order: Vec<usize>,
    /// By pose, its place among them.
    places: Vec<usize>,
    /// By row, where the arm moves.
    predictions: Vec<f64>,
    /// By pose and joint, where the order of poses tells from which side joints came.
    sides: Vec<Vec<f64>>,
}

impl<'a> Columns<'a> {
    /// `rows`: of the problem that is judged, whose first ones are the readings.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated beside the solution.
    pub fn new(session: &'a Session, solved: &'a Solved, rows: usize) -> Result<Columns<'a>, EvaluateError> {
        let joints = session.robot.chain.joints().iter().enumerate();
        let slope = |(joint, described): (usize, &gravcal_dynamics::Joint)| match described.kind {
            JointKind::Prismatic => Ok(Vec::new()),
            _ => solved.slope_of_coordinate(joint, rows),
        };
        let times: Option<Vec<f64>> = session.poses.iter().map(|pose| pose.conditions.time).collect();
        let times = times.filter(|times| times.iter().any(|time| *time != times[0]));
        let slopes = in_parallel(joints, slope).into_iter().collect::<Result<_, _>>()?;
        let predictions = delayed::predictions(session, solved)?;
        let mut readings = vec![Vec::new(); session.channel_count()];
        for (row, id) in solved.built.rows.iter().enumerate() {
            readings[id.channel].push(ReadingRow { row, pose: id.pose, std: solved.readings().std(session, *id) });
        }
        let torques = solved.standing_torques(session)?;
        let mut in_order: Vec<usize> = solved.built.rows.iter().map(|id| id.pose).collect();
        in_order.dedup();
        if let Some(times) = &times {
            in_order.sort_by(|a, b| times[*a].total_cmp(&times[*b]));
        }
        let mut places = vec![0; session.poses.len()];
        in_order.iter().enumerate().for_each(|(place, pose)| places[*pose] = place);
        let turned_gravity = TurnedGravity::new(solved, rows)?;
        Ok(Columns {
            session,
            solved,
            rows,
            readings,
            slopes,
            leaning: turned_gravity.leaning(session, solved),
            turned_gravity: turned_gravity.columns,
            loads: stated_loads(session, solved, rows)?,
            distances: stated_distances(session, solved, rows)?,
            pulled: pulled(session, solved),
            fast_clock: fast_clock(session, solved, rows)?,
            displaced: solved.displaced_joints(session)?,
            turned_instruments: solved.turned_instruments(session)?,
            torques,
            predicted: PredictedTorques::new(session, solved)?,
            of_axes: PredictedAxes::new(session, solved)?,
            times,
            in_order,
            places,
            predictions,
            sides: sides_by_order(session),
        })
    }

    /// Every term that can be looked for in a channel.
    pub fn terms(&self, channel: usize) -> Vec<Term> {
        let mut terms = vec![Term::Trend, Term::TrendCurve, Term::TrendInTables, Term::Tables];
        if channel < self.session.joints.len() {
            if !self.slopes[channel].is_empty() {
                terms.extend(ORDERS.map(Term::TorqueHarmonic));
            }
            terms.extend([Term::Spring, Term::Velocity, Term::Acceleration, Term::Direction]);
            terms.extend([Term::TorqueGains, Term::TorqueGainTrend, Term::TorqueNonlinearity, Term::Crosstalk]);
            terms.extend(self.stated(channel, [SensorParameter::TorqueGain, SensorParameter::TorqueBias]));
            if self.session.terms.with_friction().contains(&channel) {
                terms.push(Term::FrictionTrend);
            }
            if self.may_build_up(channel) {
                terms.push(Term::Presliding);
            }
            if !self.predictions.is_empty() {
                terms.extend([Term::TorqueLag, Term::TorqueFilter, Term::LoadFriction, Term::FrictionCurve]);
            }
        } else if self.readings[channel].len() >= FEWEST_OF_AXIS {
            terms.extend([Term::TorqueNonlinearity, Term::Crosstalk]);
        }
        terms
    }

    /// Whether a joint has friction in the model that is there at once, and it was followed how it would build up.
    fn may_build_up(&self, joint: usize) -> bool {
        let terms = &self.session.terms;
        let followed = |pose: &Pose| pose.conditions.presliding.get(joint).is_some_and(Option::is_some);
        terms.with_friction().contains(&joint)
            && !terms.with_presliding().contains(&joint)
            && self.session.poses.iter().any(followed)
    }

    /// Those of a joint's coordinate, which every channel may show.
    pub fn terms_of_position(&self, joint: usize) -> Vec<Term> {
        if self.slopes[joint].is_empty() {
            return Vec::new();
        }
        let table = |place: usize| self.session.poses[self.in_order[place]].table;
        let froms = (1..PARTS).map(|part| part * self.in_order.len() / PARTS);
        // Where a table begins, it is the zero of that table.
        let froms = froms.filter(|from| self.in_order.len() >= FEWEST_PARTED && table(*from) == table(from - 1));
        let jumps = froms.map(|from| Term::PositionJump { from });
        let stated = self.stated(joint, [SensorParameter::PositionGain, SensorParameter::PositionOffset]);
        let always = ORDERS.map(Term::PositionHarmonic).chain([Term::Compliance, Term::PositionOffsets]);
        always.chain(jumps).chain(stated).collect()
    }

    /// Those of these parameters of a joint's sensors of which the session states more than a start.
    fn stated(&self, joint: usize, of: [SensorParameter; 2]) -> impl Iterator<Item = Term> {
        let is_stated =
            move |parameter: &SensorParameter| self.session.joints[joint].of(*parameter).kind != PriorKind::Flat;
        of.into_iter().filter(is_stated).map(Term::StatedSensor)
    }

    /// The pose at a place in the order of times.
    pub fn pose_at(&self, place: usize) -> usize {
        self.in_order[place]
    }

    /// Those of no single channel.
    pub fn terms_of_arm(&self) -> Vec<Term> {
        let gravity = (self.tables_of_all().len() > 1).then_some(Term::Gravity);
        let loads = (0..self.loads.len()).flat_map(|load| [Term::LoadMass(load), Term::LoadPlacement(load)]);
        let distances = (0..self.distances.len()).map(Term::LoadDistance);
        let pull = (!self.pulled.is_empty()).then_some(Term::Pull);
        let base = (!self.leaning.is_empty()).then_some(Term::BaseGivesWay);
        let clock = (!self.fast_clock.is_empty()).then_some(Term::ClockRate);
        let placements = (0..self.displaced.aside.len()).map(Term::JointPlacement);
        let tilts = self.displaced.tilted.iter().map(|tilted| Term::JointTilt(tilted.link));
        gravity
            .into_iter()
            .chain(loads)
            .chain(distances)
            .chain(pull)
            .chain(base)
            .chain(clock)
            .chain(placements)
            .chain(tilts)
            .collect()
    }

    /// Name of the joint that may sit elsewhere.
    pub fn placed(&self, placement: usize) -> &str {
        &self.session.robot.chain.movers()[self.displaced.aside[placement].link].name
    }

    /// What a radian does about each axis of instruments whose mounting is taken as exact.
    pub fn turned_instruments(&self) -> &[Vec<f64>] {
        &self.turned_instruments
    }

    /// Whether times are known.
    pub fn in_time(&self) -> bool {
        self.times.is_some()
    }

    /// Time, or number of the pose.
    pub fn when(&self, pose: usize) -> f64 {
        self.times.as_ref().map_or(pose as f64, |times| times[pose])
    }

    /// Columns of a term, one for each coefficient; one of all channels has the same ones in each.
    pub fn of(&self, channel: usize, term: &Term) -> Vec<Vec<f64>> {
        match term {
            Term::Trend => vec![self.trend(channel, |_| 0)],
            Term::TrendCurve => vec![self.squared_time(channel, 0.5)],
            Term::TrendInTables => self.trend_in_tables(channel),
            Term::Tables => self.apart(&self.tables(channel), MOST_TABLES, |within| {
                vec![self.reading(channel, |pose| f64::from(within(pose)))]
            }),
            Term::TorqueGains => self.apart(&self.tables(channel), MOST_RECORDINGS, |within| {
                vec![self.reading(channel, |pose| f64::from(within(pose)) * self.predicted.reading(pose, channel))]
            }),
            Term::TorqueGainTrend => vec![self.times_reading(channel, self.trend(channel, |_| 0))],
            Term::TorqueNonlinearity if channel >= self.session.joints.len() => {
                POWERS.map(|power| self.reading(channel, |pose| self.of_axes.power(pose, channel, power))).into()
            }
            Term::Crosstalk if channel >= self.session.joints.len() => {
                let others = self.of_axes.others(channel).into_iter();
                others.map(|other| self.reading(channel, |pose| self.of_axes.reading(pose, other))).collect()
            }
            Term::TorqueNonlinearity => {
                POWERS.map(|power| self.reading(channel, |pose| self.predicted.power(pose, channel, power))).into()
            }
            Term::Crosstalk => {
                let others = self.predicted.others(channel).into_iter();
                others.map(|other| self.reading(channel, |pose| self.predicted.torque(pose, other))).collect()
            }
            Term::LoadFriction => {
                let of_load = |pose: usize| self.predicted.reading(pose, channel).abs();
                vec![self.condition(channel, |pose| &pose.conditions.direction, of_load)]
            }
            Term::FrictionTrend => vec![self.times_friction(channel, self.trend(channel, |_| 0))],
            Term::FrictionCurve => self.over_speed(channel),
            Term::PositionOffsets => self.apart(&self.tables_of_all(), MOST_RECORDINGS, |within| {
                vec![self.coordinate(channel, |pose| f64::from(within(pose)))]
            }),
            Term::PositionJump { from } => vec![self.coordinate(channel, |pose| f64::from(self.places[pose] >= *from))],
            Term::Gravity => self.apart(&self.tables_of_all(), MOST_RECORDINGS, |within| {
                self.turned_gravity.iter().map(|turned| self.only(turned, within)).collect()
            }),
            Term::LoadMass(load) => self.loads[*load].mass.clone(),
            Term::LoadPlacement(load) => self.loads[*load].placement.clone(),
            Term::LoadDistance(distance) => self.distances[*distance].clone(),
            Term::Pull => self.pulled.clone(),
            Term::BaseGivesWay => self.leaning.clone(),
            Term::ClockRate => self.fast_clock.clone(),
            Term::JointPlacement(placement) => self.displaced.aside[*placement].columns.clone(),
            Term::JointTilt(link) => self.displaced.tilted[*link].columns.clone(),
            Term::TorqueHarmonic(order) => [f64::sin, f64::cos]
                .map(|function| self.reading(channel, |pose| function(f64::from(*order) * self.angle(channel, pose))))
                .into(),
            Term::PositionHarmonic(order) => [f64::sin, f64::cos]
                .map(|function| {
                    self.coordinate(channel, |pose| function(f64::from(*order) * self.angle(channel, pose)))
                })
                .into(),
            Term::Spring => self.spring(channel),
            Term::StatedSensor(parameter) => vec![match parameter {
                SensorParameter::TorqueGain => self.reading(channel, |pose| self.predicted.torque(pose, channel)),
                SensorParameter::TorqueBias => self.reading(channel, |_| 1.0),
                SensorParameter::PositionGain => {
                    self.coordinate(channel, |pose| self.session.poses[pose].position[channel])
                }
                SensorParameter::PositionOffset => self.coordinate(channel, |_| 1.0),
            }],
            Term::Compliance => vec![self.coordinate(channel, |pose| self.torques[pose][channel])],
            Term::Velocity => vec![self.condition(channel, |pose| &pose.conditions.velocity, |_| 1.0)],
            Term::Acceleration => vec![self.condition(channel, |pose| &pose.conditions.acceleration, |_| 1.0)],
            Term::Direction if !self.sides.is_empty() => vec![self.reading(channel, |pose| self.sides[pose][channel])],
            Term::Direction => vec![self.condition(channel, |pose| &pose.conditions.direction, |_| 1.0)],
            Term::Presliding => vec![self.reading(channel, |pose| self.not_built_up(channel, pose))],
            Term::TorqueLag => vec![self.of_slopes(channel, |[slope, _]| -slope)],
            Term::TorqueFilter => vec![self.of_slopes(channel, |[_, bend]| bend)],
        }
    }

    /// A joint that bends by so much, rad, under the largest torque that it carries; nothing of one that carries none, or slides.
    pub fn bent(&self, joint: usize, angle: f64) -> Option<Vec<f64>> {
        let largest = self.torques.iter().map(|pose| pose[joint].abs()).fold(0.0, f64::max);
        let bends = !self.slopes[joint].is_empty() && largest > 0.0;
        bends.then(|| self.coordinate(joint, |pose| angle * self.torques[pose][joint] / largest))
    }

    /// A torque as large as a joint's sliding friction, the same whichever way it moves; nothing where no friction is known.
    pub fn uneven_friction(&self, joint: usize) -> Option<Vec<f64>> {
        let friction = sliding_friction(self.session, self.solved, joint);
        friction.iter().any(|friction| *friction != 0.0).then(|| self.reading(joint, |pose| friction[pose]))
    }

    /// An eccentric position sensor, a radian off to either side once over a turn; nothing of a joint that slides.
    pub fn eccentric(&self, joint: usize) -> Vec<Vec<f64>> {
        match self.slopes[joint].is_empty() {
            true => Vec::new(),
            false => self.of(joint, &Term::PositionHarmonic(1)),
        }
    }

    /// What moves the estimate where a term of these coefficients is missing, one entry a row of the problem, in standard deviations.
    pub fn missing(&self, channel: usize, term: &Term, coefficients: &[f64]) -> Vec<f64> {
        weighted_sum(&self.lacked(channel, term), coefficients, self.rows)
    }

    /// The same of a term that each joint has, with these coefficients.
    pub fn missing_in_joints(&self, term: &Term, coefficients: &[f64]) -> Vec<f64> {
        let columns: Vec<Vec<f64>> =
            self.joints_with(term).into_iter().flat_map(|joint| self.lacked(joint, term)).collect();
        weighted_sum(&columns, coefficients, self.rows)
    }

    /// The joint whose torque, or the axis whose reading, shows most in the reading of another, and its coefficient.
    pub fn shows_most(&self, channel: usize, coefficients: &[f64]) -> Option<(usize, f64)> {
        match channel < self.session.joints.len() {
            true => self.predicted.shows_most(channel, coefficients),
            false => self.of_axes.shows_most(channel, coefficients),
        }
    }

    /// Columns of a term as a model of it has it: what drifts was at the beginning what the parameter says.
    fn lacked(&self, channel: usize, term: &Term) -> Vec<Vec<f64>> {
        match term {
            Term::Trend => vec![self.time_since(channel, |_| 0)],
            Term::TrendCurve => vec![self.squared_time(channel, 0.0)],
            Term::TrendInTables => vec![self.time_since(channel, |pose| self.session.poses[pose].table)],
            Term::TorqueGainTrend => vec![self.times_reading(channel, self.time_since(channel, |_| 0))],
            Term::FrictionTrend => vec![self.times_friction(channel, self.time_since(channel, |_| 0))],
            _ => self.of(channel, term),
        }
    }

    /// The columns of a term in each joint that it may be in.
    pub fn of_each_joint(&self, term: &Term) -> Vec<Vec<f64>> {
        self.joints_with(term).into_iter().flat_map(|joint| self.of(joint, term)).collect()
    }

    /// Joints that a term may be in.
    fn joints_with(&self, term: &Term) -> Vec<usize> {
        let may_be = |joint: &usize| self.terms(*joint).contains(term) || self.terms_of_position(*joint).contains(term);
        (0..self.slopes.len()).filter(may_be).collect()
    }

    /// Tables in which a channel is read.
    pub fn tables(&self, channel: usize) -> Vec<usize> {
        let tables: BTreeSet<usize> = self.poses(channel).map(|pose| self.session.poses[pose].table).collect();
        tables.into_iter().collect()
    }

    /// Tables in which anything is read.
    pub fn tables_of_all(&self) -> Vec<usize> {
        let tables = self.solved.built.rows.iter().map(|id| self.session.poses[id.pose].table);
        tables.collect::<BTreeSet<usize>>().into_iter().collect()
    }

    /// The pose of every reading of a channel.
    fn poses(&self, channel: usize) -> impl Iterator<Item = usize> {
        self.readings[channel].iter().map(|reading| reading.pose)
    }

    /// A term that adds to the readings of a channel.
    fn reading(&self, channel: usize, value: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut column = vec![0.0; self.rows];
        for ReadingRow { row, pose, std } in &self.readings[channel] {
            column[*row] = value(*pose) / std;
        }
        column
    }

    /// A term that adds to the readings of a channel, by the slopes of their predictions over time.
    fn of_slopes(&self, channel: usize, value: impl Fn([f64; 2]) -> f64) -> Vec<f64> {
        let mut column = vec![0.0; self.rows];
        let slopes = delayed::slopes(self.session, &self.predictions, &self.readings[channel]);
        for (ReadingRow { row, std, .. }, slopes) in self.readings[channel].iter().zip(slopes) {
            column[*row] = value(slopes) / std;
        }
        column
    }

    /// A term that adds to the coordinate of a joint.
    fn coordinate(&self, joint: usize, value: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut column = self.slopes[joint].clone();
        let mut latest = None;
        for (id, entry) in self.solved.built.rows.iter().zip(&mut column) {
            // Rows of one pose follow each other.
            let of_pose =
                latest.filter(|(pose, _)| *pose == id.pose).map_or_else(|| value(id.pose), |(_, known)| known);
            latest = Some((id.pose, of_pose));
            *entry *= of_pose;
        }
        column
    }

    /// The angle that the sensor shows.
    fn angle(&self, joint: usize, pose: usize) -> f64 {
        self.session.joints[joint].of(SensorParameter::PositionGain).nominal * self.session.poses[pose].position[joint]
    }

    /// A condition of a joint, times what it acts on; zero where it is not known.
    fn condition(&self, joint: usize, of: impl Fn(&Pose) -> &Vec<f64>, acts_on: impl Fn(usize) -> f64) -> Vec<f64> {
        let own = |pose: usize| of(&self.session.poses[pose]).get(joint).copied().unwrap_or(0.0);
        self.reading(joint, |pose| own(pose) * acts_on(pose))
    }

    /// A torque that goes with a joint's own position reading, and with its square: from the middle to the ends of what it moves.
    fn spring(&self, joint: usize) -> Vec<Vec<f64>> {
        let position = |pose: usize| self.session.poses[pose].position[joint];
        let (low, high) = self
            .poses(joint)
            .map(position)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        let half = 0.5 * (high - low);
        let from_middle = |pose: usize| (position(pose) - low) / half - 1.0;
        let power = |power: i32| self.reading(joint, |pose| from_middle(pose).powi(power));
        if half > 0.0 { [1, 2].map(power).into() } else { Vec::new() }
    }

    /// Terms of a friction that is no line over the speed.
    fn over_speed(&self, joint: usize) -> Vec<Vec<f64>> {
        let fastest = self.highest_speed(joint);
        let term = |term: usize| {
            self.reading(joint, |pose| {
                let conditions = &self.session.poses[pose].conditions;
                let of_joint = |values: &[f64]| values.get(joint).copied().unwrap_or(0.0);
                let [direction, speed] = [&conditions.direction, &conditions.velocity].map(|values| of_joint(values));
                friction_curve::terms(direction, speed / fastest)[term]
            })
        };
        if fastest > 0.0 { (0..friction_curve::TERMS).map(term).collect() } else { Vec::new() }
    }

    /// The highest speed of a joint's windows, rad/s or m/s.
    pub fn highest_speed(&self, joint: usize) -> f64 {
        let speed =
            |pose: usize| self.session.poses[pose].conditions.velocity.get(joint).map_or(0.0, |speed| speed.abs());
        self.poses(joint).map(speed).fold(0.0, f64::max)
    }

    /// A column of a joint's readings, each times what its torque makes of it.
    fn times_reading(&self, joint: usize, mut column: Vec<f64>) -> Vec<f64> {
        for ReadingRow { row, pose, .. } in &self.readings[joint] {
            column[*row] *= self.predicted.reading(*pose, joint);
        }
        column
    }

    /// The same, each times what friction of the model makes of it.
    fn times_friction(&self, joint: usize, mut column: Vec<f64>) -> Vec<f64> {
        let read = [Need::Direction, Need::Presliding, Need::Velocity];
        let friction = modelled_friction(self.session, self.solved, joint, &read);
        for ReadingRow { row, pose, .. } in &self.readings[joint] {
            column[*row] *= friction.get(*pose).copied().unwrap_or(0.0);
        }
        column
    }

    /// What a friction of one that builds up over [`TRAVEL`] is less than one that is there at once; nothing where that is not known.
    fn not_built_up(&self, joint: usize, pose: usize) -> f64 {
        let followed = self.session.poses[pose].conditions.presliding.get(joint).copied().flatten();
        followed.map_or(0.0, |followed| followed.at(TRAVEL).0 - followed.at(0.0).0)
    }

    /// Time (or order) since the first pose of a channel that is of the same group.
    fn time_since(&self, channel: usize, group: impl Fn(usize) -> usize) -> Vec<f64> {
        let mut first: BTreeMap<usize, f64> = BTreeMap::new();
        for pose in self.poses(channel) {
            let since = first.entry(group(pose)).or_insert(f64::INFINITY);
            *since = since.min(self.when(pose));
        }
        self.reading(channel, |pose| self.when(pose) - first[&group(pose)])
    }

    /// Square of the time (or order) from a share of its span on, in halves of that.
    fn squared_time(&self, channel: usize, share: f64) -> Vec<f64> {
        let times = || self.poses(channel).map(|pose| self.when(pose));
        let (first, last) = (times().fold(f64::INFINITY, f64::min), times().fold(f64::NEG_INFINITY, f64::max));
        let (from, half) = (first + share * (last - first), 0.5 * (last - first));
        self.reading(channel, |pose| if half > 0.0 { ((self.when(pose) - from) / half).powi(2) } else { 0.0 })
    }

    /// Time (or order) less its mean over the poses of a channel that are of one group.
    fn trend(&self, channel: usize, group: impl Fn(usize) -> usize) -> Vec<f64> {
        let mut sums: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
        for pose in self.poses(channel) {
            let (sum, count) = sums.entry(group(pose)).or_default();
            *sum += self.when(pose);
            *count += 1.0;
        }
        self.reading(channel, |pose| {
            let (sum, count) = sums[&group(pose)];
            if count < DRIFTING as f64 { 0.0 } else { self.when(pose) - sum / count }
        })
    }

    fn trend_in_tables(&self, channel: usize) -> Vec<Vec<f64>> {
        if self.tables(channel).len() < 2 {
            return Vec::new();
        }
        vec![self.trend(channel, |pose| self.session.poses[pose].table)]
    }

    /// Columns of each table but the first; none of more than `most`.
    fn apart(
        &self,
        tables: &[usize],
        most: usize,
        of: impl Fn(&dyn Fn(usize) -> bool) -> Vec<Vec<f64>>,
    ) -> Vec<Vec<f64>> {
        if tables.len() > most {
            return Vec::new();
        }
        tables.iter().skip(1).flat_map(|table| of(&|pose| self.session.poses[pose].table == *table)).collect()
    }

    /// The rows of some poses; zero in all others.
    fn only(&self, column: &[f64], within: impl Fn(usize) -> bool) -> Vec<f64> {
        let mut only = vec![0.0; self.rows];
        for ((id, entry), own) in self.solved.built.rows.iter().zip(column).zip(&mut only) {
            *own = if within(id.pose) { *entry } else { 0.0 };
        }
        only
    }
}

/// Columns times their coefficients; `rows` zeros where there are none.
fn weighted_sum(columns: &[Vec<f64>], coefficients: &[f64], rows: usize) -> Vec<f64> {
    let mut sum = vec![0.0; rows];
    for (column, coefficient) in columns.iter().zip(coefficients) {
        sum.iter_mut().zip(column).for_each(|(sum, entry)| *sum += coefficient * entry);
    }
    sum
}
