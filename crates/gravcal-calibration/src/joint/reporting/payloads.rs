//! Loads of unknown mass: what the link with them has more than the link without.
//!
//! ```text
//!     m = m₁ − m₀,    c = (h₁ − h₀)/m,    I_c = I₁ − I₀ − (h·h 1 − h hᵀ)/m,    h = h₁ − h₀
//! ```
//!
//! 0: the link by itself, 1: with the load. Differences can be determined where neither body is. Whether they are is judged as all else: no
//! direction without information may change them.

use gravcal_estimation::BlockId;
use gravcal_estimation::statistics::LinearFunction;
use gravcal_robot_model::number::significant;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{LAST_FRAME_CHOICE, Load, Session};

use crate::joint::solved::Solved;
use crate::joint::variables::WithPayload;
use crate::result::{PayloadNumber, PayloadResult};

/// Share of a direction without information along a difference from which on that is open, in scaled coordinates.
const OPEN: f64 = 1e-5;
/// A mass that is less than so many standard deviations has no centre.
const WEIGHED: f64 = 3.0;

/// What is found of each load of unknown mass.
pub(crate) fn payloads(session: &Session, solved: &Solved) -> Vec<PayloadResult> {
    let unknown = session.loads.iter().zip(&solved.built.variables.with_payloads).filter(|(load, _)| load.is_unknown());
    unknown.map(|(load, with)| Payload::new(session, solved, load, *with).report()).collect()
}

/// In which frame the centre of mass of a load stands whose link's own is a choice.
pub(super) fn frame_notes(session: &Session, payloads: &[PayloadResult]) -> Vec<String> {
    let chain = &session.robot.chain;
    let links = chain.links();
    let note = |payload: &PayloadResult| {
        let link = links.iter().position(|link| link.name == payload.link)?;
        let chosen = |joint: &usize| {
            let reason = session.fixed_reason(*joint, SensorParameter::PositionOffset);
            chain.moves(*joint, link) && reason == Some(LAST_FRAME_CHOICE)
        };
        let joint = (0..session.joints.len()).find(chosen)?;
        let center = payload.center_of_mass_m.as_ref()?;
        let far = center.iter().map(|number| number.value * number.value).sum::<f64>().sqrt();
        let name = &chain.joints()[joint].name;
        Some(format!(
            "The centre of mass of {} is told with {} held, as no reading tells it, and the frame of link {} turns with that offset. For each degree that it is \
             off, the centre lies up to {} mm elsewhere, about the axis of {name}; its interval does not include that. Where the offset is known, state \
             it as fixed.",
            payload.load,
            SensorParameter::PositionOffset.name(name),
            payload.link,
            significant(1e3 * far * f64::to_radians(1.0), 2)
        ))
    };
    payloads.iter().filter_map(note).collect()
}

struct Payload<'a> {
    solved: &'a Solved,
    load: &'a Load,
    link: String,
    with: Option<WithPayload>,
}

impl<'a> Payload<'a> {
    fn new(session: &Session, solved: &'a Solved, load: &'a Load, with: Option<WithPayload>) -> Self {
        Payload { solved, load, link: session.robot.chain.links()[load.link].name.clone(), with }
    }

    fn report(&self) -> PayloadResult {
        let mut reported = PayloadResult {
            load: self.load.name.clone(),
            link: self.link.clone(),
            mass_kg: None,
            center_of_mass_m: None,
            tensor_kg_m2: None,
            undetermined: None,
        };
        let variables = &self.solved.built.variables;
        let bare = variables.inertia.get(self.load.link).copied();
        let Some((with, bare)) = self.with.zip(bare) else {
            reported.undetermined = Some("no pose carries it".into());
            return reported;
        };
        if self.solved.built.problem.block(bare).fixed.is_some() {
            reported.undetermined =
                Some(format!("no pose is read without it: record poses of link {} without it, too", self.link));
            return reported;
        }
        let moments = [0, 1, 2, 3].map(|component| self.difference(with.moments, bare, component));
        let Some(mass) = moments[0].number(self.solved) else {
            reported.undetermined = Some(SCALE.into());
            return reported;
        };
        reported.mass_kg = Some(mass);
        if mass.value < WEIGHED * mass.std {
            reported.undetermined = Some("the centre of mass: its mass is not told from zero".into());
            return reported;
        }
        let centre = [1, 2, 3].map(|axis| moments[axis].over(&moments[0]).number(self.solved));
        let [Some(x), Some(y), Some(z)] = centre else {
            reported.undetermined =
                Some("the centre of mass: add poses that turn the link which carries it to other sides".into());
            return reported;
        };
        reported.center_of_mass_m = Some([x, y, z]);
        let tensor = with.tensor.zip(variables.tensors.get(self.load.link).copied());
        reported.tensor_kg_m2 = tensor.and_then(|(with, bare)| {
            let entries = PAIRS.iter().enumerate().map(|(component, pair)| {
                self.difference(with, bare, component).less(&steiner(&moments, *pair)).number(self.solved)
            });
            let entries: Option<Vec<PayloadNumber>> = entries.collect();
            entries.and_then(|entries| entries.try_into().ok())
        });
        // Of an arm that stands nobody expects it.
        if tensor.is_some() && reported.tensor_kg_m2.is_none() {
            reported.undetermined = Some("the inertia tensor: record the arm in motion with and without it".into());
        }
        reported
    }

