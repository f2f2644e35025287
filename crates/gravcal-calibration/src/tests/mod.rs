//! What several layers come to together: from sessions, simulated or recorded, to results.

mod bending;
mod branches;
mod by_groups;
mod consistent_inertias;
mod deflections;
mod descriptions;
mod drafted_wrist;
mod friction_in_tables;
mod instrumented;
mod known_in_motion;
mod left_out;
mod moving_arm;
mod one_sided;
mod payloads;
mod reference;
mod repeated;
mod robustness;
mod sensor_models;
mod simulated_motion;
mod slow_sweeps;
mod stuck;
mod unexplained_errors;
mod unstated_noise;
mod weighed_loads;
mod wrist_by_hand;
