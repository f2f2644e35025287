//! Sessions from files: what is read, and what is refused in which words.

use std::f64::consts::PI;
use std::fs;

use gravcal_estimation::{Loss, LossName};
use gravcal_recording::{Conditions, InputRole, Memory, Numbers, PositionUnit, Reading, TorqueUnit};
use gravcal_robot_model::Registry;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{
    Ask, Constraints, GravityPrior, InertiaPrior, InputFile, JointPriors, Load, LoadDistance, ParameterPrior, Pose,
    PoseBlocks, PoseTable, PriorKind, Session, UncertaintyChoice,
};
use tempfile::TempDir;

use crate::document::Document;
use crate::{read_session, read_session_in_memory, read_solver_options, solver_name_error};

const SESSION: &str = r#"
robot = "robot.toml"
estimators = ["joint"]
solver = "levenberg-marquardt"
[gravity]
magnitude_m_per_s2 = 9.81
hemisphere = [0, 3, -4]
[readings]
position = { columns = ["q1", "q2"], unit = "deg" }
torque = { columns = ["y1", "y2"], unit = "count", std = 0.8 }
sweep_column = "sweep"
[[joint]]
name = "elbow"
torque_sign = "reversed"
torque_gain = { nominal = 5.5, unit = "count/(N·m)" }
[[load]]
name = "plate-a"
mass_kg = 1.724
link = "forearm"
[[load]]
name = "plate-b"
mass_kg = 1.7
link = "forearm"
position_m = [0, 0, 0.1]
position_std_m = 0.001
[[load_distance]]
between = ["plate-a", "plate-b"]
distance_m = 0.402
[[poses]]
file = "a.csv"
[[poses]]
file = "b.csv"
load = "plate-b"
swept = "elbow"
step = 2
[ask]
add = ["elbow.position_offset"]
drop = ["shoulder.torque_bias", "gravity"]
"#;

const ROBOT: &str = r#"
name = "two-joints"
convention = "standard-dh"
[[joint]]
name = "shoulder"
a_m = 0.0
alpha_deg = 90
d_m = 0.0
link = "upper-arm"
mass_kg = 2
center_of_mass_m = [0, 0, 0.1]
torque_sensor = { gain = { value = 6.69, unit = "count/(N·m)" }, bias = { value = 2048, unit = "count" } }
[[joint]]
name = "elbow"
a_m = 0.0
alpha_deg = 90
d_m = 0.0
link = "forearm"
position_sensor = { gain = { value = 0.5, unit = "deg/deg" }, offset = { value = 90, unit = "deg" } }
"#;

const A: &str = "q1,q2,y1,y2,sweep\n0,0,2000,2100,s\n90,180,2001,,s\n";
const B: &str = "q1,q2,y1,y2,sweep\n0,1,5,6,\n0,2,7,8,\n";

const FILES: [(&str, &str); 4] = [("session.toml", SESSION), ("robot.toml", ROBOT), ("a.csv", A), ("b.csv", B)];

/// Reads the session above with some texts of its files changed: (file, old, new).
pub(super) fn read(changes: &[(&str, &str, &str)]) -> Result<Session, String> {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in FILES {
        let changed = changes.iter().filter(|(file, ..)| *file == name).fold(text.to_owned(), |text, (_, old, new)| {
            assert_eq!(text.matches(old).count(), 1, "`{old}` must stand once in {name}");
            text.replace(old, new)
        });
        fs::write(folder.path().join(name), changed).unwrap();
    }
    read_session(&folder.path().join("session.toml")).map_err(|error| without_folder(&folder, error))
}

fn without_folder(folder: &TempDir, error: impl ToString) -> String {
    error.to_string().replace(&format!("{}/", folder.path().display()), "")
}

/// The session above with one thing changed.
pub(super) fn changed(old: &str, new: &str) -> Session {
    read(&[("session.toml", old, new)]).unwrap()
}

/// What is said of the session above with one thing changed.
fn refused(old: &str, new: &str) -> String {
    read(&[("session.toml", old, new)]).unwrap_err()
}

/// Sees to it that an error begins as expected, with file, line and field.
#[track_caller]
pub(super) fn assert_refused(old: &str, new: &str, expected: &str) {
    let message = refused(old, new);
    assert!(message.starts_with(&format!("session.toml:{expected}")), "{message}");
}

fn parameter_prior(nominal: f64, kind: PriorKind) -> ParameterPrior {
    ParameterPrior { nominal, kind }
}

fn start(nominal: f64) -> ParameterPrior {
    parameter_prior(nominal, PriorKind::Flat)
}

/// A table of numbers as it stands in a file, without its last column, a label.
fn numbers(text: &str) -> Numbers {
    let mut lines = text.lines().map(|line| line.rsplit_once(',').unwrap().0.split(',').collect::<Vec<_>>());
    let columns = lines.next().unwrap().into_iter().map(str::to_owned).collect();
    Numbers::new(columns, lines.flatten().map(|cell| cell.parse().unwrap_or(f64::NAN)).collect()).unwrap()
}

#[test]
fn recordings_in_memory_are_as_good_as_files() {
    let label = ("session.toml", "sweep_column = \"sweep\"\n", "");
    let read = read(&[label]).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("robot.toml"), ROBOT).unwrap();
    let document = Document::of(&path("memory"), SESSION.replace(label.1, label.2)).unwrap();
    let in_memory = |memory: &Memory| read_session_in_memory(&document, &Registry::standard(), memory, &|_, _| {});
    let memory = Memory::default().with(path("a.csv"), numbers(A)).with(path("b.csv"), numbers(B));
    let session = in_memory(&memory).unwrap();
    // Rows in memory have no header.
    let rows: Vec<Pose> = session.poses.into_iter().map(|pose| Pose { line: pose.line + 1, ..pose }).collect();
    assert_eq!(rows, read.poses);
    assert_eq!(session.inputs, [InputFile::new(InputRole::Robot, path("robot.toml"))]);

    let error = in_memory(&Memory::default().with(path("a.csv"), numbers(A))).unwrap_err().to_string();
    assert!(error.contains("b.csv: there is no such file"), "{error}");
    let error = in_memory(&memory.with(path("a.csv"), numbers("q1,y1,y2,\n0,1,2,\n"))).unwrap_err().to_string();
    assert!(error.contains("there is no column `q2`"), "{error}");
}

