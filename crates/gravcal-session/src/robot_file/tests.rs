//! Robots from files: what is read, and what is refused in which words.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fs;
use std::path::PathBuf;

use gravcal_dynamics::{Chain, DhConvention, DhRow, JointKind, Link, LinkInertia, chain_from_dh};
use gravcal_recording::{PositionUnit, TorqueUnit};
use gravcal_robot_model::robot::{NominalPositionSensor, NominalSensors, NominalTorqueSensor, Robot};
use tempfile::TempDir;

use super::*;
use crate::document::{Document, Field};

const ROBOT: &str = r#"
name = "crane"
convention = "standard-dh"
[[joint]]
name = "slew"
a_m = 0.0
alpha_deg = 90
d_m = 0.5
theta_rad = 0.25
limits_deg = [-90, 180]
link = "tower"
mass_kg = 2
center_of_mass_m = [0.1, 0, -0.5]
torque_sensor = { gain = { value = 6.69, unit = "count/(N·m)" }, bias = { value = 2048, unit = "count" } }
position_sensor = { gain = { value = 0.5, unit = "deg/count" }, offset = { value = 180, unit = "deg" } }
[[joint]]
name = "boom"
kind = "prismatic"
a_m = 0.1
alpha_rad = 0.0
d_m = 0.0
limits_m = [0, 2]
torque_sensor = { gain = { value = 2, unit = "V/N" } }
position_sensor = { gain = { value = 1, unit = "mm/mm" }, offset = { value = 3, unit = "mm" } }
"#;

/// A loop of two joints between the links `b` and `c`.
const LOOP: &str = r#"<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
<joint name="j1" type="revolute"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="j2" type="revolute"><parent link="c"/><child link="b"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"#;

/// A folder with one file in it.
fn folder_with(name: &str, text: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    (folder, path)
}

fn read(text: &str) -> Result<Robot, String> {
    let (folder, path) = folder_with("robot.toml", text);
    read_robot(&path).map_err(|error| without_folder(&folder, &error))
}

fn without_folder(folder: &TempDir, error: &FileError) -> String {
    error.to_string().replace(&format!("{}/", folder.path().display()), "")
}

/// What is said of the robot above with one thing changed.
fn refused(old: &str, new: &str) -> String {
    assert_eq!(ROBOT.matches(old).count(), 1, "`{old}` must stand once in the example");
    read(&ROBOT.replace(old, new)).unwrap_err()
}

#[test]
fn a_robot_is_read_in_si() {
    let robot = read(ROBOT).unwrap();
    let inertia = LinkInertia { mass: 2.0, first_moment: [0.2, 0.0, -1.0] };
    let rows = [
        DhRow {
            name: "slew".into(),
            kind: JointKind::Revolute,
            a: 0.0,
            alpha: FRAC_PI_2,
            d: 0.5,
            theta: 0.25,
            limits: Some([-FRAC_PI_2, PI]),
            link: Link { name: "tower".into(), inertia: Some(inertia) },
        },
        DhRow {
            name: "boom".into(),
            kind: JointKind::Prismatic,
            a: 0.1,
            alpha: 0.0,
            d: 0.0,
            theta: 0.0,
            limits: Some([0.0, 2.0]),
            link: Link { name: "link2".into(), inertia: None },
        },
    ];
    assert_eq!(robot.name, "crane");
    assert_eq!(robot.chain, chain_from_dh("base", DhConvention::Standard, &rows).unwrap());

    let modified = read(&ROBOT.replace("standard-dh\"", "modified-dh\"\nbase = \"floor\"")).unwrap();
    assert_eq!(modified.chain, chain_from_dh("floor", DhConvention::Modified, &rows).unwrap());
}

#[test]
fn nominal_sensors_are_read_in_si() {
    let robot = read(ROBOT).unwrap();
    let slew = NominalSensors {
        torque: Some(NominalTorqueSensor { unit: TorqueUnit::Count, gain: 6.69, bias: 2048.0 }),
        position: Some(NominalPositionSensor { unit: PositionUnit::Count, gain: 0.5 * (PI / 180.0), offset: PI }),
    };
    let boom = NominalSensors {
        torque: Some(NominalTorqueSensor { unit: TorqueUnit::Volt, gain: 2.0, bias: 0.0 }),
        position: Some(NominalPositionSensor { unit: PositionUnit::Millimeter, gain: 1.0, offset: 0.003 }),
    };
    assert_eq!(robot.sensors, [slew, boom]);
}

