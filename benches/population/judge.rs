//! What is wrong with an answer, beside the truth and what exact rank says of it.

use std::collections::BTreeMap;
use std::fmt;

use gravcal_calibration::result::{EstimatorResult, GravityResult, ParameterResult, Verdict};
use nalgebra::Vector3;

use super::calibrate::Answer;
use super::draw::NOMINAL_GAIN;
use super::independent::Information;
use super::model::{State, state};
use super::truth::Truth;
use super::write::readings;

/// A value this many of its standard deviations from the truth is wrong.
const FAR: f64 = 6.0;
/// A standard deviation below this share of the bound is wrong.
const NARROW: f64 = 0.5;
/// Standard deviation beyond which a number is of no use: of a gain, relative; of an angle, rad; of a bias, in spreads of its readings;
/// of a tool, kg and kg·m.
const USE_GAIN: f64 = 0.1;
const USE_ANGLE: f64 = 0.1;
const USE_TOOL: [f64; 4] = [0.1, 0.01, 0.01, 0.01];
const USE_BIAS: f64 = 0.5;

/// What may be wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// The session is refused.
    Refused,
    /// No answer, as without convergence.
    Failed,
    /// A value is told that exact rank denies.
    Denied,
    /// A value is too far from the truth.
    Far,
    /// A standard deviation is too small.
    Narrow,
    /// Gravity points up.
    UpsideDown,
    /// Another method tells other parameters.
    Differs,
}

impl Cause {
    /// Every cause.
    pub const ALL: [Cause; 7] =
        [Cause::Refused, Cause::Failed, Cause::Denied, Cause::Far, Cause::Narrow, Cause::UpsideDown, Cause::Differs];
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Cause::Refused => "refused",
            Cause::Failed => "without an answer",
            Cause::Denied => "told what rank denies",
            Cause::Far => "more than 6 std off",
            Cause::Narrow => "std below half the bound",
            Cause::UpsideDown => "gravity upside down",
            Cause::Differs => "methods tell different parameters",
        })
    }
}

/// An answer beside the truth.
#[derive(Clone, Debug, Default)]
pub struct Judged {
    /// What is wrong, with words.
    pub wrong: Vec<(Cause, String)>,
    /// Of every value told of which exact rank leaves a value: its error in standard deviations, and whether its 95 % interval holds
    /// the truth.
    pub errors: Vec<(f64, bool)>,
    /// Names of what has less than half the bound, but not of that within reach.
    pub narrow_without_end: Vec<String>,
    /// Names of what is told and exact rank denies, but not where no unknown goes beyond reason.
    pub denied_without_end: Vec<String>,
    /// Names of all that is told.
    pub reported: Vec<String>,
    /// How many values are determined well enough to be of use, by their bounds; and how many of these are told.
    pub of_use: [usize; 2],
}

/// Judges an answer.
pub fn judge(truth: &Truth, information: &BTreeMap<String, Information>, answer: &Answer) -> Judged {
    let mut judged = Judged::default();
    let result = match &answer.result {
        Ok(result) => result,
        Err(error) => {
            judged.wrong.push((Cause::Refused, error.clone()));
            return judged;
        }
    };
    if result.verdict == Verdict::Failed {
        judged.wrong.push((Cause::Failed, result.termination.clone()));
    }
    judged.parameters(truth, information, result);
    judged.gravity(truth, information, result);
    judged
}

impl Judged {
    fn parameters(&mut self, truth: &Truth, information: &BTreeMap<String, Information>, result: &EstimatorResult) {
        let State { names, values } = state(truth);
        let limits = limits_of_use(truth);
        for ((name, value), limit) in names.iter().zip(values).skip(2).zip(limits) {
            let (Some(known), Some(parameter)) = (information.get(name), result.parameter(name)) else { continue };
            let estimated = Estimated::of(parameter);
            self.count_use(known.determined() && known.bound <= limit, estimated.is_some());
            if let Some(estimated) = estimated {
                self.reported.push(name.clone());
                self.value(name, &estimated, (value, limit), known);
            }
        }
    }

    fn gravity(&mut self, truth: &Truth, information: &BTreeMap<String, Information>, result: &EstimatorResult) {
        let known: Vec<Information> =
            ["gravity.1", "gravity.2"].iter().filter_map(|name| information.get(*name).copied()).collect();
        let determined = known.iter().all(Information::determined);
        self.count_use(determined && known.iter().all(|known| known.bound <= USE_ANGLE), result.gravity.is_some());
        let within_reach = known.iter().all(|known| known.bound_within_reach <= USE_ANGLE);
        let Some(found) = &result.gravity else { return };
        self.reported.push("gravity".to_owned());
        let GravityResult { vector_m_per_s2: vector, std_m_per_s2: std, ci95_m_per_s2: ci95, .. } = found;
        if truth.gravity.dot(&Vector3::from(*vector)) < 0.0 {
            self.wrong.push((Cause::UpsideDown, format!("gravity {vector:.3?}")));
        } else if !determined && !within_reach {
            let share = known.iter().fold(0.0_f64, |share, known| share.max(known.share));
            self.wrong.push((Cause::Denied, format!("gravity told, null share {share:.1e}")));
        } else {
            self.denied_without_end.extend((!determined).then(|| "gravity".to_owned()));
            for axis in 0..2 {
                let estimated = Estimated { value: vector[axis], std: std[axis], ci95: ci95[axis] };
                self.error(&format!("gravity[{axis}]"), &estimated, truth.gravity[axis]);
            }
        }
    }

