//! The text of a draft.

use std::fmt::Write;
use std::path::Path;

use gravcal_recording::{PositionUnit, TorqueUnit};

use super::body::DraftBody;
use super::joints::{DraftJoint, MatchedBy};
use super::poses::Rule;
use super::quoting::{list, one_or_list, quoted};
use super::recorded::{Draft, DraftPoses};
use crate::document::relative_path;

/// What a sensor reads at no torque, as far as anyone can say: a current or a share is about zero then, others read what is amid their
/// readings (to four digits: it is a start).
fn reading_at_no_torque(joint: &DraftJoint, unit: TorqueUnit) -> f64 {
    let middle = 0.5 * (joint.torque_range[0] + joint.torque_range[1]);
    match unit {
        TorqueUnit::Ampere | TorqueUnit::Milliampere | TorqueUnit::Percent => 0.0,
        _ => format!("{middle:.3e}").parse().unwrap_or(middle),
    }
}

impl Draft<'_> {
    /// The session, to stand in `folder`. `poses`: what [`search`](Self::search) found.
    pub fn text(&self, poses: &DraftPoses, folder: &Path) -> String {
        let searched = poses.searched();
        let rule = Rule::of(searched, self.is_in_rows_apart());
        let recording = relative_path(folder, self.recording);
        let mut text = format!(
            "# A session to start from, drawn up by `gravcal inspect` from {}.\n{HEAD}",
            recording.rsplit('/').next().unwrap_or(&recording)
        );
        if let Some(body) = &self.body {
            text += &format!("estimators = [\"joint\"]\n{GRAVITY_OF_BODY}\n[readings]\n");
            text += &poses.doubt().map_or_else(String::new, |doubt| commented(&format!("LOOK AT THIS: {doubt}")));
            text += &format!("{ROWS_OF_BODY}{}{}{}", body.orientation_text(), self.csv_text(), body.sensor_text());
            return text + &self.loads() + &self.poses_text(&recording);
        }
        text += &self.robot_text(folder);
        text += ESTIMATORS;
        text += GRAVITY;
        text += self.inertia();
        if rule == Rule::Rows {
            text += "\n[readings]\n";
            text += &poses.doubt().map_or_else(String::new, |doubt| commented(&format!("LOOK AT THIS: {doubt}")));
            text += ROWS;
        }
        text += &self.readings();
        text += &self.csv_text();
        text += &self.rule(rule, searched);
        text += &self.own_units();
        if rule == Rule::Motion {
            text += &self.sensors_in_motion();
        }
        text + &self.loads() + &self.poses_text(&recording)
    }

    fn poses_text(&self, recording: &str) -> String {
        let mut text = format!("\n[[poses]]\nfile = {}\n", quoted(recording));
        if let Some(load) = self.inspection.metadata.get("load") {
            let _ = writeln!(text, "load = {}                         # as the recording says", quoted(load));
        }
        text
    }

    /// What was guessed of the joints and the robot, for people.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = self.body.as_ref().map_or_else(Vec::new, DraftBody::notes);
        let by = match self.by {
            MatchedBy::Name => None,
            MatchedBy::Number => Some("the order of the numbers in the columns' names"),
            MatchedBy::Order => Some("their order"),
        };
        let listed = |joints: &mut dyn Iterator<Item = &DraftJoint>| {
            joints.map(|joint| format!("{} is `{}`", joint.name, joint.position.0)).collect::<Vec<_>>().join(", ")
        };
        if let Some(by) = by {
            let pairs = listed(&mut self.joints.iter());
            notes.push(format!("joints were matched by {by}, as their names differ: {pairs}"));
        }
        let by_part = listed(&mut self.joints.iter().filter(|joint| joint.by_part));
        if self.by == MatchedBy::Name && !by_part.is_empty() {
            notes.push(format!("joints were matched by their names within those of the columns: {by_part}"));
        }
        let silent: Vec<&str> =
            self.joints.iter().filter(|joint| joint.torque.is_none()).map(|joint| joint.name.as_str()).collect();
        if !silent.is_empty() {
            notes.push(format!("no torque is recorded of {}: the column is \"\" there", silent.join(", ")));
        }
        if let Some(ends) = self.robot.filter(|robot| robot.guessed).and_then(|robot| robot.ends.as_ref()) {
            notes.push(format!("the chain is taken to go from `{}` to `{}`", ends.base, ends.tips.join("`, `")));
        }
        if !self.left_out.is_empty() {
            notes.push(format!("left out, as no joints of the chain: {}", self.left_out.join(", ")));
        }
        let own = self.joints.iter().filter(|joint| joint.is_missing_nominal());
        let own: Vec<&str> = own.map(|joint| joint.name.as_str()).collect();
        if !own.is_empty() {
            let own = own.join(", ");
            notes.push(format!(
                "sensors read in units of their own: fill in the gains that stand as comments in the session, for {own}"
            ));
        }
        if self.inspection.metadata.contains_key("load") {
            notes.push("the mass of the load that the recording names is to be filled in".to_owned());
        }
        notes
    }

    fn robot_text(&self, folder: &Path) -> String {
        let Some(robot) = self.robot else { return NO_ROBOT.to_owned() };
        let path = quoted(&relative_path(folder, &robot.path));
        let Some(ends) = &robot.ends else { return format!("robot = {path}\n") };
        let tips: Vec<&str> = ends.tips.iter().map(String::as_str).collect();
        let guessed = if robot.guessed { "   # base and tip are guesses" } else { "" };
        format!("robot = {{ urdf = {path}, base = {}, tip = {} }}{guessed}\n", quoted(&ends.base), one_or_list(&tips))
    }

    fn inertia(&self) -> &'static str {
        let links = self.robot.map_or(&[][..], |robot| robot.robot.chain.links());
        if links.iter().any(|link| link.inertia.is_some()) { INERTIA_OF_ROBOT } else { INERTIA }
    }

    fn readings(&self) -> String {
        let joints = &self.joints;
        let mut text = String::new();
        let doubts = self.inspection.pairing_doubt().into_iter().chain(self.inspection.topics_doubt());
        text.extend(doubts.map(|doubt| format!("\n{}", commented(&format!("LOOK AT THIS: {doubt}")))));
        text += match self.by {
            MatchedBy::Name => "",
            MatchedBy::Number => {
                "\n# The robot's joints and the recording's have different names: they were taken in the order of the numbers in the \
                 columns' names."
            }
            MatchedBy::Order => {
                "\n# The robot's joints and the recording's have different names: they were taken in their order."
            }
        };
        text += "\n# Columns in the order of the robot's joints:";
        for joint in joints {
            let recorded = if joint.recorded == joint.name { "" } else { joint.position.0.as_str() };
            let _ = write!(text, " {}{}{recorded}", joint.name, if recorded.is_empty() { "" } else { " is " });
            text.push(if std::ptr::eq(joint, &raw const joints[joints.len() - 1]) { '.' } else { ',' });
        }
        let columns: Vec<&str> = joints.iter().map(|joint| joint.position.0.as_str()).collect();
        let units: Vec<&str> = joints.iter().map(|joint| joint.position.1.name()).collect();
        let _ =
            write!(text, "\n[readings.position]\ncolumns = {}\nunit = {}{GUESS}", list(&columns), one_or_list(&units));
        let torque =
            |joint: &DraftJoint| joint.torque.clone().map_or(("".into(), ""), |(name, unit)| (name, unit.name()));
        let said = joints.iter().all(|joint| joint.torque.is_none() || joint.nominal.torque.is_some());
        let by = if said { AS_THE_ROBOT_SAYS } else { GUESS };
        let torques: Vec<(String, &str)> = joints.iter().map(torque).collect();
        let columns: Vec<&str> = torques.iter().map(|torque| torque.0.as_str()).collect();
        let units: Vec<&str> = torques.iter().map(|torque| torque.1).collect();
        let _ = write!(text, "\n[readings.torque]\ncolumns = {}\nunit = {}{by}", list(&columns), one_or_list(&units));
        for joint in joints.iter().filter(|joint| !joint.clipped.is_empty()) {
            let ends: Vec<String> = joint.clipped.iter().map(f64::to_string).collect();
            let _ = writeln!(
                text,
                "# Many readings of {} are {}: if that is an end of its range, say so by lowest = …, highest = …",
                joint.name,
                ends.join(" or ")
            );
        }
        if let Some(time) = self.time() {
            let _ = write!(
                text,
                "\n[readings.time]\ncolumn = {}\nunit = \"{}\"{GUESS}",
                quoted(&time.column),
                time.unit.name
            );
        }
        text
    }

    fn csv_text(&self) -> String {
        let columns = self.csv.columns.as_ref().map(|columns| columns.iter().map(String::as_str).collect::<Vec<_>>());
        columns.map_or_else(String::new, |columns| {
            format!("\n[readings.csv]                         # the file has no header\ncolumns = {}\n", list(&columns))
        })
    }

    /// What must be said of sensors that count in their own unit and of which the robot's file says nothing.
    fn own_units(&self) -> String {
        let mut text = String::new();
        for joint in self.joints.iter().filter(|joint| joint.is_missing_nominal()) {
            if text.is_empty() {
                text += OWN_UNITS;
            }
            let _ = writeln!(text, "# [[joint]]\n# name = {}", quoted(&joint.name));
            if let Some(unit) = joint.own_torque_unit() {
                let _ = writeln!(text, "# torque_gain = {{ nominal = …, unit = \"{unit}/(N·m)\" }}");
                let _ = writeln!(
                    text,
                    "# torque_bias = {{ nominal = {}, unit = \"{unit}\" }}",
                    reading_at_no_torque(joint, unit)
                );
            }
            if let Some(unit) = joint.own_position_unit() {
                let _ = writeln!(text, "# position_gain = {{ nominal = …, unit = \"rad/{unit}\" }}");
                let _ = writeln!(text, "# position_offset = {{ nominal = …, unit = \"rad\" }}");
            }
        }
        text
    }

    fn loads(&self) -> String {
        let last = self.robot.and_then(|robot| robot.robot.chain.links().last());
        let unknown = if self.body.is_some() { BODY } else { "link7" };
        let link = quoted(last.map_or(unknown, |link| link.name.as_str()));
        match self.inspection.metadata.get("load") {
            Some(load) => {
                let load = quoted(load);
                format!(
                    "\n# FILL IN what the load weighs, and its link:\n[[load]]\nname = {load}\n# mass_kg = …\nlink = {link}\n# position_m = [0, 0, 0.1]             # of its centre of mass in the link, where known\n"
                )
            }
            None if self.body.is_some() => String::new(),
            None => LOADS.replace("LINK", &link),
        }
    }
}

