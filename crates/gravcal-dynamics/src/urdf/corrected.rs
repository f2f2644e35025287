//! A URDF whose joints begin where their calibrated position sensors say, and whose base hangs as gravity says.
//!
//! A calibrated coordinate is `θ = c + o` where `c = s · reading` and `o` is the position offset. The new file is the old one,
//! to the byte, but for
//!
//! ```text
//!     origin of the joint      X' = X · Rot(axis, o)          revolute, continuous
//!                              X' = X · Trans(o · axis)       prismatic
//!     limits, soft limits, calibration     l' = l − o
//!     offset of a joint that mimics it     offset' = offset + multiplier · o
//! ```
//!
//! so that it takes `c` for the joint's value: the same pose as that of the old file at `c + o`. Where gravity is given, a new
//! root link with a vertical z axis carries the old root by a fixed joint. Gravity says nothing of the heading: the rotation is the
//! smallest one. Links' inertias, where such are given, stand in place of the old ones (`inertials.rs`).

use std::collections::BTreeMap;

use nalgebra::{Rotation3, Unit, Vector3};
use quick_xml::events::{BytesStart, BytesText, Event};
use quick_xml::{Reader, Writer};
use urdf_rs::JointType;

use super::essentials::located;
use super::inertials::{inertials, with_inertials};
use super::tree::Tree;
use super::xml::{attribute, name_of, number, put, with};
use super::{UrdfError, joint, read};
use crate::body_inertia::BodyInertia;
use crate::transform::Transform;

/// The link that hangs upright, where gravity is given.
pub const UPRIGHT_LINK: &str = "gravity_aligned_world";
/// The fixed joint between it and the old root.
const UPRIGHT_JOINT: &str = "gravity_aligned_world_to_root";

/// What a calibration knows of a URDF's frames.
#[derive(Clone, Debug, PartialEq)]
pub struct UrdfCorrection<'a> {
    /// The link in whose frame gravity is given, and gravity in it, m/s²; `None` leaves the root as it is.
    pub gravity: Option<(&'a str, [f64; 3])>,
    /// Joints with the offsets of their coordinates, rad or m.
    pub offsets: &'a [(String, f64)],
    /// The rigid body on each named link, in the link's frame, links that fixed joints attach to it included; none leaves all as they are.
    pub inertias: &'a [(String, BodyInertia)],
    /// Lines of a comment at the top of the file.
    pub comment: &'a [String],
}

impl UrdfCorrection<'_> {
    /// The corrected URDF.
    ///
    /// # Errors
    /// Text that is no URDF; joints or links that it does not have; a joint that moves between the root and the base; a link or
    /// joint of the name that the new root would have.
    pub fn apply(&self, text: &str) -> Result<String, UrdfError> {
        let robot = read(text)?;
        let tree = Tree::new(&robot)?;
        let offsets: BTreeMap<&str, f64> = self.offsets.iter().map(|(name, offset)| (name.as_str(), *offset)).collect();
        if let Some(name) = offsets.keys().find(|name| robot.joints.iter().all(|joint| joint.name != **name)) {
            return Err(UrdfError::MissingJoint { name: (*name).to_owned() });
        }
        let root = self.gravity.map(|(base, gravity)| upright(&tree, base, gravity)).transpose()?;
        let changes = robot.joints.iter().map(|joint| Ok((joint.name.as_str(), Change::of(joint, &offsets)?)));
        let changes: BTreeMap<&str, Change> = changes.collect::<Result<_, UrdfError>>()?;
        let text = Rewriting { changes, root, comment: self.comment }.write(text)?;
        if self.inertias.is_empty() { Ok(text) } else { with_inertials(&text, &inertials(&tree, self.inertias)?) }
    }
}