#[test]
fn gravity_loads_and_tables_are_read() {
    let session = read(&[]).unwrap();
    assert_eq!(session.robot.name, "two-joints");
    let gravity = GravityPrior { magnitude: 9.81, magnitude_std: None, hemisphere: Some([0.0, 0.6, -0.8]) };
    assert_eq!(session.gravity, gravity);
    assert_eq!(session.inertia, InertiaPrior::Unknown);
    let plate_a = Load { name: "plate-a".into(), mass: 1.724, link: 1, position: None, position_std: None };
    let plate_b =
        Load { name: "plate-b".into(), mass: 1.7, link: 1, position: Some([0.0, 0.0, 0.1]), position_std: Some(0.001) };
    assert_eq!(session.loads, [plate_a, plate_b]);
    assert_eq!(session.load_distances, [LoadDistance { between: [0, 1], distance: 0.402, std: None }]);
    assert_eq!(session.estimators, ["joint"]);
    let solver = session.solver.unwrap();
    assert_eq!((solver.name(), solver.options().len()), ("levenberg-marquardt", 0));
    let drop = vec!["shoulder.torque_bias".to_owned(), "gravity".to_owned()];
    assert_eq!(session.ask, Ask { add: vec!["elbow.position_offset".to_owned()], drop });

    let folder = session.inputs[0].path.parent().unwrap().to_owned();
    let table = |name: &str, load, swept, step| PoseTable { path: folder.join(name), load, swept, step };
    assert_eq!(session.tables, [table("a.csv", None, None, None), table("b.csv", Some(1), Some(1), Some(2))]);
    let inputs = [
        (InputRole::Session, "session.toml"),
        (InputRole::Robot, "robot.toml"),
        (InputRole::Recording, "a.csv"),
        (InputRole::Recording, "b.csv"),
    ];
    let inputs = inputs.map(|(role, name)| InputFile::new(role, folder.join(name)));
    assert_eq!(session.inputs, inputs);
}

#[test]
fn poses_of_all_tables_are_read_in_si() {
    let session = read(&[]).unwrap();
    let reading = |value: f64| Some(Reading { value, std: Some(0.8) });
    let pose = |table, line, position: [f64; 2], torque: [Option<Reading>; 2]| Pose {
        table,
        line,
        sweep_label: (table == 0).then(|| "s".to_owned()),
        load: (table == 1).then_some(1),
        position: position.map(|angle| angle * (PI / 180.0)).into(),
        orientation: None,
        torque: torque.into(),
        instruments: Vec::new(),
        conditions: Conditions::default(),
        course: None,
    };
    let expected = [
        pose(0, 2, [0.0, 0.0], [reading(2000.0), reading(2100.0)]),
        pose(0, 3, [90.0, 180.0], [reading(2001.0), None]),
        pose(1, 2, [0.0, 1.0], [reading(5.0), reading(6.0)]),
        pose(1, 3, [0.0, 2.0], [reading(7.0), reading(8.0)]),
    ];
    assert_eq!(session.poses, expected);
}

#[test]
fn nominals_come_from_the_session_then_the_robot_then_the_default() {
    let session = read(&[]).unwrap();
    let joint = |torque_sign_declared, parameters| JointPriors {
        torque_unit: Some(TorqueUnit::Count),
        torque_sign_declared,
        position_unit: PositionUnit::Degree,
        parameters,
    };
    // The shoulder's torque sensor is the robot's, its position sensor the default.
    assert_eq!(session.joints[0], joint(false, [start(6.69), start(2048.0), start(1.0), start(0.0)]));
    // The elbow's torque gain is the session's, reversed, its bias the default, its position sensor the robot's.
    assert_eq!(session.joints[1], joint(true, [start(-5.5), start(0.0), start(0.5), start(PI / 2.0)]));
}

#[test]
fn knowledge_is_a_start_a_prior_or_exact() {
    let elbow = |parameter: &str, quantity: SensorParameter| {
        let line = "torque_gain = { nominal = 5.5, unit = \"count/(N·m)\" }";
        changed(line, &format!("{line}\n{parameter}")).joints[1].of(quantity)
    };
    let prior = |std: f64| PriorKind::Gaussian { std };
    let offset = elbow("position_offset = { nominal = -180, std = 2, unit = 'deg' }", SensorParameter::PositionOffset);
    assert_eq!(offset, parameter_prior(-PI, prior(2.0 * (PI / 180.0))));
    let bias = elbow("torque_bias = { fixed = -7, unit = 'count' }", SensorParameter::TorqueBias);
    assert_eq!(bias, parameter_prior(-7.0, PriorKind::Fixed));
    let gain = elbow("position_gain = { nominal = 1.1, std = 0.1, unit = 'rad/rad' }", SensorParameter::PositionGain);
    assert_eq!(gain, parameter_prior(1.1, prior(0.1)));
    let reversed = "position_sign = 'reversed'\nposition_gain = { fixed = 2, unit = 'deg/deg' }";
    assert_eq!(elbow(reversed, SensorParameter::PositionGain), parameter_prior(-2.0, PriorKind::Fixed));
    assert_eq!(elbow("position_sign = 'reversed'", SensorParameter::PositionGain), start(-0.5));
}

#[test]
fn gains_of_counts_are_converted() {
    let position_gain = "position_gain = { nominal = 90, std = 9, unit = \"deg/count\" }";
    let session = read(&[
        ("session.toml", "unit = \"deg\"", "unit = [\"deg\", \"count\"]"),
        ("session.toml", "torque_sign = \"reversed\"", position_gain),
    ])
    .unwrap();
    let gain = session.joints[1].of(SensorParameter::PositionGain);
    assert_eq!(gain, parameter_prior(PI / 2.0, PriorKind::Gaussian { std: 9.0 * (PI / 180.0) }));
    assert_eq!(session.joints[1].position_unit, PositionUnit::Count);
    assert_eq!(session.poses[1].position, [PI / 2.0, 180.0]);
}

#[test]
fn a_joint_without_a_torque_sensor_has_no_torque_unit() {
    let session = changed("[\"y1\", \"y2\"], unit = \"count\"", "[\"\", \"y2\"], unit = [\"\", \"count\"]");
    assert_eq!(session.joints[0].torque_unit, None);
    assert!(session.poses.iter().all(|pose| pose.torque[0].is_none()));
    assert_eq!(session.poses[0].torque[1], Some(Reading { value: 2100.0, std: Some(0.8) }));
}

#[test]
fn readings_of_torque_need_no_nominal_gain() {
    let session = read(&[
        ("session.toml", "unit = \"count\"", "unit = [\"count\", \"Nm\"]"),
        ("session.toml", "torque_gain = { nominal = 5.5, unit = \"count/(N·m)\" }\n", ""),
    ])
    .unwrap();
    assert_eq!(session.joints[1].of(SensorParameter::TorqueGain), start(-1.0));
}

#[test]
fn noise_is_for_all_joints_or_for_each() {
    let session = changed("std = 0.8", "std = [0.8, 4], count = 16");
    assert_eq!(session.poses[0].torque[0], Some(Reading { value: 2000.0, std: Some(0.2) }));
    assert_eq!(session.poses[0].torque[1], Some(Reading { value: 2100.0, std: Some(1.0) }));
    let columns = "std_columns = [\"q2\", \"\"], count_columns = [\"q1\", \"\"], usable_columns = [\"\", \"q1\"]";
    let tables = [("a.csv", "0,0,", "1,4,"), ("a.csv", "90,180,", "0.5,8,"), ("b.csv", "0,1,", "1,1,")];
    let changes: Vec<_> = std::iter::once(("session.toml", "std = 0.8", columns)).chain(tables).collect();
    let message = read(&changes).unwrap_err();
    assert!(message.starts_with("a.csv:3: column `q1`: "), "{message}");
}

#[test]
fn gravity_follows_from_latitude_and_altitude() {
    let session =
        changed("magnitude_m_per_s2 = 9.81", "latitude_deg = 48.4\naltitude_m = 480\nmagnitude_std_m_per_s2 = 1e-3");
    assert!((session.gravity.magnitude - 9.8078).abs() < 1e-4, "{}", session.gravity.magnitude);
    assert_eq!(session.gravity.magnitude_std, Some(1e-3));
}

