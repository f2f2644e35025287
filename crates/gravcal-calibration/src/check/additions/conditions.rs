//! Recording some of the poses again under other conditions: for what sensors do beyond gain and bias.

use super::addition::Addition;
use super::poses::{POSES, attached, some_present};
use crate::check::hypothetical::Hypothetical;

/// °C.
const WARMER: f64 = 10.0;
/// s.
const LATER: f64 = 3600.0;

/// From the other side, warmer, later: each where the session says it of its poses.
pub fn others(now: &Hypothetical) -> Vec<Addition> {
    let Some(first) = now.session.poses.first().map(|pose| &pose.conditions) else { return Vec::new() };
    let again = |how: &str| format!("record {POSES} of the poses again, {how}");
    let mut additions = Vec::new();
    if !(first.direction.is_empty() && first.velocity.is_empty()) {
        additions.push(Addition::new(again("each approached from the other side"), |hypothetical| {
            let added = repeated(hypothetical);
            for pose in &mut hypothetical.session.poses[added..] {
                let sides = pose.conditions.direction.iter_mut().chain(&mut pose.conditions.velocity);
                sides.for_each(|side| *side *= -1.0);
            }
        }));
    }
    if !first.temperature.is_empty() {
        additions.push(Addition::new(again(&format!("{WARMER:.0} °C warmer")), |hypothetical| {
            let added = repeated(hypothetical);
            let poses = hypothetical.session.poses[added..].iter_mut();
            poses.flat_map(|pose| &mut pose.conditions.temperature).for_each(|temperature| *temperature += WARMER);
        }));
    }
    if first.time.is_some() {
        additions.push(Addition::new(again("an hour later"), |hypothetical| {
            let added = repeated(hypothetical);
            let last = hypothetical.session.poses.iter().filter_map(|pose| pose.conditions.time).fold(0.0, f64::max);
            hypothetical.session.poses[added..].iter_mut().for_each(|pose| pose.conditions.time = Some(last + LATER));
        }));
    }
    additions
}

/// Adds some of the poses once more; gives the index of the first one.
fn repeated(hypothetical: &mut Hypothetical) -> usize {
    let added = hypothetical.session.poses.len();
    let load = attached(hypothetical);
    hypothetical.record(load, some_present(hypothetical, load));
    added
}
