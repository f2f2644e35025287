//! What hangs on that which the session takes as exact.
//!
//! Lengths of the robot, directions of its axes, masses of loads and places of theirs, the strength of gravity, the stiffness of joints, mountings of instruments, position sensors that are not eccentric, zeros and gains of torque sensors that are the same in all
//! tables, friction that is the same both ways, the rate of the clock: what is wrong of them passes for gains and offsets, so that residuals need not show it.
//! By each `Δ` that an error of a usual size moves a number, it is off by `√(Σ Δ²)` in all.

use gravcal_estimation::BlockId;
use gravcal_estimation::statistics::{StatisticsError, moved_by};
use gravcal_robot_model::number::significant;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};

use super::search::Search;
use super::terms::{Elastic, Harmonic, Recorder, SensorGain, SensorZero, Stated, Surroundings, Term};
use super::uneven_friction::{UNEVEN, friction_in_poses};
use crate::joint::{is_stiffness_unsaid, is_strength_guessed};
use crate::judgement::{Asked, Judgement};
use crate::result::{ResidualTest, ResidualTestKind, TakenAsExact};

/// Share by which a load is heavier than stated, with the screws and the scale's error, and with gravity where nobody looked its strength up.
const HEAVIER: f64 = 5e-3;
/// What a hose or a cable pulls with that nobody has taken off, N.
const PULLS: f64 = 0.1;
/// How far joints and loads are from where nobody has measured, m.
const ASIDE: f64 = 1e-3;
/// By how much axes are tilted where nobody has measured, rad.
const TILTED: f64 = 0.05 * std::f64::consts::PI / 180.0;
/// By how much a joint bends under the largest torque that it carries, rad.
const BENDS: f64 = 0.05 * std::f64::consts::PI / 180.0;
/// By how much an instrument is turned against its mounting where nobody has measured, rad.
const TURNED: f64 = 0.2 * std::f64::consts::PI / 180.0;
/// How far an eccentric position sensor is off, to either side once over a turn, rad.
const ECCENTRIC: f64 = 0.05 * std::f64::consts::PI / 180.0;
/// By how much the zero of a torque sensor is another in the next recording, in what its readings span; of more tables it is not asked.
const SHIFTED: f64 = 1e-3;
/// By what share its gain is, as the arm grows warmer.
const STRONGER: f64 = 5e-4;
const MOST_TABLES: usize = 6;
/// By how much a cable or a hose pulls at a joint like a spring at the ends of what it moves, in what its torque readings span.
const SPRUNG: f64 = 1e-3;
/// By how much a base leans under the largest moment of the arm, rad.
const LEANS: f64 = 0.05 * std::f64::consts::PI / 180.0;
/// By what share a clock runs fast that nobody has compared.
const FAST: f64 = 1e-3;
/// By how many of its standard deviations that must move a number to be worth a remark.
const REMARKABLE: f64 = 2.0;

/// Something that is taken as exact.
struct Exact {
    /// If it were as wrong as is usual.
    wrong: String,
    /// What to do about it.
    cure: &'static str,
    /// What that does to the whitened residuals.
    columns: Vec<Vec<f64>>,
    /// Numbers that would be others themselves, not off.
    itself: Option<Itself>,
}

/// Numbers that would be others themselves.
#[derive(Clone, Copy, PartialEq)]
enum Itself {
    /// This parameter of each joint's sensors.
    Sensors(SensorParameter),
    Gravity,
}