#[test]
fn masses_of_the_model_may_be_known() {
    let model = "[inertia]\nlinks = \"model\"\nrelative_std = 0.1\n[readings]";
    let massless = refused("[readings]", model);
    assert_eq!(
        massless,
        "session.toml:9: inertia.links: the model needs the mass of every link, but robot.toml has none for forearm: \
         add them there, name only other links in relative_std, or write links = \"unknown\""
    );
    let masses = "link = \"forearm\"\nmass_kg = 1\ncenter_of_mass_m = [0, 0, 0]";
    let known = [("session.toml", "[readings]", model), ("robot.toml", "link = \"forearm\"", masses)];
    assert_eq!(read(&known).unwrap().inertia, InertiaPrior::Model { relative_std: vec![Some(0.1); 2] });
    let one = model.replace("0.1", "{ upper-arm = 0.2 }");
    assert_eq!(changed("[readings]", &one).inertia, InertiaPrior::Model { relative_std: vec![Some(0.2), None] });
    let unknown = refused("[readings]", &model.replace("0.1", "{ hand = 0.2 }"));
    assert!(unknown.starts_with("session.toml:10: inertia.relative_std.hand: there is no link `hand`"), "{unknown}");
}

#[test]
fn lengths_and_axes_may_be_known_to_within_a_standard_deviation() {
    let said = |said: &str| format!("[inertia]\n{said}\n[readings]");
    assert_eq!(changed("[readings]", &said("length_std_m = 5e-4")).length_std, Some(5e-4));
    assert_eq!(
        refused("[readings]", &said("length_std_m = -1")),
        "session.toml:9: inertia.length_std_m: -1 is not a standard deviation: expected a positive number of m"
    );
    assert_eq!(
        refused("[readings]", &said("length_std_m = 5e-4\ndescription = \"sweep\"")),
        "session.toml:9: inertia.length_std_m: moments of sweeps ask for no lengths: leave it out"
    );
    let axis_std = changed("[readings]", &said("axis_std_deg = 0.05")).axis_std.unwrap();
    assert!((axis_std.to_degrees() - 0.05).abs() < 1e-12, "{axis_std}");
    assert_eq!(
        refused("[readings]", &said("axis_std_deg = 0.05\ndescription = \"sweep\"")),
        "session.toml:9: inertia.axis_std_deg: moments of sweeps take axes as exact: leave it out, or write description = \"link\""
    );
}

#[test]
fn files_that_are_not_there() {
    let folder = tempfile::tempdir().unwrap();
    let message = |path: &str| without_folder(&folder, read_session(&folder.path().join(path)).unwrap_err());
    assert_eq!(message("session.toml"), "session.toml: there is no such file");
    fs::create_dir(folder.path().join("session.toml")).unwrap();
    assert_eq!(message("session.toml"), "session.toml: this is a folder: name a file in it");
    assert_eq!(
        refused("\"robot.toml\"", "\"robots.toml\""),
        "robots.toml: there is no such file\n  named by robot in session.toml:2"
    );
    assert_eq!(
        refused("\"a.csv\"", "\"c.csv\""),
        "c.csv: there is no such file\n  named by poses[0].file in session.toml:30"
    );
    let table_is_folder = refused("\"a.csv\"", "\".\"");
    assert!(table_is_folder.contains("the folder has no .mcap file"), "{table_is_folder}");
}

#[test]
fn a_data_folder_that_is_absent_is_reported_with_its_variable() {
    let message = refused("\"a.csv\"", "\"${GRAVCAL_NO_SUCH_VARIABLE:-data}/a.csv\"");
    assert!(message.starts_with("data/a.csv: there is no such folder as "), "{message}");
    assert!(
        message.ends_with(
            "\n  named by poses[0].file in session.toml:30\n  the environment variable GRAVCAL_NO_SUCH_VARIABLE is not \
             set, so its default `data` is used; set it if the files lie elsewhere"
        ),
        "{message}"
    );
    assert_refused(
        "\"a.csv\"",
        "\"${GRAVCAL_NO_SUCH_VARIABLE}/a.csv\"",
        "30: poses[0].file: the environment variable GRAVCAL_NO_SUCH_VARIABLE is not set: set it",
    );
}

#[test]
fn a_solver_is_a_name_or_a_table_of_options() {
    let table = "solver = { name = \"dogleg\", max_iterations = 7 }";
    let solver = changed("solver = \"levenberg-marquardt\"", table).solver.unwrap();
    assert_eq!((solver.name(), solver.options().len()), ("dogleg", 1));
    let options: std::collections::BTreeMap<String, i64> =
        read_solver_options(&solver, std::marker::PhantomData).unwrap();
    assert_eq!(options["max_iterations"], 7);
    let read: Result<std::collections::BTreeMap<String, bool>, _> =
        read_solver_options(&solver, std::marker::PhantomData);
    let error = read.unwrap_err();
    assert_eq!((error.line(), error.field()), (Some(4), Some("solver.max_iterations")));
    assert!(solver_name_error(&solver, "is unknown").to_string().ends_with("session.toml:4: solver.name: is unknown"));

    assert_refused(
        "\"levenberg-marquardt\"",
        "3",
        "4: solver: invalid type: integer `3`, expected the name of a solver",
    );
    assert_refused("\"levenberg-marquardt\"", "{ name = 3 }", "4: solver: its name is 3, not a text");
    assert_refused("\"levenberg-marquardt\"", "{ }", "4: solver: missing field `name`");
}

#[test]
fn keys_are_known_and_values_of_their_type() {
    assert_refused("mass_kg = 1.724", "mas_kg = 1.724", "18: load[0].mas_kg: unknown field `mas_kg`, expected one of");
    assert_refused("solver =", "solvers =", "4: solvers: unknown field `solvers`, expected one of");
    assert!(refused("solver =", "solvers =").contains("(did you mean `solver`?)"));
    assert_refused(
        "= 1.724",
        "= \"heavy\"",
        "18: load[0].mass_kg: invalid type: string \"heavy\", expected a mass in kg",
    );
    assert_refused("= 1.724", "= nan", "18: load[0].mass_kg: expected a finite number, found nan");
    assert_refused("9.81", "inf", "6: gravity.magnitude_m_per_s2: expected a finite number, found inf");
    assert_refused("\"reversed\"", "\"negative\"", "14: joint[0].torque_sign: unknown variant `negative`");
    assert_refused("step = 2", "step = 2.5", "35: poses[1].step: invalid type: floating point `2.5`");
    assert_refused("std = 0.8", "std = true", "10: readings.torque.std: invalid type: boolean `true`");
    assert_refused("[gravity]", "[gravity", "5: ");
}

