//! Which sensor parameters the data determine.
//!
//! A parameter is *determined* if no direction without information touches it (rank of the whitened, column-scaled
//! Jacobian), and if its standard deviation is within a limit beyond which a number would mislead: 10 % of a gain's nominal value,
//! 0.1 rad of an angle (10 mm of a displacement), half the spread of the readings for a bias, 0.1 rad of gravity's
//! direction. The second test is needed because at a noisy estimate a direction without information looks weak
//! instead of empty: an upright base is never estimated as exactly upright.

use gravcal_estimation::{Covariance, Problem, Spectrum, Values, sparse_basis};
use gravcal_kinematics::JointKind;

use crate::joint::Layout;
use crate::parameter::Quantity;
use crate::session::Session;

/// Coefficients of a combination below this share of the largest are not told.
const READABLE: f64 = 0.02;

/// What the data say of the sensor parameters and gravity.
#[derive(Debug)]
pub(crate) struct Judgement {
    /// By joint and quantity; held parameters count as determined.
    pub parameters: Vec<[bool; 4]>,
    /// Whether gravity is determined.
    pub gravity: bool,
    /// Combinations without information, and those with too little.
    pub combinations: Vec<Combination>,
}

/// A combination of sensor parameters that is not determined.
#[derive(Clone, Debug)]
pub(crate) struct Combination {
    /// Joint, quantity and coefficient: relative change of a gain, change of an angle or bias in units
    /// of its limit.
    pub sensors: Vec<(usize, Quantity, f64)>,
    /// Whether gravity takes part.
    pub gravity: bool,
    /// Standard deviation in units of the limit; `None` where there is no information at all.
    pub std_over_limit: Option<f64>,
    /// The sensor parameter in it on which the readings depend most: held, it fixes the combination.
    pub anchor: Option<(usize, Quantity)>,
}

impl Combination {
    /// Whether it is this one parameter.
    fn is_only(&self, parameter: (usize, Quantity)) -> bool {
        !self.gravity && self.sensors.len() == 1 && (self.sensors[0].0, self.sensors[0].1) == parameter
    }

    /// Whether holding this parameter would fix a combination that has no effect.
    pub fn breaks_with(&self, parameter: (usize, Quantity)) -> bool {
        self.std_over_limit.is_none() && self.sensors.iter().any(|(j, q, _)| (*j, *q) == parameter)
    }
}

/// Judges a solution. `spreads`: largest less smallest torque reading of each joint; `idle`: joints that carry no
/// gravity, which cannot anchor a combination.
pub(crate) fn judge(
    session: &Session,
    problem: &Problem,
    values: &Values,
    layout: &Layout,
    (spectrum, covariance): (&Spectrum, &Covariance),
    spreads: &[f64],
    idle: &[bool],
) -> Judgement {
    let asked = SensorColumns::new(session, problem, values, layout, spreads, idle);
    let mut combinations = asked.without_information(spectrum);
    combinations.extend(asked.with_little_information(covariance, &combinations));
    let touched = |joint: usize, quantity: Quantity| {
        combinations.iter().any(|c| c.sensors.iter().any(|(j, q, _)| (*j, *q) == (joint, quantity)))
    };
    Judgement {
        parameters: (0..session.joints.len())
            .map(|joint| Quantity::ALL.map(|quantity| !touched(joint, quantity)))
            .collect(),
        gravity: !combinations.iter().any(|c| c.gravity),
        combinations,
    }
}

/// The columns of sensor parameters and gravity, each with what it is and its limit.
struct SensorColumns {
    columns: Vec<usize>,
    /// `None`: gravity.
    identity: Vec<Option<(usize, Quantity)>>,
    /// Standard deviation beyond which a number would mislead.
    limits: Vec<f64>,
    /// Unit in which a combination is told: the value itself for a gain, so that a common scale shows as such.
    units: Vec<f64>,
    idle: Vec<bool>,
}

impl SensorColumns {
    fn new(
        session: &Session,
        problem: &Problem,
        values: &Values,
        layout: &Layout,
        spreads: &[f64],
        idle: &[bool],
    ) -> Self {
        let mut all = SensorColumns {
            columns: Vec::new(),
            identity: Vec::new(),
            limits: Vec::new(),
            units: Vec::new(),
            idle: idle.to_vec(),
        };
        for column in problem.columns_of(layout.gravity) {
            let limit = 0.1 * session.gravity.magnitude;
            all.push(column, None, limit, limit);
        }
        for (joint, ids) in layout.sensors.iter().enumerate() {
            let turns = session.robot.chain.joints()[joint].kind == JointKind::Revolute;
            for quantity in Quantity::ALL {
                let id = ids[quantity as usize];
                let limit = match quantity {
                    Quantity::TorqueGain | Quantity::PositionGain => {
                        0.1 * session.joints[joint].of(quantity).nominal.abs()
                    }
                    Quantity::TorqueBias => 0.5 * spreads[joint],
                    Quantity::PositionOffset if turns => 0.1,
                    Quantity::PositionOffset => 0.01,
                };
                let unit = match quantity {
                    Quantity::TorqueGain | Quantity::PositionGain => 0.1 * values.scalar(id).abs(),
                    Quantity::TorqueBias | Quantity::PositionOffset => limit,
                };
                for column in problem.columns_of(id) {
                    let positive = |v: f64| v.max(f64::MIN_POSITIVE);
                    all.push(column, Some((joint, quantity)), positive(limit), positive(unit));
                }
            }
        }
        all
    }

