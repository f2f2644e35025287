//! The channels of a session: everything that gives a number in a pose and is not a position.
//!
//! First the torque of each joint, in their order, then the axes of each instrument.

use gravcal_recording::Reading;

use super::contents::Session;
use super::reading_id::ReadingId;

impl Session {
    /// How many there are.
    pub fn channel_count(&self) -> usize {
        self.joints.len() + self.instruments.iter().map(|instrument| instrument.kind.axes().len()).sum::<usize>()
    }

    /// `joint1`, or `wrist.fx`.
    pub fn channel_name(&self, channel: usize) -> String {
        match self.axis(channel) {
            None => self.robot.chain.joints()[channel].name.clone(),
            Some((instrument, axis)) => {
                let instrument = &self.instruments[instrument];
                format!("{}.{}", instrument.name, instrument.kind.axes()[axis])
            }
        }
    }

    /// Unit of its readings; empty where it has none.
    pub fn channel_unit(&self, channel: usize) -> String {
        match self.axis(channel) {
            None => self.joints[channel].torque_unit.map_or_else(String::new, |unit| unit.to_string()),
            Some((instrument, axis)) => self.instruments[instrument].units[axis].clone().unwrap_or_default(),
        }
    }

    /// The reading of a channel in a pose, where there is one.
    pub fn reading(&self, ReadingId { pose, channel }: ReadingId) -> Option<&Reading> {
        let pose = &self.poses[pose];
        match channel.checked_sub(self.joints.len()) {
            None => pose.torque[channel].as_ref(),
            Some(place) => pose.instruments[place].as_ref(),
        }
    }

    /// The same, to be changed.
    pub fn reading_mut(&mut self, ReadingId { pose, channel }: ReadingId) -> Option<&mut Reading> {
        let joints = self.joints.len();
        let pose = &mut self.poses[pose];
        match channel.checked_sub(joints) {
            None => pose.torque[channel].as_mut(),
            Some(place) => pose.instruments[place].as_mut(),
        }
    }

    /// Index of the instrument and of its axis; `None` for a joint.
    pub fn axis(&self, channel: usize) -> Option<(usize, usize)> {
        let place = channel.checked_sub(self.joints.len())?;
        let owner = self.instruments.iter().position(|instrument| instrument.readings().contains(&place))?;
        Some((owner, place - self.instruments[owner].first_reading))
    }

    /// Largest less smallest reading of each channel, in its unit; 0 where there is none.
    pub fn spreads(&self) -> Vec<f64> {
        let spread = |channel| {
            let values =
                (0..self.poses.len()).filter_map(|pose| Some(self.reading(ReadingId { pose, channel })?.value));
            let range = |(low, high): (f64, f64), value: f64| (low.min(value), high.max(value));
            let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), range);
            (high - low).max(0.0)
        };
        (0..self.channel_count()).map(spread).collect()
    }

    /// By channel, whether a reading states no standard deviation, so that it is estimated from residuals.
    pub fn noise_estimated(&self) -> Vec<bool> {
        let unstated = |channel| {
            let mut readings = (0..self.poses.len()).filter_map(|pose| self.reading(ReadingId { pose, channel }));
            readings.any(|reading| reading.std.is_none())
        };
        (0..self.channel_count()).map(unstated).collect()
    }
}
