//! What a chain is checked for before it is built.

use std::collections::HashSet;

use nalgebra::Vector3;

use super::attachment::Attachment;
use super::error::ChainError;
use crate::joint::Joint;
use crate::link::Link;

/// How far from 1 the length of an axis may be (what six printed digits leave); it is then made exactly 1.
const AXIS_LENGTH: f64 = 1e-5;

pub(super) fn counts(
    base: &str,
    joints: &[Joint],
    links: &[Link],
    attachments: &[Attachment],
) -> Result<(), ChainError> {
    if joints.is_empty() {
        return Err(ChainError::NoJoints { base: base.to_owned() });
    }
    if joints.len() != links.len() {
        return Err(ChainError::LinkCount { joints: joints.len(), links: links.len() });
    }
    if joints.len() != attachments.len() {
        return Err(ChainError::AttachmentCount { joints: joints.len(), attachments: attachments.len() });
    }
    Ok(())
}

pub(super) fn names(base: &str, joints: &[Joint], links: &[Link]) -> Result<(), ChainError> {
    let joint_names = joints.iter().map(|joint| joint.name.as_str());
    let link_names = std::iter::once(base).chain(links.iter().map(|link| link.name.as_str()));
    if let Some(name) = first_repeated(joint_names) {
        return Err(ChainError::RepeatedJoint(name.to_owned()));
    }
    if let Some(name) = first_repeated(link_names) {
        return Err(ChainError::RepeatedLink(name.to_owned()));
    }
    Ok(())
}

fn first_repeated<'a>(mut names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let mut seen = HashSet::new();
    names.find(|name| !seen.insert(*name))
}

pub(super) fn link(link: &Link) -> Result<(), ChainError> {
    let Some(inertia) = link.inertia else {
        return Ok(());
    };
    if !inertia.mass.is_finite() || inertia.first_moment.iter().any(|h| !h.is_finite()) {
        return Err(ChainError::NotFinite { what: format!("mass or first moment of link `{}`", link.name) });
    }
    if inertia.mass < 0.0 {
        return Err(ChainError::NegativeMass { link: link.name.clone(), mass: inertia.mass });
    }
    Ok(())
}

pub(super) fn finite(joint: &Joint) -> Result<(), ChainError> {
    let limits_finite = joint.limits.iter().flatten().all(|limit| limit.is_finite());
    let parts = [
        ("transform before", joint.before.is_finite()),
        ("transform after", joint.after.is_finite()),
        ("axis", joint.axis.iter().all(|value| value.is_finite())),
        ("limits", limits_finite),
    ];
    match parts.into_iter().find(|(_, finite)| !finite) {
        Some((part, _)) => Err(ChainError::NotFinite { what: format!("{part} of joint `{}`", joint.name) }),
        None => Ok(()),
    }
}

pub(super) fn limits(joint: &Joint) -> Result<(), ChainError> {
    match joint.limits {
        Some([lower, upper]) if lower > upper => Err(ChainError::Limits { joint: joint.name.clone(), lower, upper }),
        _ => Ok(()),
    }
}