#[test]
fn units_are_mandatory() {
    assert_eq!(
        refused(", unit = \"deg\"", ""),
        "session.toml:9: readings.position.unit: the unit is missing: expected a unit of position, one of rad, deg, m, \
         mm, count, V"
    );
    assert_refused(
        ", unit = \"count\"",
        "",
        "10: readings.torque.unit: the unit is missing: expected a unit of torque",
    );
    assert_refused("unit = \"count\"", "unit = \"counts\"", "10: readings.torque.unit: the unit `counts` does not fit");
    assert_refused("unit = \"deg\"", "unit = [\"deg\"]", "9: readings.position.unit: expected 2 entries, one for each");
    assert_refused(
        "unit = \"deg\"",
        "unit = [\"deg\", \"x\"]",
        "9: readings.position.unit[1]: the unit `x` does not fit",
    );
    assert_refused(
        "nominal = 5.5, unit = \"count/(N·m)\"",
        "nominal = 5.5",
        "15: joint[0].torque_gain.unit: the unit is missing: expected one of N·m/(N·m), mN·m/(N·m), N/(N·m)",
    );
}

#[test]
fn a_gain_of_torque_a_reading_is_reported_the_right_way_round() {
    let gain = "nominal = 5.5, unit = \"count/(N·m)\"";
    for (written, reported) in [("12", "12"), ("12.5", "12.5")] {
        let message = refused(gain, &format!("nominal = {written}, unit = \"N·m/count\""));
        assert!(
            message.contains(&format!("; {reported} N·m/count is 0.08")) && message.ends_with("count/(N·m)"),
            "{message}"
        );
    }
}

#[test]
fn units_of_the_files_agree() {
    assert_refused(
        "count/(N·m)",
        "V/(N·m)",
        "15: joint[0].torque_gain.unit: this is for readings in V, but those of the joint are in count: make them agree",
    );
    assert_refused(
        "unit = \"count\"",
        "unit = [\"V\", \"count\"]",
        "10: readings.torque.unit: torque readings of joint `shoulder` are in V here, but in count in robot.toml: make \
         the two files agree, or give torque_gain and torque_bias under [[joint]]",
    );
    assert_refused(
        "unit = \"deg\"",
        "unit = [\"deg\", \"V\"]",
        "9: readings.position.unit: position readings of joint `elbow` are in V here, but in deg in robot.toml: make the \
         two files agree, or give position_gain under [[joint]]",
    );
    // Angles are the same in SI, whichever unit the two files are written in.
    assert_eq!(changed("unit = \"deg\"", "unit = \"rad\"").joints[1].of(SensorParameter::PositionGain), start(0.5));
}

#[test]
fn a_sensors_own_numbers_need_a_nominal_gain() {
    assert_eq!(
        refused("torque_gain = { nominal = 5.5, unit = \"count/(N·m)\" }\n", ""),
        "session.toml:10: readings.torque.unit: torque readings of joint `elbow` are in count, and nothing says roughly \
         what that is: add torque_gain = { nominal = ..., unit = \"count/(N·m)\" } to its [[joint]] (name = \"elbow\"), or to \
         [joints] for all of them, or a torque_sensor in robot.toml"
    );
    let message = refused("unit = \"deg\"", "unit = [\"count\", \"deg\"]");
    assert!(
        message
            .starts_with("session.toml:9: readings.position.unit: position readings of joint `shoulder` are in count")
    );
    assert!(message.contains("position_gain = { nominal = ..., unit = \"rad/count\" }"), "{message}");
}

#[test]
fn gains_are_positive_and_signs_are_declared() {
    assert_eq!(
        refused("nominal = 5.5", "nominal = -5.5"),
        "session.toml:15: joint[0].torque_gain.nominal: -5.5 is not a gain: expected a positive number; a sensor that is \
         mounted the other way round is declared by torque_sign, position_sign or (of an instrument) sign = \"reversed\""
    );
    assert_refused("nominal = 5.5", "fixed = 0", "15: joint[0].torque_gain.fixed: 0 is not a gain");
}

#[test]
fn knowledge_does_not_contradict_itself() {
    let forms = "15: joint[0].torque_gain: expected { nominal, unit } (a start), { nominal, std, unit }";
    assert_refused("nominal = 5.5", "nominal = 5.5, fixed = 5", forms);
    assert_refused("nominal = 5.5", "fixed = 5, std = 1", forms);
    assert_refused("nominal = 5.5, ", "", forms);
    assert_refused(
        "nominal = 5.5",
        "nominal = 5.5, std = 0",
        "15: joint[0].torque_gain.std: 0 is not a standard deviation: expected a positive number of count/(N·m)",
    );
    assert_refused(
        "[\"y1\", \"y2\"]",
        "[\"y1\", \"\"]",
        "15: joint[0].torque_gain: joint `elbow` has no column in readings.torque: name one, or delete this",
    );
}

#[test]
fn joints_are_known_and_declared_once() {
    assert_refused(
        "name = \"elbow\"",
        "name = \"elbwo\"",
        "13: joint[0].name: there is no joint `elbwo`; known: `shoulder`, `elbow`",
    );
    assert_refused(
        "[[joint]]\n",
        "[[joint]]\nname = \"elbow\"\n[[joint]]\n",
        "15: joint[1].name: `elbow` is already joint[0].name: give each its own name",
    );
}

/// Key by key: what a joint's own table says stands.
#[test]
fn what_is_said_of_all_joints_is_of_those_that_say_nothing_else() {
    let all = "[joints]\ntorque_gain = { nominal = 7, std = 0.7, unit = \"count/(N·m)\" }\n\
               torque_bias = { nominal = 2000, unit = \"count\" }\ntorque_sign = \"normal\"\n\
               sensor_models = [{ kind = \"torque-gain-polynomial\", degree = 2 }]\n[[joint]]\n";
    let session = changed("[[joint]]\n", all);
    let [shoulder, elbow] = [0, 1].map(|joint| &session.joints[joint]);
    let gains = [shoulder, elbow].map(|joint| joint.of(SensorParameter::TorqueGain));
    assert_eq!(gains, [parameter_prior(7.0, PriorKind::Gaussian { std: 0.7 }), start(-5.5)]);
    assert_eq!(elbow.of(SensorParameter::TorqueBias), start(2000.0));
    assert!(shoulder.torque_sign_declared);
    let terms: Vec<String> = session.further.iter().map(|parameter| parameter.name()).collect();
    assert_eq!(terms, ["elbow.torque_gain_2", "shoulder.torque_gain_2"]);
    let own = changed("[[joint]]\n", &format!("{all}sensor_models = []\n"));
    assert_eq!(own.further.len(), 1, "an empty list is the joint's own");
}

#[test]
fn what_is_said_of_all_joints_is_reported_where_it_fits_one_of_them_not() {
    let all = |said: &str| format!("[joints]\n{said}\n[[joint]]\n");
    let refused = |said: &str, expected: &str| assert_refused("[[joint]]\n", &all(said), expected);
    refused("name = \"elbow\"", "13: joints.name: [joints] is said of all joints: delete the name, or write [[joint]]");
    refused("mass_kg = 2", "13: joints.mass_kg: unknown field");
    refused(
        "torque_gain = { nominal = 7, unit = \"V/(N·m)\" }",
        "13: joints.torque_gain.unit: joint `shoulder`: this is for readings in V, but those of the joint are in count: make them \
         agree; or say torque_gain in a [[joint]] of its own",
    );
    refused(
        "position_offset = { nominal = 0, std = 1, unit = \"deg\" }",
        "13: joints.position_offset.std: the first joint's offset defines the base frame, so it cannot be uncertain: add [[joint]] \
         name = \"shoulder\", position_offset = { nominal = 0, unit = \"rad\" }",
    );
    assert_refused("name = \"elbow\"\n", "", "12: joint[0]: missing field `name`");
}

