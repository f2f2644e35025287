//! What a URDF gives, and each way in which it can be wrong.

use proptest::prelude::*;

use super::*;
use crate::chain::ChainError;

/// A column that turns, an arm on it behind a fixed bracket, and a hand with one finger.
pub(super) const ARM: &str = r#"
<robot name="arm" xmlns:drake="http://drake.mit.edu">
  <!-- was: <xacro:include filename="arm.xacro"/> -->
  <gazebo reference="hand"><gravity>1</gravity></gazebo>
  <link name="base"/>
  <link name="column"><inertial><origin xyz="0 0 0.1"/><mass value="3"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="bracket"><inertial><origin xyz="0 0.5 0"/><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="arm"/>
  <link name="hand"><inertial><origin xyz="0.1 0 0"/><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="finger"><inertial><mass value="9"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <joint name="pan" type="continuous">
    <parent link="base"/><child link="column"/><axis xyz="0 0 2"/>
  </joint>
  <joint name="mount" type="fixed">
    <parent link="column"/><child link="bracket"/><origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>
  </joint>
  <joint name="lift" type="revolute">
    <parent link="bracket"/><child link="arm"/><origin xyz="0.2 0 0"/><axis xyz="0 -1 0"/>
    <limit lower="-1" upper="2" effort="1" velocity="1" drake:acceleration="3"/>
  </joint>
  <joint name="wrist" type="fixed">
    <parent link="arm"/><child link="hand"/><origin xyz="0.5 0 0" rpy="1.5707963267948966 0 0"/>
  </joint>
  <joint name="grip" type="prismatic">
    <parent link="hand"/><child link="finger"/><axis xyz="0 1 0"/><limit lower="0" upper="0.04" effort="1" velocity="1"/>
  </joint>
  <transmission name="t"><joint name="lift"/></transmission>
</robot>"#;

fn arm_with(from: &str, to: &str) -> Result<Chain, UrdfError> {
    assert!(ARM.contains(from), "nothing to replace: {from}");
    Chain::from_urdf(&ARM.replacen(from, to, 1), "base", &["hand"])
}

fn refused(from: &str, to: &str) -> UrdfError {
    arm_with(from, to).unwrap_err()
}

fn refused_between(base: &str, tip: &str) -> UrdfError {
    Chain::from_urdf(ARM, base, &[tip]).unwrap_err()
}

fn assert_close(left: [f64; 3], right: [f64; 3]) {
    assert!(left.iter().zip(right).all(|(l, r)| (l - r).abs() < 1e-15), "{left:?} is not {right:?}");
}

#[test]
fn joints_of_the_path() {
    let chain = Chain::from_urdf(ARM, "base", &["hand"]).unwrap();
    let joints = chain.joints();
    assert_eq!(joints.iter().map(|joint| joint.name.as_str()).collect::<Vec<_>>(), ["pan", "lift"]);
    assert_eq!((joints[0].axis, joints[0].limits), ([0.0, 0.0, 1.0], None));
    assert_eq!((joints[1].axis, joints[1].limits), ([0.0, -1.0, 0.0], Some([-1.0, 2.0])));
    // The bracket turns its x to the column's y.
    assert_close(joints[1].before.translation(), [1.0, 0.2, 0.0]);
    assert_close(joints[1].after.translation(), [0.5, 0.0, 0.0]);
}

#[test]
fn fixed_bodies_are_merged_and_the_last_link_is_the_tip() {
    let chain = Chain::from_urdf(ARM, "base", &["hand"]).unwrap();
    let names: Vec<_> = chain.links().iter().map(|link| link.name.as_str()).collect();
    assert_eq!(names, ["column", "hand"]);

    let column = chain.links()[0].inertia.unwrap();
    // 3 kg at (0, 0, 0.1); 2 kg at (1, 0, 0) + Rot_z(90°) (0, 0.5, 0).
    assert_eq!(column.mass, 5.0);
    assert_close(column.first_moment, [2.0 * 0.5, 0.0, 0.3]);

    let hand = chain.links()[1].inertia.unwrap();
    assert_eq!(hand.mass, 1.0);
    assert_close(hand.first_moment, [0.1, 0.0, 0.0]);
}

