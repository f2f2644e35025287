//! What recordings of a line are like, and the simulation of one.

use clap::ValueEnum;
use gravcal_robot_model::parameter::SensorParameter;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;

use crate::arms::Arm;

/// Standard deviation of a sample of torque, N·m, and of a position, rad.
const TORQUE: f64 = 0.03;
const POSITION: f64 = 1e-5;
/// Samples of a dwell: 1.5 s at 200 Hz.
const DWELL: usize = 300;
/// Time from pose to pose of an arm that stands, with settling, and of the motion, s.
const PERIOD: f64 = MOVE + 0.3 + 1.5;
const MOVE: f64 = 1.5;
/// Poses between which the load is said to be there in the line `label-some`.
const SOME: [f64; 2] = [11.0, 14.0];
/// Of an arm in motion: samples of a stretch, and stretches of a table.
const STRETCH: usize = 4000;
const STRETCHES: usize = 2;

/// Postures in which each joint sweeps, how far, rad, and how far from the middle it and others may stand.
const POSTURES: usize = 3;
const REACH: f64 = 0.9;
const MIDDLE: f64 = 0.6;
const HELD: f64 = 1.5;
/// Width of the bins of sweeps: 100 samples at 4° a second, and the curvature of a torque over them changes it by a 20,000th.
const BIN_DEG: f64 = 2.0;

/// Kinds of recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Line {
    /// Random poses, joints come from both sides.
    Still,
    /// The same, and the session estimates Coulomb friction.
    Coulomb,
    /// Every joint always rises to its pose.
    OneWay,
    /// Every pose from both sides.
    Pairs,
    /// From pose to pose one joint moves, and the others stand; 60 bare and 60 loaded poses.
    OneMoves,
    /// Friction grows by 0.02 of the torque.
    Load,
    /// Nine bare and nine loaded poses.
    Few,
    /// Dwells of 6 s.
    Long,
    /// Torque readings with noise that is correlated over 1 s.
    Coloured,
    /// Zeros walk by 0.05 N·m over a recording.
    Walk,
    /// Zeros drift by 0.05 N·m over a recording.
    Drift,
    /// Torque sensors lack 0.05 N·m where their torque rose last, and read as much more where it fell, from a change of 1 N·m on.
    Hysteresis,
    /// Torque sensors lack 0.3 % of each change of their torque, which dies away over 3 s.
    Creep,
    /// Position readings with a harmonic of 1e-3 rad.
    Harmonics,
    /// Joints sag by 1e-4 rad for each N·m, which their sensors do not see.
    Elastic,
    /// The torque columns of two joints are swapped.
    Swapped,
    /// A torque column is read with the wrong sign, which the session declares to be right.
    Reversed,
    /// The bare poses are said to carry the load.
    Label,
    /// Three of the bare poses, in the middle, are said to carry the load.
    LabelSome,
    /// Positions are in radians and said to be in degrees.
    Degrees,
    /// Positions are in degrees and said to be in radians.
    Radians,
}

/// Where poses come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Source {
    /// Standstills of a recording
    Standstills,
    /// Slow sweeps: every joint in three postures, bare and loaded
    Sweeps,
    /// The means of the standstills as a table, without standard deviations
    Table,
    /// Windows of an arm that never stands (lines still, elastic and harmonics): every joint on a sum of five sines, twice 20 s bare and twice loaded; the session estimates Coulomb friction
    Motion,
}

impl Source {
    /// Whether arms move that feel the inertia tensors of their links.
    pub fn moves(self) -> bool {
        matches!(self, Source::Sweeps | Source::Motion)
    }
}

/// One recording of an arm.
#[derive(Clone, Copy, Debug)]
pub struct Recording {
    pub seed: u64,
    /// The session; its arm's sensors depend on the seed and this alone.
    pub number: u64,
    /// Which of the recordings of this arm: noise and random poses are others in each.
    pub take: u64,
    /// What is not where it was in the first one.
    pub moved: Option<Moved>,
}

/// A sensor that moved.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    pub joint: usize,
    pub parameter: SensorParameter,
    /// By how much, unit of the parameter.
    pub by: f64,
}

/// What is simulated.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    pub line: Line,
    pub from: Source,
    /// Of slow sweeps, degrees a second.
    pub speed: f64,
    /// Coulomb friction, N·m.
    pub friction: f64,
    /// Whether sessions say that readings have no errors beyond their noise and that joints do not bend.
    pub exact: bool,
    poses: usize,
    samples: usize,
}

impl Setting {
    pub fn of(line: Line, friction: f64, (from, speed): (Source, f64), exact: bool) -> Setting {
        let poses = match line {
            _ if from == Source::Motion => STRETCHES,
            Line::Few => 9,
            Line::Pairs => 13,
            Line::OneMoves => 60,
            _ => 25,
        };
        let samples = match line {
            _ if from == Source::Motion => STRETCH,
            Line::Long => 4 * DWELL,
            _ => DWELL,
        };
        Setting { line, from, speed, friction, exact, poses, samples }
    }

