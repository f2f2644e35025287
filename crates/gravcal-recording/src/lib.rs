//! Recordings in and out: tables of static poses with units.
//!
//! A *static pose* is one standstill of a robot: the position reading of every joint, and the torque reading of
//! those joints that have one. Recordings are CSV files, one row a standstill; a [`PoseMapping`] says which column
//! is which reading and in which unit, and [`read_poses`] gives the poses in SI units:
//!
//! ```text
//! CSV file ── Table ──(PoseMapping)──► Vec<StaticPose>          [Cell] ── write_table ──► CSV file
//! ```
//!
//! **Conventions.** Inside the program angles are radians and lengths metres; degrees and millimetres become those
//! here and nowhere else. Readings whose unit is the sensor's own (count, V) stay as they are. A missing torque
//! reading is an empty cell; `nan` is an error, because a program that fails to read a sensor writes it too.
//!
//! **What is refused.** Whatever a file may hold, reading it gives poses or a [`ReadError`] that names the file, the
//! line, the column, what was found and what to do. Nothing is skipped silently, and no file is left half written.
//!
//! ```
//! use gravcal_recording::*;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("poses.csv");
//! write_atomically(&path, b"q1_deg,tau1,samples\n90,2075,16\n-90,,16\n")?;
//!
//! let torque = ReadingColumn {
//!     column: "tau1".to_owned(),
//!     std: Some(0.8), // of one sample, as there is a count
//!     count_column: Some("samples".to_owned()),
//!     ..ReadingColumn::default()
//! };
//! let mapping = PoseMapping {
//!     positions: vec![PositionColumn::new("q1_deg", "deg".parse()?)],
//!     torques: vec![Some((torque, "count".parse()?))],
//!     ..PoseMapping::default()
//! };
//! let poses = read_poses(&path, &mapping)?.poses;
//! assert_eq!(poses[0].position, [std::f64::consts::FRAC_PI_2]);
//! assert_eq!(poses[0].torque, [Some(Reading { value: 2075.0, std: Some(0.2) })]);
//! assert_eq!(poses[1].torque, [None]);
//! # Ok(())
//! # }
//! ```
//!
//! What an earlier `calibration.json` says is read here too, as names, numbers and their covariance ([`read_earlier`]).
//!
//! A recording of an arm in motion is read row by row ([`open`]), and [`static_poses`] finds where the arm stands.
//!
//! The crate knows no robot: a joint is a place in a list. It filters nothing and weighs nothing; only when the mapping asks
//! for it, it takes means of repeated rows and slopes over time, and leaves out readings by the motion of the arm.

mod column_names;
mod columns;
mod conditions;
mod counted;
mod csv_lines;
mod digest;
mod earlier;
mod error;
mod file;
mod input_role;
mod iso8601;
mod mapping;
mod mapping_error;
mod memory;
mod merge;
mod motion;
mod orientation;
mod pose;
mod presliding;
mod rows;
mod selection;
mod slope;
mod slopes_ahead;
mod static_pose;
mod still;
mod suggest;
mod sweep;
mod table;
mod turns;
mod unit;
mod windows;
mod write;
mod write_files;
mod write_table;
mod write_temporary;

pub use columns::is_saturated;
pub use conditions::{
    ConditionColumn, ConditionColumns, ConditionUnit, Conditions, FurtherColumn, MotionSource, Slope,
};
pub use counted::counted;
pub use csv_lines::CsvWriting;
pub use digest::{Digest, DigestError};
pub use earlier::{
    EarlierError, EarlierEstimate, EarlierInertia, EarlierInput, EarlierNumber, EarlierParameter, EarlierPayload,
    EarlierQuantity, read_earlier, read_earlier_estimators, read_earlier_inputs, read_earlier_session,
};
pub use error::{Place, ReadError};
pub use file::{LARGEST_DOCUMENT, LARGEST_RESULTS, file_name, holds, in_command, read_whole};
pub use input_role::InputRole;
pub use mapping::{PoseMapping, PositionColumn, ReadingColumn};
pub use mapping_error::MappingError;
pub use memory::{Memory, Numbers, NumbersError};
pub use motion::reader::Part;
pub use motion::row_clock::RowClock;
pub use orientation::{Orientation, OrientationColumns, OrientationForm};
pub use pose::{Recording, read_part, read_poses};
pub use presliding::{DahlFriction, Presliding};
pub use rows::{
    Change, CheckedFile, Clipped, ColumnFound, Gap, Guess, Heading, Inspection, JointFound, Meaning, RewriteError,
    Rewriting, Row, RowWriter, Rows, Source, Stuck, TimeFound, Topic, Watch, Watched, are_same_numbers, column_numbers,
    create, inspect, inspect_as, named_joint, open, open_as, open_parquet, rewrite, shielded_parquet,
};
pub use selection::{MotionLimits, Selection};
pub use slopes_ahead::SlopesAhead;
pub use static_pose::{Reading, StaticPose};
pub use still::{
    Reason, Rejected, RemainingSettling, Settling, Spread, Standstill, Standstills, Stillness, static_poses,
};
pub use suggest::nearest_name;
pub use sweep::{
    RejectedStroke, SparseBins, StrokeReason, Sweep, SweepRule, Sweeps, SweptBin, Travel, WIDEST_BIN, slow_sweeps,
};
pub use table::Table;
pub use turns::{unwrapped, within_turn};
pub use unit::{PositionUnit, TorqueUnit, UnknownUnit};
pub use windows::{
    Clock, Course, FILTER_LENGTH, Kept, MotionSample, MotionWindow, MotionWindows, WeighedStretch, WindowRule,
    motion_windows,
};
pub use write::{NewFile, WriteError, write_atomically};
pub use write_files::NewFiles;
pub use write_table::{Cell, table_contents, write_table};
pub use write_temporary::{clear_abandoned, is_temporary};