impl Search<'_> {
    /// Which number that is told hangs most on each of them, where it hangs on it much. `tests`: what is named there, intervals include already;
    /// `moved`: what is missing moves each column by, which widens them.
    pub fn taken_as_exact(
        &self,
        judgement: &Judgement,
        (tests, moved): (&[ResidualTest], &[Vec<f64>]),
    ) -> Result<Vec<TakenAsExact>, StatisticsError> {
        let included = |of_kind: &dyn Fn(&ResidualTestKind) -> bool| {
            tests.iter().any(|test| test.named && test.spoils_intervals && of_kind(&test.kind))
        };
        let exact = [
            (!included(&|kind| matches!(kind, ResidualTestKind::JointPlacement { .. }))).then(|| self.lengths()),
            (!included(&|kind| matches!(kind, ResidualTestKind::JointTilt { .. }))).then(|| self.axes()),
            (!included(&|kind| matches!(kind, ResidualTestKind::LoadMass { .. }))).then(|| self.masses_of_loads()),
            (!included(&|kind| matches!(kind, ResidualTestKind::LoadPlacement { .. }))).then(|| self.places_of_loads()),
            (!included(&|kind| matches!(kind, ResidualTestKind::LoadDistance { .. }))).then(|| self.distances()),
            self.pulls(
                !included(&|kind| matches!(kind, ResidualTestKind::Pull)),
                !included(&|kind| matches!(kind, ResidualTestKind::Spring)),
            ),
            (!included(&|kind| matches!(kind, ResidualTestKind::Compliance))).then(|| self.stiffness()),
            Some(self.mountings()),
            (!included(&|kind| matches!(kind, ResidualTestKind::Tables { .. }))).then(|| self.zeros()),
            (!included(&|kind| {
                matches!(kind, ResidualTestKind::TorqueGain { .. } | ResidualTestKind::TorqueGainTrend)
            }))
            .then(|| self.gains()),
            (!included(&|kind| matches!(kind, ResidualTestKind::PositionHarmonic { .. })))
                .then(|| self.position_sensors()),
            Some(self.friction()),
            (!included(&|kind| matches!(kind, ResidualTestKind::BaseGivesWay))).then(|| self.base()),
            (!included(&|kind| matches!(kind, ResidualTestKind::ClockRate))).then(|| self.clock()),
        ];
        let mut taken = Vec::new();
        for Exact { wrong, cure, columns, itself } in exact.into_iter().flatten() {
            if let Some((parameter, off_in_std)) = self.moved_most(judgement, &columns, itself, moved)? {
                taken.push(TakenAsExact { wrong, parameter, off_in_std, cure: cure.to_owned() });
            }
        }
        Ok(taken)
    }

    fn lengths(&self) -> Exact {
        Exact {
            wrong: format!(
                "each joint were {} mm off, along x, y and z, from where the robot's description has it",
                1e3 * ASIDE
            ),
            cure: "state [inertia] length_std_m",
            columns: self.all_aside(|term| matches!(term, Term::Stated(Stated::JointPlacement(_))), ASIDE),
            itself: None,
        }
    }

    fn axes(&self) -> Exact {
        Exact {
            wrong: format!(
                "each joint's axis were tilted by {}° in both directions across it",
                significant(TILTED.to_degrees(), 1)
            ),
            cure: "state [inertia] axis_std_deg",
            columns: self.all_aside(|term| matches!(term, Term::Stated(Stated::JointTilt(_))), TILTED),
            itself: None,
        }
    }

    /// All by the same share, as one scale weighed them: which is what a stronger gravity does, too.
    fn masses_of_loads(&self) -> Exact {
        let percent = significant(100.0 * HEAVIER, 1);
        let loads = self.session.loads.iter().enumerate();
        let heavier =
            loads.flat_map(|(load, stated)| self.aside(Term::Stated(Stated::LoadMass(load)), HEAVIER * stated.mass));
        let together = heavier.reduce(|sum, own| sum.iter().zip(&own).map(|(a, b)| a + b).collect());
        let (or, cure) = match is_strength_guessed(self.session) {
            false => ("", "state mass_kg = { nominal = …, std = … }"),
            true => (", or gravity stronger,", "state mass_kg = { nominal = …, std = … } and latitude_deg"),
        };
        let wrong = format!("all loads were {percent} % heavier{or} than stated");
        Exact { wrong, cure, columns: together.into_iter().collect(), itself: None }
    }

    fn places_of_loads(&self) -> Exact {
        Exact {
            wrong: format!("each load were {} mm off, along x, y and z, from where position_m says", 1e3 * ASIDE),
            cure: "state position_std_m of the load",
            columns: self.all_aside(|term| matches!(term, Term::Stated(Stated::LoadPlacement(_))), ASIDE),
            itself: None,
        }
    }

    fn distances(&self) -> Exact {
        Exact {
            wrong: format!("each distance of two loads were {} mm more than distance_m says", 1e3 * ASIDE),
            cure: "state std_m beside distance_m",
            columns: self.all_aside(|term| matches!(term, Term::Stated(Stated::LoadDistance(_))), ASIDE),
            itself: None,
        }
    }

    /// A hose that hangs from the arm, and cables along it, which are bent and stretched as it moves.
    fn pulls(&self, at_last_link: bool, at_joints: bool) -> Option<Exact> {
        let hose = self.all_aside(|term| at_last_link && *term == Term::Surroundings(Surroundings::Pull), PULLS);
        let of_joint = |joint: usize| {
            let pull = SPRUNG * self.solved.readings().spreads[joint];
            let off = move |column: Vec<f64>| column.into_iter().map(|entry| pull * entry).collect();
            Term::Elastic(Elastic::Spring).columns(&self.columns, joint).into_iter().map(off)
        };
        let cables: Vec<Vec<f64>> = (0..self.session.joints.len()).filter(|_| at_joints).flat_map(of_joint).collect();
        let by_hose = format!("a hose pulled at the last link ({PULLS} N along each axis)");
        let by_cables = format!("at each joint ({} % of its torque range)", significant(100.0 * SPRUNG, 1));
        let wrong = match (hose.is_empty(), cables.is_empty()) {
            (false, false) => format!("{by_hose} and cables {by_cables}"),
            (false, true) => by_hose,
            (true, false) => format!("cables pulled {by_cables}"),
            (true, true) => return None,
        };
        let columns = [hose, cables].concat();
        Some(Exact { wrong, cure: "take them off", columns, itself: None })
    }

    /// All that is stated of one kind, as far off.
    fn all_aside(&self, of_kind: impl Fn(&Term) -> bool, off: f64) -> Vec<Vec<f64>> {
        let terms = Term::of_arm(&self.columns).into_iter();
        terms.filter(of_kind).flat_map(|term| self.aside(term, off)).collect()
    }

    /// Of joints of which nothing says how they bend.
    fn stiffness(&self) -> Exact {
        let in_motion = self.session.has_windows();
        let unsaid = is_stiffness_unsaid(self.session) || (in_motion && !self.session.deflection.stiff);
        let may_bend = |joint: &usize| unsaid && !self.solved.has_bending(*joint);
        let joints = (0..self.session.joints.len()).filter(may_bend);
        Exact {
            wrong: format!("each joint bent by {}° under its largest torque", significant(BENDS.to_degrees(), 1)),
            cure: match in_motion {
                false => "state [deflection] compliance_std_rad_per_newton_metre",
                true => "record standstills (readings.still), and calibrate them by themselves with [deflection]",
            },
            columns: joints.flat_map(|joint| self.bent(joint)).collect(),
            itself: None,
        }
    }

    /// A joint that bends; nothing of one that carries no torque, or slides.
    fn bent(&self, joint: usize) -> Vec<Vec<f64>> {
        let largest = self.columns.torques.iter().map(|pose| pose[joint].abs()).fold(0.0, f64::max);
        let by = BENDS / largest;
        let bent = |column: Vec<f64>| column.into_iter().map(|entry| by * entry).collect();
        match self.columns.slides(joint) || largest == 0.0 {
            true => Vec::new(),
            false => Term::Elastic(Elastic::Compliance).columns(&self.columns, joint).into_iter().map(bent).collect(),
        }
    }

    /// Alike whichever way the moment points. Gravity is told as the base sees it on the mean of the poses.
    fn base(&self) -> Exact {
        Exact {
            wrong: format!("the base leaned by {}° under the arm's largest moment", significant(LEANS.to_degrees(), 1)),
            cure: "bolt it to what does not give way",
            columns: self.all_aside(|term| *term == Term::Surroundings(Surroundings::BaseGivesWay), LEANS),
            itself: Some(Itself::Gravity),
        }
    }

    /// Of an arm in motion.
    fn clock(&self) -> Exact {
        Exact {
            wrong: format!("the clock ran {} % fast", significant(100.0 * FAST, 1)),
            cure: "record the times of the controller that samples the readings",
            columns: self.all_aside(|term| *term == Term::Recorder(Recorder::ClockRate), FAST),
            itself: None,
        }
    }

    fn mountings(&self) -> Exact {
        let turned = self.columns.turned_instruments.iter();
        Exact {
            wrong: format!(
                "each instrument were turned by {}° against its mounting, about each axis",
                significant(TURNED.to_degrees(), 1)
            ),
            cure: "measure the mounting; of an accelerometer state mounting_std_deg",
            columns: turned.map(|column| column.iter().map(|entry| TURNED * entry).collect()).collect(),
            itself: None,
        }
    }

    /// A term that another table than the first may have of each joint, by so much.
    fn in_other_tables(&self, term: Term, other: impl Fn(usize) -> f64) -> Vec<Vec<f64>> {
        let few = self.columns.tables_of_all().len() <= MOST_TABLES;
        let of_joint = |joint: usize| {
            let other = other(joint);
            let of_table = move |column: Vec<f64>| column.into_iter().map(|entry| other * entry).collect();
            term.columns(&self.columns, joint).into_iter().map(of_table)
        };
        (0..self.session.joints.len()).filter(|_| few).flat_map(of_joint).collect()
    }

    /// Of torque sensors, in another table than the first.
    fn gains(&self) -> Exact {
        Exact {
            wrong: format!(
                "the gain of each torque sensor were another in each file, by {} %",
                significant(100.0 * STRONGER, 1)
            ),
            cure: "record poses with and without load by turns, with a warm arm",
            columns: self.in_other_tables(Term::Gain(SensorGain::InTables), |_| STRONGER),
            itself: None,
        }
    }

    /// Of torque sensors, in another table than the first.
    fn zeros(&self) -> Exact {
        Exact {
            wrong: format!(
                "the zero of each torque sensor were another in each file, by {} % of what its readings span",
                significant(100.0 * SHIFTED, 1)
            ),
            cure: "record poses with and without load by turns, in one recording",
            columns: self.in_other_tables(Term::Zero(SensorZero::InTables), |joint| {
                SHIFTED * self.solved.readings().spreads[joint]
            }),
            itself: Some(Itself::Sensors(SensorParameter::TorqueBias)),
        }
    }

    /// Position sensors that have no terms beside gain and offset.
    fn position_sensors(&self) -> Exact {
        let modelled = |joint: usize| self.session.terms.of_positions().any(|term| term.joint == joint);
        let joints = (0..self.session.joints.len()).filter(|joint| !modelled(*joint));
        let off = |column: Vec<f64>| column.into_iter().map(|entry| ECCENTRIC * entry).collect();
        Exact {
            wrong: format!(
                "each position sensor were eccentric (up to {}° off to either side, once over a turn)",
                significant(ECCENTRIC.to_degrees(), 1)
            ),
            cure: match self.session.has_windows() {
                false => "name { kind = \"position-harmonics\", orders = [1] } in sensor_models of the joints",
                true => "what is read in motion does not tell it: calibrate position-harmonics from static poses",
            },
            columns: joints.flat_map(|joint| self.eccentric(joint)).map(off).collect(),
            itself: None,
        }
    }

    /// A radian off to either side once over a turn; nothing of a joint that slides.
    fn eccentric(&self, joint: usize) -> Vec<Vec<f64>> {
        match self.columns.slides(joint) {
            true => Vec::new(),
            false => Term::Harmonic(Harmonic::Position(1)).columns(&self.columns, joint),
        }
    }

    /// Of joints that come both ways.
    fn friction(&self) -> Exact {
        // A torque as large as a joint's friction, the same whichever way it moves.
        let of_joint = |joint: usize| {
            let friction = friction_in_poses(&self.columns, joint);
            let known = friction.iter().any(|friction| *friction != 0.0);
            known.then(|| self.columns.reading(joint, |pose| friction[pose]))
        };
        let off = |column: Vec<f64>| column.into_iter().map(|entry| UNEVEN * entry).collect();
        Exact {
            wrong: format!(
                "friction of each joint were {} % more one way than the other",
                significant(200.0 * UNEVEN, 1)
            ),
            cure: "no reading tells it from a bias: state torque_bias with its std where a sensor's zero is known",
            columns: (0..self.session.joints.len()).filter_map(of_joint).map(off).collect(),
            itself: None,
        }
    }

    /// The number that is told which all of them together move most, by how many of its standard deviations; nothing where that is not worth a remark.
    fn moved_most(
        &self,
        judgement: &Judgement,
        columns: &[Vec<f64>],
        itself: Option<Itself>,
        missing: &[Vec<f64>],
    ) -> Result<Option<(String, f64)>, StatisticsError> {
        if columns.is_empty() {
            return Ok(None);
        }
        let moved = moved_by(&self.solution, &self.weighted(columns.to_vec()))?;
        let squares =
            |of: &[Vec<f64>], column: usize| of.iter().map(|moved| moved[column] * moved[column]).sum::<f64>();
        let off = |block: BlockId| {
            let times = |column: usize| {
                let variance = self.solved.covariance().std(column).powi(2) + squares(missing, column);
                if variance > 0.0 { (squares(&moved, column) / variance).sqrt() } else { 0.0 }
            };
            self.solution.problem.columns_of(block).map(times).fold(0.0, f64::max)
        };
        let variables = &self.solved.built.variables;
        let is_itself =
            |id: &ParameterId| matches!(id, ParameterId::Sensor(_, own) if itself == Some(Itself::Sensors(*own)));
        let told = self.session.parameters().into_iter().filter(|id| judgement.determines(*id) && !is_itself(id));
        let told = told.map(|id| (self.session.parameter_name(id), off(variables.block(id))));
        let gravity = judgement.determines(Asked::Gravity) && itself != Some(Itself::Gravity);
        let gravity = gravity.then(|| ("gravity".to_owned(), off(variables.gravity)));
        let most = told.chain(gravity).max_by(|a, b| a.1.total_cmp(&b.1));
        Ok(most.filter(|(_, times)| *times > REMARKABLE && times.is_finite()))
    }
}
