//! Priors of sensor parameters that the readings contradict.
//!
//! With a prior `N(m, s²)` and the estimate `v ± σ` of readings and prior together, the readings alone say
//!
//! ```text
//!     u = v + (v − m) σ²/(s² − σ²),   σ_u² = σ² s²/(s² − σ²),   z = (u − m)/√(s² + w² σ_u²)
//! ```
//!
//! `w` is the factor by which standard deviations are wider than the noise makes them. To first order this is the estimate without the prior.

use gravcal_robot_model::number::{shown_unit, significant};
use gravcal_robot_model::parameter::ParameterId;
use gravcal_robot_model::session::{ParameterPrior, PriorKind, Session};

use crate::joint::solved::Solved;

/// Standard deviations between prior and readings from which they contradict each other: of thirty right priors, one does in 500 sessions.
pub(super) const CONTRADICTED: f64 = 4.0;
/// A variance that is more than this share of the prior's is the prior's own: the readings say too little.
pub(super) const OF_PRIOR: f64 = 0.9;
/// The worst so many are named one by one.
pub(super) const NAMED: usize = 3;

/// A prior, what readings alone say, and by how many standard deviations that is from it.
struct Contradicted {
    id: ParameterId,
    nominal: f64,
    std: f64,
    found: f64,
    apart: f64,
}

impl Solved {
    /// In a sentence each, the worst first; and how many more there are.
    pub(in crate::joint) fn contradicted_priors(&self, session: &Session) -> Vec<String> {
        let contradicted = |id: ParameterId| {
            let ParameterPrior { nominal, kind: PriorKind::Gaussian { std } } = session.prior(id) else { return None };
            let (found, apart) = self.beside_prior(id, nominal, std)?;
            (apart > CONTRADICTED).then_some(Contradicted { id, nominal, std, found, apart })
        };
        let mut all: Vec<Contradicted> = session.parameters().into_iter().filter_map(contradicted).collect();
        all.sort_by(|a, b| b.apart.total_cmp(&a.apart));
        let more = more_in_words(all.len().saturating_sub(NAMED));
        all.iter().take(NAMED).map(|one| one.in_words(session)).chain(more).collect()
    }

    /// What the readings alone say of a parameter, and how far from its prior that is, in standard deviations; nothing where they say too little.
    fn beside_prior(&self, id: ParameterId, nominal: f64, std: f64) -> Option<(f64, f64)> {
        let block = self.built.variables.block(id);
        let column = self.judged_problem().columns_of(block).next()?;
        let value = self.estimate.values.scalar(block);
        let by_noise = self.analysis.covariance().std(column);
        let (prior, own) = (std * std, by_noise * by_noise);
        if own > OF_PRIOR * prior || own == 0.0 {
            return None;
        }
        let found = value + (value - nominal) * own / (prior - own);
        let widened = (self.covariance().std(column) / by_noise).max(1.0);
        let of_found = own * prior / (prior - own);
        Some((found, (found - nominal).abs() / (prior + widened * widened * of_found).sqrt()))
    }
}

/// How many more there are than those that are named.
fn more_in_words(more: usize) -> Option<String> {
    let stated = match more {
        0 => return None,
        1 => "value of one more parameter".to_owned(),
        _ => format!("values of {more} more parameters"),
    };
    Some(format!("The readings also contradict the stated {stated}, by fewer standard deviations."))
}

impl Contradicted {
    fn in_words(&self, session: &Session) -> String {
        let (name, unit) = (session.parameter_name(self.id), session.parameter(self.id).unit);
        let (unit, factor) = shown_unit(&unit);
        format!(
            "The readings contradict what the session states of {name}: {} ± {} {unit} is {} standard deviations from {} {unit}, which they \
             alone give. Check the value and its std; without std the value is only a start.",
            significant(factor * self.nominal, 5),
            significant(factor * self.std, 2),
            significant(self.apart, 2),
            significant(factor * self.found, 5),
        )
    }
}