#[test]
fn xml_is_told_to_be_a_urdf_by_another_name() {
    let (folder, path) = folder_with("arm.xml", "\u{feff}<?xml version=\"1.0\"?>\n<robot name=\"arm\"/>");
    let error = without_folder(&folder, &read_robot(&path).unwrap_err());
    assert!(
        error.starts_with("arm.xml: this is XML, where a TOML file is expected; the name of a URDF must"),
        "{error}"
    );
}

#[test]
fn keys_and_names_are_known() {
    assert!(
        refused("d_m = 0.5", "d_mm = 500")
            .starts_with("robot.toml:8: joint[0].d_mm: unknown field `d_mm`, expected one of")
    );
    assert!(refused("a_m = 0.0\n", "").starts_with("robot.toml:4: joint[0]: missing field `a_m`"));
    assert!(refused("standard-dh", "dh").contains("unknown variant `dh`, expected `standard-dh` or `modified-dh`"));
    assert!(refused("prismatic", "sliding").starts_with("robot.toml:18: joint[1].kind: unknown variant `sliding`"));
    assert!(
        refused("d_m = 0.5", "d_m = \"half\"").starts_with("robot.toml:8: joint[0].d_m: invalid type: string \"half\"")
    );
    assert_eq!(
        refused("\"boom\"", "\"slew\""),
        "robot.toml:17: joint[1].name: `slew` is already joint[0].name: give each its own name"
    );
    assert_eq!(
        refused("\"tower\"", "\"link2\""),
        "robot.toml:16: joint[1].link: `link2` is already joint[0].link: give each its own name"
    );
    assert!(
        refused("\"tower\"", "\"base\"")
            .starts_with("robot.toml:4: joint: two links (the base counts as one) are named `base`")
    );
    let no_joint = read("name = 'a'\nconvention = 'standard-dh'\njoint = []\n").unwrap_err();
    assert!(no_joint.starts_with("robot.toml:3: joint: the chain from `base` has no joint"), "{no_joint}");
}

/// Rows behind the crane's: a second boom on the tower, and one on the floor that mimics it.
const BRANCHES: &str = r#"
[[joint]]
name = "jib"
parent = "tower"
mounting = { position_m = [0, 0.2, 1], rpy_deg = [90, 0, 0] }
a_m = 0.3
alpha_deg = 0
d_m = 0
[[joint]]
name = "mast"
parent = "base"
mimic = { joint = "jib", multiplier = -2, offset_deg = 90 }
a_m = 0.3
alpha_deg = 0
d_m = 0
"#;

fn branched() -> String {
    format!("{ROBOT}{BRANCHES}")
}

#[test]
fn a_robot_may_branch_and_joints_may_mimic() {
    let robot = read(&branched()).unwrap();
    let chain = &robot.chain;
    assert_eq!((0..4).map(|link| chain.parent(link)).collect::<Vec<_>>(), [None, Some(0), Some(0), None]);
    assert_eq!((chain.joint_count(), robot.sensors.len()), (3, 3));
    assert_eq!(chain.links_of(2).collect::<Vec<_>>(), [2, 3]);
    // In the tower's frame, whose y points up: 0.3 m along the mounted x, which a quarter turn leads to its z.
    let jib = chain.forward(&[-0.25, 0.0, FRAC_PI_2])[2];
    assert!(jib.translation().iter().zip([0.0, -1.3, 0.7]).all(|(a, b)| (a - b).abs() < 1e-15), "{jib:?}");
    // 90° − 2 · 90°
    let mast = chain.forward(&[0.0, 0.0, FRAC_PI_2])[3].translation();
    assert!(mast.iter().zip([0.0, -0.3, 0.0]).all(|(a, b)| (a - b).abs() < 1e-15), "{mast:?}");
}

