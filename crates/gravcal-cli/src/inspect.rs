//! `gravcal inspect`: what is in a recording, which poses it holds, and a session to start from.

use std::path::{Path, PathBuf};

use clap::Args;
use gravcal_recording::{CsvWriting, Inspection, clear_abandoned, in_command, inspect_as, write_atomically};
use gravcal_robot_model::session::Searched;
use gravcal_session::draft::{Draft, DraftError, DraftPoses, DraftRobot, RecordedJoints};
use gravcal_session::read_session;
use serde::Serialize;

use crate::columns::ColumnNames;
use crate::exit::Exit;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::{targets, terminal};

/// Tell what is in a recording, and draw up a session of it
///
/// Topics, columns, rates, gaps, ranges and what they perhaps mean; sensors that are stuck or at an end of their range, rows that stand
/// twice, time that runs backwards, and what of the file is damaged; then the poses that are found in it. It reads CSV, MCAP
/// (sensor_msgs/JointState in CDR or JSON), bags of ROS 2 in SQLite (.db3), folders of rosbag2 and Parquet. A clock may be a column of
/// numbers, or of dates with times (ISO 8601); without an offset these are taken to be in UTC.
///
/// With --session it writes a session to start from: columns and units are guessed, said to be guesses, and what only you know (loads,
/// masses, where you are) stands there as comments.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The recording; name others of the same columns in its session, as further [[poses]]
    #[arg(value_name = "FILE")]
    file: PathBuf,

    /// Named beside it, which a glob easily does: refused with what to do.
    #[arg(hide = true)]
    others: Vec<PathBuf>,

    /// Write a session to start from
    #[arg(long, value_name = "OUT.toml")]
    session: Option<PathBuf>,

    /// Robot of the session: a robot.toml or a URDF
    #[arg(long, value_name = "ROBOT")]
    robot: Option<PathBuf>,

    /// First link of a URDF's chain [default: the root, on which all else hangs]
    #[arg(long, value_name = "LINK", requires = "robot")]
    base: Option<String>,

    /// Last link of a URDF's chain; one for each branch [default: what the recorded joints tell]
    #[arg(long = "tip", value_name = "LINK", requires = "robot")]
    tips: Vec<String>,

    #[command(flatten)]
    columns: ColumnNames,

    /// Replace the session if there is one
    #[arg(long, requires = "session")]
    overwrite: bool,

    /// Print JSON instead of text
    #[arg(long)]
    json: bool,

    /// Show no progress
    #[arg(long, short)]
    quiet: bool,
}

const EXAMPLES: &str = "\
Examples:
  gravcal inspect recording.mcap
  gravcal inspect bag/ --json
  gravcal inspect recording.mcap --robot robot.toml --session session.toml
  gravcal inspect recording.csv --robot arm.urdf --base base_link --tip tool0 --session session.toml
  gravcal inspect no-header.csv --columns t_s,q1_deg,q2_deg,tau1_Nm,tau2_Nm

Exit codes:
  0  the recording was read, and the session written
  1  what was found could not be printed or shown in full; files are complete
  2  bad input or usage; nothing is written";

/// What to do about a recording in which nothing stands and nothing sweeps slowly.
const NO_POSES: &str = "\
No pose was found. Any of these makes some:
  - Record again, and let the arm stand for half a second or more in each of
    many poses: [readings.still] finds them.
  - Record again, and move one joint after the other to and fro, no faster than
    12 deg/s, while the rest stand: [readings.sweeps] makes a pose of each degree.
  - Identify gravity, inertia and friction from this recording in motion
    ([readings.motion]): with --robot ROBOT --session OUT.toml this command draws
    up such a session.";

