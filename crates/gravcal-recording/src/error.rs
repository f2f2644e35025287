//! What can be wrong with a recording: each error names the place, what was found, and what to do.

use std::path::{Path, PathBuf};
use std::{fmt, io};

use crate::iso8601::ISO_8601;

use crate::MappingError;
use crate::motion::row_clock::RowClock;

/// One cell of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file, as it was named by whoever asked to read it.
    pub path: PathBuf,
    /// Line in the file, counted from 1.
    pub line: u64,
    /// Name of the column.
    pub column: String,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: column `{}`", self.path.display(), self.line, self.column)
    }
}

/// Why a recording could not be read. Lines are counted from 1.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file does not exist, but its folder does.
    #[error("{}: there is no such file", path.display())]
    NoFile {
        /// The file.
        path: PathBuf,
    },
    /// The file's folder does not exist.
    #[error("{}: there is no such folder as {}", path.display(), folder.display())]
    NoFolder {
        /// The file.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// The operating system refuses.
    #[error("{}: cannot be read: {cause}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        cause: io::Error,
    },
    /// The file is no UTF-8 text.
    #[error("{}:{line}: this is not UTF-8 text; save the table as CSV in UTF-8", path.display())]
    NotUtf8 {
        /// The file.
        path: PathBuf,
        /// The first line with an invalid byte.
        line: u64,
    },
    /// The file holds nothing but comments and blank lines.
    #[error("{}: the file is empty; its first line must name the columns", path.display())]
    NoHeader {
        /// The file.
        path: PathBuf,
    },
    /// The file holds the names of its columns and nothing else.
    #[error("{}: the file has a header but no rows", path.display())]
    NoRows {
        /// The file.
        path: PathBuf,
    },
    /// A column has an empty name.
    #[error("{}:{line}: column {position} of the header has no name; name it or delete it", path.display())]
    NoColumnName {
        /// The file.
        path: PathBuf,
        /// Line of the header.
        line: u64,
        /// Place of the column, counted from 1.
        position: usize,
    },
    /// Two columns have the same name.
    #[error("{}:{line}: the header names column `{column}` twice; rename one{}", path.display(), no_header(&[column]))]
    DuplicateColumn {
        /// The file.
        path: PathBuf,
        /// Line of the header.
        line: u64,
        /// The name.
        column: String,
    },
    /// A row has more or fewer cells than the header.
    #[error("{}:{line}: expected {expected} cells, as in the header, found {found}", path.display())]
    Ragged {
        /// The file.
        path: PathBuf,
        /// Line of the row.
        line: u64,
        /// Cells of the header.
        expected: usize,
        /// Cells of the row.
        found: usize,
    },
    /// The names that are said of the columns are more or fewer than these.
    #[error(
        "{}: its rows have {found} cells, and {} columns are named for files without a header: {}; name as many",
        path.display(), names.len(), listed(names)
    )]
    OtherColumns {
        /// The file.
        path: PathBuf,
        /// The names.
        names: Vec<String>,
        /// Cells of its first row.
        found: usize,
    },
    /// A quoted cell goes on over the end of its line: nearly always a quote that is not closed, which would
    /// otherwise swallow rows.
    #[error("{}:{line}: a cell that begins here goes on over the end of the line; is a quote (\") not closed?", path.display())]
    LineBreak {
        /// The file.
        path: PathBuf,
        /// Line on which the row begins.
        line: u64,
    },
    /// The file has no column of this name.
    #[error("{}: there is no column `{column}`{}; the columns are {}", path.display(), hint(column, columns), listed(columns))]
    UnknownColumn {
        /// The file.
        path: PathBuf,
        /// The name that was asked for.
        column: String,
        /// The names that the file has, in its order.
        columns: Vec<String>,
    },
    /// A cell that should hold a finite number holds something else.
    #[error(
        "{place}: expected a finite number, found `{found}`; leave the cell empty if a reading is missing, and remove a row that gives units or is no reading"
    )]
    NotANumber {
        /// The cell.
        place: Place,
        /// Its text.
        found: String,
    },
    /// The clock is said to be dates with times, and a cell of it is none.
    #[error("{place}: expected a date with a time (ISO 8601) such as 2024-05-01T12:00:00.010Z, found `{found}`")]
    NotADate {
        /// The cell.
        place: Place,
        /// Its text.
        found: String,
    },
    /// The clock holds dates with times and is said to be in another unit, or the other way round.
    #[error("{}: {}", path.display(), clock(column, unit, *dates))]
    OtherClock {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
        /// The unit that its numbers are said to have.
        unit: &'static str,
        /// Whether it holds dates with times.
        dates: bool,
    },
    /// Dates with times are no readings of a sensor.
    #[error("{}: column `{column}` holds dates with times, and no readings: name another column", path.display())]
    DatesAsReadings {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
    },
    /// A condition of the pose is missing.
    #[error("{place}: the cell is empty or NaN, and the model of a sensor needs it; fill it in, or delete the row")]
    NoCondition {
        /// The cell.
        place: Place,
    },
    /// A cell that should say from which side a joint came says something else.
    #[error("{place}: expected 1 (rising), -1 (falling) or 0 (not known), found {found}")]
    NotADirection {
        /// The cell.
        place: Place,
        /// What stands there.
        found: f64,
    },
    /// The rows are not in the order of their times.
    #[error(
        "{place}: the time does not rise from the row before, and a slope over time needs that it does; sort the rows, \
         or delete those that stand twice"
    )]
    TimeStands {
        /// The cell.
        place: Place,
    },
    /// A slope needs two rows.
    #[error(
        "{place}: no other row is within half of the {window} s over which the slope is taken; widen that, or delete the \
         row"
    )]
    NoNeighbour {
        /// The cell with the row's time.
        place: Place,
        /// Time over which the slope is taken, s.
        window: f64,
    },
    /// The limits of motion leave too little.
    #[error(
        "{}: {left} of its {rows} rows keep to the limits of speed and acceleration, and two at least are needed; widen \
         them, or leave the table out",
        path.display()
    )]
    AllInMotion {
        /// The file.
        path: PathBuf,
        /// Its rows.
        rows: usize,
        /// Those that are left.
        left: usize,
    },
    /// The part of the table that counts is empty, or nearly so.
    #[error("{}: {left} of its {rows} rows are between from_s and until_s, and two at least are needed; widen them", path.display())]
    NothingInPart {
        /// The file.
        path: PathBuf,
        /// Its rows.
        rows: usize,
        /// Those in the part.
        left: usize,
    },
    /// There are no samples.
    #[error(
        "{}: no two rows have readings and different times by its clock `{column}`, so that neither rates nor motion can be told; name the column \
         of the times (readings.time = {{ column = \"…\", unit = \"s\" }}), or record them",
        path.display()
    )]
    NothingRecorded {
        /// The file.
        path: PathBuf,
        /// The column of the times.
        column: String,
    },
    /// The arm never stands, or never sweeps slowly.
    #[error(
        "{}: no standstill and no slow sweep is found in it{}; {clock}; {}",
        path.display(),
        reported(rejected),
        clock.advice()
    )]
    NothingStands {
        /// The file.
        path: PathBuf,
        /// What seemed to be one, and why it is none.
        rejected: Vec<String>,
        /// How its rows come.
        clock: Box<RowClock>,
    },
    /// Windows of an arm in motion need times that rise.
    #[error(
        "{}: row {row}: the clock `{column}` runs backwards, from {before:.6} to {after:.6} s, and speeds cannot be told; sort the rows by time, or split \
         the recording where the clock was set",
        path.display()
    )]
    ClockRunsBackwards {
        /// The file.
        path: PathBuf,
        /// The column of the times.
        column: String,
        /// Which row.
        row: u64,
        /// Time of the row before, s.
        before: f64,
        /// Its own time, s.
        after: f64,
    },
    /// A recording of an arm in motion has no times.
    #[error(
        "{}: there is no column `{column}`, and without a clock neither speeds nor standstills can be told; name the column of the times \
         (readings.time = {{ column = \"…\", unit = \"s\" }}), or record them; the columns are {}",
        path.display(),
        listed(columns)
    )]
    NoClock {
        /// The file.
        path: PathBuf,
        /// Where the times are looked for.
        column: String,
        /// What it has.
        columns: Vec<String>,
    },
    /// A joint is suddenly elsewhere.
    #[error(
        "{}: row {row}: `{column}` jumps by {turns:.2} of a turn from the row before, and no joint can; delete the row, or split the \
         recording there; check the unit of readings.position, too",
        path.display()
    )]
    PositionJumps {
        /// The file.
        path: PathBuf,
        /// Which row.
        row: u64,
        /// The column of the joint's positions.
        column: String,
        /// By how many turns.
        turns: f64,
    },
    /// No row of a recording is in the part of it that counts.
    #[error("{}: it lasts {lasts:.3} s, and {}", path.display(), outside(*from, *until))]
    NoRowInPart {
        /// The file.
        path: PathBuf,
        /// First moment of the part, s after the first row.
        from: Option<f64>,
        /// Last moment of it.
        until: Option<f64>,
        /// How long the recording is, s.
        lasts: f64,
    },
    /// Samples are too rare for windows of an arm in motion.
    #[error(
        "{}: {clock}, too seldom for windows of {length} s; {}",
        path.display(),
        clock.cure(&faster_or_longer(*rate, *least))
    )]
    TooSlowForWindows {
        /// The file.
        path: PathBuf,
        /// How its rows come.
        clock: Box<RowClock>,
        /// Length of a window, s.
        length: f64,
        /// The shortest that would do, s.
        least: f64,
        /// The rate that would do, Hz.
        rate: f64,
    },
    /// No part of a recording is as long as a window.
    #[error(
        "{}: it has no {length} s without an interruption, which is one window; {clock}; {}",
        path.display(),
        clock.cure("record longer, without pauses")
    )]
    ShorterThanWindow {
        /// The file.
        path: PathBuf,
        /// Length of a window, s.
        length: f64,
        /// How its rows come.
        clock: Box<RowClock>,
    },
    /// A position reading is missing.
    #[error(
        "{place}: the position is missing, and every torque depends on every position; delete the row, or, where positions and torques \
         have rows of their own (two topics, two rates), let poses be found in the recording (readings.still)"
    )]
    NoPosition {
        /// The cell.
        place: Place,
    },
    /// A part of an orientation is missing.
    #[error("{place}: the cell is empty or NaN, and every reading depends on how the body stood; delete the row")]
    NoOrientation {
        /// The cell.
        place: Place,
    },
    /// The cells of an orientation are no rotation.
    #[error(
        "{place}: expected the orientation of the body, found {found}; check which columns are which, and their order \
         (readings.orientation)"
    )]
    NoRotation {
        /// The first of its cells.
        place: Place,
        /// What they are instead.
        found: String,
    },
    /// A cell that says whether a reading is usable says neither yes nor no.
    #[error("{place}: expected 1 or true (usable), 0 or false (not usable), found `{found}`")]
    NotYesOrNo {
        /// The cell.
        place: Place,
        /// Its text.
        found: String,
    },
    /// A standard deviation is zero, negative, or too small for its mean to have one.
    #[error(
        "{place}: a standard deviation must be greater than 0, found {found}; leave the cell empty if it is unknown"
    )]
    BadStd {
        /// The cell.
        place: Place,
        /// Its number, in the unit of the reading.
        found: f64,
    },
    /// A number of samples is below one.
    #[error("{place}: a number of samples must be at least 1, found {found}")]
    BadCount {
        /// The cell.
        place: Place,
        /// Its number.
        found: f64,
    },
    /// A standard deviation is given, but not of how many samples the reading is the mean.
    #[error(
        "{place}: the number of samples is missing, and the mean's standard deviation depends on it; fill it in, \
         or leave the reading empty"
    )]
    NoCount {
        /// The cell.
        place: Place,
    },
    /// All rows are one pose.
    #[error("{}: a table of one pose cannot identify anything{}; record more poses", path.display(), same(*rows))]
    OnePose {
        /// The file.
        path: PathBuf,
        /// How many rows were merged into the pose.
        rows: u32,
    },
    /// The file is no recording of a kind that can be read.
    #[error("{}: {what}", path.display())]
    NotRecording {
        /// The file.
        path: PathBuf,
        /// What it is instead, and what to do.
        what: String,
    },
    /// No message in the file is one of joint states.
    #[error(
        "{}: it has no messages of joint states (sensor_msgs/JointState) that can be read; {}{}",
        path.display(), topics(found), lost_parts(lost)
    )]
    NoJointStates {
        /// The file.
        path: PathBuf,
        /// Topics that it has, each with its type.
        found: Vec<String>,
        /// What of it is damaged or could not be read, in words.
        lost: Vec<String>,
    },
    /// It has more columns than any recording.
    #[error(
        "{}: it has {found} columns, and no more than {most} are read; leave out those that are no readings of the arm",
        path.display()
    )]
    TooManyColumns {
        /// The file.
        path: PathBuf,
        /// How many it has.
        found: usize,
        /// How many are read.
        most: usize,
    },
    /// A line of a CSV file is longer than any row can be.
    #[error("{}:{line}: the line is longer than {most} bytes; is this a CSV file?", path.display())]
    LongLine {
        /// The file.
        path: PathBuf,
        /// The line.
        line: u64,
        /// The longest that is read, bytes.
        most: usize,
    },
    /// The mapping contradicts itself, whatever the file holds.
    #[error(transparent)]
    Mapping(#[from] MappingError),
}

