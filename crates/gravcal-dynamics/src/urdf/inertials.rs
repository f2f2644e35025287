//! A URDF whose links have other inertias.
//!
//! What joints move rigidly together is one body to the readings. It stands in the `<inertial>` of the link that its joint carries, about its
//! centre of mass and along that link's axes; links that fixed joints attach to it lose theirs, as it is in the sum. So do links that hang
//! on it by joints which are not on the way to a tip: who read the arm felt them as a part of its last body.

use std::collections::{BTreeMap, BTreeSet};

use quick_xml::events::{BytesEnd, BytesStart, BytesText, Event};
use quick_xml::{Reader, Writer};
use urdf_rs::JointType;

use super::error::UrdfError;
use super::essentials::located;
use super::joint;
use super::tree::Tree;
use super::xml::{attribute, name_of, put};
use crate::body_inertia::BodyInertia;
use crate::transform::Transform;

/// What becomes of the `<inertial>` of some links: another one, or none.
pub(super) type Inertials = BTreeMap<String, Option<String>>;

/// `bodies`: the rigid body on each named link, in that link's frame; all that it moves with hangs together with it by fixed joints.
pub(super) fn inertials(tree: &Tree<'_>, bodies: &[(String, BodyInertia)]) -> Result<Inertials, UrdfError> {
    let roots = bodies.iter().map(|(name, body)| {
        let (root, pose) = carried_link(tree, tree.find("link", name)?)?;
        Ok((root, body.in_frame(&pose.inverse())))
    });
    let roots = roots.collect::<Result<Vec<_>, UrdfError>>()?;
    let own: BTreeSet<usize> = roots.iter().map(|(root, _)| *root).collect();
    let mut inertials = Inertials::new();
    for (root, body) in &roots {
        let mut open = tree.child_joints(*root).to_vec();
        while let Some(index) = open.pop() {
            let child = tree.child(index);
            if !own.contains(&child) {
                inertials.insert(tree.link_name(child), None);
                open.extend(tree.child_joints(child));
            }
        }
        inertials.insert(tree.link_name(*root), Some(element(body)));
    }
    Ok(inertials)
}

/// The link that the movable joint of a link's rigid body carries, and the link's pose in its frame.
fn carried_link(tree: &Tree<'_>, link: usize) -> Result<(usize, Transform), UrdfError> {
    let (mut root, mut pose) = (link, Transform::identity());
    while let Some(index) = tree.parent_joint(root) {
        let carrying = &tree.robot.joints[index];
        if carrying.joint_type != JointType::Fixed {
            break;
        }
        pose = joint::origin(carrying)? * pose;
        root = tree.parent_link(index);
    }
    Ok((root, pose))
}

fn element(body: &BodyInertia) -> String {
    let [x, y, z] = body.center_of_mass();
    let [xx, xy, yy, xz, yz, zz] = body.tensor_about_center();
    format!(
        "\n    <inertial>\n      <origin xyz=\"{x} {y} {z}\" rpy=\"0 0 0\"/>\n      <mass value=\"{}\"/>\n      <inertia ixx=\"{xx}\" \
         ixy=\"{xy}\" ixz=\"{xz}\" iyy=\"{yy}\" iyz=\"{yz}\" izz=\"{zz}\"/>\n    </inertial>",
        body.mass
    )
}

/// The text with these inertias, everything else as it is.
pub(super) fn with_inertials(text: &str, inertials: &Inertials) -> Result<String, UrdfError> {
    let mut reader = Reader::from_str(text);
    let mut writer = Writer::new(Vec::new());
    let mut depth = 0;
    let mut in_changed_link = false;
    loop {
        let event = reader.read_event().map_err(|error| located(text, &reader, &error))?;
        let changed = |start: &BytesStart<'_>| -> Result<Option<&Option<String>>, UrdfError> {
            let name = if depth == 1 && name_of(start) == "link" { attribute(start, "name")? } else { None };
            Ok(name.and_then(|name| inertials.get(&name)))
        };
        match &event {
            Event::Eof => break,
            Event::Start(start) if depth == 2 && in_changed_link && name_of(start) == "inertial" => {
                reader.read_to_end(start.name()).map_err(|error| located(text, &reader, &error))?;
            }
            Event::Empty(start) if depth == 2 && in_changed_link && name_of(start) == "inertial" => {}
            Event::Start(start) => {
                let change = changed(start)?;
                in_changed_link = if depth == 1 { change.is_some() } else { in_changed_link };
                put(&mut writer, event.borrow())?;
                if let Some(Some(new)) = change {
                    put(&mut writer, Event::Text(BytesText::from_escaped(new.as_str())))?;
                }
                depth += 1;
            }
            Event::Empty(start) => match changed(start)? {
                Some(Some(new)) => {
                    put(&mut writer, Event::Start(start.borrow()))?;
                    put(&mut writer, Event::Text(BytesText::from_escaped(format!("{new}\n  "))))?;
                    put(&mut writer, Event::End(BytesEnd::new("link")))?;
                }
                _ => put(&mut writer, event.borrow())?,
            },
            Event::End(_) => {
                depth -= 1;
                put(&mut writer, event.borrow())?;
            }
            other => put(&mut writer, other.borrow())?,
        }
    }
    Ok(String::from_utf8_lossy(&writer.into_inner()).into_owned())
}

#[cfg(test)]
mod tests {
    use super::super::{UrdfCorrection, tests::ARM};
    use super::*;
    use crate::chain::Chain;

    #[test]
    fn a_chain_from_the_new_file_has_the_new_inertias_and_nothing_else_is_changed() {
        let old = Chain::from_urdf(ARM, "base", &["hand"]).unwrap();
        let tensor = [0.03, 0.002, 0.025, -0.001, 0.003, 0.02];
        let body = |k: usize| BodyInertia::about_center(1.5 + k as f64, [0.1, -0.2, 0.05 * k as f64], tensor);
        let bodies: Vec<(String, BodyInertia)> =
            old.links().iter().enumerate().map(|(k, link)| (link.name.clone(), body(k))).collect();
        let correction = UrdfCorrection { gravity: None, offsets: &[], inertias: &bodies, comment: &[] };
        let text = correction.apply(ARM).unwrap();
        let new = Chain::from_urdf(&text, "base", &["hand"]).unwrap();
        assert_eq!(new.joints(), old.joints());
        let expected = bodies.iter().flat_map(|(_, body)| body.parameters());
        let found = new.inertial_parameters().unwrap();
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}\n{text}");
        // What is replaced is gone.
        assert_eq!(text.matches("<inertial>").count(), 2);
        let again = Chain::from_urdf(&correction.apply(&text).unwrap(), "base", &["hand"]).unwrap();
        assert_eq!(again, new);
    }
}