/// A joint without a torque sensor has nothing of what is said of all torque sensors.
#[test]
fn what_is_said_of_all_torque_sensors_is_of_those_there_are() {
    let own = "name = \"elbow\"\ntorque_sign = \"reversed\"\ntorque_gain = { nominal = 5.5, unit = \"count/(N·m)\" }";
    let all = "[joints]\ntorque_sign = \"normal\"\ntorque_gain = { nominal = 7, unit = \"count/(N·m)\" }\n\
               sensor_models = [{ kind = \"torque-gain-polynomial\" }, { kind = \"position-harmonics\", orders = [1] }]\n[[joint]]\n";
    let changes = [
        ("session.toml", own, "name = \"elbow\""),
        ("session.toml", "[[joint]]\n", all),
        ("session.toml", "[\"y1\", \"y2\"]", "[\"y1\", \"\"]"),
    ];
    let session = read(&changes).unwrap();
    assert_eq!(session.joints[1].torque_unit, None);
    let of_elbow = session.further.iter().filter(|parameter| parameter.name().starts_with("elbow")).count();
    assert_eq!((session.further.len(), of_elbow), (6, 2));
}

#[test]
fn a_part_of_a_table_needs_a_clock() {
    let part = "file = \"a.csv\"\nuntil_s = 2000.5";
    assert_refused(
        "file = \"a.csv\"",
        part,
        "31: poses[0].until_s: a part is told by the recording's clock, and no column",
    );
    let changes = [
        ("session.toml", "sweep_column = \"sweep\"", "time = { column = \"y1\", unit = \"s\" }"),
        ("session.toml", "file = \"b.csv\"", "file = \"b.csv\"\nfrom_s = 0"),
        ("session.toml", "file = \"a.csv\"", "file = \"a.csv\"\nuntil_s = 1"),
    ];
    let reported = read(&changes).unwrap_err();
    assert!(reported.starts_with("a.csv: 1 of its 2 rows are between from_s and until_s"), "{reported}");
    let wider = [changes[0], changes[1], ("session.toml", "file = \"a.csv\"", "file = \"a.csv\"\nuntil_s = 1.5")];
    assert_eq!(read(&wider).unwrap().poses.len(), 4);
}

#[test]
fn gravity_has_a_magnitude_and_a_direction() {
    let either = "5: gravity: expected either magnitude_m_per_s2, or latitude_deg and altitude_m, and not both";
    assert_refused("magnitude_m_per_s2 = 9.81\n", "", either);
    assert_refused("magnitude_m_per_s2 = 9.81", "latitude_deg = 48", either);
    assert_refused("= 9.81", "= 9.81\nlatitude_deg = 48\naltitude_m = 0", either);
    assert_refused("= 9.81", "= 0", "6: gravity.magnitude_m_per_s2: 0 is not a magnitude of gravity");
    assert_refused(
        "magnitude_m_per_s2 = 9.81",
        "latitude_deg = 484\naltitude_m = 0",
        "6: gravity.latitude_deg: expected a number from -90 to 90, found 484",
    );
    assert_refused("[0, 3, -4]", "[0, 0.0, -0.0]", "7: gravity.hemisphere: a zero vector has no direction");
    assert_refused("= 9.81", "= 9.81\nmagnitude_std_m_per_s2 = 0", "7: gravity.magnitude_std_m_per_s2: 0 is not a ");
    assert_eq!(changed("hemisphere = [0, 3, -4]\n", "").gravity.hemisphere, None);
    let far = changed("[0, 3, -4]", "[0, 3e200, -4e200]").gravity.hemisphere.unwrap();
    assert!((far[1] - 0.6).abs() < 1e-15 && (far[2] + 0.8).abs() < 1e-15);
}

#[test]
fn inertia_is_unknown_or_the_models() {
    let with = |lines: &str| refused("[readings]", &format!("[inertia]\n{lines}\n[readings]"));
    assert!(with("relative_std = 0.1").starts_with("session.toml:9: inertia.relative_std: of unknown links nothing"));
    assert!(
        with("links = \"model\"").starts_with("session.toml:8: inertia.relative_std: how well is the model known?")
    );
}

#[test]
fn columns_fit_the_joints() {
    assert_refused(
        "[\"q1\", \"q2\"]",
        "[\"q1\"]",
        "9: readings.position.columns: expected 2 entries, one for each joint (shoulder, elbow), found 1",
    );
    assert_refused(
        "[\"q1\", \"q2\"]",
        "[\"q1\", \"\"]",
        "9: readings.position.columns[1]: joint `elbow` has no column",
    );
    assert_refused("[\"y1\", \"y2\"]", "[\"y1\", \"y2\", \"y3\"]", "10: readings.torque.columns: expected 2 entries");
    assert_refused("[\"y1\", \"y2\"]", "[\"y1\", \"q1\"]", "8: readings: column `q1` is mapped to two readings");
    assert_refused("std = 0.8", "std = [0.8]", "10: readings.torque.std: expected 2 entries");
    assert_refused("std = 0.8", "std_columns = [\"s\"]", "10: readings.torque.std_columns: expected 2 entries");
    assert_refused("std = 0.8", "std = 0", "10: readings.torque.std: column `y1`: the standard deviation must be");
    assert_refused("std = 0.8", "std = 1, count = 0", "10: readings.torque.count: column `y1`: the number of samples");
    assert_refused("std = 0.8", "count = 9", "10: readings.torque: column `y1`: a number of samples is given but no");
}

#[test]
fn some_joint_has_a_torque_reading() {
    let none = "no joint has a torque reading, and without torque there is nothing to calibrate";
    let line = "torque = { columns = [\"y1\", \"y2\"], unit = \"count\", std = 0.8 }\n";
    assert_refused(line, "", &format!("8: readings.torque: {none}"));
    assert_refused("[\"y1\", \"y2\"]", "[\"\", \"\"]", &format!("10: readings.torque.columns: {none}"));
}

#[test]
fn loads_have_a_mass_and_a_link() {
    assert_refused(
        "mass_kg = 1.724",
        "mass_kg = -1.7",
        "18: load[0].mass_kg: -1.7 is not a mass: expected a positive number of kg",
    );
    assert_refused(
        "name = \"plate-a\"\nmass_kg = 1.724\nlink = \"forearm\"",
        "name = \"plate-a\"\nmass_kg = 1.724\nlink = \"forarm\"",
        "19: load[0].link: there is no link `forarm` (did you mean `forearm`?); known: `upper-arm`, `forearm`",
    );
    assert_refused("name = \"plate-b\"", "name = \"plate-a\"", "21: load[1].name: `plate-a` is already load[0].name");
    assert_refused("position_m = [0, 0, 0.1]\n", "", "24: load[1].position_std_m: a standard deviation of what?");
    assert_refused("= 0.001", "= -0.001", "25: load[1].position_std_m: -0.001 is not a standard deviation");
}

