//! Which parameters the data determine.
//!
//! A parameter is *determined* if no direction without information touches it (rank of the whitened, column-scaled
//! Jacobian), and if its standard deviation is within a limit beyond which a number would mislead: 10 % of a gain (of its
//! estimated value, and of its nominal one), 0.1 rad of an angle (10 mm of a displacement), half the spread of the readings for a
//! bias, 0.1 rad of gravity's direction. The second test is needed because at a noisy estimate a direction without information looks
//! weak instead of empty: an upright base is never estimated as exactly upright. Noise may then be explained by a sensor that hardly
//! reads anything, with a gain that is zero but for its error: precise beside the nominal value, and of no use, not even for its sign.
//!
//! Numbers decide; combinations are what is told of it, with their small parts left out.

use std::collections::BTreeSet;

use gravcal_estimation::{Covariance, Problem, Spectrum, Values, sparse_basis};
use gravcal_robot_model::parameter::{ParameterId, Quantity};
use gravcal_robot_model::session::Session;
use gravcal_robot_model::session::parameters::GAIN_LIMIT;

use crate::joint::Layout;

/// Coefficients of a combination below this share of the largest are not told.
const READABLE: f64 = 0.02;
/// A direction without information touches a column if the column's part of it, in scaled coordinates, exceeds this. Null vectors are
/// accurate to 1e-7 at the tolerance of the rank.
const TOUCHED: f64 = 1e-5;

/// What the data say of the parameters and gravity.
#[derive(Debug)]
pub(crate) struct Judgement {
    /// Whether gravity is determined.
    pub gravity: bool,
    /// Combinations without information, and those with too little.
    pub combinations: Vec<Combination>,
    /// Every parameter that is not determined.
    open: BTreeSet<ParameterId>,
}

impl Judgement {
    /// Whether a parameter is determined; held ones count as such.
    pub fn determines(&self, id: ParameterId) -> bool {
        !self.open.contains(&id)
    }

    /// Counts as open what is so in another judgement.
    pub fn leave_open_what_is_open_in(&mut self, other: &Judgement) {
        if self.gravity && !other.gravity {
            self.gravity = false;
            self.combinations.push(Combination::of_gravity(None));
        }
        self.leave_open(other.open.iter().copied());
    }

    /// Counts parameters as open for a reason that is told elsewhere.
    pub fn leave_unsaid(&mut self, parameters: impl IntoIterator<Item = ParameterId>) {
        self.open.extend(parameters);
    }

    /// Counts gravity and all parameters as open for a reason that is told elsewhere.
    pub fn leave_all_unsaid(&mut self, session: &Session) {
        self.gravity = false;
        self.leave_unsaid(session.parameters());
    }

    /// Counts parameters as without any information.
    pub fn leave_open(&mut self, parameters: impl IntoIterator<Item = ParameterId>) {
        for id in parameters {
            if self.open.insert(id) {
                self.combinations.push(Combination::alone(id, None));
            }
        }
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
}

impl Combination {
    fn alone(parameter: ParameterId, std_over_limit: Option<f64>) -> Combination {
        Combination { parameters: vec![(parameter, 1.0)], gravity: false, std_over_limit }
    }

    fn of_gravity(std_over_limit: Option<f64>) -> Combination {
        Combination { parameters: Vec::new(), gravity: true, std_over_limit }
    }

    fn contains(&self, parameter: ParameterId) -> bool {
        self.parameters.iter().any(|(id, _)| *id == parameter)
    }
}

/// A solution as it is judged.
pub(crate) struct Judged<'a> {
    pub problem: &'a Problem,
    pub values: &'a Values,
    pub layout: &'a Layout,
    /// Of the problem at the values.
    pub spectrum: &'a Spectrum,
}

/// Judges a solution by its rank and this covariance. `spreads`: largest less smallest torque reading of each joint.
pub(crate) fn judge(session: &Session, solution: &Judged<'_>, covariance: &Covariance, spreads: &[f64]) -> Judgement {
    let asked = ParameterColumns::new(session, solution, spreads);
    let mut judgement = asked.without_information(solution.spectrum);
    ParameterColumns::tell_the_rest(&mut judgement);
    asked.add_little_information(covariance, &mut judgement);
    judgement
}