/// XML of the link and the joint above the old root.
fn upright(tree: &Tree<'_>, base: &str, gravity: [f64; 3]) -> Result<String, UrdfError> {
    let base = tree.find("base", base)?;
    let taken = tree.robot.links.iter().any(|link| link.name == UPRIGHT_LINK)
        || tree.robot.joints.iter().any(|joint| joint.name == UPRIGHT_JOINT);
    if taken {
        return Err(UrdfError::UprightLinkTaken { name: UPRIGHT_LINK.to_owned() });
    }
    let (mut link, mut root_from_base) = (base, Transform::identity());
    while let Some(index) = tree.parent_joint(link) {
        let carrying = &tree.robot.joints[index];
        if carrying.joint_type != JointType::Fixed {
            return Err(UrdfError::MovingRoot { joint: carrying.name.clone(), base: tree.link_name(base) });
        }
        root_from_base = joint::origin(carrying)? * root_from_base;
        link = tree.parent_link(index);
    }
    let down = root_from_base.rotate_vector(gravity);
    let [roll, pitch, yaw] = roll_pitch_yaw(&smallest_rotation_down(down));
    let root = quick_xml::escape::escape(tree.link_name(link)).into_owned();
    Ok(format!(
        "\n  <link name=\"{UPRIGHT_LINK}\"/>\n  <joint name=\"{UPRIGHT_JOINT}\" type=\"fixed\">\n    \
         <parent link=\"{UPRIGHT_LINK}\"/>\n    <child link=\"{root}\"/>\n    \
         <origin xyz=\"0 0 0\" rpy=\"{roll} {pitch} {yaw}\"/>\n  </joint>"
    ))
}

/// Takes a direction to that of −z about a horizontal axis; about x where it points up.
fn smallest_rotation_down(direction: [f64; 3]) -> Rotation3<f64> {
    let turned = Rotation3::rotation_between(&Vector3::from(direction), &-Vector3::z());
    turned.unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI))
}

/// URDF's roll, pitch and yaw of a rotation, rad.
fn roll_pitch_yaw(rotation: &Rotation3<f64>) -> [f64; 3] {
    let (roll, pitch, yaw) = rotation.euler_angles();
    // Zero without a sign reads better.
    [roll, pitch, yaw].map(|angle| angle + 0.0)
}

/// What changes in one joint.
struct Change {
    /// New `xyz` and `rpy`.
    origin: Option<[[f64; 3]; 2]>,
    /// What is taken from limits.
    offset: f64,
    /// What is added to the offset with which it mimics another, and that offset then.
    mimic_offset: Option<f64>,
}

impl Change {
    fn of(source: &urdf_rs::Joint, offsets: &BTreeMap<&str, f64>) -> Result<Change, UrdfError> {
        let offset = offsets.get(source.name.as_str()).copied().unwrap_or(0.0);
        let led = source.mimic.as_ref().and_then(|mimic| Some((mimic, *offsets.get(mimic.joint.as_str())?)));
        let led = led.filter(|(_, leader)| *leader != 0.0);
        let mimic_offset =
            led.map(|(mimic, leader)| mimic.offset.unwrap_or(0.0) + mimic.multiplier.unwrap_or(1.0) * leader);
        if offset == 0.0 {
            return Ok(Change { origin: None, offset, mimic_offset });
        }
        let (origin, axis) = (joint::origin(source)?, Vector3::from(joint::axis(source)?));
        let moved = match source.joint_type {
            JointType::Prismatic => Transform::along((offset * axis).into()),
            _ => Transform::turned(*Rotation3::from_axis_angle(&Unit::new_normalize(axis), offset).matrix()),
        };
        let origin = origin * moved;
        let rotation = Rotation3::from_matrix_unchecked(origin.rotation);
        Ok(Change { origin: Some([origin.translation(), roll_pitch_yaw(&rotation)]), offset, mimic_offset })
    }
}

/// One pass over the text.
struct Rewriting<'a> {
    changes: BTreeMap<&'a str, Change>,
    root: Option<String>,
    comment: &'a [String],
}

/// Where the pass is: names of the elements that are open, and the joint if it is in one.
#[derive(Default)]
struct Place {
    open: Vec<String>,
    joint: Option<String>,
    /// Whether the joint's origin has been seen, of which the first counts.
    has_origin: bool,
}