#[test]
fn distances_are_between_two_loads_on_one_link() {
    assert_refused(
        "[\"plate-a\", \"plate-b\"]",
        "[\"plate-a\", \"plate-c\"]",
        "27: load_distance[0].between[1]: there is no load `plate-c`; known: `plate-a`, `plate-b`",
    );
    assert_refused(
        "[\"plate-a\", \"plate-b\"]",
        "[\"plate-a\", \"plate-a\"]",
        "27: load_distance[0].between: a load is",
    );
    assert_refused("= 1.7\nlink = \"forearm\"", "= 1.7\nlink = \"upper-arm\"", "27: load_distance[0].between: the two");
    assert_refused("= 0.402", "= 0", "28: load_distance[0].distance_m: 0 is not a distance: expected a positive");
    assert_refused(
        "= 0.402",
        "= 0.402\ndistance_std_m = 0",
        "29: load_distance[0].distance_std_m: 0 is not a standard",
    );
}

#[test]
fn tables_name_known_things_and_are_read_once() {
    let listed = read(&[("session.toml", "load = \"plate-b\"", "load = [\"plate-b\"]")]).unwrap();
    assert_eq!(listed.tables[1].load, Some(1));
    assert_refused("load = \"plate-b\"", "load = \"plate-c\"", "33: poses[1].load: there is no load `plate-c`; known:");
    assert_refused(
        "load = \"plate-b\"",
        "load = [\"plate-a\", \"plate-b\"]",
        "33: poses[1].load: a pose carries one load: describe bodies on one link as one load",
    );
    assert_refused("swept = \"elbow\"", "swept = \"wrist\"", "34: poses[1].swept: there is no joint `wrist`; known:");
    assert_refused(
        "step = 2",
        "step = 4",
        "35: poses[1].step: the sequential procedure has the steps 1, 2 and 3, not 4",
    );
    assert_refused(
        "\"b.csv\"",
        "\"./a.csv\"",
        "32: poses[1].file: this table is already poses[0]: every reading may enter once only",
    );
    assert_refused(
        "[ask]",
        "[[validation]]\nfile = \"a.csv\"\n[ask]",
        "37: validation[0].file: this table is already poses[0]: every reading may enter once only",
    );
    assert_refused(
        "[ask]",
        "[validation]\nfile = \"a.csv\"\n[ask]",
        "36: validation: one table where a list is expected: double its brackets, [[...]]",
    );
    let tables = SESSION.split_once("[[poses]]").unwrap().1.split_once("[ask]").unwrap().0;
    let message = refused(&format!("[[poses]]{tables}"), "");
    assert!(message.starts_with("session.toml:1: poses: there are no poses: add [[poses]]"), "{message}");
}

#[test]
fn only_a_joint_that_turns_is_swept() {
    let slide = "name = \"elbow\"\nkind = \"prismatic\"";
    let sensor =
        "position_sensor = { gain = { value = 0.5, unit = \"deg/deg\" }, offset = { value = 90, unit = \"deg\" } }\n";
    let message = read(&[
        ("robot.toml", "name = \"elbow\"", slide),
        ("robot.toml", sensor, ""),
        ("session.toml", "unit = \"deg\"", "unit = [\"deg\", \"mm\"]"),
        ("session.toml", "count/(N·m)", "count/N"),
    ])
    .unwrap_err();
    assert!(message.starts_with("session.toml:34: poses[1].swept: joint `elbow` is prismatic"), "{message}");
}

#[test]
fn a_loss_has_a_width_of_its_own_or_the_usual_one() {
    let loss = |table: &str| changed("solver =", &format!("{table}\nsolver =")).loss;
    assert_eq!(read(&[]).unwrap().loss, Loss::None);
    assert_eq!(loss("loss = { kind = 'none' }").name(), LossName::None);
    assert_eq!(loss("loss = { kind = 'huber' }"), Loss::Huber(1.345));
    assert_eq!(loss("loss = { kind = 'geman-mcclure', width = 3 }"), Loss::GemanMcClure(3.0));
    let refused =
        |table: &str, expected: &str| assert_refused("[gravity]", &format!("[loss]\n{table}\n[gravity]"), expected);
    refused("kind = 'welsch'", "6: loss.kind: unknown loss `welsch`; there is: none, huber");
    refused(
        "kind = 'huber'\nwidth = 0",
        "7: loss.width: the width 0 of a loss must be between 0.001 and 1000000 standard",
    );
    refused("kind = 'cauchy'\nwidth = 1e200", "7: loss.width: the width 1000");
    refused("kind = 'tukey'\nwidth = -2", "7: loss.width: the width -2 of a loss");
    refused("kind = 'none'\nwidth = 2", "7: loss.width: without a loss there is no width");
    refused("width = 2", "5: loss: missing field `kind`");
}

#[test]
fn an_uncertainty_has_what_it_needs_and_nothing_else() {
    let rows: String = (0..31).map(|k| format!("{k},0,2000,,s\n")).collect();
    let table = format!("q1,q2,y1,y2,sweep\n{rows}");
    let with = |section: &str| {
        let text = format!("[uncertainty]\n{section}\n[gravity]");
        read(&[("session.toml", "[gravity]", text.as_str()), ("a.csv", A, table.as_str())])
    };
    assert_eq!(read(&[]).unwrap().uncertainty, UncertaintyChoice::Noise);
    let chosen = |section: &str| with(section).unwrap().uncertainty;
    assert_eq!(chosen("kind = 'sandwich'\nblock_poses = 1"), UncertaintyChoice::Sandwich { block_poses: 1 });
    let bootstrap = |replicates, seed| UncertaintyChoice::Bootstrap { block_poses: 1, replicates, seed };
    assert_eq!(chosen("kind = 'bootstrap'\nblock_poses = 1"), bootstrap(500, 1));
    assert_eq!(chosen("kind = 'bootstrap'\nblock_poses = 1\nreplicates = 200\nseed = 7"), bootstrap(200, 7));
    let refused = |section: &str, expected: &str| {
        let message = with(section).unwrap_err();
        assert!(message.starts_with(&format!("session.toml:{expected}")), "{message}");
    };
    refused("kind = 'scatter'", "6: uncertainty.kind: unknown variant `scatter`, expected one of `noise`, `jackknife`");
    let jackknife = |blocks| UncertaintyChoice::Jackknife { blocks };
    assert_eq!(chosen("kind = 'jackknife'"), jackknife(PoseBlocks::Found));
    assert_eq!(chosen("kind = 'jackknife'\nblock_poses = 2"), jackknife(PoseBlocks::Poses(2)));
    assert_eq!(chosen("kind = 'jackknife'\nblocks = 'sweeps'"), jackknife(PoseBlocks::Sweeps));
    let pairs = "[uncertainty]\nkind = 'jackknife'\nblocks = 'pairs'\n[gravity]";
    let rows: String = (0..32).map(|k| format!("{},0,2000,,s\n", k / 2)).collect();
    let table = format!("q1,q2,y1,y2,sweep\n{rows}");
    let paired = read(&[("session.toml", "[gravity]", pairs), ("a.csv", A, table.as_str())]).unwrap();
    assert_eq!(paired.uncertainty, jackknife(PoseBlocks::Pairs));
    let rows: String = (0..32).map(|k| format!("{},0,2000,,s\n", 5 * k)).collect();
    let table = format!("q1,q2,y1,y2,sweep\n{rows}");
    let apart = [
        ("session.toml", "[gravity]", pairs),
        ("a.csv", A, table.as_str()),
        ("b.csv", B, "q1,q2,y1,y2,sweep\n0,1,5,6,\n0,9,7,8,\n"),
    ];
    let message = read(&apart).unwrap_err();
    assert!(message.contains("7: uncertainty.blocks: no two rows that follow each other"), "{message}");
    refused(
        "kind = 'jackknife'\nblock_poses = 3",
        "7: uncertainty.block_poses: 33 samples in blocks of 3 are 11 blocks",
    );
    refused("kind = 'jackknife'\nblock_s = 0", "7: uncertainty.block_s: ");
    refused("kind = 'jackknife'\nblock_s = 1.5", "7: uncertainty.block_s: some poses have no time");
    refused("kind = 'jackknife'\nblock_s = 1.5\nblock_poses = 2", "7: uncertainty.block_s: blocks are of poses");
    refused("kind = 'sandwich'\nblock_poses = 1\nblocks = 'pairs'", "8: uncertainty.blocks: only a jackknife has");
    refused("block_s = 2", "6: uncertainty.block_s: only a jackknife has such blocks");
    refused("kind = 'sandwich'", "5: uncertainty.block_poses: how many neighbouring poses may share an error?");
    refused("kind = 'sandwich'\nblock_poses = 0", "7: uncertainty.block_poses: 33 samples in blocks of 0 are 0 blocks");
    refused(
        "kind = 'sandwich'\nblock_poses = 2",
        "7: uncertainty.block_poses: 33 samples in blocks of 2 are 16 blocks",
    );
    refused("kind = 'sandwich'\nblock_poses = -1", "7: uncertainty.block_poses: invalid value: integer `-1`");
    refused("kind = 'sandwich'\nblock_poses = 1\nseed = 2", "8: uncertainty.seed: only a bootstrap draws anything");
    refused("block_poses = 1", "6: uncertainty.block_poses: the noise knows no blocks");
    refused("replicates = 200", "6: uncertainty.replicates: only a bootstrap draws anything");
    refused(
        "kind = 'bootstrap'\nblock_poses = 1\nreplicates = 20",
        "8: uncertainty.replicates: an interval of 95 % needs 100 replicates at least",
    );
}