/// Column and limit of use of gravity and every parameter.
pub(crate) fn limits_of_use(session: &Session, solution: &Judged<'_>, spreads: &[f64]) -> Vec<(usize, f64)> {
    let asked = ParameterColumns::new(session, solution, spreads);
    asked.0.iter().map(|asked| (asked.column, asked.limit)).collect()
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

/// A column of a parameter or of gravity.
struct Asked {
    column: usize,
    /// `None`: gravity.
    identity: Option<ParameterId>,
    /// Standard deviation beyond which a number would mislead.
    limit: f64,
    /// Unit in which a combination is told: the value itself for a gain, so that a common scale shows as such.
    unit: f64,
}

/// All of them.
struct ParameterColumns(Vec<Asked>);

impl ParameterColumns {
    fn new(session: &Session, solution: &Judged<'_>, spreads: &[f64]) -> Self {
        let Judged { problem, values, layout, .. } = solution;
        let of_gravity = 0.1 * session.gravity.magnitude;
        let gravity = problem.columns_of(layout.gravity);
        let mut all: Vec<Asked> =
            gravity.map(|column| Asked { column, identity: None, limit: of_gravity, unit: of_gravity }).collect();
        for id in session.parameters() {
            let value = values.scalar(layout.block(id));
            let limit = limit(session, id, value, spreads);
            let unit = own_limit(id, value).unwrap_or(limit);
            let positive = |v: f64| v.max(f64::MIN_POSITIVE);
            for column in problem.columns_of(layout.block(id)) {
                all.push(Asked { column, identity: Some(id), limit: positive(limit), unit: positive(unit) });
            }
        }
        ParameterColumns(all)
    }

    fn without_information(&self, spectrum: &Spectrum) -> Judgement {
        let touched = |asked: &&Asked| spectrum.null_share(asked.column) > TOUCHED;
        let touched: Vec<Option<ParameterId>> = self.0.iter().filter(touched).map(|asked| asked.identity).collect();
        let columns: Vec<usize> = self.0.iter().map(|asked| asked.column).collect();
        let in_units = |v: Vec<f64>| unit_length(v.iter().zip(&self.0).map(|(c, asked)| c / asked.unit).collect());
        let directions: Vec<Vec<f64>> = spectrum.null_space_within(&columns).into_iter().map(in_units).collect();
        let basis = sparse_basis(&directions, TOUCHED);
        let combinations = basis.iter().map(|direction| self.combination(direction));
        Judgement {
            gravity: !touched.contains(&None),
            combinations: combinations.collect(),
            open: touched.into_iter().flatten().collect(),
        }
    }

    /// Tells by themselves the open parameters that no combination tells.
    fn tell_the_rest(judgement: &mut Judgement) {
        let told = |id: &ParameterId| judgement.combinations.iter().any(|c| c.contains(*id));
        let untold: Vec<ParameterId> = judgement.open.iter().copied().filter(|id| !told(id)).collect();
        judgement.combinations.extend(untold.into_iter().map(|id| Combination::alone(id, None)));
    }

    /// Parameters beyond their limit, told one by one.
    fn add_little_information(&self, covariance: &Covariance, judgement: &mut Judgement) {
        let mut gravity: f64 = 0.0;
        for Asked { column, identity, limit, .. } in &self.0 {
            let ratio = covariance.std(*column) / limit;
            match identity {
                None => gravity = gravity.max(ratio),
                Some(id) if ratio > 1.0 && judgement.open.insert(*id) => {
                    judgement.combinations.push(Combination::alone(*id, Some(ratio)));
                }
                Some(_) => {}
            }
        }
        if gravity > 1.0 && judgement.gravity {
            judgement.gravity = false;
            judgement.combinations.push(Combination::of_gravity(Some(gravity)));
        }
    }

    fn combination(&self, direction: &[f64]) -> Combination {
        let largest = direction.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let mut combination = Combination { parameters: Vec::new(), gravity: false, std_over_limit: None };
        for (coefficient, asked) in direction.iter().zip(&self.0) {
            if coefficient.abs() > READABLE * largest {
                match asked.identity {
                    None => combination.gravity = true,
                    Some(id) => combination.parameters.push((id, *coefficient)),
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