#[test]
fn what_hangs_wrong_is_reported() {
    let refused = |old: &str, new: &str| {
        let text = branched();
        assert_eq!(text.matches(old).count(), 1, "`{old}` must stand once in the example");
        read(&text.replace(old, new)).unwrap_err()
    };
    assert_eq!(
        refused("parent = \"tower\"", "parent = \"towr\""),
        "robot.toml:28: joint[2].parent: there is no link in the rows before `towr` (did you mean `tower`?); known: \
         `tower`, `link2`, `base`"
    );
    let later = refused("parent = \"tower\"", "parent = \"link4\"");
    assert!(later.contains("there is no link in the rows before `link4`"), "{later}");
    let broken = refused("parent = \"base\"", "parent = \"link2\"");
    assert!(broken.contains("joint `mast` hangs on link `link2`, whose branch has ended; give the joints"), "{broken}");
    let missing = refused("joint = \"jib\"", "joint = \"jab\"");
    assert!(missing.starts_with("robot.toml:36: joint[3].mimic.joint: there is no joint `jab`"), "{missing}");
    let itself = refused("joint = \"jib\"", "joint = \"mast\"");
    assert!(itself.contains("joint `mast` mimics itself by way of others"), "{itself}");
    let twice = refused("offset_deg = 90", "offset_deg = 90, offset_rad = 1");
    assert!(twice.contains("joint[3].mimic.offset_rad: the offset is given twice: keep one"), "{twice}");
    let metres = refused("offset_deg = 90", "offset_m = 1");
    assert!(metres.contains("the offset of a revolute joint is offset_deg or offset_rad"), "{metres}");
    let sensor =
        refused("parent = \"base\"", "parent = \"base\"\ntorque_sensor = { gain = { value = 2, unit = \"V/(N·m)\" } }");
    assert!(
        sensor.starts_with("robot.toml:36: joint[3].torque_sensor: a joint that mimics has no sensor of its own"),
        "{sensor}"
    );
}

#[test]
fn numbers_are_finite() {
    assert_eq!(refused("a_m = 0.0", "a_m = nan"), "robot.toml:6: joint[0].a_m: expected a finite number, found nan");
}

#[test]
fn angles_are_given_once() {
    assert_eq!(
        refused("alpha_deg = 90", "alpha_deg = 90\nalpha_rad = 1"),
        "robot.toml:8: joint[0].alpha_rad: alpha is given in degrees and in radians: keep one"
    );
    assert!(refused("alpha_deg = 90\n", "").starts_with("robot.toml:4: joint[0]: the twist is missing"));
}

#[test]
fn limits_are_in_order_and_fit_the_joint() {
    for swapped in ["[180, -90]", "[90, 90]"] {
        let message = refused("[-90, 180]", swapped);
        assert!(message.starts_with("robot.toml:10: joint[0].limits_deg: the limits "), "{message}");
        assert!(message.ends_with("are the wrong way round: expected [lower, upper]"), "{message}");
    }
    let of_wrong_kind = "limits of a revolute joint are limits_deg or limits_rad, those of a prismatic one limits_m";
    assert_eq!(refused("limits_m", "limits_rad"), format!("robot.toml:22: joint[1].limits_rad: {of_wrong_kind}"));
    assert_eq!(refused("limits_deg", "limits_m"), format!("robot.toml:10: joint[0].limits_m: {of_wrong_kind}"));
    assert_eq!(
        refused("limits_deg = [-90, 180]", "limits_deg = [-90, 180]\nlimits_rad = [-1, 2]"),
        "robot.toml:11: joint[0].limits_rad: limits_deg is given as well: keep one"
    );
}

#[test]
fn masses_come_with_their_place() {
    assert_eq!(
        refused("mass_kg = 2", "mass_kg = -2"),
        "robot.toml:12: joint[0].mass_kg: -2 is not a mass: expected a number of kg, zero or more"
    );
    assert!(refused("mass_kg = 2\n", "").starts_with("robot.toml:12: joint[0].center_of_mass_m: "));
    assert!(refused("center_of_mass_m = [0.1, 0, -0.5]\n", "").starts_with("robot.toml:12: joint[0].mass_kg: "));
}

