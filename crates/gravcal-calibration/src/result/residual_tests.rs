//! Tests on residuals: whether what a fit leaves has a shape that noise has not.

use std::fmt;

use serde::Serialize;

/// One test on the residuals of a channel: a term that the model lacks, or neighbours that are alike.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResidualTest {
    /// `joint3`, or `wrist.fx`; `all joints` where a term is looked for in all at once.
    pub channel: String,
    /// What was looked for.
    #[serde(flatten)]
    pub kind: ResidualTestKind,
    /// Its statistic: F, or Student's t of neighbours.
    pub statistic: f64,
    /// Its degrees of freedom: terms, and what is left to tell their size.
    pub degrees_of_freedom: [f64; 2],
    /// Blocks of neighbouring poses whose scatter told the noise, where neighbours are alike.
    pub blocks: Option<usize>,
    /// Probability of a statistic at least as large if the model is right.
    pub p_value: f64,
    /// The same corrected for the number of tests, by Holm's method.
    pub corrected_p_value: f64,
    /// Size of the term: its coefficient, the amplitude of a harmonic, the largest difference of a table from the mean one; of neighbours
    /// their correlation.
    pub size: f64,
    /// Unit of the size.
    pub unit: String,
    /// What is seen of it in the residuals, root mean square, in standard deviations of one reading.
    pub in_noise: f64,
    /// Whether the corrected p-value tells that it is there.
    pub named: bool,
    /// Whether it is so large that intervals cannot hold.
    pub spoils_intervals: bool,
}

/// What a test on residuals looks for.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum ResidualTestKind {
    /// A reading that drifts with time, or from pose to pose where no time is known.
    Trend,
    /// A reading that drifts, and not evenly.
    TrendCurve,
    /// A reading that drifts within each table.
    TrendInTables,
    /// A reading that drifts and then stays.
    Settling,
    /// Neighbouring poses whose residuals are alike.
    Neighbours,
    /// A reading that depends on its joint's own angle.
    TorqueHarmonic {
        /// Periods a turn.
        order: u32,
    },
    /// A reading that goes with its joint's own position, as if a spring pulled.
    Spring,
    /// A parameter of a joint's sensors that is not what the session states, as fixed or with a standard deviation.
    StatedSensor {
        /// Its name.
        parameter: String,
    },
    /// A coordinate that runs unevenly.
    PositionHarmonic {
        /// Periods a turn.
        order: u32,
    },
    /// A coordinate that gives way under the joint's torque.
    Compliance,
    /// A reading that depends on its joint's speed.
    Velocity,
    /// A reading that depends on its joint's acceleration.
    Acceleration,
    /// A reading that depends on accelerations of other joints.
    AccelerationOfOther {
        /// The joint that the test is of: which sits elsewhere, is tilted, or whose acceleration or torque (crosstalk) shows in the reading; or the axis of an
        /// instrument that does.
        joint: String,
    },
    /// A reading that depends on the side from which its joint came.
    Direction,
    /// Friction of an arm in motion that builds up after its joint turned round.
    Presliding,
    /// A torque reading of an arm in motion that comes later than its positions, or sooner.
    TorqueLag,
    /// A torque reading of an arm in motion that passed a filter that its positions have not passed, or the other way round.
    TorqueFilter,
    /// Gravity, as the base sees it, that is turned in another table: the base stood otherwise.
    Gravity {
        /// The file in which it is turned most.
        file: String,
    },
    /// The mass of a load, which is stated without a standard deviation.
    LoadMass {
        /// Its name.
        load: String,
    },
    /// The place of a load, which is stated without a standard deviation.
    LoadPlacement {
        /// Its name.
        load: String,
    },
    /// The distance of two loads, which is stated without a standard deviation.
    LoadDistance {
        /// Name of the first.
        load: String,
        /// Of a distance of two loads, the name of the second.
        other: String,
    },
    /// Something that pulls at the last link.
    Pull,
    /// A base that gives way under the arm: its turn under the arm's largest moment.
    BaseGivesWay,
    /// A clock that runs fast or slow, of an arm in motion.
    ClockRate,
    /// Where a joint sits on the link before it: lengths are stated without a standard deviation.
    JointPlacement {
        /// The joint that the test is of: which sits elsewhere, is tilted, or whose acceleration or torque (crosstalk) shows in the reading; or the axis of an
        /// instrument that does.
        joint: String,
    },
    /// How a joint is tilted on the link before it: directions of axes are stated without a standard deviation.
    JointTilt {
        /// The joint that the test is of: which sits elsewhere, is tilted, or whose acceleration or torque (crosstalk) shows in the reading; or the axis of an
        /// instrument that does.
        joint: String,
    },
    /// The gain of a torque sensor that is another in another table.
    TorqueGain {
        /// The file that is farthest off.
        file: String,
    },
    /// The gain of a torque sensor that drifts with time, or from pose to pose where no time is known.
    TorqueGainTrend,
    /// A reading of a torque, or of an instrument's axis, that goes with the square or cube of what it senses.
    TorqueNonlinearity,
    /// A reading at an end of its sensor's range, which the session does not state: how far on the mean the true ones are beyond it.
    Saturation,
    /// A torque reading that goes with torques of other joints, or one of an instrument's axis with what its other axes sense.
    Crosstalk {
        /// The joint that the test is of: which sits elsewhere, is tilted, or whose acceleration or torque (crosstalk) shows in the reading; or the axis of an
        /// instrument that does.
        joint: String,
    },
    /// Friction of an arm in motion that grows with the joint's torque.
    LoadFriction,
    /// Friction that grows or falls with time, as gears warm up.
    FrictionTrend,
    /// Friction of an arm in motion that is no line over the speed.
    FrictionCurve {
        /// Speed over which what is more or less than a line falls to a third, rad/s or m/s.
        speed: f64,
    },
    /// The zero of a position sensor that is another in another table.
    PositionOffset {
        /// The file that is farthest off.
        file: String,
    },
    /// A position sensor that reads otherwise on each side from which its joint comes: half the difference, rad.
    Backlash,
    /// A reading that depends on whether what its sensor senses rose or fell from the pose before: half the difference.
    Hysteresis,
    /// A reading that lacks a share of what changed since the pose before, or goes too far by it.
    Creep,
    /// The zero of a position sensor that changes on the way.
    PositionJump {
        /// The file in which it changes.
        file: String,
        /// Row in it about which it changes.
        line: u64,
    },
    /// A reading that is another in another table.
    Tables {
        /// The file that is farthest off.
        file: String,
    },
}

