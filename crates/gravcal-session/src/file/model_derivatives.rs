//! Derivatives that models of anyone's write by hand, held against differences before anything is solved: a wrong one bends standard deviations,
//! and no residual shows it.

use std::panic::{AssertUnwindSafe, catch_unwind};

use gravcal_robot_model::State;
use gravcal_robot_model::sensors::{Moment, Term, WrongDerivative};
use gravcal_robot_model::session::{Pose, Session};

use crate::document::{Document, Field, FileError};

/// Poses at which derivatives are looked at.
pub(super) const LOOKED_AT: usize = 5;

/// Sees to it that the terms of sensors have the derivatives that they say.
pub(super) fn check(document: &Document, session: &Session) -> Result<(), FileError> {
    let nominal = State::nominal(session);
    let every = session.poses.len().div_ceil(LOOKED_AT).max(1);
    for model in session.terms.models() {
        for term in model.terms {
            let wrong = |pose: &Pose| wrong_at(session, term, &nominal, pose);
            let wrong = || at_most_places(session.poses.iter().step_by(every).map(wrong));
            let what = match catch_unwind(AssertUnwindSafe(wrong)) {
                Ok(None) => continue,
                Ok(Some(wrong)) => format!("is wrong: {wrong}"),
                Err(_) => "panicked, as is said above. Does it use what it does not say that it reads?".to_owned(),
            };
            let joint = &session.robot.chain.joints()[model.joint].name;
            let message = format!("the sensor model {} of {joint} {what}", model.name);
            return Err(document.error(&Field::new("joint"), message));
        }
    }
    Ok(())
}

/// What is wrong at most of the places that were looked at: that of the first one. A model may have a kink where one of them is.
pub(super) fn at_most_places(found: impl Iterator<Item = Option<WrongDerivative>>) -> Option<WrongDerivative> {
    let (wrong, right): (Vec<_>, Vec<_>) = found.partition(Option::is_some);
    if wrong.len() > right.len() { wrong.into_iter().next()? } else { None }
}

/// Parameters a little beside these, as many a model has a kink at zero.
pub(super) fn beside(x: &[f64]) -> Vec<f64> {
    x.iter().map(|x| x + 1e-3 * x.abs().max(1.0)).collect()
}

fn wrong_at(session: &Session, term: &Term, nominal: &State, pose: &Pose) -> Option<WrongDerivative> {
    // Neither zero nor alike; and beside where joints stand, as many a model has a kink at zero.
    let torques: Vec<f64> = (1..=pose.position.len()).map(|joint| 0.7 * joint as f64).collect();
    let coordinates = session.nominal_coordinates(pose).into_iter().zip(1..);
    let coordinates: Vec<f64> = coordinates.map(|(coordinate, joint)| coordinate + 1e-3 * f64::from(joint)).collect();
    let at = Moment::new(&torques, &coordinates, &pose.position, &pose.conditions);
    let own = beside(&nominal.further[term.places.clone()]);
    term.check_derivatives(&at, &own).err()
}

#[cfg(test)]
mod tests {
    use gravcal_robot_model::parameter::Limit;
    use gravcal_robot_model::sensors::{
        Declared, Options, ParameterSpec, Partials, Reads, RefusedOption, SensorModel, SensorTerm, Site, declare_terms,
    };

    use super::*;
    use crate::file::tests::changed;

    /// `a |x| + b sin θ` of the joint's own angle, with a derivative by `a` that is so many times too large, and a kink where `a` starts.
    #[derive(Clone, Copy, Debug)]
    struct Ripple(f64);

    impl SensorTerm for Ripple {
        fn reads(&self) -> Reads {
            Reads::positions().coordinate(0)
        }

        fn value(&self, at: &Moment<'_>, x: &[f64], partials: Option<Partials<'_>>) -> f64 {
            let (sine, cosine) = at.coordinate(0).sin_cos();
            if let Some(partials) = partials {
                partials.by_parameter[0] = self.0 * x[0].signum();
                partials.by_parameter[1] = sine;
                partials.by_coordinate[0] = x[1] * cosine;
            }
            x[0].abs() + x[1] * sine
        }
    }

    impl SensorModel for Ripple {
        fn name(&self) -> &str {
            "ripple"
        }

        fn help(&self) -> &str {
            "a test's"
        }

        fn declare(&self, _: &Site<'_>, _: &Options) -> Result<Vec<Declared>, RefusedOption> {
            let parameter = |name| ParameterSpec::new(name, "count", Limit::Absolute(1.0));
            Ok(vec![Declared::new([parameter("a"), parameter("b")], *self)])
        }
    }

    fn checked(wrong: f64) -> Result<(), String> {
        let mut session = changed("std = 0.8", "std = 0.7");
        let chain = &session.robot.chain;
        let names: Vec<&str> = chain.joints().iter().map(|joint| joint.name.as_str()).collect();
        let kinds: Vec<_> = chain.joints().iter().map(|joint| joint.kind).collect();
        let site = Site::new(0, &names, &kinds, &session.joints[0]);
        for (term, parameters) in declare_terms(&Ripple(wrong), &site, &Options::default()).unwrap() {
            session.terms.extend([term]);
            session.further.extend(parameters);
        }
        let document = Document::of(std::path::Path::new("session.toml"), String::new()).unwrap();
        check(&document, &session).map_err(|error| error.to_string())
    }

    #[test]
    fn a_model_with_a_wrong_derivative_is_named_with_its_joint() {
        assert_eq!(checked(1.0), Ok(()));
        let refused = checked(3.0).unwrap_err();
        let expected = "the sensor model ripple of shoulder is wrong: the derivative by parameter 0 is 3, but differences of values say ";
        assert!(refused.contains(expected), "{refused}");
    }
}