#[test]
fn what_is_asked_for_exists() {
    let added = "[\"elbow.position_offset\"]";
    assert_refused(added, "[\"wrist.torque_gain\"]", "37: ask.add[0]: there is no joint `wrist`; known:");
    assert_refused(
        added,
        "[\"elbow.torque_gai\"]",
        "37: ask.add[0]: there is no quantity `torque_gai` (did you mean `torque_gain`?); known: `torque_gain`, ",
    );
    assert_refused(added, "[\"elbow\"]", "37: ask.add[0]: `elbow` is no parameter: expected `gravity` or <joint>.<qu");
    assert_refused(added, "[\"gravity\"]", "38: ask.drop[1]: `gravity` is added as well: keep one");
    let no_sensor = read(&[
        ("session.toml", "[\"y1\", \"y2\"]", "[\"\", \"y2\"]"),
        ("session.toml", added, "[\"shoulder.torque_gain\"]"),
    ])
    .unwrap_err();
    assert!(no_sensor.starts_with("session.toml:37: ask.add[0]: joint `shoulder` has no column"), "{no_sensor}");
}

/// What is said of the session above with another first table.
fn table_refused(table: &str) -> String {
    read(&[("a.csv", A, table)]).unwrap_err()
}

#[test]
fn tables_are_whole() {
    let named_by = "\n  named by poses[0].file in session.toml:30";
    let cases = [
        ("q1,q2,y1,sweep\n0,0,1,\n1,1,1,\n", "a.csv: there is no column `y2`"),
        ("q1,q2,y1,y2,sweep\n0,0,1,2,\n0,high,1,2,\n", "a.csv:3: column `q2`: expected a finite number, found `high`"),
        ("q1,q2,y1,y2,sweep\n0,0,1,inf,\n0,1,1,2,\n", "a.csv:2: column `y2`: expected a finite number, found `inf`"),
        ("q1,q2,y1,y2,sweep\n0,NaN,1,2,\n0,1,1,2,\n", "a.csv:2: column `q2`: the position is missing"),
        ("q1,q2,y1,y2,sweep\n0,0,1,2,\n0,1,1\n", "a.csv:3: expected 5 cells, as in the header, found 3"),
        ("q1,q2,y1,y2,sweep\n", "a.csv: the file has a header but no rows"),
        ("", "a.csv: the file is empty"),
        ("q1,q2,y1,y2,sweep\n0,0,1,2,\n", "a.csv: a table of one pose cannot identify anything"),
    ];
    for (table, expected) in cases {
        let message = table_refused(table);
        assert!(message.starts_with(expected) && message.ends_with(named_by), "{message}");
    }
}

#[test]
fn repeated_rows_may_be_merged() {
    let merged = [
        ("session.toml", "sweep_column = \"sweep\"", "merge_repeated_rows = true"),
        ("a.csv", "90,180,2001,,s", "0,0,2002,,s\n1,1,2000,2000,s"),
    ];
    let session = read(&merged).unwrap();
    assert_eq!(session.poses.len(), 4);
    assert_eq!(session.poses[0].torque[0].map(|reading| reading.value), Some(2001.0));
}

#[test]
fn the_robots_errors_name_the_session() {
    let message = read(&[("robot.toml", "mass_kg = 2", "mass_kg = -2")]).unwrap_err();
    assert!(message.starts_with("robot.toml:10: joint[0].mass_kg: -2 is not a mass"), "{message}");
    assert!(message.ends_with("\n  named by robot in session.toml:2"), "{message}");
}

#[test]
fn values_are_of_their_kind() {
    assert_refused("[readings]\n", "inertia = 3\n[readings]\n", "8: gravity.inertia: unknown field `inertia`");
    assert_refused("solver =", "inertia = 3\nsolver =", "4: inertia: invalid type: integer `3`, expected a table");
    assert_refused("[[joint]]\n", "[joint]\n", "12: joint: one table where a list is expected: double its brackets");
}

/// Whatever stands in the file, there is an answer.
#[test]
fn no_part_of_a_session_panics() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("session.toml");
    fs::write(folder.path().join("robot.toml"), ROBOT).unwrap();
    for end in (0..SESSION.len()).filter(|end| SESSION.is_char_boundary(*end)) {
        fs::write(&path, &SESSION[..end]).unwrap();
        assert!(read_session(&path).is_err());
    }
}

#[test]
fn constraints_are_for_all_links_or_for_those_named() {
    let demanded = |constraints: &str| changed("[ask]", &format!("[constraints]\n{constraints}\n[ask]")).constraints;
    let session = changed("solver = \"levenberg-marquardt\"\n", "");
    assert!(session.constraints.is_empty());
    let all = demanded("masses = \"positive\"\ncenter_of_mass_within_m = 1\ntorque_gains_within = 0.2");
    let expected = Constraints {
        positive_masses: true,
        center_of_mass_within: vec![Some(1.0); 2],
        torque_gains_within: Some(0.2),
        physical_inertias: false,
    };
    assert_eq!(all, expected);
    let named = demanded("center_of_mass_within_m = { forearm = 0.25 }");
    assert_eq!(named.center_of_mass_within, [None, Some(0.25)]);
    assert!(!named.positive_masses && !named.is_empty());
}