impl fmt::Display for ResidualTestKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ResidualTestKind::Trend => f.write_str("trend"),
            ResidualTestKind::TrendCurve => f.write_str("trend that bends"),
            ResidualTestKind::TrendInTables => f.write_str("trend in each table"),
            ResidualTestKind::Settling => f.write_str("zero that settles"),
            ResidualTestKind::Neighbours => f.write_str("neighbours alike"),
            ResidualTestKind::TorqueHarmonic { order } => write!(f, "torque harmonic {order}"),
            ResidualTestKind::Spring => f.write_str("spring"),
            ResidualTestKind::StatedSensor { parameter } => write!(f, "stated {parameter}"),
            ResidualTestKind::PositionHarmonic { order } => write!(f, "position harmonic {order}"),
            ResidualTestKind::Compliance => f.write_str("compliance"),
            ResidualTestKind::Velocity => f.write_str("velocity"),
            ResidualTestKind::Acceleration => f.write_str("acceleration"),
            ResidualTestKind::AccelerationOfOther { joint } => write!(f, "acceleration of {joint}"),
            ResidualTestKind::Direction => f.write_str("side of approach"),
            ResidualTestKind::Presliding => f.write_str("pre-sliding"),
            ResidualTestKind::TorqueLag => f.write_str("torque lag"),
            ResidualTestKind::TorqueFilter => f.write_str("torque filter"),
            ResidualTestKind::Gravity { file } => write!(f, "gravity ({file})"),
            ResidualTestKind::LoadMass { load } => write!(f, "mass of load {load}"),
            ResidualTestKind::LoadPlacement { load } => write!(f, "place of load {load}"),
            ResidualTestKind::LoadDistance { load, other } => write!(f, "distance of loads {load} and {other}"),
            ResidualTestKind::Pull => f.write_str("pull"),
            ResidualTestKind::BaseGivesWay => f.write_str("base that gives way"),
            ResidualTestKind::ClockRate => f.write_str("clock rate"),
            ResidualTestKind::JointTilt { joint } => write!(f, "tilt of {joint}"),
            ResidualTestKind::JointPlacement { joint } => write!(f, "place of {joint}"),
            ResidualTestKind::TorqueGain { file } => write!(f, "torque gain ({file})"),
            ResidualTestKind::TorqueGainTrend => f.write_str("torque gain trend"),
            ResidualTestKind::TorqueNonlinearity => f.write_str("torque nonlinearity"),
            ResidualTestKind::Saturation => f.write_str("saturation"),
            ResidualTestKind::Crosstalk { joint } => write!(f, "crosstalk ({joint})"),
            ResidualTestKind::LoadFriction => f.write_str("friction by load"),
            ResidualTestKind::FrictionTrend => f.write_str("friction trend"),
            ResidualTestKind::FrictionCurve { .. } => f.write_str("friction by speed"),
            ResidualTestKind::PositionOffset { file } => write!(f, "position offset ({file})"),
            ResidualTestKind::Hysteresis => f.write_str("hysteresis"),
            ResidualTestKind::Creep => f.write_str("creep"),
            ResidualTestKind::Backlash => f.write_str("backlash"),
            ResidualTestKind::PositionJump { file, line } => write!(f, "position jump ({file}:{line})"),
            ResidualTestKind::Tables { file } => write!(f, "tables ({file})"),
        }
    }
}
