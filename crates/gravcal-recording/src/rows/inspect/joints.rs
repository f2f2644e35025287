//! Which columns are of one joint, as far as their names tell.

use super::{Inspection, Meaning};
use crate::rows::joint_state::ColumnName;

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
    /// The joints of the recording, in the order of their positions. Of several columns with one meaning the first that has readings
    /// is taken, of the same topic where one is; where names do not tell which torque is whose, and there are as many as positions, they
    /// are taken in their order.
    /// What was asked of a joint is taken only where no sensor's reading is there, and a motor's current where no torque is.
    pub fn joints(&self) -> Vec<JointFound> {
        let mut joints: Vec<JointFound> = Vec::new();
        for position in self.meaning(Meaning::Position) {
            let name = self.columns[position].guess.joint.clone().unwrap_or_default();
            if joints.iter().all(|joint| joint.name != name) {
                let of = |meaning| self.of_joint(&name, position, meaning);
                let (torque, velocity) = (of(Meaning::Torque).or_else(|| of(Meaning::Current)), of(Meaning::Velocity));
                joints.push(JointFound { name, position, torque, velocity });
            }
        }
        let by_order = |meaning| Some(self.meaning(meaning)).filter(|torques| torques.len() == joints.len());
        if joints.iter().all(|joint| joint.torque.is_none())
            && let Some(torques) = by_order(Meaning::Torque).or_else(|| by_order(Meaning::Current))
        {
            joints.iter_mut().zip(torques).for_each(|(joint, torque)| joint.torque = Some(torque));
        }
        joints
    }

    /// Those of them whose torque reading ever changes; all, where none does. A gripper's fingers have mostly none.
    pub fn joints_with_torque(&self) -> Vec<JointFound> {
        let changes = |torque: usize| self.columns[torque].lowest < self.columns[torque].highest;
        let (alive, dead): (Vec<JointFound>, Vec<JointFound>) =
            self.joints().into_iter().partition(|joint| joint.torque.is_some_and(changes));
        if alive.is_empty() { dead } else { alive }
    }

    /// Those of joints that move: by a hundredth at least of what the one does that moves most. The fingers of a gripper that carries
    /// something all the time are part of what the arm carries.
    pub fn moving<'j>(&self, joints: &'j [JointFound]) -> impl Iterator<Item = &'j JointFound> {
        let range = |joint: &JointFound| self.columns[joint.position].highest - self.columns[joint.position].lowest;
        let largest = joints.iter().map(range).fold(0.0, f64::max);
        joints.iter().filter(move |joint| range(joint) >= 0.01 * largest)
    }

    /// Columns that say something and have this meaning: those that sensors read, where there is one.
    fn meaning(&self, meaning: Meaning) -> Vec<usize> {
        let is = |index: &usize| {
            let column = &self.columns[*index];
            column.readings > 0 && column.guess.meaning == Some(meaning)
        };
        let (commanded, read): (Vec<usize>, Vec<usize>) =
            (0..self.columns.len()).filter(is).partition(|index| self.columns[*index].guess.commanded);
        if read.is_empty() { commanded } else { read }
    }

    fn of_joint(&self, name: &str, position: usize, meaning: Meaning) -> Option<usize> {
        let found: Vec<usize> = self
            .meaning(meaning)
            .into_iter()
            .filter(|index| self.columns[*index].guess.joint.as_deref().unwrap_or_default() == name)
            .collect();
        let topic = |index: usize| ColumnName::parse(&self.columns[index].name).and_then(|name| name.topic);
        found.iter().copied().find(|index| topic(*index) == topic(position)).or(found.first().copied())
    }
}
