//! Which parameters the data determine.
//!
//! A parameter is *determined* if no direction without information touches it (rank of the whitened, column-scaled
//! Jacobian), and if its standard deviation is within a limit beyond which a number would mislead: 10 % of a gain (of its
//! estimated value, and of its nominal one), 0.1 rad of an angle (10 mm of a displacement), half the spread of the readings for a
//! bias, 0.1 rad of gravity's direction. The second test is needed because at a noisy estimate a direction without information looks
//! weak instead of empty: an upright base is never estimated as exactly upright. Noise may then be explained by a sensor that hardly
//! reads anything, with a gain that is zero but for its error: precise beside the nominal value, and of no use, not even for its sign.

use gravcal_estimation::{Covariance, Problem, Spectrum, Values, sparse_basis};

use crate::joint::Layout;
use crate::parameter::{ParameterId, Quantity};
use crate::session::Session;
use crate::session::parameters::GAIN_LIMIT;

/// Coefficients of a combination below this share of the largest are not told.
const READABLE: f64 = 0.02;

/// What the data say of the parameters and gravity.
#[derive(Debug)]
pub(crate) struct Judgement {
    /// Whether gravity is determined.
    pub gravity: bool,
    /// Combinations without information, and those with too little.
    pub combinations: Vec<Combination>,
}

impl Judgement {
    /// Whether a parameter is determined; held ones count as such.
    pub fn determines(&self, id: ParameterId) -> bool {
        !self.combinations.iter().any(|combination| combination.contains(id))
    }
}

/// A combination of parameters that is not determined.
#[derive(Clone, Debug)]
pub(crate) struct Combination {
    /// Parameter and coefficient: relative change of a gain, change of any other in units of its limit.
    pub parameters: Vec<(ParameterId, f64)>,
    /// Whether gravity takes part.
    pub gravity: bool,
    /// Standard deviation in units of the limit; `None` where there is no information at all.
    pub std_over_limit: Option<f64>,
    /// The parameter in it on which the readings depend most: held, it fixes the combination.
    pub anchor: Option<ParameterId>,
}

impl Combination {
    /// One parameter without any information.
    pub fn alone(parameter: ParameterId) -> Combination {
        Combination { parameters: vec![(parameter, 1.0)], gravity: false, std_over_limit: None, anchor: None }
    }

    /// Whether it is this one parameter.
    fn is_only(&self, parameter: ParameterId) -> bool {
        !self.gravity && self.parameters.len() == 1 && self.contains(parameter)
    }

    /// Whether a parameter takes part.
    pub fn contains(&self, parameter: ParameterId) -> bool {
        self.parameters.iter().any(|(id, _)| *id == parameter)
    }

    /// Whether holding this parameter would fix a combination that has no effect.
    pub fn breaks_with(&self, parameter: ParameterId) -> bool {
        self.std_over_limit.is_none() && self.contains(parameter)
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
    let asked = ParameterColumns::new(session, problem, values, layout, spreads, idle);
    let mut combinations = asked.without_information(spectrum);
    combinations.extend(asked.with_little_information(covariance, &combinations));
    Judgement { gravity: !combinations.iter().any(|c| c.gravity), combinations }
}

/// Standard deviation beyond which the number found for a parameter would mislead, in its unit.
pub(crate) fn limit(session: &Session, id: ParameterId, value: f64, spreads: &[f64]) -> f64 {
    let limit = session.limit(id, spreads);
    own_limit(id, value).map_or(limit, |own| limit.min(own))
}

/// The limit of a gain that comes from its own value.
fn own_limit(id: ParameterId, value: f64) -> Option<f64> {
    let is_gain = matches!(id, ParameterId::Sensor(_, Quantity::TorqueGain | Quantity::PositionGain));
    is_gain.then(|| GAIN_LIMIT * value.abs())
}

/// The columns of parameters and gravity, each with what it is and its limit.
struct ParameterColumns {
    columns: Vec<usize>,
    /// `None`: gravity.
    identity: Vec<Option<ParameterId>>,
    /// Standard deviation beyond which a number would mislead.
    limits: Vec<f64>,
    /// Unit in which a combination is told: the value itself for a gain, so that a common scale shows as such.
    units: Vec<f64>,
    idle: Vec<bool>,
}

impl ParameterColumns {
    fn new(
        session: &Session,
        problem: &Problem,
        values: &Values,
        layout: &Layout,
        spreads: &[f64],
        idle: &[bool],
    ) -> Self {
        let mut all = ParameterColumns {
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
        for id in session.parameters() {
            let value = values.scalar(layout.block(id));
            let limit = limit(session, id, value, spreads);
            let unit = own_limit(id, value).unwrap_or(limit);
            for column in problem.columns_of(layout.block(id)) {
                let positive = |v: f64| v.max(f64::MIN_POSITIVE);
                all.push(column, Some(id), positive(limit), positive(unit));
            }
        }
        all
    }

    fn push(&mut self, column: usize, identity: Option<ParameterId>, limit: f64, unit: f64) {
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

    fn anchor(&self, direction: &[f64], spectrum: &Spectrum, taken: &[ParameterId]) -> Option<ParameterId> {
        let largest = direction.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let effect = |i: &usize| spectrum.column_scale(self.columns[*i]) * self.units[*i];
        (0..direction.len())
            .filter(|i| direction[*i].abs() > READABLE * largest)
            .filter(|i| self.identity[*i].is_some_and(|identity| !taken.contains(&identity)))
            .filter(|i| !matches!(self.identity[*i], Some(ParameterId::Sensor(joint, _)) if self.idle[joint]))
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
            let coefficient =
                |identity: ParameterId| combination.parameters.iter().find(|(id, _)| *id == identity).map(|(_, c)| *c);
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
        let mut combination = Combination { parameters: Vec::new(), gravity: false, std_over_limit, anchor: None };
        for (coefficient, identity) in direction.iter().zip(&self.identity) {
            if coefficient.abs() > READABLE * largest {
                match identity {
                    None => combination.gravity = true,
                    Some(id) => combination.parameters.push((*id, *coefficient)),
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
