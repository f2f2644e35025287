//! Units of positions that are taken for each other.

/// A unit that is declared, and the one in which readings are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MistakenUnit {
    /// As the session says.
    pub declared: &'static str,
    /// As the readings look.
    pub likely: &'static str,
}

/// Position gains of readings in another unit than declared, relative to their nominal values: of angles, and of lengths.
const ANGLES: [(f64, MistakenUnit); 2] = [
    (180.0 / std::f64::consts::PI, MistakenUnit::RADIANS_AS_DEGREES),
    (std::f64::consts::PI / 180.0, MistakenUnit::DEGREES_AS_RADIANS),
];
const LENGTHS: [(f64, MistakenUnit); 2] =
    [(1e3, MistakenUnit { declared: "mm", likely: "m" }), (1e-3, MistakenUnit::MILLIMETERS_AS_METERS)];
/// How far a gain may be from such a number, as a share of it.
const NEAR: f64 = 0.3;

impl MistakenUnit {
    pub(super) const DEGREES_AS_RADIANS: MistakenUnit = MistakenUnit { declared: "rad", likely: "deg" };
    pub(super) const RADIANS_AS_DEGREES: MistakenUnit = MistakenUnit { declared: "deg", likely: "rad" };
    pub(super) const MILLIMETERS_AS_METERS: MistakenUnit = MistakenUnit { declared: "m", likely: "mm" };

    /// The mistake behind a position gain that is `ratio` times its nominal value, if it is one of units.
    pub fn of_gain(ratio: f64) -> Option<MistakenUnit> {
        ANGLES
            .iter()
            .chain(&LENGTHS)
            .find(|(factor, _)| (ratio.abs() / factor - 1.0).abs() < NEAR)
            .map(|(_, mistaken)| *mistaken)
    }

    /// Those of angles, each with the position gain, relative to its nominal value, that makes of the readings what their own unit does.
    pub fn of_angles() -> [(f64, MistakenUnit); 2] {
        ANGLES
    }

    /// What readings look like, in words that follow on the readings' name.
    pub fn reported(self) -> String {
        format!("look like {}, and are declared as {}", self.likely, self.declared)
    }

    /// What to do about it.
    pub fn cure(self) -> String {
        format!("say unit = \"{}\" in [readings] position", self.likely)
    }
}