    /// A component of the link with the load less that of the link without.
    fn difference(&self, with: BlockId, bare: BlockId, component: usize) -> WithSlopes {
        let (problem, values) = (&self.solved.built.problem, &self.solved.estimate.values);
        let column = |id: BlockId| problem.columns_of(id).nth(component);
        let function = [(column(with), 1.0), (column(bare), -1.0)];
        let function = function.into_iter().filter_map(|(column, sign)| Some((column?, sign))).collect();
        WithSlopes { value: values.get(with)[component] - values.get(bare)[component], function }
    }
}

const SCALE: &str = "the mass: what the readings say of it goes with something that they leave open, as a rule the common scale of the torque \
                     gains. State torque gains that are known ([joints] torque_gain = { fixed = …, unit = … }), or record poses with a load of known \
                     mass, too";

/// Rows and columns of a tensor's entries.
const PAIRS: [(usize, usize); 6] = [(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)];

/// A number with its slopes by the problem's columns.
#[derive(Clone, Debug)]
struct WithSlopes {
    value: f64,
    function: LinearFunction,
}

impl WithSlopes {
    /// `self / other`.
    fn over(&self, other: &WithSlopes) -> WithSlopes {
        let value = self.value / other.value;
        let own = self.function.iter().map(|(column, slope)| (*column, slope / other.value));
        let others = other.function.iter().map(|(column, slope)| (*column, -value * slope / other.value));
        WithSlopes { value, function: summed(own.chain(others)) }
    }

    /// `self − other`.
    fn less(&self, other: &WithSlopes) -> WithSlopes {
        let own = self.function.iter().copied();
        let others = other.function.iter().map(|(column, slope)| (*column, -slope));
        WithSlopes { value: self.value - other.value, function: summed(own.chain(others)) }
    }

    /// With its interval, where it is determined.
    fn number(&self, solved: &Solved) -> Option<PayloadNumber> {
        let columns: Vec<usize> = self.function.iter().map(|(column, _)| *column).collect();
        let scale = |column: usize| solved.analysis.column_scale(column);
        let along = |null: &Vec<f64>| {
            let terms = self.function.iter().zip(null);
            let (sum, size) = terms.fold((0.0_f64, 0.0_f64), |(sum, size), ((column, slope), step)| {
                (sum + slope * step, size + slope.abs() * step.abs().max(1.0 / scale(*column)))
            });
            sum.abs() > OPEN * size
        };
        if solved.analysis.null_space_within(&columns).iter().any(along) {
            return None;
        }
        let std = solved.covariance().std_of(&self.function);
        let ci95 = solved.uncertainty.interval(self.value, &self.function);
        Some(PayloadNumber { value: self.value, std, ci95 })
    }
}

/// `(h·h δ_ab − h_a h_b)/m`.
fn steiner([mass, x, y, z]: &[WithSlopes; 4], (a, b): (usize, usize)) -> WithSlopes {
    let h = [x, y, z];
    let (m, delta) = (mass.value, |i: usize, j: usize| f64::from(i == j));
    let square: f64 = h.iter().map(|h| h.value * h.value).sum();
    let value = (delta(a, b) * square - h[a].value * h[b].value) / m;
    let slope = |k: usize| (2.0 * delta(a, b) * h[k].value - delta(a, k) * h[b].value - delta(b, k) * h[a].value) / m;
    let by_moments = (0..3).flat_map(|k| {
        let by = slope(k);
        h[k].function.iter().map(move |(column, own)| (*column, by * own))
    });
    let by_mass = mass.function.iter().map(|(column, own)| (*column, -value / m * own));
    WithSlopes { value, function: summed(by_moments.chain(by_mass)) }
}

/// Each column once.
fn summed(terms: impl Iterator<Item = (usize, f64)>) -> LinearFunction {
    let mut function = LinearFunction::new();
    for (column, slope) in terms {
        match function.iter_mut().find(|(known, _)| *known == column) {
            Some((_, sum)) => *sum += slope,
            None => function.push((column, slope)),
        }
    }
    function
}

#[cfg(test)]
mod tests {
    use gravcal_dynamics::BodyInertia;

    use super::*;

    #[test]
    fn slopes_of_centre_and_tensor_are_those_of_differences() {
        let body = [1.7, 0.3, -0.2, 0.4];
        let numbers = |body: [f64; 4]| [0, 1, 2, 3].map(|k| WithSlopes { value: body[k], function: vec![(k, 1.0)] });
        let centre = |body: [f64; 4], axis: usize| {
            let all = numbers(body);
            all[1 + axis].over(&all[0])
        };
        let tensor = |body: [f64; 4], entry: usize| steiner(&numbers(body), PAIRS[entry]);
        let by_hand = BodyInertia::about_center(1.7, [0, 1, 2].map(|k| body[1 + k] / 1.7), [0.0; 6]);
        for entry in 0..6 {
            assert!((tensor(body, entry).value - by_hand.tensor[entry]).abs() < 1e-15);
        }
        for column in 0..4 {
            let moved = |by: f64| {
                let mut moved = body;
                moved[column] += by;
                moved
            };
            let check = |of: &dyn Fn([f64; 4]) -> WithSlopes| {
                let difference = (of(moved(1e-6)).value - of(moved(-1e-6)).value) / 2e-6;
                let slope = of(body).function.iter().find(|(k, _)| *k == column).map_or(0.0, |(_, slope)| *slope);
                assert!((difference - slope).abs() < 1e-8, "{column}: {difference} {slope}");
            };
            (0..3).for_each(|axis| check(&|body| centre(body, axis)));
            (0..6).for_each(|entry| check(&|body| tensor(body, entry)));
        }
    }
}