impl DraftJoint {
    fn own_torque_unit(&self) -> Option<TorqueUnit> {
        let (_, unit) = self.torque.as_ref()?;
        (unit.is_sensors_own() && self.nominal.torque.is_none()).then_some(*unit)
    }

    fn own_position_unit(&self) -> Option<PositionUnit> {
        let unit = self.position.1;
        (unit.is_sensors_own() && self.nominal.position.is_none()).then_some(unit)
    }

    fn is_missing_nominal(&self) -> bool {
        self.own_torque_unit().is_some() || self.own_position_unit().is_some()
    }
}

/// A text as lines of comments.
fn commented(text: &str) -> String {
    let mut lines = vec!["#".to_owned()];
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + word.chars().count() < COMMENT => *line += &format!(" {word}"),
            _ => lines.push(format!("# {word}")),
        }
    }
    lines.join("\n") + "\n"
}

/// Letters in a line of a comment.
const COMMENT: usize = 120;

const HEAD: &str = "\
# Units, and which column is what, are guesses from names and ranges: look them over. Then
#   gravcal check SESSION        tells what the recording can determine, and what would cure what it cannot
#   gravcal calibrate SESSION    finds it

";

const NO_ROBOT: &str = "\
# FILL IN the robot: a robot.toml of Denavit-Hartenberg rows, or { urdf = \"arm.urdf\", base = \"base_link\", tip = \"tool0\" }
robot = \"robot.toml\"
";