impl ReadError {
    /// Says why a file cannot be opened: what the operating system calls "not found" may be file or folder.
    pub(crate) fn opening(path: &Path, cause: io::Error) -> ReadError {
        let path = path.to_owned();
        if cause.kind() != io::ErrorKind::NotFound {
            return ReadError::Io { path, cause };
        }
        match missing_folder(&path) {
            Some(folder) => ReadError::NoFolder { path, folder },
            None => ReadError::NoFile { path },
        }
    }
}

/// The folder that `path` stands in, if it does not exist. The folder of a bare file name always does.
pub(crate) fn missing_folder(path: &Path) -> Option<PathBuf> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty())?;
    (!folder.exists()).then(|| folder.to_owned())
}

/// What to do where windows hold too few rows.
fn faster_or_longer(rate: f64, least: f64) -> String {
    format!(
        "record at {:.0} Hz or more, or take longer windows for slower motions: readings.motion = {{ window_s = {:.2} }}",
        rate.ceil(),
        (1e2 * least).ceil() / 1e2
    )
}

/// What of a recording is asked for.
fn outside(from: Option<f64>, until: Option<f64>) -> String {
    let from = from.map(|from| format!("from_s = {from}"));
    let until = until.map(|until| format!("until_s = {until}"));
    let asked: Vec<String> = from.into_iter().chain(until).collect();
    format!("no row of it is in the part that counts ({}): both are seconds after its first row", asked.join(", "))
}