    fn push(&mut self, column: usize, identity: Option<(usize, Quantity)>, limit: f64, unit: f64) {
        self.columns.push(column);
        self.identity.push(identity);
        self.limits.push(limit);
        self.units.push(unit);
    }

    fn without_information(&self, spectrum: &Spectrum) -> Vec<Combination> {
        let directions: Vec<Vec<f64>> = spectrum
            .null_space_within(&self.columns)
            .iter()
            .map(|v| unit_length(v.iter().zip(&self.units).map(|(c, unit)| c / unit).collect()))
            .collect();
        let mut combinations: Vec<Combination> = Vec::new();
        for direction in sparse_basis(&directions, 1e-5) {
            let taken: Vec<_> = combinations.iter().filter_map(|c| c.anchor).collect();
            let anchor = self.anchor(&direction, spectrum, &taken);
            combinations.push(Combination { anchor, ..self.combination(&direction, None) });
        }
        combinations
    }

    fn anchor(&self, direction: &[f64], spectrum: &Spectrum, taken: &[(usize, Quantity)]) -> Option<(usize, Quantity)> {
        let largest = direction.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let effect = |i: &usize| spectrum.column_scale(self.columns[*i]) * self.units[*i];
        (0..direction.len())
            .filter(|i| direction[*i].abs() > READABLE * largest)
            .filter(|i| self.identity[*i].is_some_and(|identity| !taken.contains(&identity)))
            .filter(|i| self.identity[*i].is_some_and(|(joint, _)| !self.idle[joint]))
            .max_by(|a, b| effect(a).total_cmp(&effect(b)))
            .and_then(|i| self.identity[i])
    }

    /// Parameters beyond their limit, told one by one: as they are known when the combinations without information
    /// are fixed by their anchors. An anchor itself is told in its combination only.
    fn with_little_information(&self, covariance: &Covariance, without: &[Combination]) -> Vec<Combination> {
        let mut weak: Vec<Combination> = Vec::new();
        for (index, identity) in self.identity.iter().enumerate() {
            let told = match identity {
                None => weak.iter().chain(without).any(|c| c.gravity),
                Some(identity) => without.iter().any(|c| c.anchor == Some(*identity) || c.is_only(*identity)),
            };
            let ratio = covariance.std_of(&self.anchored(index, without)) / self.limits[index];
            if ratio > 1.0 && !told {
                let mut direction = vec![0.0; self.columns.len()];
                direction[index] = 1.0;
                weak.push(self.combination(&direction, Some(ratio)));
            }
        }
        weak
    }

    /// The change of one column, with the combinations without information fixed by their anchors.
    fn anchored(&self, index: usize, without: &[Combination]) -> Vec<(usize, f64)> {
        let mut terms = vec![(self.columns[index], 1.0)];
        let identity = self.identity[index];
        for combination in without.iter().filter(|c| c.anchor != identity) {
            let coefficient = |identity: (usize, Quantity)| {
                combination.sensors.iter().find(|(j, q, _)| (*j, *q) == identity).map(|(_, _, c)| *c)
            };
            let own = identity.and_then(coefficient);
            if let (Some(own), Some(anchor), Some(of_anchor)) =
                (own, combination.anchor, combination.anchor.and_then(coefficient))
                && let Some(at) = self.identity.iter().position(|i| *i == Some(anchor))
            {
                let in_units = own * self.units[index] / (of_anchor * self.units[at]);
                terms.push((self.columns[at], -in_units));
            }
        }
        terms
    }

    fn combination(&self, direction: &[f64], std_over_limit: Option<f64>) -> Combination {
        let largest = direction.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let mut combination = Combination { sensors: Vec::new(), gravity: false, std_over_limit, anchor: None };
        for (coefficient, identity) in direction.iter().zip(&self.identity) {
            if coefficient.abs() > READABLE * largest {
                match identity {
                    None => combination.gravity = true,
                    Some((joint, quantity)) => combination.sensors.push((*joint, *quantity, *coefficient)),
                }
            }
        }
        combination
    }
}

fn unit_length(v: Vec<f64>) -> Vec<f64> {
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    v.iter().map(|c| c / length).collect()
}