impl Rewriting<'_> {
    fn write(&self, text: &str) -> Result<String, UrdfError> {
        let mut reader = Reader::from_str(text);
        let mut writer = Writer::new(Vec::new());
        let mut place = Place::default();
        loop {
            let event = reader.read_event().map_err(|error| located(text, &reader, &error))?;
            let after = match &event {
                Event::Eof => break,
                Event::Start(start) => {
                    let changed = self.element(start, &mut place)?;
                    let name = name_of(start);
                    let after = (place.open.is_empty() && name == "robot").then(|| self.head());
                    place.open.push(name);
                    put(&mut writer, Event::Start(changed))?;
                    after
                }
                Event::Empty(start) => {
                    put(&mut writer, Event::Empty(self.element(start, &mut place)?))?;
                    None
                }
                Event::End(_) => {
                    if place.open.len() == 2 {
                        self.leave_joint(&mut writer, &mut place)?;
                    }
                    place.open.pop();
                    put(&mut writer, event.borrow())?;
                    None
                }
                other => {
                    put(&mut writer, other.borrow())?;
                    None
                }
            };
            if let Some(head) = after {
                put(&mut writer, Event::Text(BytesText::from_escaped(head)))?;
            }
        }
        Ok(String::from_utf8_lossy(&writer.into_inner()).into_owned())
    }

    /// What stands first in the robot: a comment, and the new root.
    fn head(&self) -> String {
        let lines = self.comment.iter().map(|line| format!("\n    {}", without_double_hyphens(line)));
        let comment = match self.comment {
            [] => String::new(),
            _ => format!("\n  <!--{}\n  -->", lines.collect::<String>()),
        };
        comment + self.root.as_deref().unwrap_or("")
    }

    /// An element as it is to be written.
    fn element<'e>(&self, start: &BytesStart<'e>, place: &mut Place) -> Result<BytesStart<'e>, UrdfError> {
        let name = name_of(start);
        if place.open.len() == 1 && place.open[0] == "robot" && name == "joint" {
            place.joint = attribute(start, "name")?;
            place.has_origin = false;
        }
        let change = place.joint.as_deref().and_then(|joint| self.changes.get(joint));
        let Some(change) = change.filter(|_| place.open.len() == 2) else { return Ok(start.clone()) };
        let shifted = |names: [&str; 2]| {
            let [a, b] = names.map(|name| -> Result<Option<f64>, UrdfError> { number(start, name) });
            let both = names.into_iter().zip([a?, b?]);
            let given = both.filter_map(|(name, value)| Some((name, format!("{}", value? - change.offset))));
            with(start, &given.collect::<Vec<_>>())
        };
        match name.as_str() {
            "origin" if !place.has_origin => {
                place.has_origin = true;
                match &change.origin {
                    Some(origin) => with(start, &origin_attributes(origin)),
                    None => Ok(start.clone()),
                }
            }
            "limit" if change.offset != 0.0 => {
                // One that is not given is zero where the other is.
                match (number(start, "lower")?, number(start, "upper")?) {
                    (None, None) => Ok(start.clone()),
                    (lower, upper) => {
                        let less = |limit: Option<f64>| format!("{}", limit.unwrap_or(0.0) - change.offset);
                        with(start, &[("lower", less(lower)), ("upper", less(upper))])
                    }
                }
            }
            "safety_controller" if change.offset != 0.0 => shifted(["soft_lower_limit", "soft_upper_limit"]),
            "calibration" if change.offset != 0.0 => shifted(["rising", "falling"]),
            "mimic" => match change.mimic_offset {
                Some(offset) => with(start, &[("offset", format!("{offset}"))]),
                None => Ok(start.clone()),
            },
            _ => Ok(start.clone()),
        }
    }

    /// A joint without an origin gets one.
    fn leave_joint(&self, writer: &mut Writer<Vec<u8>>, place: &mut Place) -> Result<(), UrdfError> {
        let change = place.joint.take().and_then(|joint| self.changes.get(joint.as_str()));
        if let (Some(origin), false) = (change.and_then(|change| change.origin.as_ref()), place.has_origin) {
            put(writer, Event::Empty(with(&BytesStart::new("origin"), &origin_attributes(origin))?))?;
        }
        Ok(())
    }
}

/// A comment of XML must not hold two hyphens in a row.
fn without_double_hyphens(line: &str) -> String {
    let mut text = String::with_capacity(line.len());
    for c in line.chars() {
        if c == '-' && text.ends_with('-') {
            text.push(' ');
        }
        text.push(c);
    }
    text
}