/// What is wrong with the unit of a clock.
fn clock(column: &str, unit: &str, dates: bool) -> String {
    match dates {
        true => format!("the clock `{column}` holds dates with times: its unit is \"{ISO_8601}\", and not {unit}"),
        false => format!(
            "the clock `{column}` holds numbers, and no dates with times: say their unit, such as \"s\", not {unit}"
        ),
    }
}

/// What may be between cells, and how to write it.
pub(crate) const SEPARATORS: &str = "cells are separated by commas, semicolons or tabs, not by spaces: write the table so \
                                     (numpy: np.savetxt(…, delimiter=\",\"))";

/// What may have been meant by the name of a column that does not exist, or what to do.
fn hint(column: &str, columns: &[String]) -> String {
    if let [only] = columns
        && only.contains(' ')
    {
        return format!(" ({SEPARATORS})");
    }
    if !columns.is_empty() && columns.iter().enumerate().all(|(at, name)| *name == format!("column{}", at + 1)) {
        return " (the file has no header: name its columns in the session, [readings.csv] columns = [\"…\", …])"
            .to_owned();
    }
    if let [only] = columns
        && only.contains([';', '\t'])
    {
        return " (cells must be separated by commas)".to_owned();
    }
    let no_header = no_header(columns);
    if !no_header.is_empty() {
        return no_header.to_owned();
    }
    let known: Vec<&str> = columns.iter().map(String::as_str).collect();
    match crate::suggest::nearest_name(column, &known) {
        Some(near) => format!(" (did you mean `{near}`?)"),
        None => String::new(),
    }
}

