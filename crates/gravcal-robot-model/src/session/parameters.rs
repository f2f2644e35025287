//! The parameters of a session as one list, whatever they belong to.

use gravcal_dynamics::JointKind;

use super::contents::Session;
use super::instrument::{AuxiliarySensor, AuxiliarySensorKind};
use super::known::{InertiaPrior, JointPriors, Load};
use super::parameter_prior::{ParameterPrior, PriorKind};
use crate::parameter::{Limit, Parameter, ParameterId, SensorParameter, UNREAD};

/// Standard deviation, relative to a gain, beyond which a number would mislead; of an angle, rad; of a displacement, m.
pub const GAIN_LIMIT: f64 = 0.1;
const ANGLE_LIMIT: f64 = 0.1;
const DISPLACEMENT_LIMIT: f64 = 0.01;
/// Share of the largest torque of any joint of its kind that matters for each: what a bias is off by less changes no torque of the arm by as much
/// as sensors are good for.
const LEAST_SPREAD: f64 = 1e-3;

impl Session {
    /// Every parameter in the order in which results tell them: what belongs to a joint or instrument stands together.
    pub fn parameters(&self) -> Vec<ParameterId> {
        let of = |owner: &str| -> Vec<ParameterId> {
            let own = self.further.iter().enumerate();
            let own = own.filter(|(_, parameter)| parameter.owner == owner && parameter.same_as.is_none());
            own.map(|(index, _)| ParameterId::Further(index)).collect()
        };
        let mut all = Vec::new();
        for (joint, described) in self.robot.chain.joints().iter().enumerate() {
            all.extend(SensorParameter::ALL.map(|quantity| ParameterId::Sensor(joint, quantity)));
            all.extend(of(&described.name));
        }
        for (index, parameter) in self.further.iter().enumerate() {
            if parameter.same_as.is_none() && !all.contains(&ParameterId::Further(index)) {
                all.extend(of(&parameter.owner));
            }
        }
        all
    }

    /// One of them.
    pub fn parameter(&self, id: ParameterId) -> Parameter {
        match id {
            ParameterId::Sensor(joint, quantity) => self.sensor_parameter(joint, quantity),
            ParameterId::Further(index) => self.further[index].clone(),
        }
    }

    fn sensor_parameter(&self, joint: usize, quantity: SensorParameter) -> Parameter {
        let described = &self.robot.chain.joints()[joint];
        Parameter {
            owner: described.name.clone(),
            quantity: quantity.as_str().to_owned(),
            unit: self.parameter_unit(joint, quantity),
            convention: quantity.convention().into(),
            prior: self.joints[joint].of(quantity),
            fixed: self.fixed_reason(joint, quantity),
            limit: self.sensor_limit(joint, quantity),
            cure: MOVE_MORE.into(),
            linear: quantity == SensorParameter::TorqueBias,
            same_as: None,
        }
    }

    fn sensor_limit(&self, joint: usize, quantity: SensorParameter) -> Limit {
        match quantity {
            SensorParameter::TorqueGain | SensorParameter::PositionGain => Limit::ShareOfNominal(GAIN_LIMIT),
            SensorParameter::TorqueBias => Limit::HalfSpread { channel: joint },
            SensorParameter::PositionOffset => match self.robot.chain.joints()[joint].kind {
                JointKind::Revolute => Limit::Absolute(ANGLE_LIMIT),
                JointKind::Prismatic => Limit::Absolute(DISPLACEMENT_LIMIT),
            },
        }
    }

    /// What is known of a parameter.
    pub fn prior(&self, id: ParameterId) -> ParameterPrior {
        match id {
            ParameterId::Sensor(joint, quantity) => self.joints[joint].of(quantity),
            ParameterId::Further(index) => self.further[index].prior,
        }
    }