#[test]
fn what_moves_beyond_the_tip_is_cut_and_named() {
    let to_hand = Chain::from_urdf(ARM, "base", &["hand"]).unwrap();
    assert_eq!(to_hand.cut_joints(), ["grip"]);
    let to_column = Chain::from_urdf(ARM, "base", &["column"]).unwrap();
    assert_eq!(to_column.cut_joints(), ["lift"]);
    assert_eq!(to_column.links()[0].inertia.unwrap().mass, 5.0);
    let to_finger = Chain::from_urdf(ARM, "base", &["finger"]).unwrap();
    assert!(to_finger.cut_joints().is_empty());
    assert_eq!(to_finger.joints()[2].kind, JointKind::Prismatic);
}

#[test]
fn a_tip_before_the_end_of_its_body_still_carries_all_of_it() {
    let chain = Chain::from_urdf(ARM, "base", &["arm"]).unwrap();
    let arm = chain.links()[1].inertia.unwrap();
    assert_eq!((arm.mass, chain.cut_joints()), (1.0, ["grip".to_owned()].as_slice()));
    assert_close(arm.first_moment, [0.6, 0.0, 0.0]);
}

#[test]
fn the_base_may_be_any_link() {
    let chain = Chain::from_urdf(ARM, "bracket", &["hand"]).unwrap();
    assert_eq!((chain.base(), chain.joint_count()), ("bracket", 1));
    assert_close(chain.joints()[0].before.translation(), [0.2, 0.0, 0.0]);
}