    pub fn name(&self) -> String {
        let name = self.line.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned());
        format!("{name}-{}", self.friction)
    }

    /// `simulation.toml` of one session.
    pub fn simulation(&self, arm: &Arm, recording: Recording) -> String {
        let Recording { seed, number, take, moved } = recording;
        let mut random = Pcg64::new(u128::from(seed), u128::from(number));
        let normal = |random: &mut Pcg64, std: f64| std * random.sample::<f64, _>(StandardNormal);
        // Of an arm that stands, the noise of a mean is stated, of which its samples are drawn.
        let root = if self.from == Source::Motion { 1.0 } else { (self.samples as f64).sqrt() };
        let torque = TORQUE / root;
        // Positions of a bin are means of so many samples that their noise says nothing, and a session that states it has an unknown for each.
        let position = match self.from {
            Source::Sweeps => String::new(),
            _ => format!("std = {}\n", POSITION / root),
        };
        let mut text = format!(
            "robot = {}\nseed = {}\n[gravity]\ndirection = [0.3, 0.2, -0.9]\nhemisphere = [0.3, 0.2, -0.9]\nmagnitude_m_per_s2 = 9.80665\n\
             [torque]\nunit = \"N·m\"\nstd = {torque}\nconverter = {{ bits = 17, range = [-327.68, 327.68] }}\n\
             [position]\nunit = \"rad\"\n{position}",
            arm.robot,
            Pcg64::seed_from_u64(seed ^ number.rotate_left(32) ^ take.rotate_left(48)).random::<u32>()
        );
        text += &self.recorded();
        if self.from == Source::Motion {
            text += &format!("motion = {{ harmonics = 5, period_s = {}, seed = {number} }}\n", arm.period);
        }
        if self.line == Line::Elastic {
            text += "[deflection]\ncompliance_rad_per_newton_metre = -1e-4\n";
        }
        for (index, joint) in arm.joints.iter().enumerate() {
            let [gain, bias] = [1.0 + normal(&mut random, 0.03), normal(&mut random, 0.3)];
            let [scale, offset] =
                [1.0 + normal(&mut random, 0.003), if index == 0 { 0.0 } else { normal(&mut random, 0.01) }];
            let moved_by = |parameter: SensorParameter| {
                moved.filter(|moved| moved.joint == index && moved.parameter == parameter).map_or(0.0, |moved| moved.by)
            };
            let [gain, bias] =
                [gain + moved_by(SensorParameter::TorqueGain), bias + moved_by(SensorParameter::TorqueBias)];
            let offset = offset + moved_by(SensorParameter::PositionOffset);
            text += &format!(
                "[[joint]]\nname = {joint:?}\ntorque_sensor = {{ gain = {{ value = {gain}, unit = \"N·m/(N·m)\" }}, bias = {{ value = {bias}, unit = \"N·m\" }} }}\n\
                 position_sensor = {{ gain = {{ value = {scale}, unit = \"rad/rad\" }}, offset = {{ value = {offset}, unit = \"rad\" }} }}\n"
            );
            text += &self.models();
        }
        text += &format!(
            "[[load]]\nname = \"weight\"\nmass_kg = {}\nlink = {:?}\nposition_m = [0.05, 0.04, 0.08]\n\
",
            arm.load, arm.tip
        );
        text + &if self.from == Source::Sweeps { sweeps(arm, &mut random) } else { self.random_poses() }
    }

    fn random_poses(&self) -> String {
        let moving = if self.line == Line::OneMoves { "moving = 1\n" } else { "" };
        let table = |name: &str, load: &str| {
            format!("[[random]]\nfile = \"{name}.csv\"\nposes = {}\n{moving}{load}", self.poses)
        };
        table("bare", "") + &table("loaded", "load = \"weight\"\n")
    }

    fn recorded(&self) -> String {
        let move_s = if self.from == Source::Sweeps { 0.3 } else { MOVE };
        let mut text = format!(
            "[recording]\nrate_hz = 200\nsamples = {}\nmove_s = {move_s}\nsettling_s = 0.3\nvibration = 5\nsettling_time_constant_s = 0.05\n",
            self.samples
        );
        if self.from == Source::Sweeps {
            text += &format!("sweep_deg_per_s = {}\n", self.speed);
        }
        match self.line {
            Line::OneWay => text += "approach = \"one-way\"\n",
            Line::Pairs => text += "approach = \"both-ways\"\n",
            Line::Coloured => text += "noise_correlation_s = 1\n",
            // A walk of so much over the 160 s of a recording of both tables.
            Line::Walk => text += &format!("walk_per_root_s = {}\n", 0.05 / 160f64.sqrt()),
            Line::Hysteresis => text += "hysteresis = { share = 0.1, over = 0.5 }\n",
            Line::Creep => text += "creep = { share = 0.003, time_constant_s = 3 }\n",
            _ => {}
        }
        let per_torque = if self.line == Line::Load { 0.02 } else { 0.0 };
        if self.from != Source::Motion && (self.friction > 0.0 || per_torque > 0.0) {
            text += &format!("friction = {{ coulomb_newton_metre = {}, per_torque = {per_torque} }}\n", self.friction);
        }
        text
    }

    /// What the joints' sensors do besides.
    fn models(&self) -> String {
        match self.line {
            _ if self.from == Source::Motion => format!(
                "sensor_models = [{{ kind = \"coulomb-friction\", parameters = {{ coulomb_friction = {{ value = {}, unit = \"N·m\" }} }} }}]\n{}",
                self.friction,
                self.unmodelled()
            ),
            // The recording has the friction of bristles; what the session estimates has no truth of its own.
            Line::Coulomb => {
                "sensor_models = [{ kind = \"coulomb-friction\", parameters = { coulomb_friction = { value = 0, unit = \"N·m\" } } }]\n".into()
            }
            _ => self.unmodelled(),
        }
    }

    /// What no session knows of.
    fn unmodelled(&self) -> String {
        match self.line {
            Line::Drift => format!(
                "unmodelled = [{{ kind = \"torque-bias-in-time\", parameters = {{ torque_bias_drift = {{ value = {}, unit = \"N·m/s\" }} }} }}]\n",
                0.05 / 160.0
            ),
            Line::Harmonics => "unmodelled = [{ kind = \"position-harmonics\", orders = [2], parameters = { position_sine_2 = { value = 7e-4, unit = \"rad\" }, position_cosine_2 = { value = 7e-4, unit = \"rad\" } } }]\n".into(),
            _ => String::new(),
        }
    }

    /// What a careless user does to `session.toml`.
    pub fn spoil(&self, session: String, arm: &Arm) -> Result<String, String> {
        let replaced = |text: &str, from: &str, to: &str| match text.contains(from) {
            true => Ok(text.replacen(from, to, 1)),
            false => Err(format!("`{from}` is not in the session")),
        };
        let session = session.replacen("[readings.sweeps]\n", &format!("[readings.sweeps]\nbin_deg = {BIN_DEG}\n"), 1);
        let columns = [1, 2].map(|joint: usize| format!("\"{}.effort\"", arm.joints[joint]));
        match self.line {
            Line::Swapped => {
                let [a, b] = &columns;
                replaced(&replaced(&replaced(&session, a, "\"\"")?, b, a)?, "\"\"", b)
            }
            Line::Reversed => {
                Ok(format!("{session}\n[[joint]]\nname = {:?}\ntorque_sign = \"reversed\"\n", arm.joints[1]))
            }
            Line::Label => replaced(&session, "file = \"bare.csv\"", "file = \"bare.csv\"\nload = \"weight\""),
            Line::LabelSome => {
                let file = "[[poses]]\nfile = \"bare.csv\"\n";
                let [from, until] = SOME.map(|pose| pose * PERIOD + 0.5 * MOVE);
                let some = format!(
                    "{file}until_s = {from}\n\n{file}from_s = {from}\nuntil_s = {until}\nload = \"weight\"\n\n{file}from_s = {until}\n"
                );
                replaced(&session, file, &some)
            }
            Line::Degrees => {
                let units = |unit: &str| format!("unit = [{}]", vec![format!("{unit:?}"); arm.joints.len()].join(", "));
                replaced(&session, &units("rad"), &units("deg"))
            }
            _ if self.exact => {
                let torque = "[readings.torque]\n";
                let exact = replaced(&session, torque, &format!("{torque}unexplained_std = \"none\"\n"))?;
                Ok(exact + "\n[deflection]\ncompliance_std_rad_per_newton_metre = 0\n")
            }
            _ => Ok(session),
        }
    }
}

/// Every joint sweeps in each posture, bare and loaded, while the others stand anywhere.
fn sweeps(arm: &Arm, random: &mut Pcg64) -> String {
    let mut text = String::new();
    for posture in 0..POSTURES {
        for joint in &arm.joints {
            for (name, load) in [("bare", ""), ("loaded", "load = \"weight\"\n")] {
                let middle: f64 = random.random_range(-MIDDLE..MIDDLE);
                let [from, to] = [middle - REACH, middle + REACH].map(f64::to_degrees);
                let others = arm.joints.iter().filter(|other| *other != joint);
                let held: Vec<String> =
                    others.map(|other| format!("{other:?} = {}", random.random_range(-HELD..HELD))).collect();
                text += &format!(
                    "[[sweep]]\nfile = \"{name}-{posture}-{joint}.csv\"\njoint = {joint:?}\nrange_deg = [{from}, {to}]\nposes = 10\n\
                     held_rad = {{ {} }}\n{load}",
                    held.join(", ")
                );
            }
        }
    }
    text
}