#[cfg(test)]
mod tests {
    use gravcal_robot_model::parameter::SensorParameter;

    use super::*;
    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// With a prior of the second joint's position gain so far from its true value, and of this standard deviation; nothing without one.
    fn solved(prior: Option<(f64, f64)>) -> (Session, Solved) {
        let simulation = sarcos_shoulder();
        let truth = simulation.truth.sensors[1][SensorParameter::PositionGain as usize];
        let mut session = simulation.session(0);
        if let Some((off, std)) = prior {
            let parameter = &mut session.joints[1].parameters[SensorParameter::PositionGain as usize];
            *parameter = ParameterPrior { nominal: truth + off, kind: PriorKind::Gaussian { std } };
        }
        let readings = select(&session, Signals::All);
        let solved = with_environment(|environment| solve(&session, &readings, None, environment)).unwrap();
        (session, solved)
    }

    const GAIN: ParameterId = ParameterId::Sensor(1, SensorParameter::PositionGain);

    #[test]
    fn a_prior_far_from_what_the_readings_say_is_named() {
        let contradicted = |off: f64, std: f64| {
            let (session, solved) = solved(Some((off, std)));
            solved.contradicted_priors(&session)
        };
        assert_eq!(contradicted(1e-3, 1e-3), Vec::<String>::new());
        let named = contradicted(6e-3, 1e-3);
        assert!(named.len() == 1 && named[0].contains("joint2.position_gain"), "{named:?}");
        assert_eq!(contradicted(1e-3, 1e-9), Vec::<String>::new(), "the prior says all");
    }

    /// Angles in degrees, as everywhere else; and the worst three in full.
    #[test]
    fn of_many_priors_the_worst_are_named_and_angles_are_in_degrees() {
        let simulation = sarcos_shoulder();
        let mut session = simulation.session(0);
        let mut contradict = |joint: usize, parameter: SensorParameter, off: f64, std: f64| {
            let truth = simulation.truth.sensors[joint][parameter as usize];
            session.joints[joint].parameters[parameter as usize] =
                ParameterPrior { nominal: truth + off, kind: PriorKind::Gaussian { std } };
        };
        contradict(1, SensorParameter::PositionOffset, 2f64.to_radians(), 0.1f64.to_radians());
        (0..3).for_each(|joint| contradict(joint, SensorParameter::TorqueBias, 10.0, 1.0));
        let readings = select(&session, Signals::All);
        let solved = with_environment(|environment| solve(&session, &readings, None, environment)).unwrap();
        let named = solved.contradicted_priors(&session);
        assert_eq!(named.len(), 4, "{named:?}");
        assert!(named[0].contains("joint2.position_offset") && named[0].contains(" ± 0.10 deg is "), "{named:?}");
        assert_eq!(Some(&named[3]), more_in_words(1).as_ref());
    }

    #[test]
    fn one_more_and_many_more_are_counted_in_words() {
        let more = [0, 1, 2].map(|more| more_in_words(more).unwrap_or_default());
        let [one, two] = ["value of one more parameter", "values of 2 more parameters"]
            .map(|stated| format!("The readings also contradict the stated {stated}, by fewer standard deviations."));
        assert_eq!(more, [String::new(), one, two]);
    }

    /// To first order the readings alone give what a solve without the prior does.
    #[test]
    fn what_the_readings_alone_say_is_what_a_solve_without_the_prior_gives() {
        let (_, with) = solved(Some((2e-3, 1e-3)));
        let (_, without) = solved(None);
        let value = |solved: &Solved| solved.estimate.values.scalar(solved.built.variables.block(GAIN));
        let truth = sarcos_shoulder().truth.sensors[1][SensorParameter::PositionGain as usize];
        let (found, _) = with.beside_prior(GAIN, truth + 2e-3, 1e-3).unwrap();
        let moved = (value(&with) - value(&without)).abs();
        assert!((found - value(&without)).abs() < 0.05 * moved, "{found} {} {}", value(&without), value(&with));
    }
}
