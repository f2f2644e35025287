//! Tilting the base.

use super::addition::Addition;
use crate::check::hypothetical::Hypothetical;
use crate::check::tilts::{first_axis, turned_from};

/// Degrees.
const TILT_DEG: f64 = 10.0;

/// The whole session again on a tilted base: gravity in the base frame is one unknown, the same in all poses. A body without joints
/// has no base that its poses depend on.
pub fn tilted(now: &Hypothetical) -> Vec<Addition> {
    if now.session.joints.is_empty() {
        return Vec::new();
    }
    let words = format!("tilt the base by {TILT_DEG:.0}° and record all poses again");
    vec![Addition::new(words, |hypothetical| {
        let axis = first_axis(&hypothetical.session);
        let tilted = turned_from(hypothetical.values.gravity.into(), axis, TILT_DEG.to_radians());
        hypothetical.values.gravity = tilted.into();
        let declared = &mut hypothetical.session.gravity.hemisphere;
        *declared = declared.map(|_| tilted.normalize().into());
    })]
}
