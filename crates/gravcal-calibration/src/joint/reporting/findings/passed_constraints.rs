//! Constraints that the readings would like to pass by far.

use crate::joint::mistakes::hypothesis::Mistake;
use crate::joint::reporting::answer::Answer;

/// Standard deviations by which readings pass a constraint that they contradict.
const PASSED: f64 = 5.0;

impl Answer {
    pub(super) fn passed_constraints(&self) -> Option<Mistake> {
        let passed = self.solved.estimate.active.iter().zip(&self.solved.leans).filter(|(_, lean)| **lean > PASSED);
        let passed: Vec<String> =
            passed.map(|(active, lean)| format!("\"{}\" by {lean:.0} standard deviations", active.name)).collect();
        (!passed.is_empty()).then(|| Mistake {
            what: format!("the readings contradict {}", passed.join(", ")),
            advice: "A constraint that the readings would like to pass so far spoils what is estimated under it: \
                     widen it, or drop it and look at what comes out."
                .into(),
        })
    }
}
