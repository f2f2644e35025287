//! Gravity in the other hemisphere than the declared one.

use crate::joint::mistakes::hypotheses::Mistake;
use crate::joint::reporting::answer::Answer;

impl Answer {
    pub(super) fn contradicted_hemisphere(&self) -> Option<Mistake> {
        self.solved.hemisphere_contradicted.then(|| Mistake {
            what: "gravity came out in the other hemisphere than the declared one".into(),
            advice: "The readings decide against [gravity] hemisphere: correct it, or look for torque sensors that \
                     are all reversed."
                .into(),
        })
    }
}
