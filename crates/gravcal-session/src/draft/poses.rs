//! How the poses of a draft come about: what `[readings]` says of motion.

use gravcal_recording::TorqueUnit;
use gravcal_robot_model::session::Searched;

use super::joints::DraftJoint;
use super::quoting::quoted;
use super::recorded::Draft;

/// How poses come about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// Every row is one.
    Rows,
    /// The standstills are.
    Still,
    /// Angles that a joint passes slowly both ways are.
    Sweeps,
    /// Windows of an arm in motion are.
    Motion,
}

impl Rule {
    /// `apart`: no row has both positions and torques, so that none is a pose by itself.
    pub fn of(searched: Option<&Searched>, apart: bool) -> Rule {
        match searched {
            None => Rule::Rows,
            Some(searched) if searched.found() == 0 && apart => Rule::Still,
            Some(searched) if searched.found() == 0 => Rule::Motion,
            Some(searched) if searched.sweeps.is_some() => Rule::Sweeps,
            Some(_) => Rule::Still,
        }
    }
}

impl Draft<'_> {
    /// The part of `[readings]` that says how rows become poses.
    pub(super) fn rule(&self, rule: Rule, searched: Option<&Searched>) -> String {
        match rule {
            Rule::Rows => String::new(),
            Rule::Still => {
                let found = searched.map_or(0, Searched::found);
                let none = if found == 0 { NONE_STANDS } else { "" };
                format!(
                    "\n# Poses are the standstills found in the recording: {found}.\n{none}[readings.still]\n{STILL}"
                )
            }
            Rule::Sweeps => {
                let found = searched.map_or(0, Searched::found);
                format!("{SWEEPS_BEFORE}{found}.\n[readings.sweeps]\n{SWEEPS}")
            }
            Rule::Motion => MOTION.to_owned(),
        }
    }

    /// Sensors of the joints of an arm in motion: friction, and what makes little data suffice.
    pub(super) fn sensors_in_motion(&self) -> String {
        let joints = self.joints.iter().filter(|joint| joint.torque.is_some());
        let joint = |joint: &DraftJoint| {
            let mut text = format!("\n[[joint]]\nname = {}\n{FRICTION}", quoted(&joint.name));
            if joint.torque.as_ref().is_some_and(|(_, unit)| *unit == TorqueUnit::NewtonMeter) {
                text += AS_CALIBRATED;
            }
            text
        };
        IN_MOTION.to_owned() + &joints.map(joint).collect::<String>()
    }
}

const STILL: &str = "# least_duration_s = 0.1               # shorter ones are left out
";

const NONE_STANDS: &str = "\
# LOOK AT THIS: none was found. Positions and torques come in rows of their own (two topics), so that no row is a pose by itself: record
# again, and let the arm stand longer in each pose; the slower topic tells how long.
";

const IN_MOTION: &str = "
# A joint that moves has friction in its torque. Without a load of known mass torque gains and inertias have one common scale: it
# helps to take the sensors as their maker calibrated them, by the lines with `fixed`.
";

const FRICTION: &str = "sensor_models = [{ kind = \"coulomb-friction\" }, { kind = \"viscous-friction\" }]\n";

const AS_CALIBRATED: &str = "\
# torque_gain = { fixed = 1, unit = \"N·m/(N·m)\" }
# position_gain = { fixed = 1, unit = \"rad/rad\" }
# position_offset = { fixed = 0, unit = \"rad\" }
";

const SWEEPS_BEFORE: &str = "
# Poses are the angles that a joint passed slowly both ways while the others stood; friction cancels in the mean of both. A joint whose
# sensor_models name coulomb-friction has both ways as poses of their own instead. Sweeps found in the recording: ";

const SWEEPS: &str = "# bin_deg = 1                          # a pose for each degree
# acceleration_below_rad_per_s2 = 0.05 # as is the square of the speed: faster is left out
";

const MOTION: &str = "
# The arm never stands still in the recording. So gravity, inertia and friction are found together, from windows of the motion.
# Standstills (half a second or more in each pose) tell the sensors better: [readings.still] instead of [readings.motion].
[readings.motion]
";
