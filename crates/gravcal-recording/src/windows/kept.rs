//! What is costly to make of something that many share, kept with it.

use std::any::Any;
use std::fmt;
use std::sync::OnceLock;

/// A place for one value that somebody makes of what it stands beside. It is no part of that: a copy, which may be changed, keeps nothing, and any two are
/// the same.
#[derive(Default)]
pub struct Kept(OnceLock<Box<dyn Any + Send + Sync>>);

impl Kept {
    /// What is kept, made where nothing is; nothing where that is of another kind.
    pub fn or_make<T: Any + Send + Sync>(&self, make: impl FnOnce() -> T) -> Option<&T> {
        self.0.get_or_init(|| Box::new(make())).downcast_ref()
    }
}

impl Clone for Kept {
    fn clone(&self) -> Self {
        Kept::default()
    }
}

impl PartialEq for Kept {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl fmt::Debug for Kept {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Kept")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_made_once_and_no_copy_has_it() {
        let kept = Kept::default();
        assert_eq!(kept.or_make(|| 1_u8), Some(&1));
        assert_eq!(kept.or_make(|| 2_u8), Some(&1));
        assert_eq!(kept.or_make(|| 2.0_f64), None);
        assert_eq!(kept.clone().or_make(|| 2_u8), Some(&2));
    }
}