    fn value(&mut self, name: &str, estimated: &Estimated, (truth, limit): (f64, f64), known: &Information) {
        if !known.determined() && known.bound_within_reach > limit {
            let off = (estimated.value - truth) / estimated.std;
            let (value, std) = (estimated.value, estimated.std);
            let words =
                format!("{name} {value:.5} ± {std:.2e} (truth {truth:.5}, z {off:.1}), null share {:.1e}", known.share);
            self.wrong.push((Cause::Denied, words));
            return;
        }
        self.denied_without_end.extend((!known.determined()).then(|| name.to_owned()));
        self.error(name, estimated, truth);
        if estimated.std < NARROW * known.bound_within_reach {
            let share = estimated.std / known.bound_within_reach;
            self.wrong.push((Cause::Narrow, format!("{name} std {:.2e} is {share:.2} of the bound", estimated.std)));
        } else if estimated.std < NARROW * known.bound {
            self.narrow_without_end.push(name.to_owned());
        }
    }

    fn error(&mut self, name: &str, estimated: &Estimated, truth: f64) {
        let Estimated { value, std, ci95: [low, high] } = *estimated;
        let off = (value - truth) / std;
        self.errors.push((off, low <= truth && truth <= high));
        if off.is_nan() || off.abs() > FAR {
            self.wrong.push((Cause::Far, format!("{name} {value:.5} ± {std:.2e} (truth {truth:.5}, z {off:.1})")));
        }
    }

    fn count_use(&mut self, of_use: bool, reported: bool) {
        self.of_use[0] += usize::from(of_use);
        self.of_use[1] += usize::from(of_use && reported);
    }

    /// Takes up what is wrong with the answer of another method, and where it tells other parameters.
    pub fn beside(&mut self, method: &str, other: Judged) {
        let only = |a: &[String], b: &[String]| a.iter().filter(|name| !b.contains(name)).cloned().collect::<Vec<_>>();
        let (more, less) = (only(&other.reported, &self.reported), only(&self.reported, &other.reported));
        self.wrong.extend(other.wrong.into_iter().map(|(cause, words)| (cause, format!("{method}: {words}"))));
        if !more.is_empty() || !less.is_empty() {
            self.wrong.push((Cause::Differs, format!("{method} also tells {more:?}, does not tell {less:?}")));
        }
    }

    /// The causes, each once.
    pub fn causes(&self) -> Vec<Cause> {
        Cause::ALL.into_iter().filter(|cause| self.wrong.iter().any(|(wrong, _)| wrong == cause)).collect()
    }
}

/// A value with its uncertainty.
struct Estimated {
    value: f64,
    std: f64,
    ci95: [f64; 2],
}

impl Estimated {
    /// Nothing where no value is told, or where it is no estimate but held.
    fn of(parameter: &ParameterResult) -> Option<Estimated> {
        let ParameterResult { value, std, ci95, held, .. } = parameter;
        let estimated = Estimated { value: (*value)?, std: (*std)?, ci95: (*ci95)? };
        (held.is_none() && estimated.std != 0.0).then_some(estimated)
    }
}

/// Of each unknown behind gravity; infinite for bodies and placements, which nobody asks for.
fn limits_of_use(truth: &Truth) -> Vec<f64> {
    let nominal = if truth.said.counts { NOMINAL_GAIN } else { 1.0 };
    let readings = readings(truth);
    let spread = |joint: usize| {
        let own = readings.iter().skip(joint).step_by(truth.channels());
        own.clone().fold(f64::MIN, |most, y| most.max(*y)) - own.fold(f64::MAX, |least, y| least.min(*y))
    };
    let gains = truth.sensors.torque_gain.iter().map(|gain| USE_GAIN * gain.abs().min(nominal));
    let joints = 0..truth.arm.joint_count();
    let biases = joints.clone().map(|joint| USE_BIAS * spread(joint));
    let arm = gains.chain(biases).chain(joints.clone().map(|_| USE_GAIN)).chain(joints.clone().map(|_| USE_ANGLE));
    let others = 4 * truth.arm.joint_count() + [0, 3, 5][truth.placements.len()];
    let wrist = [USE_GAIN; 6]
        .into_iter()
        .chain((truth.arm.joint_count()..truth.channels()).map(|axis| USE_BIAS * spread(axis)));
    arm.chain(std::iter::repeat_n(f64::INFINITY, others)).chain(wrist).chain(USE_TOOL).collect()
}