/// What is told.
#[derive(Serialize)]
struct Reported<'a> {
    #[serde(flatten)]
    inspection: &'a Inspection,
    /// How many standstills or, where there are none, slow sweeps; absent where rows are poses, or columns cannot be told.
    poses_found: Option<usize>,
    /// What the search for poses says.
    notes: Vec<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Exit, Failure> {
    let file = only(&arguments.file, &arguments.others)?;
    targets::check([Some(file), arguments.robot.as_deref()].into_iter().flatten(), arguments.session.as_slice())?;
    if let Some(session) = arguments.session.as_deref().filter(|session| session.exists() && !arguments.overwrite) {
        let message = format!("{}: there is such a file already", session.display());
        return Err(Failure::said(message).hint("--overwrite replaces it, --session OUT.toml writes elsewhere"));
    }
    let progress = Progress::new(arguments.quiet);
    let watch =
        |doing: &str, share: f64| progress.stage(&format!("{doing} {}: {:.0} %", file.display(), 100.0 * share));
    let csv = arguments.columns.of(file, &CsvWriting::default())?;
    let inspection = inspect_as(file, &csv, &|share| watch("reading", share));
    let inspection = inspection.map_err(|error| Failure::bad_input(&error))?;
    let inspection = with_robots_names(arguments, inspection)?;
    let robot = robot(arguments, &inspection)?;
    let inspection = match &robot {
        Some(robot) => inspection.with_sliding(|joint| robot.slides(joint)),
        None => inspection,
    };
    let draft = match Draft::new(file, &inspection, robot.as_ref()) {
        Ok(draft) => Some(draft.written(csv)),
        // What cannot be guessed matters only to who wants it, or has given a robot that does not fit.
        Err(error) if arguments.session.is_some() || robot.is_some() => return Err(refused(&error, file)),
        Err(_) => None,
    };
    let draft = match draft {
        None => None,
        Some(draft) => {
            let draft = draft.looked_at(&|share| watch("looking at", share));
            let draft = draft.map_err(|error| Failure::bad_input(&error))?;
            let poses = draft.search(&|share| watch("searching", share)).map_err(|error| Failure::bad_input(&error))?;
            Some((draft, poses))
        }
    };
    drop(progress);
    let session = arguments.session.as_deref().zip(draft.as_ref());
    if let Some((path, (draft, poses))) = session {
        write(path, draft, poses)?;
    }
    report(arguments, &inspection, draft.as_ref())?;
    if let Some((path, (draft, poses))) = session.filter(|_| !arguments.json) {
        report_session(path, draft, poses)?;
    }
    Ok(Exit::Determined)
}

/// The one recording that is inspected.
fn only<'f>(file: &'f Path, others: &[PathBuf]) -> Result<&'f Path, Failure> {
    if others.is_empty() {
        return Ok(file);
    }
    let table = |other: &PathBuf| format!("\n  [[poses]]\n  file = {:?}", other.display().to_string());
    let tables: String = others.iter().map(table).collect();
    let message = format!("{} recordings are named, and one is inspected at a time", 1 + others.len());
    let hint = format!(
        "draw up the session from {}; others of the same columns are added to it by hand, each with the load it was taken \
         with, if any (load = \"…\"):{tables}",
        file.display()
    );
    Err(Failure::said(message).hint(hint))
}

/// The same where columns bear the names of the robot's joints. Where they tell no positions and torques at all, that is said before
/// anything of the robot: its chain cannot be guessed then.
fn with_robots_names(arguments: &Arguments, inspection: Inspection) -> Result<Inspection, Failure> {
    let Some(path) = &arguments.robot else { return Ok(inspection) };
    let names = DraftRobot::joint_names(path).map_err(|error| Failure::bad_input(&error))?;
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let inspection = inspection.with_joint_names(&names);
    match Draft::new(&arguments.file, &inspection, None) {
        Err(error) => Err(refused(&error, &arguments.file)),
        Ok(_) => Ok(inspection),
    }
}

fn robot(arguments: &Arguments, inspection: &Inspection) -> Result<Option<DraftRobot>, Failure> {
    let Some(path) = &arguments.robot else { return Ok(None) };
    let mut joints = inspection.joints_with_torque();
    let silent = inspection.joints_with_silent_torque();
    joints.extend(
        silent.into_iter().filter(|silent| joints.iter().all(|joint| joint.name != silent.name)).collect::<Vec<_>>(),
    );
    let all: Vec<&str> = joints.iter().map(|joint| joint.name.as_str()).collect();
    let moving: Vec<&str> = inspection.moving(&joints).map(|joint| joint.name.as_str()).collect();
    let recorded = RecordedJoints { all: &all, moving: &moving };
    let robot = DraftRobot::read(path, arguments.base.as_deref(), &arguments.tips, recorded);
    robot
        .map(Some)
        .map_err(|error| Failure::bad_input(&error).hint("--base LINK and --tip LINK choose links of a URDF"))
}