fn origin_attributes([xyz, rpy]: &[[f64; 3]; 2]) -> [(&'static str, String); 2] {
    let reported = |[a, b, c]: &[f64; 3]| format!("{a} {b} {c}");
    [("xyz", reported(xyz)), ("rpy", reported(rpy))]
}

#[cfg(test)]
mod tests {
    use super::super::tests::ARM;
    use super::*;
    use crate::chain::Chain;

    const GRAVITY: [f64; 3] = [3.0, -4.0, -8.0];

    fn corrected(text: &str, offsets: &[(&str, f64)]) -> Result<String, UrdfError> {
        let offsets: Vec<(String, f64)> = offsets.iter().map(|(name, offset)| ((*name).to_owned(), *offset)).collect();
        UrdfCorrection {
            gravity: Some(("base", GRAVITY)),
            offsets: &offsets,
            inertias: &[],
            comment: &["a -- b --- c----".to_owned()],
        }
        .apply(text)
    }

    fn torques(chain: &Chain, coordinates: &[f64], gravity: [f64; 3]) -> Vec<f64> {
        let inertia: Vec<f64> = chain
            .links()
            .iter()
            .flat_map(|link| {
                link.inertia.map_or([0.0; 4], |i| [i.mass, i.first_moment[0], i.first_moment[1], i.first_moment[2]])
            })
            .collect();
        let mut torque = vec![0.0; coordinates.len()];
        chain.gravity_torque(coordinates, gravity, &inertia, &mut torque);
        torque
    }

    #[test]
    fn the_new_file_at_c_is_the_old_one_at_c_plus_o_and_upright() {
        let offsets = [("pan", 0.3), ("lift", -0.2)];
        let text = corrected(ARM, &offsets).unwrap();
        let old = Chain::from_urdf(ARM, "base", &["hand"]).unwrap();
        let new = Chain::from_urdf(&text, UPRIGHT_LINK, &["hand"]).unwrap();
        let magnitude = GRAVITY.iter().map(|g| g * g).sum::<f64>().sqrt();
        for c in [[0.0, 0.0], [1.0, -0.7], [-2.5, 0.4]] {
            let before = torques(&old, &[c[0] + 0.3, c[1] - 0.2], GRAVITY);
            let after = torques(&new, &c, [0.0, 0.0, -magnitude]);
            assert!(before.iter().zip(&after).all(|(a, b)| (a - b).abs() < 1e-12), "{before:?} {after:?}");
        }
        assert_eq!(
            new.joints()[1].limits.map(|[low, high]| [low + 1.0 - 0.2, high - 2.0 - 0.2].map(|d| d.abs() < 1e-15)),
            Some([true; 2])
        );
        // What has nothing to do with frames stays.
        assert!(
            text.contains("drake:acceleration=\"3\"")
                && text.contains("<!-- was:")
                && text.contains("a - - b - - - c- - - -\n")
        );
        assert!(text.contains("<transmission name=\"t\"><joint name=\"lift\"/></transmission>"));
    }

    #[test]
    fn nothing_to_correct_changes_no_byte() {
        let offsets = [("pan".to_owned(), 0.0)];
        let correction = UrdfCorrection { gravity: None, offsets: &offsets, inertias: &[], comment: &[] };
        assert_eq!(correction.apply(ARM).unwrap(), ARM);
    }

    #[test]
    fn sliding_joints_and_those_that_mimic_move_along() {
        let text = ARM.replace(
            "<joint name=\"grip\" type=\"prismatic\">",
            "<joint name=\"grip\" type=\"prismatic\"><mimic joint=\"lift\" multiplier=\"0.5\" offset=\"0.01\"/>",
        );
        let new = corrected(&text, &[("lift", 0.2)]).unwrap();
        let chain = |text: &str| Chain::from_urdf(text, "base", &["finger"]).unwrap();
        let [old, new] = [chain(&text), chain(&new)];
        let tells = |chain: &Chain, lift: f64| torques(chain, &[0.4, lift], GRAVITY);
        assert!(tells(&old, 0.7).iter().zip(tells(&new, 0.5)).all(|(a, b)| (a - b).abs() < 1e-12));
        let slid = corrected(ARM, &[("grip", 0.02)]).unwrap();
        let chain = Chain::from_urdf(&slid, "base", &["finger"]).unwrap();
        let moved = chain.joints()[2].before.translation();
        assert!(moved.iter().zip([0.5, 0.0, 0.02]).all(|(a, b)| (a - b).abs() < 1e-15), "{moved:?}");
    }

    #[test]
    fn what_cannot_be_corrected_is_refused() {
        assert!(matches!(corrected(ARM, &[("elbow", 0.1)]), Err(UrdfError::MissingJoint { .. })));
        let correction = UrdfCorrection { gravity: Some(("arm", GRAVITY)), offsets: &[], inertias: &[], comment: &[] };
        assert!(matches!(correction.apply(ARM), Err(UrdfError::MovingRoot { .. })));
        let twice = corrected(ARM, &[]).unwrap();
        assert!(matches!(corrected(&twice, &[]), Err(UrdfError::UprightLinkTaken { .. })));
    }
}
