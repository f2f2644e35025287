//! A term of any family, and all that are looked for.

use gravcal_robot_model::parameter::SensorParameter;

use super::earlier_load::EarlierLoad;
use super::elastic::Elastic;
use super::friction::Friction;
use super::harmonic::Harmonic;
use super::lacked::Lacked;
use super::motion::Motion;
use super::position_zero::PositionZero;
use super::recorder::Recorder;
use super::sensor_gain::SensorGain;
use super::sensor_zero::SensorZero;
use super::stated::Stated;
use super::surroundings::Surroundings;
use crate::judgement::residual_tests::columns::Columns;

/// A term that is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Term {
    Zero(SensorZero),
    Gain(SensorGain),
    EarlierLoad(EarlierLoad),
    Harmonic(Harmonic),
    Elastic(Elastic),
    Motion(Motion),
    Friction(Friction),
    Recorder(Recorder),
    PositionZero(PositionZero),
    Stated(Stated),
    Surroundings(Surroundings),
}

impl Term {
    /// Every term that can be looked for in the readings of a channel.
    pub fn of_channel(of: &Columns, channel: usize) -> Vec<Term> {
        let mut terms: Vec<Term> = SensorZero::of_channel(of, channel).into_iter().map(Term::Zero).collect();
        terms.extend(EarlierLoad::of_channel(of, channel).into_iter().map(Term::EarlierLoad));
        let gains = SensorGain::of_channel(of, channel).into_iter().map(Term::Gain);
        if of.is_joint(channel) {
            let stated = [SensorParameter::TorqueGain, SensorParameter::TorqueBias];
            terms.extend(Harmonic::of_torque(of, channel).into_iter().map(Term::Harmonic));
            terms.push(Term::Elastic(Elastic::Spring));
            terms.extend(Motion::of_joint(of).into_iter().map(Term::Motion));
            terms.extend(gains);
            terms.extend(Stated::of_sensors(of, channel, stated).map(Term::Stated));
            terms.extend(Friction::of_joint(of, channel).into_iter().map(Term::Friction));
            terms.extend(Recorder::of_joint(of).into_iter().map(Term::Recorder));
        } else {
            terms.extend(gains);
        }
        terms
    }

    /// Those of a joint's coordinate, which every channel may show; none of a joint that slides.
    pub fn of_coordinate(of: &Columns, joint: usize) -> Vec<Term> {
        if of.slides(joint) {
            return Vec::new();
        }
        let stated = [SensorParameter::PositionGain, SensorParameter::PositionOffset];
        let harmonics = Harmonic::of_position().map(Term::Harmonic);
        let zeros = PositionZero::of_joint(of).into_iter().map(Term::PositionZero);
        let stated = Stated::of_sensors(of, joint, stated).map(Term::Stated);
        harmonics.chain([Term::Elastic(Elastic::Compliance)]).chain(zeros).chain(stated).collect()
    }

    /// Those of no single channel.
    pub fn of_arm(of: &Columns) -> Vec<Term> {
        let surroundings = Surroundings::of_arm(of).into_iter().map(Term::Surroundings);
        let clock = (!of.fast_clock.is_empty()).then_some(Term::Recorder(Recorder::ClockRate));
        let stated = Stated::of_loads(of).into_iter().chain(Stated::of_robot(of)).map(Term::Stated);
        surroundings.chain(clock).chain(stated).collect()
    }

    /// Whether it is what the robot's description says of a joint.
    pub fn is_of_description(&self) -> bool {
        matches!(self, Term::Stated(stated) if stated.is_of_description())
    }

    /// What it tells of itself.
    pub fn lacked(&self) -> &dyn Lacked {
        match self {
            Term::Zero(term) => term,
            Term::Gain(term) => term,
            Term::EarlierLoad(term) => term,
            Term::Harmonic(term) => term,
            Term::Elastic(term) => term,
            Term::Motion(term) => term,
            Term::Friction(term) => term,
            Term::Recorder(term) => term,
            Term::PositionZero(term) => term,
            Term::Stated(term) => term,
            Term::Surroundings(term) => term,
        }
    }

    /// Columns it is looked for by.
    pub fn columns(&self, of: &Columns, channel: usize) -> Vec<Vec<f64>> {
        self.lacked().columns(of, channel)
    }

    /// Its columns in each joint that it may be in.
    pub fn columns_of_each_joint(&self, of: &Columns) -> Vec<Vec<f64>> {
        self.joints(of).into_iter().flat_map(|joint| self.columns(of, joint)).collect()
    }

    /// What moves the estimate where it is missing with these coefficients, one entry a row of the problem, in standard deviations.
    pub fn missing(&self, of: &Columns, channel: usize, coefficients: &[f64]) -> Vec<f64> {
        weighted_sum(&self.lacked().as_modelled(of, channel), coefficients, of.rows)
    }

    /// The same where each joint has it, with these coefficients.
    pub fn missing_in_joints(&self, of: &Columns, coefficients: &[f64]) -> Vec<f64> {
        let joints = self.joints(of).into_iter();
        let columns: Vec<Vec<f64>> = joints.flat_map(|joint| self.lacked().as_modelled(of, joint)).collect();
        weighted_sum(&columns, coefficients, of.rows)
    }

    /// Joints that it may be in.
    fn joints(&self, of: &Columns) -> Vec<usize> {
        let may_be = |joint: &usize| {
            Term::of_channel(of, *joint).contains(self) || Term::of_coordinate(of, *joint).contains(self)
        };
        (0..of.session.joints.len()).filter(may_be).collect()
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
