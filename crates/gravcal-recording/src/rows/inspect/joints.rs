//! Which columns are of one joint, as far as their names tell.

use super::numbers::{are_same_numbers, column_numbers};
use super::{ColumnFound, Inspection, Meaning};
use crate::rows::joint_state::ColumnName;

/// A joint that moves by this share of what the one does that moves most is one of the arm; a gripper moves less.
const OF_ARM: f64 = 0.1;
/// The same where a gripper whose torque is not recorded might have a column of zeros: one that swings open by 0.8 rad moves less.
const SURELY_OF_ARM: f64 = 0.5;

/// Longest travel, or largest speed, of a sliding joint that is taken for metres.
const METRES: f64 = 10.0;

/// The columns of a joint, as places in [`Inspection::columns`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JointFound {
    /// Its name in messages, else what is left of the names of its columns.
    pub name: String,
    /// Its position reading.
    pub position: usize,
    /// Its torque reading.
    pub torque: Option<usize>,
    /// Its speed.
    pub velocity: Option<usize>,
}

impl Inspection {
    /// The joints of the recording, in the order of their positions, or of the numbers in the names of these columns where each has its
    /// own. Of several columns with one meaning the first that has readings is taken, of the same topic where one is. Where names do not
    /// tell which torque is whose, and there are as many as positions, the numbers in them do, or else their order.
    /// What was asked of a joint is taken only where no sensor's reading is there, and a motor's current where no sensor's torque is.
    pub fn joints(&self) -> Vec<JointFound> {
        self.paired().0
    }

    /// Why positions and torques that were paired by their order may not belong together: the numbers in their names do not say so.
    pub fn pairing_doubt(&self) -> Option<String> {
        let (joints, unsure) = self.paired();
        let why = unsure?;
        let name = |place: usize| self.columns[place].name.as_str();
        let pair = |joint: &JointFound| Some(format!("`{}` with `{}`", name(joint.position), name(joint.torque?)));
        let pairs: Vec<String> = joints.iter().filter_map(pair).collect();
        Some(format!(
            "Which torque is of which joint is not told by the names of their columns: {why}. They are paired by their order: {}. Look \
             whether that is so.",
            pairs.join(", ")
        ))
    }

    /// Which topics tell the positions of the same joints, where more than one does and none by its name holds commands.
    pub fn topics_doubt(&self) -> Option<String> {
        let topic = |place: usize| ColumnName::parse(&self.columns[place].name).and_then(|name| name.topic);
        let taken = self.joints();
        let joint = |place: usize| self.columns[place].guess.joint.as_deref().unwrap_or_default();
        let mut found = self.meaning(Meaning::Position).into_iter().filter_map(|other| {
            let first = taken.iter().find(|first| first.name == joint(other))?;
            let topics = (topic(first.position)?, topic(other)?);
            (topics.0 != topics.1).then_some(topics)
        });
        let (first, other) = found.next()?;
        Some(format!(
            "The topics `{first}` and `{other}` both tell the positions of the same joints. `{first}` is taken, as it comes first: look \
             whether that is the one that holds what the sensors read, and not what was asked of the joints."
        ))
    }

    /// The joints, and what speaks against the order by which they were paired with their torques, if they were.
    fn paired(&self) -> (Vec<JointFound>, Option<String>) {
        let mut joints: Vec<JointFound> = Vec::new();
        for position in self.meaning(Meaning::Position) {
            let name = self.columns[position].guess.joint.clone().unwrap_or_default();
            if joints.iter().all(|joint| joint.name != name) {
                let of = |columns: Vec<usize>| self.of_joint(&name, position, &columns);
                let torque = self.torques().into_iter().find_map(of);
                let velocity = of(self.meaning(Meaning::Velocity));
                joints.push(JointFound { name, position, torque, velocity });
            }
        }
        let mut doubt = None;
        if joints.iter().all(|joint| joint.torque.is_none())
            && let Some(torques) = self.torques().into_iter().find(|torques| torques.len() == joints.len())
        {
            doubt = self.pair(&mut joints, &torques);
        }
        (self.by_number(joints), doubt)
    }

