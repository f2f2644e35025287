//! Every model of a sensor at once.

use gravcal_dynamics::JointKind;
use gravcal_recording::{PositionUnit, TorqueUnit};
use toml::{Table, Value};

use super::declare::declare_terms;
use super::{Options, SensorModel, SensorTerms, Side, Site};
use crate::registry::Registry;
use crate::session::{JointPriors, ParameterPrior, PriorKind};

/// What is known of a sensor beforehand: next to nothing.
pub fn joint_priors() -> JointPriors {
    let start = |nominal| ParameterPrior { nominal, kind: PriorKind::Flat };
    JointPriors {
        torque_unit: Some(TorqueUnit::Count),
        torque_sign_declared: false,
        position_unit: PositionUnit::Radian,
        parameters: [start(6.69), start(2048.0), start(1.0), start(0.2)],
    }
}

/// A formula with these unknowns, which start at zero.
pub fn formula(adds: &str, unknowns: &[&str]) -> Options {
    let said = |name: &&str| {
        let table = Table::from_iter([("unit".into(), "1".into()), ("limit".into(), 0.1.into())]);
        ((*name).to_owned(), Value::Table(table))
    };
    Options::default().with("adds", adds).with("unknowns", Table::from_iter(unknowns.iter().map(said)))
}

/// Every model on every joint of a turning, a sliding and a turning one, where it can be.
pub fn every_term() -> SensorTerms {
    terms_of(RIPPLE, |_| true)
}

/// The same but for those that read other joints' torques.
pub fn every_term_of_own_torques() -> SensorTerms {
    let ripple = "w * sin(o * coordinate + p) + w * tanh(torque / 20) * coordinate[joint2]";
    terms_of(ripple, |model| model.name() != "torque-crosstalk")
}

/// Those of torque sensors.
pub fn every_torque_term() -> SensorTerms {
    terms_of(RIPPLE, |model| model.side() == Side::Torque)
}

const RIPPLE: &str = "w * sin(o * coordinate + p) + w * tanh(torque[joint1] * torque / 20) * coordinate[joint2]";

fn terms_of(ripple: &str, has: impl Fn(&dyn SensorModel) -> bool) -> SensorTerms {
    let registry = Registry::standard();
    let options = Options::default().with("reference_degC", 25).with("orders", vec![1, 3]);
    let kinds = [JointKind::Revolute, JointKind::Prismatic, JointKind::Revolute];
    let prior = joint_priors();
    let mut terms = SensorTerms::default();
    for joint in 0..3 {
        let site = Site::new(joint, &["joint1", "joint2", "joint3"], &kinds, &prior);
        for model in registry.sensor_models().filter(|model| !model.is_repeatable() && has(*model)) {
            if kinds[joint] == JointKind::Revolute || model.side() == Side::Torque {
                terms.extend(declare_terms(model, &site, &options).unwrap().into_iter().map(|(term, _)| term));
            }
        }
        for (kind, adds) in
            [("formula", ripple), ("position-formula", "w * sin(o * position + p) + w * direction * position[joint2]")]
        {
            if !has(registry.sensor_model(kind).unwrap()) {
                continue;
            }
            let declared = declare_terms(registry.sensor_model(kind).unwrap(), &site, &formula(adds, &["w", "o", "p"]));
            terms.extend(declared.unwrap().into_iter().map(|(term, _)| term));
        }
    }
    terms
}