pub(super) fn unit_axis(joint: &Joint) -> Result<[f64; 3], ChainError> {
    let axis = Vector3::from(joint.axis);
    let length = axis.norm();
    if (length - 1.0).abs() > AXIS_LENGTH {
        return Err(ChainError::Axis { joint: joint.name.clone(), axis: joint.axis, length });
    }
    Ok((axis / length).into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::{Chain, Mimic};
    use crate::joint::JointKind;
    use crate::link::LinkInertia;
    use crate::transform::Transform;

    fn joint(name: &str) -> Joint {
        Joint {
            name: name.into(),
            kind: JointKind::Revolute,
            before: Transform::identity(),
            axis: [0.0, 0.0, 1.0],
            after: Transform::identity(),
            limits: None,
        }
    }

    fn link(name: &str, inertia: Option<LinkInertia>) -> Link {
        Link { name: name.into(), inertia }
    }

    fn one_joint(joint: Joint) -> Result<Chain, ChainError> {
        Chain::new("base", vec![joint], vec![link("arm", None)])
    }

    fn one_link(mass: f64, first_moment: [f64; 3]) -> Result<Chain, ChainError> {
        Chain::new("base", vec![joint("a")], vec![link("arm", Some(LinkInertia { mass, first_moment }))])
    }

    #[test]
    fn counts_and_names() {
        let refused = |joints: &[&str], links: &[&str]| {
            let joints = joints.iter().map(|name| joint(name)).collect();
            let links = links.iter().map(|name| link(name, None)).collect();
            Chain::new("base", joints, links).unwrap_err()
        };
        assert_eq!(refused(&[], &[]), ChainError::NoJoints { base: "base".into() });
        assert_eq!(refused(&["a"], &["x", "y"]), ChainError::LinkCount { joints: 1, links: 2 });
        assert_eq!(refused(&["a", "a"], &["x", "y"]), ChainError::RepeatedJoint("a".into()));
        assert_eq!(refused(&["a", "b"], &["x", "x"]), ChainError::RepeatedLink("x".into()));
        assert_eq!(refused(&["a"], &["base"]), ChainError::RepeatedLink("base".into()));
    }

    fn attached(parents: &[Option<usize>], mimics: &[(usize, Mimic)]) -> Result<Chain, ChainError> {
        let joints = (0..parents.len()).map(|k| joint(&format!("joint{k}"))).collect();
        let links = (0..parents.len()).map(|k| link(&format!("link{k}"), None)).collect();
        let mut attachments: Vec<_> =
            parents.iter().map(|parent| Attachment { parent: *parent, mimic: None }).collect();
        mimics.iter().for_each(|(k, mimic)| attachments[*k].mimic = Some(*mimic));
        Chain::branched("base", joints, links, &attachments)
    }

    #[test]
    fn parents_and_branches() {
        assert!(attached(&[None, Some(0), Some(1), Some(0), None], &[]).is_ok());
        let message = |parents: &[Option<usize>]| attached(parents, &[]).unwrap_err().to_string();
        let own = "joint `joint1` hangs on a link that does not come before its own";
        assert!(message(&[None, Some(1)]).starts_with(own), "{}", message(&[None, Some(1)]));
        assert!(message(&[None, Some(7)]).starts_with(own));
        let broken = message(&[None, Some(0), Some(0), Some(1)]);
        assert!(broken.starts_with("joint `joint3` hangs on link `link1`, whose branch has ended"), "{broken}");
        let error = Chain::branched("base", vec![joint("a")], vec![link("arm", None)], &[]).unwrap_err();
        assert_eq!(error, ChainError::AttachmentCount { joints: 1, attachments: 0 });
    }

    #[test]
    fn leaders() {
        let serial = [None, Some(0), Some(1)];
        let mimic = |leader, multiplier| Mimic { leader, multiplier, offset: 0.5 };
        let chain = attached(&serial, &[(0, mimic(1, 2.0)), (1, mimic(2, -3.0))]).unwrap();
        assert_eq!((chain.joint_count(), chain.link_count(), chain.joints()[0].name.as_str()), (1, 3, "joint2"));
        // −6 x + 2 · 0.5 + 0.5, −3 x + 0.5, x
        assert_eq!(chain.axis_coordinates(&[1.0])[..], [-4.5, -2.5, 1.0]);

        let circle = attached(&serial, &[(0, mimic(1, 2.0)), (1, mimic(0, 1.0))]).unwrap_err();
        assert_eq!(circle, ChainError::MimicCircle { joint: "joint0".into() });
        let missing = attached(&serial, &[(1, mimic(3, 1.0))]).unwrap_err();
        assert_eq!(missing, ChainError::UnknownLeader { joint: "joint1".into() });
        let broken = attached(&serial, &[(1, mimic(0, f64::NAN))]).unwrap_err();
        assert!(broken.to_string().starts_with("multiplier or offset by which joint `joint1` mimics"), "{broken}");
    }

    #[test]
    fn axes_and_limits() {
        let nearly = one_joint(Joint { axis: [0.600003, 0.0, 0.8], ..joint("a") }).unwrap();
        assert!((Vector3::from(nearly.joints()[0].axis).norm() - 1.0).abs() < 1e-15);

        let long = one_joint(Joint { axis: [0.0, 0.0, 2.0], ..joint("a") }).unwrap_err();
        assert!(long.to_string().contains("`a` has length 2; expected a unit vector"), "{long}");

        let swapped = one_joint(Joint { limits: Some([1.0, -1.0]), ..joint("a") }).unwrap_err();
        assert_eq!(swapped, ChainError::Limits { joint: "a".into(), lower: 1.0, upper: -1.0 });
    }

    #[test]
    fn numbers() {
        let broken = Transform::along([f64::NAN, 0.0, 0.0]);
        let refused = [
            (one_joint(Joint { before: broken, ..joint("a") }), "transform before of joint `a`"),
            (one_joint(Joint { after: broken, ..joint("a") }), "transform after of joint `a`"),
            (one_joint(Joint { axis: [f64::NAN; 3], ..joint("a") }), "axis of joint `a`"),
            (one_joint(Joint { limits: Some([0.0, f64::INFINITY]), ..joint("a") }), "limits of joint `a`"),
            (one_link(f64::NAN, [0.0; 3]), "mass or first moment of link `arm`"),
            (one_link(1.0, [f64::INFINITY; 3]), "mass or first moment of link `arm`"),
        ];
        for (result, what) in refused {
            assert_eq!(result.unwrap_err(), ChainError::NotFinite { what: what.into() });
        }
        assert_eq!(one_link(-1.0, [0.0; 3]).unwrap_err(), ChainError::NegativeMass { link: "arm".into(), mass: -1.0 });
    }
}
