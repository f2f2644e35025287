//! Libraries that panic on the bytes of a damaged file, shielded.
//!
//! A library that takes bytes apart should say what is wrong with them; some panic instead. Every call into one goes through
//! [`shielded`], so that a panic becomes a value, and its message, which means nothing to who reads a recording, is not printed.
//! What the call worked on may be half changed then, and must not be used again.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// Whether this thread is in such a call.
    static SHIELDED: Cell<bool> = const { Cell::new(false) };
}

static HOOK: Once = Once::new();

/// The call panicked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Panicked;

impl std::fmt::Display for Panicked {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("its bytes contradict each other")
    }
}

/// Calls into a library. Panics of other threads, and of this one elsewhere, are told as before.
pub(crate) fn shielded<T>(call: impl FnOnce() -> T) -> Result<T, Panicked> {
    HOOK.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |panic| {
            if !SHIELDED.get() {
                before(panic);
            }
        }));
    });
    let outer = SHIELDED.replace(true);
    let result = catch_unwind(AssertUnwindSafe(call));
    SHIELDED.set(outer);
    result.map_err(|_| Panicked)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_a_value_and_the_shield_ends_with_its_call() {
        assert_eq!(shielded(|| 7), Ok(7));
        assert_eq!(shielded(|| -> u8 { panic!("of a library") }), Err(Panicked));
        assert!(!SHIELDED.get());
        let inner = shielded(|| (shielded(|| -> u8 { panic!("of a library") }), SHIELDED.get()));
        assert_eq!(inner, Ok((Err(Panicked), true)));
    }
}