/// Five poses of the elbow alone, with the given description of the moments.
fn swept_elbow(changes: &[(&'static str, &'static str, &'static str)]) -> Result<Session, String> {
    let sweep = "q1,q2,y1,y2,sweep\n0,0,5,6,\n0,10,7,8,\n0,20,7,8,\n0,30,7,8,\n0,40,7,8,\n";
    let mut all = vec![("b.csv", B, sweep), ("session.toml", "mass_kg = 1.7\n", "mass_kg = 1.724\n")];
    all.extend(changes);
    read(&all)
}

#[test]
fn moments_may_be_described_by_sweep() {
    let section = ("session.toml", "[readings]", "[inertia]\ndescription = \"sweep\"\n[readings]");
    assert_eq!(swept_elbow(&[section]).unwrap().inertia, InertiaPrior::Sweep);
    let refused = |changes: &[_]| swept_elbow(changes).unwrap_err();
    let with = |rest: &'static str| refused(&[("session.toml", "[readings]", rest)]);
    let message = with("[inertia]\ndescription = \"sweep\"\nrelative_std = 0.1\n[readings]");
    assert!(
        message.starts_with("session.toml:10: inertia.relative_std: the moments of a sweep are of no"),
        "{message}"
    );
    let message = with("[inertia]\ndescription = \"sweeps\"\n[readings]");
    assert!(message.contains("expected `link` or `sweep`"), "{message}");
    let message = refused(&[section, ("session.toml", "[ask]", "[constraints]\nmasses = \"positive\"\n[ask]")]);
    assert!(message.starts_with("session.toml:9: inertia.description: [constraints] on masses"), "{message}");
    let message = read(&[section, ("session.toml", "mass_kg = 1.7\n", "mass_kg = 1.724\n")]).unwrap_err();
    assert!(message.starts_with("session.toml:9: inertia.description: no pose belongs to a sweep"), "{message}");
    let message = refused(&[
        section,
        ("session.toml", "mass_kg = 1.724\nlink = \"forearm\"\n[[load]]", "mass_kg = 2\nlink = \"forearm\"\n[[load]]"),
    ]);
    assert!(
        message.contains("load_distance[0].between: a distance between placements of 2 kg and 1.724 kg"),
        "{message}"
    );
}

#[test]
fn joints_may_be_elsewhere_than_their_sensors_say() {
    let section = "[deflection]\nhold_std_deg = 0.5\ncompliance_std_rad_per_newton_metre = [1e-4, 0]\n[readings]";
    let session = swept_elbow(&[("session.toml", "[readings]", section)]).unwrap();
    // The poses of the first table belong to no sweep: each is a hold of its own, which is no matter with stated noise.
    assert!((session.deflection.hold_std.unwrap() - 0.5 * PI / 180.0).abs() < 1e-15);
    let names: Vec<String> = session.compliances().map(|index| session.further[index].name()).collect();
    assert_eq!(names, ["shoulder.compliance", "elbow.compliance"]);
    assert_eq!(session.further[0].prior, parameter_prior(0.0, PriorKind::Gaussian { std: 1e-4 }));
    assert_eq!(session.further[1].fixed, Some("given as exact"));
    let session = changed("unit = \"deg\" }\ntorque", "unit = \"deg\", std = [0.1, 0] }\ntorque");
    assert!((session.deflection.reading_std[0] - 0.1 * PI / 180.0).abs() < 1e-15);
    assert_eq!((session.deflection.reading_std[1], session.deflection.hold_std), (0.0, None));
    assert!(!session.deflection.stiff);
    let stiff = changed("[readings]", "[deflection]\ncompliance_std_rad_per_newton_metre = 0\n[readings]");
    assert!(stiff.deflection.stiff && stiff.compliances().is_empty());
}

#[test]
fn deflections_that_say_nothing_are_refused() {
    let with = |lines: &str| refused("[readings]", &format!("[deflection]\n{lines}\n[readings]"));
    let starts = |lines: &str, start: &str| {
        let message = with(lines);
        assert!(message.starts_with(&format!("session.toml:9: deflection.{start}")), "{message}");
    };
    starts("hold_std_deg = 0", "hold_std_deg: 0 is not the standard deviation of a deflection: expected a positive");
    starts("pose_std_deg = -1", "pose_std_deg: -1 is not");
    let compliance = "compliance_std_rad_per_newton_metre";
    starts(&format!("{compliance} = -1e-4"), &format!("{compliance}: -0.0001 is no standard deviation"));
    starts(&format!("{compliance} = [1e-4]"), &format!("{compliance}: expected 2 entries, one for each joint"));
    let noise = |more: &str| {
        let position = "unit = \"deg\", std = 0.1 }\ntorque";
        read(&[("session.toml", "unit = \"deg\" }\ntorque", position), ("session.toml", "[ask]", more)]).unwrap_err()
    };
    let message = noise("[loss]\nkind = \"huber\"\n[ask]");
    assert!(
        message.contains("readings.position.std: errors of each pose's positions would hide its outliers"),
        "{message}"
    );
    let position = ("session.toml", "unit = \"deg\" }\ntorque", "unit = \"deg\", std = 0.1 }\ntorque");
    let message = read(&[position, ("session.toml", ", std = 0.8 }", " }")]).unwrap_err();
    assert!(message.contains("cannot be told from noise of unknown size"), "{message}");
    let message =
        read(&[("session.toml", "unit = \"deg\" }\ntorque", "unit = \"deg\", std = -0.1 }\ntorque")]).unwrap_err();
    assert!(message.contains("readings.position.std: -0.1 is no standard deviation"), "{message}");
}

#[test]
fn tables_for_validation_are_read_apart() {
    let tables = SESSION.split_once("[[poses]]\n").unwrap().1.split_once("[ask]").unwrap().0;
    let validation = |load: &str| {
        let written = format!("file = \"a.csv\"\n[[validation]]\nfile = \"b.csv\"\nload = \"{load}\"\n");
        read(&[("session.toml", tables, written.as_str())])
    };
    let session = validation("plate-b").unwrap();
    assert_eq!((session.poses.len(), session.validation.len(), session.tables.len()), (2, 2, 2));
    assert!(session.validation.iter().all(|pose| pose.table == 1 && pose.load == Some(1)), "{:?}", session.validation);
    let names: Vec<_> = session.input_paths().map(|path| path.file_name().unwrap().to_str().unwrap()).collect();
    assert_eq!(names, ["session.toml", "robot.toml", "a.csv", "b.csv"]);
    let inertia = ("session.toml", "[ask]", "[inertia]\ndescription = \"sweep\"\n[ask]");
    let written = "file = \"a.csv\"\n[[validation]]\nfile = \"b.csv\"\nload = \"plate-b\"\n";
    let message = read(&[("session.toml", tables, written), inertia]).unwrap_err();
    assert!(message.contains("validation[0]: moments are described by sweep"), "{message}");
    let message = validation("plate-a").unwrap_err();
    assert!(
        message.contains("validation[0].load: where the load `plate-a` hangs no table of [[poses]] tells"),
        "{message}"
    );
}