fn refused(error: &DraftError, file: &Path) -> Failure {
    let failure = Failure::bad_input(error).about(file.display());
    match error {
        DraftError::HalfNamed { .. } => failure,
        DraftError::OtherJoints { .. } => failure.hint("--base LINK and --tip LINK choose the chain of a URDF"),
        DraftError::NoJoints { .. } | DraftError::NoTorques { .. } => {
            failure.hint(
                "rename the columns in the file (of a CSV file without a header, --columns names them), or write the session by hand, with \
                 the columns as they are: [readings] position = { columns = [\"…\"], unit = \"rad\" }, and torque likewise; docs/tutorial shows one",
            )
        }
        DraftError::Robot(_) => failure,
    }
}

fn report(
    arguments: &Arguments,
    inspection: &Inspection,
    draft: Option<&(Draft<'_>, DraftPoses)>,
) -> Result<(), Failure> {
    let searched = draft.and_then(|(_, poses)| poses.searched());
    let found = draft.zip(searched).map_or_else(Vec::new, |((draft, _), searched)| searched.notes(&draft.mapping()));
    let doubt = draft.and_then(|(_, poses)| poses.doubt()).map(str::to_owned);
    let notes: Vec<String> = found.into_iter().chain(doubt).collect();
    if arguments.json {
        let reported = Reported { inspection, poses_found: searched.map(Searched::found), notes };
        let text = serde_json::to_string_pretty(&reported).map_err(|error| Failure::bad_input(&error))?;
        return terminal::print_exactly(&format!("{text}\n"));
    }
    let poses = match (draft, searched) {
        (Some(_), None) if !notes.is_empty() => notes.join("\n"),
        (None, _) => {
            "Names of columns do not tell the joints' positions and torques, so no poses were looked for.".to_owned()
        }
        (Some(_), None) => "There is no clock, or rows are long apart: each row may be a static pose.".to_owned(),
        (Some(_), Some(_)) => notes.join("\n"),
    };
    let none_found = searched.is_some_and(|searched| searched.found() == 0) && arguments.session.is_none();
    let next = if none_found { format!("\n{NO_POSES}\n") } else { String::new() };
    terminal::print(&format!("{inspection}\nPoses, if columns mean what they seem to\n{poses}\n{next}"))
}

fn write(path: &Path, draft: &Draft<'_>, poses: &DraftPoses) -> Result<(), Failure> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let text = draft.text(poses, folder);
    clear_abandoned(folder);
    write_atomically(path, text.as_bytes()).map_err(|error| Failure::bad_input(&error))
}

/// Tells whether the session that is written can be read as it is, and what looks wrong in it that has not been told.
fn report_session(path: &Path, draft: &Draft<'_>, poses: &DraftPoses) -> Result<(), Failure> {
    let mut notes = draft.notes();
    let next = match read_session(path) {
        Ok(session) => {
            let count = session.poses.len();
            notes.extend(session.doubts.into_iter().filter(|doubt| Some(doubt.as_str()) != poses.doubt()));
            format!("It can be read, and has {count} poses. Next: gravcal check {}", in_command(path))
        }
        Err(error) => format!("It cannot be read as it is: {error}"),
    };
    let notes: String = notes.iter().map(|note| format!("note: {note}\n")).collect();
    terminal::print(&format!("\n{notes}Session in {}. {next}\n", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn further_recordings_are_shown_as_poses_of_the_session() {
        let files = ["bare.csv", "loaded.csv", "second load.csv"].map(PathBuf::from);
        assert_eq!(only(&files[0], &[]).unwrap(), Path::new("bare.csv"));
        let reported = only(&files[0], &files[1..]).unwrap_err().to_string();
        for expected in [
            "3 recordings are named, and one is inspected at a time",
            "draw up the session from bare.csv;",
            "\n  [[poses]]\n  file = \"loaded.csv\"\n  [[poses]]\n  file = \"second load.csv\"",
        ] {
            assert!(reported.contains(expected), "{reported}");
        }
    }
}
