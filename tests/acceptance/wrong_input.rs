//! What a user can get wrong in the files of a session: each mistake is told with its file, line and field, and nothing is
//! written.
//!
//! Each case changes one thing in the small session.

use std::fs;
use std::path::Path;

use crate::program::{Run, gravcal_in};
use crate::small_session::{HEADER, RESULTS, calibrate, check, small_session};
use crate::tree;

/// Stands, in what must be told, for the line of the first change.
const LINE: &str = "{line}";

/// A mistake: what is changed, and what must be told.
struct Mistake {
    what: &'static str,
    changes: &'static [(&'static str, Change)],
    reported: &'static [&'static str],
}

/// How a file is changed.
enum Change {
    /// A text that stands in it once, or the first of those, is replaced.
    Replace(&'static str, &'static str),
    /// It holds something else.
    Contents(&'static [u8]),
    /// It is a table that holds other rows.
    Rows(&'static str),
    /// It is gone.
    Absent,
    /// A folder stands in its place.
    Folder,
}

use Change::{Absent, Contents, Folder, Replace, Rows};

const IN_THE_SESSION: &[Mistake] = &[
    Mistake {
        what: "an unknown key",
        changes: &[("session.toml", Replace("magnitude_m_per_s2", "magnitude"))],
        reported: &["session.toml:{line}: gravity.magnitude: unknown field", "`magnitude_m_per_s2`"],
    },
    Mistake {
        what: "an unknown section",
        changes: &[("session.toml", Replace("[[load_distance]]", "[[distance]]"))],
        reported: &["session.toml:{line}: distance[0]: unknown field `distance`"],
    },
    Mistake {
        what: "no unit of position",
        changes: &[("session.toml", Replace("unit = \"rad\"\n", ""))],
        reported: &["session.toml:7: readings.position.unit: the unit is missing"],
    },
    Mistake {
        what: "no unit of torque",
        changes: &[("session.toml", Replace("unit = \"count\"\n", ""))],
        reported: &["session.toml:11: readings.torque.unit: the unit is missing"],
    },
    Mistake {
        what: "no unit of what is known of a joint",
        changes: &[("session.toml", Replace("nominal = 1.0, unit = \"deg/deg\"", "nominal = 1.0"))],
        reported: &["session.toml:{line}: joint[0].position_gain.unit: the unit is missing"],
    },
    Mistake {
        what: "an unknown unit",
        changes: &[("session.toml", Replace("unit = \"count\"", "unit = \"lbf\""))],
        reported: &["session.toml:{line}: readings.torque.unit: the unit `lbf` does not fit"],
    },
    Mistake {
        what: "an unknown joint",
        changes: &[("session.toml", Replace("name = \"joint3\"", "name = \"joint33\""))],
        reported: &["session.toml:{line}: joint[0].name: there is no joint `joint33`", "known: `joint1`"],
    },
    Mistake {
        what: "an unknown swept joint",
        changes: &[("session.toml", Replace("file = \"bare.csv\"", "swept = \"wrist\"\nfile = \"bare.csv\""))],
        reported: &["session.toml:{line}: poses[0].swept: there is no joint `wrist`"],
    },
    Mistake {
        what: "a parameter of an unknown joint asked for",
        changes: &[("session.toml", Replace("[gravity]", "[ask]\nadd = [\"wrist.torque_gain\"]\n[gravity]"))],
        reported: &["ask.add[0]: there is no joint `wrist`"],
    },
    Mistake {
        what: "an unknown link",
        changes: &[("session.toml", Replace("link = \"link3\"", "link = \"link9\""))],
        reported: &["session.toml:{line}: load[0].link: there is no link `link9`", "known: `link1`"],
    },
    Mistake {
        what: "a negative mass of a load",
        changes: &[("session.toml", Replace("mass_kg = 1.724", "mass_kg = -1.724"))],
        reported: &["session.toml:{line}: load[0].mass_kg: -1.724 is not a mass"],
    },
    Mistake {
        what: "a distance between loads that do not exist",
        changes: &[("session.toml", Replace("[\"plate-a\", \"plate-b\"]", "[\"plate-a\", \"plate-c\"]"))],
        reported: &["session.toml:{line}: load_distance[0].between[1]: there is no load `plate-c`"],
    },
    Mistake {
        what: "poses with a load that does not exist",
        changes: &[("session.toml", Replace("load = \"plate-b\"", "load = \"plate-c\""))],
        reported: &["session.toml:{line}: poses[2].load: there is no load `plate-c`"],
    },
    Mistake {
        what: "text where a number belongs",
        changes: &[("session.toml", Replace("mass_kg = 1.724", "mass_kg = \"heavy\""))],
        reported: &["session.toml:{line}: load[0].mass_kg: invalid type: string \"heavy\""],
    },
    Mistake {
        what: "no number where a number belongs",
        changes: &[("session.toml", Replace("9.8", "nan"))],
        reported: &["session.toml:{line}: gravity.magnitude_m_per_s2: expected a finite number, found nan"],
    },
    Mistake {
        what: "no torque at all",
        changes: &[(
            "session.toml",
            Replace(
                "[\"joint1_torque_count\", \"joint2_torque_count\", \"joint3_torque_count\"]",
                "[\"\", \"\", \"\"]",
            ),
        )],
        reported: &["session.toml:{line}: readings.torque.columns: no joint has a torque reading"],
    },
    Mistake {
        what: "a column too few",
        changes: &[("session.toml", Replace(", \"joint3_torque_count\"]", "]"))],
        reported: &["session.toml:{line}: readings.torque.columns: expected 3 entries"],
    },
    Mistake {
        what: "a table read twice",
        changes: &[("session.toml", Replace("file = \"plate-a.csv\"", "file = \"bare.csv\""))],
        reported: &["session.toml:{line}: poses[1].file: this table is already poses[0]"],
    },
    Mistake {
        what: "an unknown loss",
        changes: &[("session.toml", Replace("[gravity]", "loss = { kind = \"welsch\" }\n[gravity]"))],
        reported: &["session.toml:{line}: loss.kind: unknown loss `welsch`", "geman-mcclure"],
    },
    Mistake {
        what: "a loss without width",
        changes: &[("session.toml", Replace("[gravity]", "loss = { kind = \"huber\", width = 0 }\n[gravity]"))],
        reported: &["session.toml:{line}: loss.width: the width 0 of a loss must be between"],
    },
    Mistake {
        what: "an unknown uncertainty",
        changes: &[("session.toml", Replace("[gravity]", "uncertainty = { kind = \"guess\" }\n[gravity]"))],
        reported: &["session.toml:{line}: uncertainty.kind: unknown variant `guess`", "`bootstrap`"],
    },
    Mistake {
        what: "fewer than thirty blocks",
        changes: &[(
            "session.toml",
            Replace("[gravity]", "uncertainty = { kind = \"sandwich\", block_poses = 5 }\n[gravity]"),
        )],
        reported: &[
            "session.toml:{line}: uncertainty.block_poses: 36 samples in blocks of 5 are 7 blocks, and 30 are needed",
            "blocks of 1 to 1 samples",
        ],
    },
    Mistake {
        what: "not TOML",
        changes: &[("session.toml", Replace("[gravity]", "[gravity"))],
        reported: &["session.toml:{line}: "],
    },
    Mistake {
        what: "an empty file",
        changes: &[("session.toml", Contents(b""))],
        reported: &["session.toml:1: missing field `gravity`"],
    },
    Mistake {
        what: "a file of bytes that are no text",
        changes: &[("session.toml", Contents(b"robot = 1\n\x7fELF\x02\x01\xff\xfe\x00\x00"))],
        reported: &["session.toml:2: this is not UTF-8 text"],
    },
    Mistake {
        what: "no session",
        changes: &[("session.toml", Absent)],
        reported: &["session.toml: there is no such file"],
    },
    Mistake {
        what: "a session that is a folder",
        changes: &[("session.toml", Folder)],
        reported: &["session.toml: this is a folder"],
    },
];

const IN_A_TABLE: &[Mistake] = &[
    Mistake {
        what: "a column that is not there",
        changes: &[("bare.csv", Replace("joint2_torque_count", "joint2_torque_V"))],
        reported: &["bare.csv: there is no column `joint2_torque_count`", "named by poses[0].file in session.toml:35"],
    },
    Mistake {
        what: "no torque columns",
        changes: &[(
            "bare.csv",
            Contents(b"joint1_position_rad,joint2_position_rad,joint3_position_rad\n0,0,0\n1,1,1\n"),
        )],
        reported: &["bare.csv: there is no column `joint1_torque_count`"],
    },
    Mistake {
        what: "text where a number belongs",
        changes: &[("plate-a.csv", Rows("0,0,0,2000,2000,2000\n0,0,1,2000,high,2000\n"))],
        reported: &["plate-a.csv:3: column `joint2_torque_count`: expected a finite number, found `high`"],
    },
    Mistake {
        what: "NaN where a position belongs",
        changes: &[("plate-b.csv", Rows("0,NaN,0,2000,2000,2000\n0,0,1,2000,2000,2000\n"))],
        reported: &["plate-b.csv:2: column `joint2_position_rad`: the position is missing"],
    },
    Mistake {
        what: "no position",
        changes: &[("bare.csv", Rows("0,,0,2000,2000,2000\n0,0,1,2000,2000,2000\n"))],
        reported: &["bare.csv:2: column `joint2_position_rad`: the position is missing"],
    },
    Mistake {
        what: "ragged rows",
        changes: &[("bare.csv", Rows("0,0,0,2000,2000,2000\n0,0,1,2000,2000\n"))],
        reported: &["bare.csv:3: expected 6 cells, as in the header, found 5"],
    },
    Mistake {
        what: "an empty table",
        changes: &[("bare.csv", Rows(""))],
        reported: &["bare.csv: the file has a header but no rows"],
    },
    Mistake {
        what: "an empty file",
        changes: &[("bare.csv", Contents(b""))],
        reported: &["bare.csv: the file is empty"],
    },
    Mistake {
        what: "no torque reading in any row",
        changes: &[
            ("bare.csv", Rows("0,0,0,,,\n0,0,1,,,\n")),
            ("plate-a.csv", Rows("0,0,0,,,\n0,0,1,,,\n")),
            ("plate-b.csv", Rows("0,0,0,,,\n0,0,1,,,\n")),
        ],
        reported: &["session.toml", "torque"],
    },
    Mistake {
        what: "a table of one pose",
        changes: &[("bare.csv", Rows("0,0,0,2000,2000,2000\n"))],
        reported: &["bare.csv: a table of one pose cannot identify anything"],
    },
    Mistake {
        what: "a file of bytes that are no text",
        changes: &[("bare.csv", Contents(b"\x89PNG\r\n\x1a\n\x00\x00\xff\xfe"))],
        reported: &["bare.csv:1: this is not UTF-8 text"],
    },
    Mistake {
        what: "a table that is not there",
        changes: &[("bare.csv", Absent)],
        reported: &["bare.csv: there is no such file", "named by poses[0].file in session.toml:35"],
    },
    Mistake {
        what: "a table that is a folder",
        changes: &[("bare.csv", Folder)],
        reported: &["bare.csv: the folder has no .mcap file", "named by poses[0].file in session.toml:35"],
    },
    Mistake {
        what: "a data folder that is not there",
        changes: &[("session.toml", Replace("\"bare.csv\"", "\"${GRAVCAL_ACCEPTANCE:-absent/data}/bare.csv\""))],
        reported: &[
            "absent/data/bare.csv: there is no such folder as absent/data",
            "named by poses[0].file in session.toml:{line}",
            "the environment variable GRAVCAL_ACCEPTANCE is not set",
        ],
    },
    Mistake {
        what: "a data folder without a default",
        changes: &[("session.toml", Replace("\"bare.csv\"", "\"${GRAVCAL_ACCEPTANCE}/bare.csv\""))],
        reported: &["session.toml:{line}: poses[0].file: the environment variable GRAVCAL_ACCEPTANCE is not set"],
    },
];

/// Where the session names its robot, and where it would name one from a URDF.
const FROM_URDF: Change = Replace("\"robot.toml\"", "{ urdf = \"arm.urdf\", base = \"base\", tip = \"lower\" }");

const IN_THE_ROBOT: &[Mistake] = &[
    Mistake {
        what: "an unknown key",
        changes: &[("robot.toml", Replace("a_m = 0.0", "a = 0.0"))],
        reported: &["robot.toml:{line}: joint[0].a: unknown field", "named by robot in session.toml:1"],
    },
    Mistake {
        what: "no unit of a sensor",
        changes: &[("robot.toml", Replace("{ value = 6.69, unit = \"count/(N·m)\" }", "{ value = 6.69 }"))],
        reported: &["robot.toml:{line}: joint[0].torque_sensor.gain.unit: the unit is missing"],
    },
    Mistake {
        what: "a negative mass",
        changes: &[("robot.toml", Replace("mass_kg = 2.0", "mass_kg = -2.0"))],
        reported: &["robot.toml:{line}: joint[0].mass_kg: -2 is not a mass", "named by robot in session.toml:1"],
    },
    Mistake {
        what: "limits the wrong way round",
        changes: &[("robot.toml", Replace("limits_deg = [-90.0, 90.0]", "limits_deg = [90.0, -90.0]"))],
        reported: &["robot.toml:{line}: joint[0].limits_deg: the limits 90, -90 are the wrong way round"],
    },
    Mistake {
        what: "a robot that is not there",
        changes: &[("robot.toml", Absent)],
        reported: &["robot.toml: there is no such file", "named by robot in session.toml:1"],
    },
    Mistake {
        what: "a robot that is a folder",
        changes: &[("robot.toml", Folder)],
        reported: &["robot.toml: this is a folder", "named by robot in session.toml:1"],
    },
    Mistake {
        what: "a URDF without its chain",
        changes: &[("session.toml", Replace("\"robot.toml\"", "\"arm.urdf\""))],
        reported: &["session.toml:{line}: robot: of a URDF one must also know where the chain begins and ends"],
    },
    Mistake {
        what: "a URDF that is not XML",
        changes: &[("arm.urdf", Contents(b"solid arm\n  facet normal 0 0 1\n")), ("session.toml", FROM_URDF)],
        reported: &["arm.urdf: not a readable URDF", "named by robot.urdf in session.toml:1"],
    },
    Mistake {
        what: "a URDF that ends too early",
        changes: &[("arm.urdf", Replace("</robot>\n", "")), ("session.toml", FROM_URDF)],
        reported: &["arm.urdf: not a readable URDF"],
    },
    Mistake {
        what: "a chain that is a loop",
        changes: &[
            ("arm.urdf", Replace("<parent link=\"base\"/>", "<parent link=\"lower\"/>")),
            ("session.toml", FROM_URDF),
        ],
        reported: &["arm.urdf: the URDF's links form a loop: ", "named by robot.urdf in session.toml:1"],
    },
    Mistake {
        what: "a chain that is closed",
        changes: &[
            ("arm.urdf", Replace("<child link=\"lower\"/>", "<child link=\"upper\"/>")),
            ("session.toml", FROM_URDF),
        ],
        reported: &["arm.urdf: link `upper` is the child of two joints, `shoulder` and `elbow`"],
    },
    Mistake {
        what: "a negative mass in a URDF",
        changes: &[
            ("arm.urdf", Replace("<mass value=\"2.0\"/>", "<mass value=\"-2.0\"/>")),
            ("session.toml", FROM_URDF),
        ],
        reported: &["arm.urdf: mass of link `upper` is -2 kg"],
    },
    Mistake {
        what: "limits of a URDF the wrong way round",
        changes: &[("arm.urdf", Replace("lower=\"-1.5\"", "lower=\"2.5\"")), ("session.toml", FROM_URDF)],
        reported: &["arm.urdf: ", "joint `shoulder`", "wrong way round"],
    },
    Mistake {
        what: "an unknown link at the chain's end",
        changes: &[(
            "session.toml",
            Replace("\"robot.toml\"", "{ urdf = \"arm.urdf\", base = \"base\", tip = \"hand\" }"),
        )],
        reported: &["arm.urdf: tip link `hand` is not in the URDF", "named by robot.urdf in session.toml:{line}"],
    },
];

/// Names that only the program knows, so that reading the session alone does not find the mistake.
const IN_NAMES: &[Mistake] = &[
    Mistake {
        what: "an unknown estimator",
        changes: &[("session.toml", Replace("robot = ", "estimators = [\"kalman\"]\nrobot = "))],
        reported: &["session.toml:{line}: estimators: unknown estimator `kalman`", "sequential, joint"],
    },
    Mistake {
        what: "an unknown solver",
        changes: &[("session.toml", Replace("robot = ", "solver = \"simplex\"\nrobot = "))],
        reported: &["session.toml:{line}: solver: unknown solver `simplex`", "levenberg-marquardt"],
    },
    Mistake {
        what: "an unknown solver with options",
        changes: &[("session.toml", Replace("robot = ", "solver = { name = \"simplex\", size = 2 }\nrobot = "))],
        reported: &["session.toml:{line}: solver.name: unknown solver `simplex`", "levenberg-marquardt"],
    },
    Mistake {
        what: "options without the solver's name",
        changes: &[("session.toml", Replace("robot = ", "solver = { max_iterations = 9 }\nrobot = "))],
        reported: &["session.toml:{line}: solver: missing field `name`"],
    },
    Mistake {
        what: "an option that the solver has not",
        changes: &[("session.toml", Replace("[gravity]", "[solver]\nmax_iteration = 9\nname = \"dogleg\"\n[gravity]"))],
        reported: &["solver.max_iteration: unknown field", "`step_tolerance`", "did you mean `max_iterations`?"],
    },
    Mistake {
        what: "an option of the wrong type",
        changes: &[(
            "session.toml",
            Replace("robot = ", "solver = { name = \"gauss-newton\", max_iterations = \"many\" }\nrobot = "),
        )],
        reported: &[
            "session.toml:{line}: solver.max_iterations: invalid type: string \"many\", expected a whole number",
        ],
    },
    Mistake {
        what: "an option that makes no sense",
        changes: &[(
            "session.toml",
            Replace("robot = ", "solver = { name = \"dogleg\", cosine_tolerance = 2.0 }\nrobot = "),
        )],
        reported: &["session.toml:{line}: solver.cosine_tolerance: ", "`2.0`, expected a number between 0 and 1"],
    },
];

#[test]
fn the_session_without_mistakes_is_calibrated() {
    let folder = small_session();
    let run = calibrate(folder.path());
    assert_eq!(run.code, 0, "{run:?}");
    assert!(folder.path().join(RESULTS).join("calibration.json").is_file());
    assert_eq!(check(folder.path()).code, 0);
}

#[test]
fn mistakes_in_a_session_are_reported() {
    assert_reported(IN_THE_SESSION, &[calibrate, check]);
}

#[test]
fn mistakes_in_a_table_are_reported() {
    assert_reported(IN_A_TABLE, &[calibrate, check]);
}

#[test]
fn mistakes_in_a_robot_are_reported() {
    assert_reported(IN_THE_ROBOT, &[calibrate, check]);
}

#[test]
fn unknown_names_are_reported() {
    assert_reported(IN_NAMES, &[calibrate]);
}

#[test]
fn results_that_cannot_be_written_are_reported() {
    for results in ["robot.toml", "robot.toml/results", "robot.toml/a/b"] {
        let folder = small_session();
        let before = tree::files_below(folder.path());
        let run = gravcal_in(folder.path(), ["calibrate", "session.toml", "--output", results]);
        assert_eq!(run.refusal(&["robot.toml: this is not a folder", "--output"]), None, "{results}");
        assert_eq!(tree::files_below(folder.path()), before, "{results}");
    }
}

#[test]
fn mistakes_on_the_command_line_are_reported() {
    let folder = small_session();
    let before = tree::files_below(folder.path());
    let lines: [(&[&str], &str); 7] = [
        (&["calibrate"], "<SESSION>"),
        (&["fly", "session.toml"], "fly"),
        (&["check", "session.toml", "--colour"], "--colour"),
        (&["calibrate", "session.toml", "--threads", "0"], "--threads"),
        (&["calibrate", "session.toml", "--threads", "many"], "--threads"),
        (&["calibrate", "session.toml", "--estimator", "kalman"], "sequential, joint"),
        (&["calibrate", "session.toml", "--solver", "simplex"], "levenberg-marquardt"),
    ];
    for (line, reported) in lines {
        assert_eq!(gravcal_in(folder.path(), line).refusal(&[reported]), None, "{line:?}");
    }
    assert_eq!(tree::files_below(folder.path()), before);
}

/// Makes each mistake in a session of its own: every command must tell it and write nothing.
fn assert_reported(mistakes: &[Mistake], commands: &[fn(&Path) -> Run]) {
    let wrong: Vec<String> = mistakes.iter().flat_map(|mistake| untold(mistake, commands)).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

fn untold(mistake: &Mistake, commands: &[fn(&Path) -> Run]) -> Vec<String> {
    let folder = small_session();
    let lines: Vec<usize> =
        mistake.changes.iter().map(|(file, change)| change.make(&folder.path().join(file))).collect();
    let reported: Vec<String> =
        mistake.reported.iter().map(|reported| reported.replace(LINE, &lines[0].to_string())).collect();
    let reported: Vec<&str> = reported.iter().map(String::as_str).collect();
    let before = tree::files_below(folder.path());
    let mut wrong: Vec<String> =
        commands.iter().filter_map(|command| command(folder.path()).refusal(&reported)).collect();
    if tree::files_below(folder.path()) != before {
        wrong.push("files were written".to_owned());
    }
    wrong.into_iter().map(|wrong| format!("{}: {wrong}", mistake.what)).collect()
}

impl Change {
    /// Changes the file; gives the line where the change begins.
    fn make(&self, file: &Path) -> usize {
        match self {
            Replace(old, new) => return replace(file, old, new),
            Contents(bytes) => fs::write(file, bytes).unwrap(),
            Rows(rows) => fs::write(file, [HEADER, rows].concat()).unwrap(),
            Absent => fs::remove_file(file).unwrap(),
            Folder => {
                fs::remove_file(file).unwrap();
                fs::create_dir(file).unwrap();
            }
        }
        1
    }
}

fn replace(file: &Path, old: &str, new: &str) -> usize {
    let text = fs::read_to_string(file).unwrap();
    let (before, _) = text.split_once(old).unwrap_or_else(|| panic!("{}: no {old}", file.display()));
    fs::write(file, text.replacen(old, new, 1)).unwrap();
    1 + before.matches('\n').count()
}
