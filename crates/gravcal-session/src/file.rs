//! Sessions from `session.toml`.
//!
//! ```toml
//! robot = "robot.toml"                       # or { urdf = "arm.urdf", base = "link_0", tip = "link_7" }; tip = [...] for branches
//! estimators = ["sequential", "joint"]       # optional
//! solver = "levenberg-marquardt"             # optional; or [solver] with name and options, such as max_iterations
//!
//! [gravity]
//! magnitude_m_per_s2 = 9.80665               # or latitude_deg and altitude_m
//! magnitude_std_m_per_s2 = 0.001             # optional: exact without it
//! hemisphere = [0, 0, -1]                    # optional: rough direction in base coordinates, settles the sign
//!
//! [inertia]                                  # optional
//! links = "unknown"                          # the default; or "model", with relative_std = 0.1 or by link { link2 = 0.1 }
//! description = "link"                       # the default; or "sweep": a moment for each sweep, lengths are not used
//!
//! [readings]
//! position = { columns = ["q1", "q2"], unit = "deg" }             # std = 0.02: of each reading, taken as exact without
//! torque = { columns = ["y1", ""], unit = "count", std = 0.8 }    # "": no torque sensor
//! # unexplained_std = "estimated" in it: errors beyond that noise, joint by joint from the residuals, as by default of means from
//! # `still` and `sweeps`; or "none", or a number; in the unit of the readings, one for all or a list, as std
//! # with lowest = 0, highest = 4095 in it: readings there or beyond are saturated, and left out
//! # or, where no robot is named and instruments are turned otherwise, how they stood: v_base = R v_body
//! orientation = { columns = ["qx", "qy", "qz", "qw"], order = "xyzw", rotation = "base-from-body" }
//! # order: or "wxyz", or none for the nine columns of a matrix, row by row; rotation: or "body-from-base"
//! sweep_column = "sweep"                     # optional: labels of sweeps
//! merge_repeated_rows = false                # optional: rows of one standstill become one pose
//! time = { column = "t", unit = "s" }        # these where a sensor's model or `select` needs them: one clock for all tables
//! # or unit = "ISO 8601", where cells are dates with times such as 2024-05-01T12:00:00.010Z
//! temperature = { columns = "T", unit = "degC" }                  # one for all joints, or a list
//! velocity = { columns = ["dq1", "dq2"], unit = "deg/s" }
//! # or velocity = { slope_over_s = 0.1 }: of the straight line through the positions that near in time (of the whole width)
//! acceleration = { slope_over_s = 0.1 }      # the same of the velocities; or columns with unit = "rad/s²"
//! direction = { columns = ["d1", "d2"] }     # from which side the joint came: 1 rising, -1 falling, 0 not known
//! further = { oil = "p_oil" }                # columns that only models of sensors know: further[oil] in a formula
//!
//! [readings.select]                          # optional: which readings of an arm in motion count
//! # a row counts where every joint keeps to this: each one's motion is felt in all torques
//! arm = { speed_below = { value = 0.8, unit = "rad/s" }, acceleration_below = { value = [0.5, 1], unit = "rad/s²" } }
//! # a joint's torque reading counts where the joint itself keeps to this; below a least speed no friction has a sign
//! joint = { speed_above = { value = 1, unit = "deg/s" } }
//!
//! [readings.still]                           # optional: the tables are recordings in motion, poses the standstills found in them
//! least_duration_s = 0.1                     # optional: shorter ones are left out; see `gravcal_recording::static_poses`
//!
//! [readings.motion]                          # optional: … or every moment of them counts, by the whole dynamics; may stand beside still
//! window_s = 0.32                            # optional: length of a window, of cut-off 1.6/window_s
//! torque_lag_s = 0.01                        # optional: torques come so much later than positions
//! recorded_filter_hz = 2                     # optional: torques have passed a low-pass filter, and positions have not
//!
//! [readings.sweeps]                          # optional: … or poses are what a joint passes slowly both ways; both may stand
//! bin_deg = 1                                # optional: a pose for each degree of that joint; see `gravcal_recording::slow_sweeps`
//! acceleration_below_rad_per_s2 = 0.05       # optional: so is the square of the speed, in rad/s
//!
//! [readings.csv]                             # optional: how CSV files are written, where that is found wrongly
//! delimiter = ";"                            # or ",", "\t", "|"
//! decimal_comma = true
//! header = false                             # columns are then "column1", "column2", ...
//! columns = ["t", "q1", "q2", "y1", "y2"]    # ... or these; files with a header have its names
//!
//! [[joint]]                                  # optional: what is known of a joint's sensors
//! name = "shoulder"
//! torque_sign = "reversed"                   # "normal" by default; position_sign likewise
//! torque_gain = { nominal = 6.69, unit = "count/(N·m)" }          # only a start
//! position_gain = { fixed = 1, unit = "deg/deg" }                 # exact
//! position_offset = { nominal = 135, std = 2, unit = "deg" }      # known that well
//! sensor_models = [                          # what its sensors do beyond gain and bias: see `gravcal_robot_model::sensors`
//!     { kind = "torque-bias-in-time", parameters = { torque_bias_drift = { nominal = 0, std = 1, unit = "count/s" } } },
//!     { kind = "torque-bias-with-temperature", reference_degC = 25 },
//! ]
//! rotor_inertia = "unknown"                  # of an arm in motion whose torques are its motors'; or what is known of it, in kg·m²
//!
//! [joints]                                   # optional: the same of all joints, where their own tables do not say it, key by key
//! sensor_models = [{ kind = "coulomb-friction" }]
//!
//! [[force_torque_sensor]]                    # optional: six axes on a last link; see `residuals::Wrench` for its signs
//! name = "wrist"
//! link = "forearm"                           # which one, where the robot branches
//! mounting = { position_m = [0, 0, 0.05], rpy_deg = [0, 0, 30] }  # optional: its frame in that link's
//! readings = { columns = ["fx", "fy", "fz", "nx", "ny", "nz"], unit = "count", std = 0.5 }   # as readings.torque
//! sign = "reversed"                          # optional: it reads what the tool exerts on the link, and not the link on the tool
//! gains = "axis"                             # optional: one an axis (the default), or a "matrix"
//! frame = "sensor"                           # optional: in which forces and moments are given (the default), or the "base"
//! biases = "session"                         # optional: one for all tables (the default), or one for each "table": zeroed anew
//! sensor_models = [{ kind = "bias-in-time" }, { kind = "bias-with-temperature", reference_degC = 25 }]   # optional: drifts of biases
//! force_gain = { nominal = 20, std = 1, unit = "count/N" }        # of each axis; as for a joint
//! moment_gain = { nominal = 400, unit = "count/(N·m)" }           # likewise force_bias, moment_bias
//! tool_mass = { fixed = 1.2, unit = "kg" }   # optional: what always hangs beyond it; tool_moment_x, _y, _z in kg·m
//!
//! [[accelerometer]]                          # optional: three axes on a link
//! name = "imu"
//! link = "link1"                             # which one, where there are several
//! mounting = { rpy_deg = [90, 0, 0] }        # optional; so is sign
//! mounting_std_deg = 2                       # optional: exact without it
//! readings = { columns = ["ax", "ay", "az"], unit = "g", std = 0.001 }
//! gain = { nominal = 0.102, unit = "g/(m/s²)" }                   # optional, likewise bias; gains as above
//!
//! [[residual]]                               # optional: what else was observed; see `gravcal_robot_model::residual_models`
//! kind = "dial-gauge"                        # a model that a program adds to gravcal
//! columns = { reading = "dial_m" }           # its columns; beside them stand the options of the model
//!
//! [[load]]                                   # optional
//! name = "plate-a"
//! mass_kg = 1.724
//! link = "link2"
//! position_m = [0, 0, 0.1]                   # optional, with or without position_std_m
//!
//! [[load_distance]]                          # optional; both loads on one link
//! between = ["plate-a", "plate-b"]
//! distance_m = 0.402
//! distance_std_m = 0.0005                    # optional: a micrometre without it
//!
//! [[poses]]                                  # one at least
//! file = "${DATA:-.}/poses-a.csv"
//! load = "plate-a"                           # optional: nothing attached without it
//! swept = "shoulder"                         # optional: found by movement without it
//! step = 2                                   # optional: the step of the sequential procedure that reads it
//! from_s = 10                                # optional, of a recording with a clock: the part that counts, after its first row
//! until_s = 95
//!
//! [[validation]]                             # optional: as [[poses]], but in no fit; what is found predicts them
//! file = "another-day.csv"
//!
//! [deflection]                               # optional: joints are not where their position sensors say
//! hold_std_deg = 0.5                         # those that stand while another sweeps: one unknown each in a sweep
//! pose_std_deg = 0.05                        # those that stand: one unknown each in a pose
//! compliance_std_rad_per_newton_metre = 1e-4 # those that stand: in proportion to their torque; or a list, one for each
//!
//! [loss]                                     # optional: how the joint estimator counts readings far beyond their noise
//! kind = "huber"                             # "none" (the default), "huber", "cauchy", "tukey", "geman-mcclure"
//! width = 1.345                              # optional, in standard deviations: where it begins to count less
//!
//! [uncertainty]                              # optional: where the joint estimator's standard deviations come from
//! kind = "jackknife"                         # "noise" (the default), "jackknife", "sandwich", "bootstrap"
//! block_poses = 10                           # neighbouring poses that may share an error; found by "jackknife", not with "noise"
//! # with "jackknife" also block_s = 1.5 (needs time), blocks = "sweeps", or blocks = "pairs" (the same pose from two sides)
//! replicates = 500                           # optional, with "bootstrap" only; so is seed = 1
//!
//! [constraints]                              # optional: obeyed by the joint estimate, which needs solver = "clarabel"
//! masses = "positive"                        # no link's mass is negative
//! center_of_mass_within_m = 0.3              # of the origin of each link's frame; or by link: { link2 = 0.3 }
//! torque_gains_within = 0.2                  # of their nominal values, relative to these
//!
//! [prior]                                    # optional: what an earlier calibration knows, for the joint estimate
//! calibration = "last-week/calibration.json" # parameters of the same names, with their whole covariance
//! estimator = "joint"                        # optional: whose answer
//! unchanged = ["base", "links", "loads"]     # optional: what is as it was then, besides the sensors
//!
//! [ask]                                      # optional
//! add = ["shoulder.position_offset"]
//! drop = ["shoulder.torque_gain"]
//! ```
//!
//! A link that turns about an axis through its frame's origin can obey both constraints on links by being heavier, which
//! changes no torque if the link before it is adapted. So these matter beside `links = "model"`, for prismatic joints, and
//! where frames lie off their axes.
//!
//! Where a value may differ by joint (`unit`, `std`, `count`) it is one for all or a list with one for each. The noise
//! columns `std_columns`, `count_columns` and `usable_columns` are lists, with `""` where a joint has none.
//!
//! Each section has its own file: what may stand there (a struct for serde) and what it comes to. Numbers carry their
//! unit in the name of the field or in a `unit` beside them; here they become SI and radians.

mod ask;
mod base_frame;
mod conditions;
mod constraints;
mod context;
mod csv;
mod declared;
mod deflection;
mod gravity;
mod inertia;
mod instruments;
mod joints;
mod loads;
mod loss;
mod missing_noise;
mod model_derivatives;
mod models;
#[cfg(test)]
mod models_tests;
mod motion;
mod normal_gravity;
mod orientation;
mod parameter_prior;
mod poses;
mod prior;
mod read_session;
mod reading_columns;
mod readings;
mod recordings;
mod residuals;
mod rotors;
mod select;
mod session_table;
mod single_poses;
mod solver;
mod still;
mod sweeps;
mod swept_speed;
#[cfg(test)]
mod tests;
mod uncertainty;
mod unexplained;
mod wrapped;

pub use context::SessionError;
pub(crate) use instruments::{AccelerometerTable, ForceTorqueTable, Instruments, read_instruments};
pub use read_session::{
    read_session, read_session_document, read_session_in_memory, read_session_watched, read_session_with,
};
pub use solver::{read_solver_options, solver_name_error, solver_option_error};