    /// Pairs joints with as many torques: by the numbers in their names or, where these are not the same, by their order. Then tells what
    /// these numbers are.
    fn pair(&self, joints: &mut [JointFound], torques: &[usize]) -> Option<String> {
        let positions: Vec<usize> = joints.iter().map(|joint| joint.position).collect();
        let numbers = [self.numbers(&positions), self.numbers(torques)];
        if let [Some(of_positions), Some(of_torques)] = &numbers
            && are_same_numbers(of_positions, of_torques)
        {
            let of = |number| of_torques.iter().position(|of| of == number).map(|place| torques[place]);
            joints.iter_mut().zip(of_positions).for_each(|(joint, number)| joint.torque = of(number));
            return None;
        }
        joints.iter_mut().zip(torques).for_each(|(joint, torque)| joint.torque = Some(*torque));
        let listed = |numbers: &[u64]| numbers.iter().map(u64::to_string).collect::<Vec<_>>().join(", ");
        match &numbers {
            [Some(of_positions), Some(of_torques)] => Some(format!(
                "those of positions carry the numbers {}, those of torques {}",
                listed(of_positions),
                listed(of_torques)
            )),
            [Some(only), None] => Some(format!("only those of positions carry numbers ({})", listed(only))),
            [None, Some(only)] => Some(format!("only those of torques carry numbers ({})", listed(only))),
            [None, None] => None,
        }
    }

    /// The numbers in the names of columns.
    fn numbers(&self, columns: &[usize]) -> Option<Vec<u64>> {
        column_numbers(columns.iter().map(|column| self.columns[*column].name.as_str()))
    }

    /// Joints in the order of the numbers in the names of their positions, where each has its own.
    fn by_number(&self, joints: Vec<JointFound>) -> Vec<JointFound> {
        let positions: Vec<usize> = joints.iter().map(|joint| joint.position).collect();
        let Some(numbers) = self.numbers(&positions) else { return joints };
        let mut numbered: Vec<(u64, JointFound)> = numbers.into_iter().zip(joints).collect();
        numbered.sort_by_key(|(number, _)| *number);
        numbered.into_iter().map(|(_, joint)| joint).collect()
    }

    /// Those of them whose torque reading ever changes; all, where none does. A gripper's fingers have mostly none.
    pub fn joints_with_torque(&self) -> Vec<JointFound> {
        let (alive, dead): (Vec<JointFound>, Vec<JointFound>) =
            self.joints().into_iter().partition(|joint| self.is_alive(joint));
        self.by_number(if alive.is_empty() { dead } else { alive })
    }

    /// Those of its joints whose torque has a column that tells nothing, and that move as much as joints of an arm do: they have no torque
    /// sensor, or none that is recorded, and the links beyond them turn all the same.
    pub fn joints_with_silent_torque(&self) -> Vec<JointFound> {
        let joints = self.joints();
        let is_empty = |joint: &JointFound| {
            let of_joint = self.columns.iter().filter(|column| column.guess.joint.as_deref() == Some(&joint.name));
            let mut torques = of_joint.filter(|column| column.guess.meaning == Some(Meaning::Torque));
            joint.torque.is_none() && torques.any(|column| column.readings == 0)
        };
        let empty = self.moving_by(OF_ARM, &joints).filter(|joint| is_empty(joint));
        let stuck =
            self.moving_by(SURELY_OF_ARM, &joints).filter(|joint| joint.torque.is_some() && !self.is_alive(joint));
        empty.chain(stuck).cloned().collect()
    }

    /// Whether a joint has a torque reading that ever changes.
    fn is_alive(&self, joint: &JointFound) -> bool {
        joint.torque.is_some_and(|torque| self.columns[torque].lowest < self.columns[torque].highest)
    }