/// What to do if the "names" of columns are numbers: then the header is missing, or taken for a comment.
fn no_header(columns: &[impl AsRef<str>]) -> &'static str {
    if columns.iter().all(|column| column.as_ref().parse::<f64>().is_ok()) {
        " (if this row holds readings, add a header line before it, one that does not begin with #)"
    } else {
        ""
    }
}

/// The topics of a file in words; of many only the first.
fn topics(found: &[String]) -> String {
    const MOST: usize = 8;
    match found.len() {
        0 => "it has no messages at all".to_owned(),
        count if count > MOST => format!("its topics are {} and {} more", found[..MOST].join(", "), count - MOST),
        _ => format!("its topics are {}", found.join(", ")),
    }
}

/// What is lost of a file of which nothing could be read; of many parts only the first.
fn lost_parts(lost: &[String]) -> String {
    match lost {
        [] => String::new(),
        [only] => format!("; {only}"),
        [first, others @ ..] => format!("; of it is lost: {first}; and {} more parts", others.len()),
    }
}

/// Names in backquotes with commas between.
fn listed(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    quoted.join(", ")
}

/// The first of some messages, in brackets.
fn reported(messages: &[String]) -> String {
    match messages {
        [] => String::new(),
        [first, ..] => format!(" (of {} that seem to be one, the first: {first})", messages.len()),
    }
}

/// Says that a pose is the only one because rows were merged.
fn same(rows: u32) -> String {
    if rows < 2 { String::new() } else { format!(" (its {rows} rows all have the same positions)") }
}
