//! One addition to a session.

use crate::check::hypothetical::Hypothetical;

/// One addition.
pub(in crate::check) struct Addition {
    /// What to do.
    pub words: String,
    /// The parameter that it states: no cure of that one alone.
    pub states: Option<String>,
    pub(super) make: Box<dyn Fn(&mut Hypothetical)>,
}

impl Addition {
    pub(super) fn new(words: String, make: impl Fn(&mut Hypothetical) + 'static) -> Addition {
        Addition { words, states: None, make: Box::new(make) }
    }

    /// The session with the addition.
    pub fn made(&self, now: &Hypothetical) -> Hypothetical {
        let mut hypothetical = now.clone();
        (self.make)(&mut hypothetical);
        hypothetical
    }
}