const ESTIMATORS: &str = "\
estimators = [\"joint\"]                # and \"sequential\", the paper's steps, where joints sweep one at a time
";

const GRAVITY: &str = "
[gravity]
magnitude_m_per_s2 = 9.80665           # standard gravity. Yours follows from latitude_deg and altitude_m, instead of this
# hemisphere = [0, 0, -1]              # roughly where it points in base coordinates, here of an upright base: settles its sign
";

const GRAVITY_OF_BODY: &str = "
[gravity]
magnitude_m_per_s2 = 9.80665           # standard gravity. Yours follows from latitude_deg and altitude_m, instead of this
hemisphere = [0, 0, -1]                # a guess: roughly where it points in the frame in which orientations are told, here down its z axis
";

/// Name of the body in a session without joints.
const BODY: &str = "body";

const INERTIA: &str = "
[inertia]
links = \"unknown\"                      # masses and centres of mass are found along with the sensors
";

const INERTIA_OF_ROBOT: &str = "
[inertia]
links = \"unknown\"                      # masses and centres of mass are found along with the sensors
# links = \"model\"                      # instead: those of the robot's file are right …
# relative_std = 0.1                   # … within 10 %, which tells the scale of the torque gains where no load does
";

const GUESS: &str = "                           # a guess\n";

const ROWS: &str = "\
# Every row of the file is taken as one static pose, as there is no clock, or rows are long apart. Where rows are single samples
# of standstills, this makes one pose of those with equal positions:
# merge_repeated_rows = true
";

const ROWS_OF_BODY: &str = "\
# Every row of the file is taken as one static pose. Where rows are single samples of standstills, this makes one pose of those
# with equal orientations:
# merge_repeated_rows = true
";

const AS_THE_ROBOT_SAYS: &str = "                         # as the robot's file says\n";

const OWN_UNITS: &str = "
# FILL IN, without the signs # : about how many of its own units (count, V, A) a N·m is, and the reading at no torque; likewise the angle.
";

const LOADS: &str = "
# Masses and torque gains have one common scale, which only something of known mass tells. Record poses with a load on the last
# link, weigh it, and say the following (and in [inertia] how well the robot's lengths and axes are known: length_std_m = 0.0005,
# axis_std_deg = 0.03):
# [[load]]
# name = \"plate\"
# mass_kg = 1.5
# link = LINK
# position_m = [0, 0, 0.1]             # of its centre of mass in that link, where known: tells the last joint's offset
# [[poses]]
# file = \"with-plate.mcap\"
# load = \"plate\"
#
# Or say what is known of a joint's sensors, such as
# [[joint]]
# name = \"…\"
# torque_gain = { nominal = 1, std = 0.01, unit = \"N·m/(N·m)\" }
";