/// About the centre of mass as in a URDF, and about the link's origin in the chain.
#[test]
fn inertia_tensors_are_those_of_a_urdf() {
    let written = "inertia_kg_m2 = { xx = 0.02, yy = 0.03, zz = 0.01, xy = 0.001, yz = -0.002 }";
    let stated = ROBOT.replace("mass_kg = 2\n", &format!("mass_kg = 2\n{written}\n"));
    let (_folder, path) = folder_with("robot.toml", &stated);
    let chain = read_robot(&path).unwrap().chain;
    let urdf = r#"<robot name="crane"><link name="base"/>
        <joint name="slew" type="revolute"><parent link="base"/><child link="tower"/><axis xyz="0 0 1"/>
            <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
        <link name="tower"><inertial><origin xyz="0.1 0 -0.5"/><mass value="2"/>
            <inertia ixx="0.02" ixy="0.001" ixz="0" iyy="0.03" iyz="-0.002" izz="0.01"/></inertial></link></robot>"#;
    let same = Chain::from_urdf(urdf, "base", &["tower"]).unwrap().inertial_parameters().unwrap();
    let read = chain.inertial_parameters().unwrap();
    assert!(read.iter().zip(&same).all(|(a, b)| (a - b).abs() < 1e-15), "{read:?} is not {same:?}");
    assert_eq!(read[10..], [0.0; 10]);

    let with = |written: &str| refused("mass_kg = 2\n", &format!("mass_kg = 2\n{written}\n"));
    assert_eq!(
        with("inertia_kg_m2 = { xx = 0.02, yy = -0.03, zz = 0.01 }"),
        "robot.toml:13: joint[0].inertia_kg_m2: nothing has a negative inertia about an axis: xx, yy and zz are zero or more"
    );
    assert!(with("inertia_kg_m2 = { xx = nan, yy = 1, zz = 1 }").contains("xx: expected a finite number, found nan"));
    assert!(with("inertia_kg_m2 = { xx = 1, yy = 1 }").contains("zz"));
    let massless = refused("mass_kg = 2\ncenter_of_mass_m = [0.1, 0, -0.5]", written);
    assert!(massless.contains("an inertia without a mass: add mass_kg and center_of_mass_m"), "{massless}");
}

#[test]
fn sensors_have_units_that_fit() {
    assert_eq!(
        refused("value = 6.69, unit = \"count/(N·m)\"", "value = 6.69"),
        "robot.toml:14: joint[0].torque_sensor.gain.unit: the unit is missing: expected one of N·m/(N·m), \
         mN·m/(N·m), N/(N·m), A/(N·m), mA/(N·m), %/(N·m), count/(N·m), V/(N·m), as the joint is revolute"
    );
    assert!(
        refused("V/N", "V/(N·m)")
            .starts_with("robot.toml:23: joint[1].torque_sensor.gain.unit: the unit `V/(N·m)` does not fit")
    );
    assert_eq!(
        refused("unit = \"count\"", "unit = \"V\""),
        "robot.toml:14: joint[0].torque_sensor.bias.unit: the bias is in V, but the gain is of readings in count: make \
         them agree"
    );
    assert!(
        refused("deg/count", "m/count")
            .starts_with("robot.toml:15: joint[0].position_sensor.gain.unit: the unit `m/count`")
    );
    assert!(refused("value = 3, unit = \"mm\"", "value = 3").starts_with(
        "robot.toml:24: joint[1].position_sensor.offset.unit: the unit is missing: expected one of m, mm"
    ));
}

#[test]
fn gains_are_positive() {
    for (old, new) in [("6.69", "-6.69"), ("6.69", "0")] {
        assert_eq!(
            refused(old, new),
            format!(
                "robot.toml:14: joint[0].torque_sensor.gain.value: {new} is not a gain: expected a positive number; \
                 that a sensor is reversed is said in the session, by torque_sign or position_sign"
            )
        );
    }
    assert!(refused("value = 0.5", "value = -0.5").starts_with("robot.toml:15: joint[0].position_sensor.gain.value: "));
}

#[test]
fn a_urdf_is_named_after_its_file() {
    let (_folder, path) = folder_with("arm.urdf", &LOOP.replacen("parent link=\"b\"", "parent link=\"a\"", 1));
    // Without the loop: a → c → b.
    let robot = read_urdf(&path, "a", &["b"]).unwrap();
    assert_eq!((robot.name.as_str(), robot.chain.joint_count()), ("arm", 2));
    assert_eq!(robot.sensors, [NominalSensors::default(), NominalSensors::default()]);
}