    /// Those of joints that move: by a hundredth at least of what the one does that moves most. The fingers of a gripper that carries
    /// something all the time are part of what the arm carries.
    pub fn moving<'j>(&self, joints: &'j [JointFound]) -> impl Iterator<Item = &'j JointFound> {
        self.moving_by(0.01, joints)
    }

    fn moving_by<'j>(&self, share: f64, joints: &'j [JointFound]) -> impl Iterator<Item = &'j JointFound> {
        let range = |joint: &JointFound| self.columns[joint.position].highest - self.columns[joint.position].lowest;
        let largest = joints.iter().map(range).fold(0.0, f64::max);
        joints.iter().filter(move |joint| range(joint) >= share * largest)
    }

    /// The same where it is known which joints slide, by the names of these: units that names of columns do not tell are those of
    /// lengths and forces.
    #[must_use]
    pub fn with_sliding(mut self, slides: impl Fn(&str) -> bool) -> Inspection {
        let columns = self.columns.iter_mut().filter(|column| column.guess.joint.as_deref().is_some_and(&slides));
        for column in columns.filter(|column| !column.guess.unit_named) {
            let long = column.lowest.abs().max(column.highest.abs()) > METRES;
            column.guess.unit = match column.guess.unit {
                Some("rad" | "deg") if long => Some("mm"),
                Some("rad" | "deg") => Some("m"),
                Some("rad/s" | "deg/s") if long => Some("mm/s"),
                Some("rad/s" | "deg/s") => Some("m/s"),
                Some("N·m") => Some("N"),
                unit => unit,
            };
        }
        self
    }

    /// The column of each of these axes of a force-torque sensor, or parts of an orientation: the first that says something of it; `None`
    /// where one is missing.
    pub fn axes<const N: usize>(&self, meaning: Meaning, axes: [&str; N]) -> Option<[&ColumnFound; N]> {
        let columns = self.meaning(meaning);
        let of = |axis: &str| columns.iter().find(|column| self.columns[**column].guess.axis == Some(axis));
        let places: Option<Vec<&ColumnFound>> = axes.iter().map(|axis| Some(&self.columns[*of(axis)?])).collect();
        places?.try_into().ok()
    }

    /// Columns that say something and have this meaning: those that sensors read, where there is one.
    fn meaning(&self, meaning: Meaning) -> Vec<usize> {
        let [read, commanded] = [false, true].map(|commanded| self.of_meaning(meaning, commanded));
        if read.is_empty() { commanded } else { read }
    }

    /// Columns of torques, the best ones first: what a controller asks of a motor is what its model says, and no reading.
    fn torques(&self) -> [Vec<usize>; 4] {
        [(Meaning::Torque, false), (Meaning::Current, false), (Meaning::Torque, true), (Meaning::Current, true)]
            .map(|(meaning, commanded)| self.of_meaning(meaning, commanded))
    }

    /// Columns that say something and have this meaning, of what was asked of joints or of what sensors read.
    fn of_meaning(&self, meaning: Meaning, commanded: bool) -> Vec<usize> {
        let is = |index: &usize| {
            let ColumnFound { readings, guess, .. } = &self.columns[*index];
            *readings > 0 && guess.meaning == Some(meaning) && guess.commanded == commanded
        };
        (0..self.columns.len()).filter(is).collect()
    }

    /// The one of these columns that is of the joint with this name and position.
    fn of_joint(&self, name: &str, position: usize, columns: &[usize]) -> Option<usize> {
        let is_its = |index: &usize| self.columns[*index].guess.joint.as_deref().unwrap_or_default() == name;
        let found: Vec<usize> = columns.iter().copied().filter(is_its).collect();
        let topic = |index: usize| ColumnName::parse(&self.columns[index].name).and_then(|name| name.topic);
        found.iter().copied().find(|index| topic(*index) == topic(position)).or(found.first().copied())
    }
}
