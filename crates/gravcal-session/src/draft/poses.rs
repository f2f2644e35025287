//! How the poses of a draft come about: what `[readings]` says of motion.

use std::fmt::Write;

use gravcal_dynamics::JointKind;
use gravcal_recording::TorqueUnit;
use gravcal_robot_model::number::rounded;
use gravcal_robot_model::session::Searched;

use super::joints::DraftJoint;
use super::quoting::{list, one_or_list, quoted};
use super::recorded::Draft;

/// Rows over which an acceleration is a slope, and a speed.
const ROWS_OF_SLOPE: f64 = 10.0;
/// Share of a joint's largest speed from which on it surely moves.
const MOVES: f64 = 0.1;

/// Time over which what the model leaves out stays alike, s, and blocks of so long that there should be.
const BLOCK_S: f64 = 0.75;
const BLOCKS: u64 = 40;

/// How poses come about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// Every row is one.
    Rows,
    /// The standstills are.
    Still,
    /// Angles that a joint passes slowly both ways are.
    Sweeps,
    /// Rows of an arm in motion that keep to limits are.
    Select,
}

impl Rule {
    /// `apart`: no row has both positions and torques, so that none is a pose by itself.
    pub fn of(searched: Option<&Searched>, apart: bool) -> Rule {
        match searched {
            None => Rule::Rows,
            Some(searched) if searched.found() == 0 && apart => Rule::Still,
            Some(searched) if searched.found() == 0 => Rule::Select,
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
            Rule::Select => self.select(),
        }
    }

    fn select(&self) -> String {
        let interval = self.inspection.time.as_ref().map_or(0.0, |time| time.interval_s);
        let window = rounded(ROWS_OF_SLOPE * interval, 2);
        let mut text = String::from(SELECT);
        match self.velocities() {
            Some(columns) => {
                let names: Vec<&str> = columns.iter().map(|column| column.column.as_str()).collect();
                let units: Vec<&str> = columns.iter().map(|column| column.unit.name).collect();
                let _ =
                    writeln!(text, "\n[readings.velocity]\ncolumns = {}\nunit = {}", list(&names), one_or_list(&units));
            }
            None => {
                let _ = writeln!(text, "\n[readings.velocity]\nslope_over_s = {window}");
            }
        }
        let _ = writeln!(
            text,
            "\n[readings.acceleration]\nslope_over_s = {window}             # of the speeds, over ten rows"
        );
        let units: Vec<&str> = self.joints.iter().map(|joint| if joint.slides() { "m/s²" } else { "rad/s²" }).collect();
        let _ = writeln!(
            text,
            "\n[readings.select.arm]                # inertia: every joint's acceleration is felt in all torques\n\
             acceleration_below = {{ value = 0.5, unit = {} }}",
            one_or_list(&units)
        );
        let least: Vec<String> = self.joints.iter().map(|joint| rounded(joint.least_speed(), 2).to_string()).collect();
        let units: Vec<&str> = self.joints.iter().map(|joint| joint.speed_unit()).collect();
        let _ = writeln!(
            text,
            "\n[readings.select.joint]              # friction: only of a joint that surely moves is its sign known\n\
             speed_above = {{ value = [{}], unit = {} }}",
            least.join(", "),
            one_or_list(&units)
        );
        text
    }

    /// Rows that may share an error: those of some time, if that leaves blocks enough to see how they scatter.
    fn block_poses(&self) -> u64 {
        let most = self.inspection.rows / BLOCKS;
        let of_time = self.inspection.time.as_ref().map(|time| (BLOCK_S / time.interval_s).round() as u64);
        of_time.map_or(most, |rows| rows.min(most)).max(1)
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
        format!("{IN_MOTION}{}\n{}", self.block_poses(), joints.map(joint).collect::<String>())
    }
}

impl DraftJoint {
    fn slides(&self) -> bool {
        self.kind == JointKind::Prismatic
    }

    fn speed_unit(&self) -> &'static str {
        match &self.velocity {
            Some((_, unit)) => unit.name,
            None if self.slides() => "m/s",
            None => "rad/s",
        }
    }

    /// In its unit; where no column tells the speeds, what is slow for most arms.
    fn least_speed(&self) -> f64 {
        self.fastest.filter(|fastest| *fastest > 0.0).map_or(0.05, |fastest| MOVES * fastest)
    }
}

const STILL: &str = "# least_duration_s = 0.1               # shorter ones are left out
";

const NONE_STANDS: &str = "\
# LOOK AT THIS: none was found. Positions and torques come in rows of their own (two topics), so that no row is a pose by itself: record
# again, and let the arm stand longer in each pose; the slower topic tells how long.
";

const IN_MOTION: &str = "
# A joint that moves has friction in its torque, and what the model leaves out exceeds the noise. A short recording without a load of known
# mass may then leave an estimate without an answer: it helps to take the sensors as their maker calibrated them, by the lines
# with `fixed`, and deviations from the scatter of blocks of rows:
# [uncertainty]
# kind = \"sandwich\"
# block_poses = ";

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

const SELECT: &str = "
# The arm never stands still in the recording. So rows in slow, even motion are taken as poses: the limits are guesses. Standstills
# (half a second or more in each pose) tell more, and need no limits: [readings.still] instead of the four sections that follow.
";
