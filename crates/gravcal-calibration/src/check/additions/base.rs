//! Tilting the base.

use super::addition::Addition;
use crate::check::supposed::Supposed;
use crate::check::tilts::{first_axis, turned_from};

/// Degrees.
const TILT_DEG: f64 = 10.0;

/// The whole session again on a tilted base: gravity in the base frame is one unknown, the same in all poses. A body without joints
/// has no base that its poses depend on.
pub fn tilted(now: &Supposed) -> Vec<Addition> {
    if now.session.joints.is_empty() {
        return Vec::new();
    }
    let words = format!("tilt the base by {TILT_DEG:.0}° and record all poses again");
    vec![Addition::new(words, |supposed| {
        let axis = first_axis(&supposed.session);
        let tilted = turned_from(supposed.values.gravity.into(), axis, TILT_DEG.to_radians());
        supposed.values.gravity = tilted.into();
        let declared = &mut supposed.session.gravity.hemisphere;
        *declared = declared.map(|_| tilted.normalize().into());
    })]
}