#[test]
fn what_is_not_stated_is_not_known() {
    let no_limits = arm_with(r#"lower="-1" upper="2""#, "").unwrap();
    assert_eq!(no_limits.joints()[1].limits, None);
    let no_mass = Chain::from_urdf(&ARM.replace(r#"<mass value="1"/>"#, r#"<mass value="0"/>"#), "base", &["hand"]);
    assert_eq!(no_mass.unwrap().links()[1].inertia, None);
}

#[test]
fn not_xml() {
    let message = Chain::from_urdf("joints: [pan]", "base", &["hand"]).unwrap_err().to_string();
    assert!(message.starts_with("not a readable URDF: "), "{message}");
    let message = refused("</robot>", "").to_string();
    assert!(message.starts_with("not a readable URDF: "), "{message}");
    let message = refused(r#"xyz="0 0 2""#, r#"xyz="0 0 up""#).to_string();
    assert!(message.contains("0 0 up"), "{message}");
}

#[test]
fn xacro() {
    assert_eq!(refused("<link name=\"base\"/>", "<xacro:base/>"), UrdfError::Xacro);
}

#[test]
fn missing_links() {
    let message = refused_between("bse", "hand").to_string();
    assert!(message.contains("base link `bse` is not in the URDF (did you mean `base`?)"), "{message}");
    assert!(message.ends_with("links there: base, column, bracket, arm, hand, finger"), "{message}");
    let message = refused_between("base", "tool0").to_string();
    assert!(message.contains("tip link `tool0` is not in the URDF; links there: base"), "{message}");
    let message = Chain::from_urdf("<robot name=\"r\"/>", "base", &["hand"]).unwrap_err().to_string();
    assert!(message.ends_with("links there: none"), "{message}");
}

#[test]
fn joints_on_undefined_links() {
    let error = refused(r#"<child link="arm"/>"#, r#"<child link="amr"/>"#);
    let expected = UrdfError::UnknownLink { joint: "lift".into(), role: "child", link: "amr".into() };
    assert_eq!(error, expected);
    let error = refused(r#"<parent link="bracket"/>"#, r#"<parent link="b"/>"#);
    let expected = UrdfError::UnknownLink { joint: "lift".into(), role: "parent", link: "b".into() };
    assert_eq!(error, expected);
}

#[test]
fn no_path() {
    let hint = |error: UrdfError| match error {
        UrdfError::NoPath { hint, .. } => hint,
        other => panic!("{other}"),
    };
    assert!(hint(refused_between("hand", "base")).contains("exchange"));
    let branch = r#"<link name="camera"/><joint name="c" type="fixed"><parent link="column"/><child link="camera"/></joint></robot>"#;
    let branched = ARM.replace("</robot>", branch);
    let error = Chain::from_urdf(&branched, "camera", &["hand"]).unwrap_err();
    assert!(hint(error).contains("branch apart at link `column`"));
    let apart = ARM.replace("</robot>", r#"<link name="table"/></robot>"#);
    let error = Chain::from_urdf(&apart, "table", &["hand"]).unwrap_err();
    assert!(hint(error).contains("more than one tree"));
}

#[test]
fn nothing_moves() {
    let error = refused_between("column", "bracket");
    assert_eq!(error, UrdfError::NothingMoves { base: "column".into(), tip: "bracket".into() });
    assert!(matches!(refused_between("base", "base"), UrdfError::NothingMoves { .. }));
}

#[test]
fn loops() {
    let closing = r#"<joint name="rod" type="revolute"><parent link="base"/><child link="hand"/><limit velocity="1"/></joint></robot>"#;
    let expected = UrdfError::TwoParents { link: "hand".into(), first: "wrist".into(), second: "rod".into() };
    assert_eq!(refused("</robot>", closing), expected);

    // Through the base: every link has one parent, and none is a root.
    let ring = r#"<joint name="ring" type="fixed"><parent link="hand"/><child link="base"/></joint></robot>"#;
    let UrdfError::Loop { links } = refused("</robot>", ring) else { panic!("expected a loop") };
    assert_eq!(links.len(), 6);
    assert_eq!(links.first(), links.last());
    assert!(links.windows(2).any(|pair| pair == ["hand", "base"]), "{links:?}");

    // Beside the chain, and a link that is its own parent.
    let beside = r#"<link name="a"/><link name="b"/>
        <joint name="ab" type="fixed"><parent link="a"/><child link="b"/></joint>
        <joint name="ba" type="fixed"><parent link="b"/><child link="a"/></joint></robot>"#;
    assert!(refused("</robot>", beside).to_string().contains(" form a loop: "));
    let own = r#"<link name="a"/><joint name="aa" type="fixed"><parent link="a"/><child link="a"/></joint></robot>"#;
    assert_eq!(refused("</robot>", own), UrdfError::Loop { links: vec!["a".into(), "a".into()] });
}

#[test]
fn repeated_names() {
    let error = refused("</robot>", r#"<link name="arm"/></robot>"#);
    assert_eq!(error, UrdfError::RepeatedLink("arm".into()));
    let error = refused(r#"joint name="lift""#, r#"joint name="pan""#);
    assert_eq!(error, UrdfError::Chain(ChainError::RepeatedJoint("pan".into())));
}

#[test]
fn joints_that_a_chain_cannot_hold() {
    for kind in ["floating", "planar"] {
        let error = refused(r#"type="revolute""#, &format!(r#"type="{kind}""#));
        assert_eq!(error, UrdfError::UnsupportedJoint { joint: "lift".into(), kind });
    }
}

/// Two fingers on a hand, the second mimicking the first, as text for the end of a URDF.
const FINGERS: &str = r#"
  <link name="left"><inertial><origin xyz="0 0.02 0"/><mass value="0.1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="right"><inertial><origin xyz="0 0.02 0"/><mass value="0.1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <joint name="follow" type="prismatic"><parent link="hand"/><child link="right"/><axis xyz="0 -1 0"/>
    <limit lower="0" upper="0.04" effort="1" velocity="1"/><mimic joint="lead" multiplier="0.5" offset="0.01"/></joint>
  <joint name="lead" type="prismatic"><parent link="hand"/><child link="left"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.04" effort="1" velocity="1"/></joint>
</robot>"#;

/// The arm with two fingers in place of one.
fn hand_with_fingers(tips: &[&str]) -> Result<Chain, UrdfError> {
    let (before, rest) = ARM.split_once(r#"  <link name="finger">"#).unwrap();
    let (_, rest) = rest.split_once("</link>").unwrap();
    let (middle, _) = rest.split_once(r#"  <joint name="grip""#).unwrap();
    Chain::from_urdf(&format!("{before}{middle}{FINGERS}"), "base", tips)
}

#[test]
fn a_joint_that_mimics_follows_its_leader() {
    let chain = hand_with_fingers(&["right", "left"]).unwrap();
    let names = |joints: &[Joint]| joints.iter().map(|joint| joint.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(chain.movers()), ["pan", "lift", "follow", "lead"]);
    assert_eq!(names(chain.joints()), ["pan", "lift", "lead"]);
    assert_eq!(chain.axis_coordinates(&[1.0, 2.0, 0.02])[..], [1.0, 2.0, 0.02, 0.02]);
    let [mut force, inertia] =
        [vec![0.0; 3], [[0.0; 4], [0.0; 4], [0.1, 0.0, 0.0, 0.0], [0.3, 0.0, 0.0, 0.0]].concat()];
    let [.., lead] = chain.axes(&[0.0; 3])[..] else { panic!("four axes") };
    chain.gravity_torque(&[0.0; 3], lead.map(|c| -10.0 * c), &inertia, &mut force);
    // 0.3 kg are lifted by the leader, half as fast 0.1 kg are let down.
    assert!((force[2] - 10.0 * (0.3 - 0.5 * 0.1)).abs() < 1e-12, "{force:?}");
}

#[test]
fn a_leader_must_be_part_of_the_robot() {
    let alone = refused(r#"<axis xyz="0 -1 0"/>"#, r#"<axis xyz="0 -1 0"/><mimic joint="grip"/>"#);
    assert_eq!(alone, UrdfError::Leader { joint: "lift".into(), leader: "grip".into() });
    assert!(alone.to_string().contains("name a tip beyond `grip` as well"), "{alone}");
    let unknown = refused(r#"<axis xyz="0 -1 0"/>"#, r#"<axis xyz="0 -1 0"/><mimic joint="tilt"/>"#);
    assert_eq!(unknown, UrdfError::Leader { joint: "lift".into(), leader: "tilt".into() });
    let itself = refused(r#"<axis xyz="0 -1 0"/>"#, r#"<axis xyz="0 -1 0"/><mimic joint="lift"/>"#);
    assert_eq!(itself, UrdfError::Chain(ChainError::MimicCircle { joint: "lift".into() }));
    let one_finger = hand_with_fingers(&["left"]).unwrap_err().to_string();
    assert!(one_finger.starts_with("joint `follow` hangs on link `hand`"), "{one_finger}");
}

/// A camera that tilts on the bracket, beside the arm.
const CAMERA: &str = r#"<link name="camera"/><joint name="tilt" type="continuous"><parent link="bracket"/><child link="camera"/></joint></robot>"#;

#[test]
fn movable_branches_that_no_tip_names() {
    let error = refused("</robot>", CAMERA);
    let expected =
        UrdfError::Branch { joint: "tilt".into(), link: "bracket".into(), base: "base".into(), tips: "`hand`".into() };
    assert_eq!(error, expected);
    // On the base it loads nothing: only the hand's own joint is cut.
    let second_arm = CAMERA.replace("bracket", "base");
    assert_eq!(arm_with("</robot>", &second_arm).unwrap().cut_joints(), ["grip"]);
}

#[test]
fn a_tip_for_each_branch() {
    let text = ARM.replace("</robot>", CAMERA);
    for (tips, names, parents) in [
        (["hand", "camera"], ["column", "hand", "camera"], [None, Some(0), Some(0)]),
        (["camera", "hand"], ["column", "camera", "hand"], [None, Some(0), Some(0)]),
    ] {
        let chain = Chain::from_urdf(&text, "base", &tips).unwrap();
        assert_eq!(chain.links().iter().map(|link| link.name.as_str()).collect::<Vec<_>>(), names);
        assert_eq!((0..3).map(|link| chain.parent(link)).collect::<Vec<_>>(), parents);
        assert_eq!(chain.cut_joints(), ["grip"]);
    }
    let finger = Chain::from_urdf(&text, "base", &["finger", "camera"]).unwrap();
    assert_eq!((finger.joint_count(), finger.parent(3), finger.cut_joints().len()), (4, Some(0), 0));
    let serial = Chain::from_urdf(ARM, "base", &["hand"]).unwrap();
    let branch = Chain::from_urdf(&text, "base", &["hand", "camera"]).unwrap();
    assert_eq!(branch.joints()[..2], serial.joints()[..]);
    assert_eq!(branch.links()[..2], serial.links()[..]);
}

#[test]
fn tips_that_say_nothing() {
    let text = ARM.replace("</robot>", CAMERA);
    let refused = |tips: &[&str]| Chain::from_urdf(&text, "base", tips).unwrap_err();
    assert_eq!(refused(&[]), UrdfError::NoTip);
    let on_the_way = |tip: &str, other: &str| UrdfError::TipOnTheWay { tip: tip.into(), other: other.into() };
    assert_eq!(refused(&["camera", "column", "hand"]), on_the_way("column", "camera"));
    assert_eq!(refused(&["camera", "hand", "arm"]), on_the_way("hand", "arm"));
    assert_eq!(refused(&["camera", "hand", "hand"]), on_the_way("hand", "hand"));
    assert_eq!(refused(&["camera", "base"]), UrdfError::NothingMoves { base: "base".into(), tip: "base".into() });
}

#[test]
fn numbers() {
    assert_eq!(refused(r#"xyz="0 -1 0""#, r#"xyz="0 0 0""#), UrdfError::ZeroAxis { joint: "lift".into() });
    let error = refused(r#"lower="-1" upper="2""#, r#"lower="2" upper="-1""#);
    let swapped = ChainError::Limits { joint: "lift".into(), lower: 2.0, upper: -1.0 };
    assert_eq!(error, UrdfError::Chain(swapped));
    assert_eq!(
        refused(r#"<mass value="2"/>"#, r#"<mass value="-2"/>"#),
        UrdfError::NegativeMass { link: "bracket".into(), mass: -2.0 }
    );
    let not_finite = [
        (r#"<mass value="2"/>"#, r#"<mass value="nan"/>"#, "mass or centre of mass of link `bracket`"),
        (r#"<origin xyz="0 0.5 0"/>"#, r#"<origin xyz="0 inf 0"/>"#, "mass or centre of mass of link `bracket`"),
        (r#"xyz="1 0 0""#, r#"xyz="1 nan 0""#, "origin of joint `mount`"),
        (r#"xyz="0.2 0 0""#, r#"xyz="0.2 0 0" rpy="inf 0 0""#, "origin of joint `lift`"),
        (r#"xyz="0 -1 0""#, r#"xyz="0 nan 0""#, "axis of joint `lift`"),
    ];
    for (from, to, what) in not_finite {
        assert_eq!(refused(from, to), UrdfError::NotFinite { what: what.into() });
    }
    let error = refused(r#"lower="-1""#, r#"lower="nan""#);
    let limits = ChainError::NotFinite { what: "limits of joint `lift`".into() };
    assert_eq!(error, UrdfError::Chain(limits));
}

#[test]
fn axes_of_any_length() {
    for axis in ["1e-300 1e-300 0", "1e300 1e300 0"] {
        let chain = arm_with(r#"xyz="0 -1 0""#, &format!(r#"xyz="{axis}""#)).unwrap();
        let half = std::f64::consts::FRAC_1_SQRT_2;
        assert_close(chain.joints()[1].axis, [half, half, 0.0]);
    }
}

proptest! {
    /// A damaged file is refused or read, but never brings the program down.
    #[test]
    fn damaged_text_does_not_panic(start in 0..ARM.len(), length in 0..200_usize, filler in "[<>/\" a-z0-9.-]{0,20}") {
        let end = (start + length).min(ARM.len());
        let damaged = format!("{}{filler}{}", &ARM[..start], &ARM[end..]);
        let _ = Chain::from_urdf(&damaged, "base", &["hand"]);
    }

    #[test]
    fn text_that_is_no_urdf_does_not_panic(text in any::<String>()) {
        prop_assert!(Chain::from_urdf(&text, "base", &["hand"]).is_err());
    }
}

#[test]
fn tensors_of_merged_bodies_are_about_the_links_origin() {
    let turned = ARM
        .replacen(r#"<origin xyz="0 0.5 0"/>"#, r#"<origin xyz="0 0.5 0" rpy="0 1.5707963267948966 0"/>"#, 1)
        .replacen(
            r#"<mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>"#,
            r#"<mass value="2"/><inertia ixx="4" ixy="0" ixz="0" iyy="5" iyz="0" izz="6"/>"#,
            1,
        );
    let parameters = Chain::from_urdf(&turned, "base", &["hand"]).unwrap().inertial_parameters().unwrap();
    // The bracket's axes: 4 along −z, 5 along y and 6 along x of the bracket, whose x is the column's y.
    let bracket = [5.0, 0.0, 6.0, 0.0, 0.0, 4.0];
    // 2 kg at (0.5, 0, 0), 3 kg at (0, 0, 0.1) with a unit tensor.
    let shift = [0.03, 0.0, 0.5 + 0.03, 0.0, 0.0, 0.5];
    let column: Vec<f64> = (0..6).map(|k| bracket[k] + shift[k] + [1.0, 0.0, 1.0, 0.0, 0.0, 1.0][k]).collect();
    let hand = [1.0, 0.1, 0.0, 0.0, 1.0, 0.0, 1.01, 0.0, 0.0, 1.01];
    for (reported, expected) in [(&parameters[4..10], column.as_slice()), (&parameters[10..], &hand)] {
        let close = reported.iter().zip(expected).all(|(l, r)| (l - r).abs() < 1e-14);
        assert!(close, "{reported:?} is not {expected:?}");
    }
}

#[test]
fn a_tensor_that_is_no_number_concerns_motion_only() {
    let chain = arm_with(r#"ixx="1""#, r#"ixx="nan""#).unwrap();
    assert_eq!(chain.links()[0].inertia.unwrap().mass, 5.0);
    let message = chain.inertial_parameters().unwrap_err().to_string();
    assert!(message.contains("inertia tensor of link `column`"), "{message}");
}