#[test]
fn what_is_no_chain_is_reported_with_its_file() {
    let refused = |text: &str, tip: &str| {
        let (folder, path) = folder_with("arm.urdf", text);
        without_folder(&folder, &read_urdf(&path, "b", &[tip]).unwrap_err())
    };
    let no_xml = refused("name = \"arm\"\n", "c");
    assert!(no_xml.starts_with("arm.urdf: not a readable URDF: "), "{no_xml}");
    let closed = refused(LOOP, "c");
    assert!(closed.starts_with("arm.urdf: ") && closed.contains("loop"), "{closed}");
    let no_tip = refused(&LOOP.replacen("parent link=\"b\"", "parent link=\"a\"", 1), "tool");
    assert!(no_tip.starts_with("arm.urdf: tip link `tool` is not in the URDF"), "{no_tip}");
}

/// Reads the robot that the document `robot = …` names.
fn resolved(folder: &TempDir, written: &str) -> Result<Robot, String> {
    #[derive(serde::Deserialize)]
    struct Named {
        robot: RobotSource,
    }
    let path = folder.path().join("session.toml");
    fs::write(&path, format!("\nrobot = {written}\n")).unwrap();
    let read = || {
        let document = Document::read(&path)?;
        let named: Named = document.parse()?;
        let (robot, _) = resolve_robot(&document, &Field::new("robot"), &named.robot)?;
        Ok(robot)
    };
    read().map_err(|error| without_folder(folder, &error))
}

#[test]
fn a_robot_is_named_by_path_or_by_urdf_with_both_ends() {
    let (folder, _) = folder_with("crane.toml", ROBOT);
    fs::write(folder.path().join("arm.urdf"), LOOP.replacen("parent link=\"b\"", "parent link=\"a\"", 1)).unwrap();
    assert_eq!(resolved(&folder, "'crane.toml'").unwrap().name, "crane");
    assert_eq!(resolved(&folder, "{ urdf = 'arm.urdf', base = 'a', tip = 'c' }").unwrap().name, "arm");
    assert_eq!(resolved(&folder, "{ urdf = 'arm.urdf', base = 'a', tip = ['c'] }").unwrap().name, "arm");
    let two = resolved(&folder, "{ urdf = 'arm.urdf', base = 'a', tip = ['c', 'b'] }").unwrap_err();
    assert!(two.starts_with("arm.urdf: tip `c` is on the way to tip `b`"), "{two}");
    let none = resolved(&folder, "{ urdf = 'arm.urdf', base = 'a', tip = [] }").unwrap_err();
    assert!(none.starts_with("arm.urdf: no tip is named"), "{none}");
}

#[test]
fn who_named_a_robot_is_reported_with_what_is_wrong_with_it() {
    let (folder, _) = folder_with("crane.toml", &ROBOT.replace("mass_kg = 2", "mass_kg = -2"));
    fs::write(folder.path().join("arm.urdf"), LOOP).unwrap();
    let refused = |written: &str| resolved(&folder, written).unwrap_err();
    let negative = refused("'crane.toml'");
    assert!(negative.starts_with("crane.toml:12: joint[0].mass_kg: -2 is not a mass"), "{negative}");
    assert!(negative.ends_with("\n  named by robot in session.toml:2"), "{negative}");
    assert_eq!(refused("'boat.toml'"), "boat.toml: there is no such file\n  named by robot in session.toml:2");
    let closed = refused("{ urdf = 'arm.urdf', base = 'b', tip = 'c' }");
    assert!(closed.ends_with("\n  named by robot.urdf in session.toml:2"), "{closed}");
}

#[test]
fn a_bare_urdf_is_answered_with_the_form_to_use() {
    let (folder, _) = folder_with("arm.urdf", LOOP);
    assert_eq!(
        resolved(&folder, "'arm.urdf'").unwrap_err(),
        "session.toml:2: robot: of a URDF one must also know where the chain begins and ends: write robot = { urdf = \
         \"arm.urdf\", base = \"<base link>\", tip = \"<last link>\" }"
    );
    let no_tip = resolved(&folder, "{ urdf = 'arm.urdf', base = 'a' }").unwrap_err();
    assert!(no_tip.starts_with("session.toml:2: robot: missing field `tip`"), "{no_tip}");
    let number = resolved(&folder, "3").unwrap_err();
    assert!(
        number.starts_with("session.toml:2: robot: invalid type: integer `3`, expected the path of a robot.toml, or {"),
        "{number}"
    );
}
