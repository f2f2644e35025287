//! Why a calibration cannot be applied.

/// Why a calibration cannot be applied.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ApplicationError {
    /// It is of another session.
    #[error("the calibration knows no parameter {name} of the session: it is of another session")]
    OtherSession {
        /// The parameter.
        name: String,
    },
    /// A body without joints has neither torques nor angles.
    #[error(
        "the session has no joints, and only their torques and angles are changed in a recording: export the gains of its instruments \
         instead (gravcal export)"
    )]
    NoJoints,
    /// A parameter in another unit: readings in one unit are not turned back by gains of another.
    #[error(
        "{name} is in {there} in the calibration, but in {here} in the session: it is of a session whose sensors are read in another \
         unit"
    )]
    Unit {
        /// The parameter.
        name: String,
        /// Its unit in the calibration.
        there: String,
        /// Its unit in the session.
        here: String,
    },
    /// Parameters without a value.
    #[error("the calibration does not determine {}", names.join(", "))]
    Undetermined {
        /// Their names.
        names: Vec<String>,
    },
    /// A drift goes on with a clock that began with the calibration's recordings.
    #[error(
        "{model} of joint {joint} depends on the time since the session's first pose, which is no guide to another recording: \
         calibrate without {model}"
    )]
    Drift {
        /// The joint.
        joint: String,
        /// The sensor's model.
        model: String,
    },
    /// A sensor's model needs velocities that nothing says.
    #[error(
        "{model} of joint {joint} depends on velocities, and readings.velocity of the session says nothing of them: say velocity = {{ \
         slope_over_s = 0.1 }} in [readings], beside time, or {{ columns = […], unit = \"rad/s\" }}, and give that session by --session"
    )]
    NoVelocities {
        /// The joint.
        joint: String,
        /// The sensor's model.
        model: String,
    },
    /// Joints that give way under their torque.
    #[error(
        "the session estimates compliances ({}), by which the angles of a recording are not corrected: calibrate without \
         compliance_std_rad_per_newton_metre in [deflection]; gravcal export --to csv writes them",
        names.join(", ")
    )]
    Compliance {
        /// Their names.
        names: Vec<String>,
    },
    /// What the calibration found of a joint's readings and the session leaves out.
    #[error(
        "the calibration says that readings depend on {}, of which the session says nothing: it is of a session with other sensor models. \
         Write those models in the session",
        names.join(", ")
    )]
    OtherModels {
        /// The parameters of the calibration.
        names: Vec<String>,
    },
    /// A column of the session is not in the recording.
    #[error("the recording has no column `{column}`, which the session's [readings] name; its columns are {known}")]
    NoColumn {
        /// The column.
        column: String,
        /// Those that there are.
        known: String,
    },
    /// Moments by sweep say nothing of other poses.
    #[error(
        "the session describes moments by sweep, which says nothing of gravity's torque in other poses: calibrate with \
         description = \"link\""
    )]
    BySweep,
    /// Gravity has no value.
    #[error("the calibration does not determine gravity")]
    NoGravity,
    /// Masses and moments are not determined as far as a torque depends on them.
    #[error("the calibration does not determine the masses and moments that gravity's torque depends on at {}", joints.join(", "))]
    NoMoments {
        /// The joints.
        joints: Vec<String>,
    },
    /// A load of unknown mass has no torque of its own here.
    #[error(
        "load `{name}` is of unknown mass, and what is left of torques without it cannot be told yet: state the mass that the calibration \
         found (mass_kg), and calibrate again"
    )]
    UnknownLoad {
        /// The name.
        name: String,
    },
    /// There is no such load.
    #[error("the session has no load `{name}`; it has {known}")]
    NoLoad {
        /// The name.
        name: String,
        /// Those that there are.
        known: String,
    },
}
