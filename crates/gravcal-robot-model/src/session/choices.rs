//! What a session chooses of the model and the estimate.

/// How far joints may be from where their position sensors say, before any torque is read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deflection {
    /// Standard deviation of the deflection of each joint that stands, the same in all poses of a sweep, rad.
    pub hold_std: Option<f64>,
    /// Standard deviation of what rounding leaves of the angle of each joint that stands, the same in all poses of a sweep, rad; empty where
    /// nothing is known of it. A position sensor that rounds more than its noise says one number all through a sweep.
    pub rounding_std: Vec<f64>,
    /// Standard deviation of the deflection of each joint that stands, another in each pose, rad.
    pub pose_std: Option<f64>,
    /// Standard deviation of each joint's position reading, unit of the reading; 0 (or missing) where taken as exact.
    pub reading_std: Vec<f64>,
    /// Place of the first joint's compliance in [`Session::further`](crate::Session::further), where joints give way; see
    /// [`Session::let_joints_give_way`](crate::Session::let_joints_give_way).
    pub compliance: Option<usize>,
    /// Whether joints are said not to bend under their torque.
    pub stiff: bool,
}

impl Deflection {
    /// Of a joint that stands in a sweep, rad.
    pub fn sweep_std(&self, joint: usize) -> f64 {
        self.hold_std.unwrap_or(0.0).hypot(self.rounding_std.get(joint).copied().unwrap_or(0.0))
    }

    /// Whether joints that stand in a sweep may be elsewhere than their sensors say all through it.
    pub fn holds(&self) -> bool {
        self.hold_std.is_some() || self.rounding_std.iter().any(|std| *std > 0.0)
    }
}

/// Where the joint estimator's standard deviations come from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum UncertaintyChoice {
    /// From the noise of the readings: the model holds. Where the readings contradict that, the larger of it, widened, and of what
    /// leaving out blocks of neighbouring poses tells.
    #[default]
    Noise,
    /// From what the estimate would be without each of some blocks of poses, which may share errors of the model.
    Jackknife {
        /// Which.
        blocks: PoseBlocks,
    },
    /// From the scatter of blocks of neighbouring poses, which may share errors of the model.
    Sandwich {
        /// Poses in a block, at least.
        block_poses: usize,
    },
    /// From solving again with such blocks drawn at random.
    Bootstrap {
        /// Poses in a block, at least.
        block_poses: usize,
        /// How often.
        replicates: usize,
        /// Which random numbers.
        seed: u64,
    },
}

/// Which poses may share an error of the model. Those of different tables never do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum PoseBlocks {
    /// Neighbouring ones, as many as their residuals say.
    #[default]
    Found,
    /// So many neighbouring ones, at least.
    Poses(usize),
    /// Neighbouring ones within so many seconds.
    Seconds(f64),
    /// Those of one sweep; each of no sweep is alone.
    Sweeps,
    /// Neighbouring ones in which every joint stands as in the first: the same pose, come to from different sides.
    Pairs,
}

/// What the joint estimate must obey, whatever the readings say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Constraints {
    /// Whether no link's mass may be negative.
    pub positive_masses: bool,
    /// Largest distance, m, of a link's centre of mass from the origin of its frame, by link; links beyond the end have none.
    pub center_of_mass_within: Vec<Option<f64>>,
    /// Largest difference of a torque gain from its nominal value, as a share of that.
    pub torque_gains_within: Option<f64>,
    /// Whether the links' inertias are also told as rigid bodies can have them. It constrains that model alone, not the estimate.
    pub physical_inertias: bool,
}

impl Constraints {
    /// Whether nothing is demanded of the estimate.
    pub fn is_empty(&self) -> bool {
        let radii = self.center_of_mass_within.iter().any(Option::is_some);
        !(self.positive_masses || radii || self.torque_gains_within.is_some())
    }

    /// Largest distance of a link's centre of mass from its frame's origin, m.
    pub fn radius(&self, link: usize) -> Option<f64> {
        self.center_of_mass_within.get(link).copied().flatten()
    }
}

/// Changes to what is asked for; names such as `joint1.torque_gain`, `gravity`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ask {
    /// Asked for besides the default.
    pub add: Vec<String>,
    /// Not asked for.
    pub drop: Vec<String>,
}

/// How the errors of a channel's readings are taken that their noise does not explain: as one more normal error of each reading, of
/// the same standard deviation in all.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum UnexplainedError {
    /// There are none: readings scatter by their noise alone.
    #[default]
    Absent,
    /// The residuals tell how large they are.
    Estimated,
    /// They are known.
    Stated {
        /// Standard deviation, unit of the reading.
        std: f64,
    },
}
