//! A wrist sensor on a body that somebody turned: columns tell how it stood, and no joints are needed.

use std::fmt::Write;

use gravcal_recording::{ColumnFound, Inspection, Meaning, OrientationColumns, OrientationForm, ReadingColumn};

use super::quoting::{list, quoted};
use super::sense::Sense;

/// Parts of a quaternion, entries of a rotation matrix, and axes of a sensor, as a session has them in order.
const PARTS: [&str; 4] = ["x", "y", "z", "w"];
const ENTRIES: [&str; 9] = ["r11", "r12", "r13", "r21", "r22", "r23", "r31", "r32", "r33"];
const AXES: [&str; 6] = ["fx", "fy", "fz", "nx", "ny", "nz"];

/// Columns of the orientation, and of the sensor's axes with their units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DraftBody {
    /// As many as the form has.
    pub oriented_by: Vec<String>,
    pub form: OrientationForm,
    pub axes: [(String, &'static str); 6],
    /// What the readings say of signs, once they have been looked at.
    pub sense: Option<Sense>,
}

impl DraftBody {
    /// What names of columns tell; `None` where one of them is missing.
    pub fn find(inspection: &Inspection) -> Option<DraftBody> {
        let names = |columns: &[&ColumnFound]| columns.iter().map(|column| column.name.clone()).collect();
        let quaternion = inspection.axes(Meaning::Orientation, PARTS);
        let (oriented_by, form) = match quaternion {
            Some(parts) => (names(&parts), OrientationForm::QuaternionXyzw),
            None => (names(&inspection.axes(Meaning::Orientation, ENTRIES)?), OrientationForm::Matrix),
        };
        let axes = inspection.axes(Meaning::ForceTorque, AXES)?;
        Some(DraftBody {
            oriented_by,
            form,
            axes: axes.map(|column| (column.name.clone(), column.guess.unit.unwrap_or("N"))),
            sense: None,
        })
    }

    pub fn orientation(&self) -> OrientationColumns {
        OrientationColumns {
            columns: self.oriented_by.clone(),
            form: self.form,
            body_from_base: self.sense.is_some_and(|sense| sense.body_from_base),
        }
    }

    pub fn instruments(&self) -> Vec<Option<ReadingColumn>> {
        let reading = |(column, _): &(String, _)| ReadingColumn { column: column.clone(), ..ReadingColumn::default() };
        self.axes.iter().map(|axis| Some(reading(axis))).collect()
    }

    /// The orientation as `[readings]` has it.
    pub fn orientation_text(&self) -> String {
        let columns = list(&self.oriented_by.iter().map(String::as_str).collect::<Vec<_>>());
        let order = if self.form == OrientationForm::Matrix { "" } else { " order = \"xyzw\"," };
        let (rotation, by) = match self.sense {
            Some(Sense { body_from_base: true, .. }) => ("body-from-base", "so the forces say"),
            Some(_) => ("base-from-body", "so the forces say"),
            None => ("base-from-body", "or \"body-from-base\""),
        };
        format!(
            "# How the sensor stood; which way the rotation goes is a guess ({by}).\norientation = {{ columns = {columns},{order} \
             rotation = \"{rotation}\" }}\n"
        )
    }

    /// The sensor's section.
    pub fn sensor_text(&self) -> String {
        let columns: Vec<&str> = self.axes.iter().map(|(column, _)| column.as_str()).collect();
        let units: Vec<&str> = self.axes.iter().map(|(_, unit)| *unit).collect();
        let mut text = format!(
            "\n[[force_torque_sensor]]\nname = \"wrist\"\nreadings = {{ columns = {}, unit = {} }}   # units are a guess\n",
            list(&columns),
            list(&units)
        );
        text += match self.sense {
            Some(Sense { reversed: true, .. }) => REVERSED,
            Some(_) => NORMAL,
            None => UNKNOWN_SIGN,
        };
        text += &self.gains_text();
        text += TOOL;
        text
    }

    fn gains_text(&self) -> String {
        let groups = [("force_gain", 0, "N"), ("moment_gain", 3, "N·m")];
        let gain = |unit: &str, sensed: &str| format!("{unit}/{}", if sensed == "N" { "N" } else { "(N·m)" });
        let natural = groups.iter().all(|(_, first, sensed)| self.axes[*first].1 == *sensed);
        let mut text = String::from(if natural { TRUSTED_GAINS } else { UNKNOWN_GAINS });
        for (key, first, sensed) in groups {
            let unit = gain(self.axes[first].1, sensed);
            let _ = match natural {
                true => writeln!(text, "{key} = {{ fixed = 1, unit = {} }}", quoted(&unit)),
                false => writeln!(text, "# {key} = {{ nominal = …, unit = {} }}", quoted(&unit)),
            };
        }
        text
    }

    /// What was guessed, for people.
    pub fn notes(&self) -> Vec<String> {
        let gravity =
            "gravity is taken to point down the z axis of the frame in which orientations are told".to_owned();
        let sense = match self.sense {
            Some(Sense { body_from_base, reversed }) => format!(
                "with that the forces say that the orientation is {}, and that the sensor reads what {}",
                if body_from_base { "the base in the body's frame" } else { "the body in the base's frame" },
                if reversed { "the tool exerts on it (sign = \"reversed\")" } else { "it exerts on the tool" }
            ),
            None => "which way the rotation goes, and the sensor's sign, is not told by the forces".to_owned(),
        };
        vec![gravity, sense]
    }
}

const REVERSED: &str = "\
sign = \"reversed\"                      # a guess from the forces: it reads what the tool exerts on it
";

const NORMAL: &str = "\
# sign = \"reversed\"                    # if it reads what the tool exerts on it; the forces do not look so
";

const UNKNOWN_SIGN: &str = "\
# sign = \"reversed\"                    # if it reads what the tool exerts on it, and not what it exerts on the tool
";

const TRUSTED_GAINS: &str = "\
# The sensor's own gains are trusted: gravity on a tool of unknown mass cannot tell them from the mass. To estimate them, delete these
# two lines and say what the tool weighs (tool_mass), or record poses with a load of known mass ([[load]], link = \"body\") as well.
";

const UNKNOWN_GAINS: &str = "\
# FILL IN, without the signs # : about how many of its own units a N and a N·m are. To estimate these gains, and not only the tool, say
# what the tool weighs (tool_mass), or record poses with a load of known mass ([[load]], link = \"body\") as well.
";

const TOOL: &str = "\
# tool_mass = { nominal = 1.2, std = 0.01, unit = \"kg\" }   # what hangs beyond the sensor, where it is known; else it is found
";
