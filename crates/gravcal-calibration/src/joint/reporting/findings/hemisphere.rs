//! Gravity in the other hemisphere than the declared one.

use gravcal_robot_model::session::Session;

use crate::joint::ends::symmetries::far_offsets;
use crate::joint::mistakes::hypotheses::Mistake;
use crate::joint::reporting::answer::Answer;
use crate::joint::variables::State;

impl Answer {
    pub(super) fn contradicted_hemisphere(&self) -> Option<Mistake> {
        self.solved.hemisphere_contradicted.then(|| Mistake {
            what: "gravity came out in the other hemisphere than the declared one".into(),
            advice: "The readings decide against [gravity] hemisphere: correct it, or look for torque sensors that \
                     are all reversed."
                .into(),
        })
    }

    /// Zeros of position sensors half a turn from where they are declared, where a hemisphere of gravity is: as many readings are explained by gravity in
    /// the other one and zeros as declared.
    pub(in crate::joint::reporting) fn half_turned_zeros(&self, session: &Session) -> Option<String> {
        let far = far_offsets(session, &self.solved.state(&State::nominal(session)));
        let told = self.gravity.is_some() && session.gravity.hemisphere.is_some();
        let names: Vec<String> = far.into_iter().map(|offset| session.parameter_name(offset)).collect();
        (told && !names.is_empty()).then(|| {
            format!(
                "With gravity in the declared hemisphere the zero of a position sensor comes out about half a turn from where it is declared: {}. Gravity in \
                 the other hemisphere may explain the readings as well, with zeros as declared: look at [gravity] hemisphere first.",
                names.join(", ")
            )
        })
    }
}
