//! Angles that begin anew after a full turn.

use std::f64::consts::TAU;

use crate::unit::PositionUnit;

/// The reading of a joint that goes on from its last one, rad, where a sensor that shows 179° and then −180° has turned by a degree. `unit`: of the column; what is no
/// angle stays.
pub fn unwrapped(reading: f64, last: Option<f64>, unit: PositionUnit) -> f64 {
    match last {
        Some(last) if unit.si() == PositionUnit::Radian => {
            let turns = ((reading - last) / TAU).round();
            if turns == 0.0 { reading } else { reading - TAU * turns }
        }
        _ => reading,
    }
}

/// The angle within the turn that begins there, rad.
pub fn within_turn(angle: f64, begin: f64) -> f64 {
    begin + (angle - begin).rem_euclid(TAU)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn angles_go_on_over_full_turns_and_lengths_do_not() {
        assert!((unwrapped(-3.1, Some(3.1), PositionUnit::Degree) - (TAU - 3.1)).abs() < 1e-15);
        assert_eq!(unwrapped(3.0, Some(3.1), PositionUnit::Radian), 3.0, "to the bit");
        assert_eq!(unwrapped(-3.1, None, PositionUnit::Radian), -3.1);
        assert_eq!(unwrapped(-3.1, Some(3.1), PositionUnit::Millimeter), -3.1);
        assert!((within_turn(-0.1, 0.0) - (TAU - 0.1)).abs() < 1e-15);
        assert_eq!(within_turn(0.5, -PI), 0.5);
    }
}