    /// Why a parameter is fixed and not estimated, if it is.
    pub fn fixed(&self, id: ParameterId) -> Option<&'static str> {
        match id {
            ParameterId::Sensor(joint, quantity) => self.fixed_reason(joint, quantity),
            ParameterId::Further(index) => self.further[index].fixed,
        }
    }

    /// The name of a parameter.
    pub fn parameter_name(&self, id: ParameterId) -> String {
        match id {
            ParameterId::Sensor(joint, quantity) => quantity.name(&self.robot.chain.joints()[joint].name),
            ParameterId::Further(index) => self.further[index].name(),
        }
    }

    /// Whether a parameter is estimated only as the session states how well it is known, and is exact otherwise: compliances, how
    /// instruments are mounted, masses of loads.
    pub fn is_unknown_by_its_std(&self, id: ParameterId) -> bool {
        let ParameterId::Further(place) = id else { return false };
        let mounted = |instrument: &&AuxiliarySensor| instrument.kind == AuxiliarySensorKind::Accelerometer;
        let mut mountings = self.instruments.iter().filter(mounted).map(AuxiliarySensor::own_parameters);
        let is_mass = self.load_masses.contains(&Some(place));
        is_mass || self.compliances().contains(&place) || mountings.any(|own| own.contains(&place))
    }

    /// What is known of a parameter, to be changed.
    pub fn prior_mut(&mut self, id: ParameterId) -> &mut ParameterPrior {
        match id {
            ParameterId::Sensor(joint, quantity) => &mut self.joints[joint].parameters[quantity as usize],
            ParameterId::Further(index) => &mut self.further[index].prior,
        }
    }

    /// Where the estimation of a parameter starts.
    pub fn nominal(&self, id: ParameterId) -> f64 {
        self.prior(id).nominal
    }

    /// Standard deviation beyond which a parameter's number would mislead. `spreads`: largest less smallest torque
    /// reading of each joint.
    pub fn limit(&self, id: ParameterId, spreads: &[f64]) -> f64 {
        let limit = match id {
            ParameterId::Sensor(joint, quantity) => self.sensor_limit(joint, quantity),
            ParameterId::Further(index) => self.further[index].limit,
        };
        match limit {
            Limit::ShareOfNominal(share) => share * self.nominal(id).abs(),
            Limit::Absolute(limit) => limit,
            Limit::HalfSpread { channel } => 0.5 * self.spread_of_use(channel, spreads) / self.lever(id),
            Limit::GainChange { joint, power } => {
                let gain = self.joints[joint].of(SensorParameter::TorqueGain).nominal.abs();
                GAIN_LIMIT * gain / (0.5 * spreads[joint] / gain).powi(power)
            }
        }
    }

    /// Largest less smallest reading of a channel, or the least that a bias is of use for: a joint that carries nothing reads its noise alone.
    fn spread_of_use(&self, channel: usize, spreads: &[f64]) -> f64 {
        let joints = self.robot.chain.joints();
        if channel >= joints.len() {
            return spreads[channel];
        }
        let gain = |joint: usize| self.nominal(ParameterId::Sensor(joint, SensorParameter::TorqueGain)).abs();
        let alike = (0..joints.len()).filter(|joint| joints[*joint].kind == joints[channel].kind && gain(*joint) > 0.0);
        let largest = alike.map(|joint| spreads[joint] / gain(joint)).fold(0.0, f64::max);
        spreads[channel].max(LEAST_SPREAD * largest * gain(channel))
    }

    /// By how much, at most, a unit of a bias-like parameter changes the readings of a torque sensor.
    fn lever(&self, id: ParameterId) -> f64 {
        match id {
            ParameterId::Sensor(..) => 1.0,
            ParameterId::Further(index) => {
                if let Some(joint) = self.rotor_of(index) {
                    return self.lever_of_rotor(joint);
                }
                match self.instruments.iter().find_map(|instrument| instrument.drift_of(index)) {
                    None => self.lever_of_term(index),
                    Some(drift) => {
                        let values = self.poses.iter().map(|pose| drift.value(&pose.conditions).abs());
                        let largest = values.fold(0.0, f64::max);
                        if largest > 0.0 { largest } else { 1.0 }
                    }
                }
            }
        }
    }

    fn lever_of_term(&self, index: usize) -> f64 {
        let values: Vec<f64> = self.further.iter().map(|parameter| parameter.prior.nominal).collect();
        let sensor = |joint: &JointPriors| {
            [SensorParameter::PositionGain, SensorParameter::PositionOffset].map(|quantity| joint.of(quantity).nominal)
        };
        let position: Vec<[f64; 2]> = self.joints.iter().map(sensor).collect();
        self.terms.lever(index, &values, &position, &self.poses)
    }

    /// Unit of a joint's sensor parameter inside the program.
    pub fn parameter_unit(&self, joint: usize, quantity: SensorParameter) -> String {
        let prior = &self.joints[joint];
        let prismatic = self.robot.chain.joints()[joint].kind == JointKind::Prismatic;
        let coordinate = if prismatic { "m" } else { "rad" };
        let effort = if prismatic { "N" } else { "(N·m)" };
        let reading = prior.torque_unit.map_or_else(|| "1".to_owned(), |unit| unit.to_string());
        match quantity {
            SensorParameter::TorqueGain => format!("{reading}/{effort}"),
            SensorParameter::TorqueBias => reading,
            SensorParameter::PositionGain => format!("{coordinate}/{}", prior.position_unit.si()),
            SensorParameter::PositionOffset => coordinate.to_owned(),
        }
    }

    /// Why a joint's sensor parameter is fixed and not estimated, if it is.
    pub fn fixed_reason(&self, joint: usize, quantity: SensorParameter) -> Option<&'static str> {
        let prior = self.joints[joint].of(quantity);
        let chain = &self.robot.chain;
        match quantity {
            _ if prior.kind == PriorKind::Fixed => Some(GIVEN),
            SensorParameter::TorqueGain | SensorParameter::TorqueBias if self.joints[joint].torque_unit.is_none() => {
                Some(NO_TORQUE_SENSOR)
            }
            SensorParameter::PositionOffset if chain.root_joint() == Some(joint) => Some(BASE_FRAME_CHOICE),
            SensorParameter::PositionOffset if chain.is_last(joint) && !self.last_frame_is_fixed(joint) => {
                Some(LAST_FRAME_CHOICE)
            }
            _ => None,
        }
    }

    /// Whether a parameter (or `gravity`) is asked for: every one but what is a choice of frame, unless the session
    /// asks for more or less.
    pub fn asks(&self, name: &str) -> bool {
        let listed = |list: &[String]| list.iter().any(|n| n == name);
        let unread = self.further.iter().any(|further| further.fixed == Some(UNREAD) && further.name() == name);
        // How far joints give way is in the way of what is wanted, like the links' moments; so are rotors, and loads.
        let listed_places = self.rotors.iter().chain(&self.load_masses).flatten().copied();
        let mut in_the_way = self.compliances().chain(listed_places);
        let nuisance = in_the_way.any(|index| self.further[index].name() == name);
        let by_default = !unread
            && !nuisance
            && !self.robot.chain.joints().iter().enumerate().any(|(joint, j)| {
                SensorParameter::ALL.iter().any(|q| {
                    let frame = [BASE_FRAME_CHOICE, LAST_FRAME_CHOICE];
                    let no_sensor = self.joints[joint].torque_unit.is_none()
                        && matches!(q, SensorParameter::TorqueGain | SensorParameter::TorqueBias);
                    let frame_choice = || self.fixed_reason(joint, *q).is_some_and(|reason| frame.contains(&reason));
                    // Names are formatted only where they could be the one.
                    name.starts_with(&j.name) && q.name(&j.name) == name && (no_sensor || frame_choice())
                })
            });
        (by_default || listed(&self.ask.add)) && !listed(&self.ask.drop)
    }

    /// Whether something known in the frame of a last link fixes that frame, or that of another one that the same joint moves:
    /// a load's placement, an instrument's mounting, the link's masses, what a residual observes of it, or the joint's offset itself.
    fn last_frame_is_fixed(&self, joint: usize) -> bool {
        let prior = matches!(self.joints[joint].of(SensorParameter::PositionOffset).kind, PriorKind::Gaussian { .. });
        let name = SensorParameter::PositionOffset.name(&self.robot.chain.joints()[joint].name);
        let earlier = self.earlier.as_ref().is_some_and(|earlier| earlier.knows(&name));
        let observed = self.residuals.iter().any(|residual| residual.sees.joints().contains(&joint));
        prior || earlier || observed || self.robot.chain.links_of(joint).any(|link| self.is_known_in_its_frame(link))
    }

    fn is_known_in_its_frame(&self, link: usize) -> bool {
        let known = |load: &&Load| load.link == link && load.position.is_some();
        let placed = match self.inertia {
            // Without lengths only the difference of two placements of one mass has a direction in the link.
            InertiaPrior::Sweep => self.loads.iter().enumerate().any(|(i, load)| {
                let same = |other: &Load| other.mass == load.mass;
                known(&load) && self.loads[..i].iter().filter(known).any(same)
            }),
            _ => self.loads.iter().any(|load| known(&load)),
        };
        let model = matches!(&self.inertia, InertiaPrior::Model { relative_std } if relative_std[link].is_some());
        placed || model || self.instruments.iter().any(|instrument| instrument.link == link)
    }
}

/// What determines most parameters of joint sensors.
pub const MOVE_MORE: &str =
    "add poses that move these joints over a wider range, at several positions of the joints before them";

/// Why a parameter of exact knowledge is fixed.
pub const GIVEN: &str = "given as exact";

/// Why gain and bias of a torque that is not read are fixed.
pub const NO_TORQUE_SENSOR: &str = "the joint has no torque sensor";

/// Why the offset of the joint on which all others hang is fixed.
pub const BASE_FRAME_CHOICE: &str = "it defines the base frame";

/// Why the offset of a last joint is fixed.
pub const LAST_FRAME_CHOICE: &str = "a choice of the last link's frame";
