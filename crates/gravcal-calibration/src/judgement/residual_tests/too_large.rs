//! Sizes that hardly any true cause has: then something else looks like it.

use crate::result::ResidualTestKind;

/// What is said instead of a cure.
pub const SOMETHING_ELSE: &str = "That is more than such a thing ever is: something else looks like it. Look first at the other tests that name something, and \
                                  at units, signs, columns, loads and what the recorder did to torques.";

/// A base that gives way by a degree shakes as the arm moves, rad.
const BASE: f64 = 0.02;
/// Descriptions are off by millimetres and tenths of a degree; copied from another arm by centimetres and degrees.
const PLACEMENT: f64 = 0.1;
const TILT: f64 = 0.1;
/// A load's place or distance, m, is measured with a ruler.
const LOAD: f64 = 0.5;
/// Clocks are off by less than a tenth, unless rows were counted at another rate; %.
const CLOCK: f64 = 20.0;

/// Whether a test of this kind found what is that large; `size`: in the unit of such tests.
pub fn is_too_large(kind: &ResidualTestKind, size: f64) -> bool {
    let most = match kind {
        ResidualTestKind::BaseGivesWay => BASE,
        ResidualTestKind::JointPlacement { .. } => PLACEMENT,
        ResidualTestKind::JointTilt { .. } => TILT,
        ResidualTestKind::LoadPlacement { .. } | ResidualTestKind::LoadDistance { .. } => LOAD,
        ResidualTestKind::ClockRate => CLOCK,
        _ => return false,
    };
    size.abs() > most
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_base_gives_way_by_less_than_a_degree_and_no_joint_sits_far_from_its_place() {
        let joint = || "elbow".to_owned();
        for (kind, plausible) in [
            (ResidualTestKind::BaseGivesWay, 1_f64.to_radians()),
            (ResidualTestKind::JointPlacement { joint: joint() }, 0.05),
            (ResidualTestKind::JointTilt { joint: joint() }, 3_f64.to_radians()),
            (ResidualTestKind::ClockRate, 5.0),
        ] {
            for size in [plausible, -plausible] {
                assert!(!is_too_large(&kind, size) && is_too_large(&kind, 10.0 * size), "{kind:?} {size}");
            }
        }
        assert!(!is_too_large(&ResidualTestKind::Trend, 1e9), "a reading may drift by any number of its unit");
    }
}
