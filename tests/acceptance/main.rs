//! What gravcal promises, tried from outside: the program as a user runs it, on the experiments and on wrong input.

#![allow(clippy::unwrap_used, clippy::panic)] // a helper of a test may fail it

mod accuracy;
mod answer;
mod book;
mod branches;
mod by_groups;
mod cluster;
mod comparisons;
mod constraints;
mod deflection;
mod earlier;
mod experiments;
mod exports;
mod extreme_numbers;
mod first_session;
mod imports;
mod instruments;
mod invariants;
mod kept;
mod keys;
mod killed;
mod no_wrong_number;
mod program;
mod real_arm_in_motion;
mod recordings;
mod reference;
mod report_page;
mod reproducible;
#[cfg(feature = "rerun")]
mod rerun;
mod robot_guides;
mod schema;
mod sensor_models;
mod seven_joints;
mod shell;
mod simulators;
mod small_session;
mod solvers;
mod spreadsheet;
mod studies;
mod tree;
#[cfg(not(feature = "rerun"))]
mod without_rerun;
mod wrist_without_joints;
mod wrong_input;
mod wrong_simulation;
