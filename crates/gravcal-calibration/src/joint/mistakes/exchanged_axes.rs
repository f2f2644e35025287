//! Axes of a force-torque sensor that are exchanged or point the other way: of its forces and moments alike, as where columns stand in
//! another order, or the sensor is mounted turned by right angles; or two columns of its forces, or of its moments, alone.

use gravcal_recording::Reading;
use gravcal_robot_model::session::{AuxiliarySensorKind, Session};

use super::hypothesis::Hypothesis;

const NAMES: [&str; 3] = ["x", "y", "z"];
/// The orders of three axes; the first is that of their names.
const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 0, 2], [2, 1, 0], [0, 2, 1], [1, 2, 0], [2, 0, 1]];

/// Which column each axis of a sensor is in, and with which sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ExchangedAxes {
    instrument: usize,
    order: [usize; 3],
    signs: [f64; 3],
    /// Where forces come first and moments after them: those of both, or of one of them.
    groups: [bool; 2],
}

impl ExchangedAxes {
    /// All that a session may have got wrong. All axes the other way round is a sensor that is reversed; where its tool's mass is free, that is negative
    /// instead, and the readings are explained.
    pub fn all(session: &Session) -> Vec<ExchangedAxes> {
        let may_be = |index: &usize| {
            let sensor = &session.instruments[*index];
            let alike = |units: &[Option<String>]| units.iter().all(|unit| *unit == units[0]);
            sensor.kind == AuxiliarySensorKind::ForceTorque
                && !sensor.in_base
                && sensor.units.len() == 6
                && sensor.units.chunks(3).all(alike)
        };
        let sign = |negative: usize| if negative == 0 { 1.0 } else { -1.0 };
        let signs = || (0..8).map(|bits| [0, 1, 2].map(|axis| sign(bits >> axis & 1)));
        let of_sensor = |instrument: usize| {
            let orders = ORDERS.into_iter().flat_map(move |order| signs().map(move |signs| (order, signs)));
            let others = orders.filter(|(order, signs)| *order != ORDERS[0] || *signs != [1.0; 3]);
            let of_both =
                others.map(move |(order, signs)| ExchangedAxes { instrument, order, signs, groups: [true; 2] });
            let pairs = ORDERS.into_iter().filter(|order| (0..3).filter(|axis| order[*axis] != *axis).count() == 2);
            let alone = [[true, false], [false, true]].into_iter();
            let of_one = pairs.flat_map(move |order| {
                alone.clone().map(move |groups| ExchangedAxes { instrument, order, signs: [1.0; 3], groups })
            });
            of_both.chain(of_one)
        };
        (0..session.instruments.len()).filter(may_be).flat_map(of_sensor).collect()
    }
}

impl Hypothesis for ExchangedAxes {
    fn made(&self, session: &Session) -> Session {
        let mut made = session.clone();
        let first = session.instruments[self.instrument].first_reading;
        for pose in &mut made.poses {
            let groups = pose.instruments[first..first + 6].chunks_mut(3).zip(self.groups);
            for (group, _) in groups.filter(|(_, is_exchanged)| *is_exchanged) {
                let read: Vec<Option<Reading>> = group.to_vec();
                for (axis, (from, sign)) in group.iter_mut().zip(self.order.into_iter().zip(self.signs)) {
                    *axis = read[from].map(|reading| Reading { value: sign * reading.value, ..reading });
                }
            }
        }
        made
    }

    fn words(&self, session: &Session) -> (String, String) {
        let ExchangedAxes { instrument, order, signs, groups } = *self;
        let name = &session.instruments[instrument].name;
        if groups != [true; 2] {
            let first = session.joints.len() + session.instruments[instrument].first_reading;
            let first = if groups[0] { first } else { first + 3 };
            let exchanged = (0..3).filter(|axis| order[*axis] != *axis);
            let columns: Vec<String> = exchanged.map(|axis| session.channel_name(first + axis)).collect();
            let what = format!("swapped columns: {}", columns.join(" and "));
            return (what, format!("Exchange them in the readings of {name}."));
        }
        if order == ORDERS[0] && signs == [-1.0; 3] {
            let cure = "Say sign = \"reversed\" in its [[force_torque_sensor]].".to_owned();
            return (format!("reversed force-torque sensor: {name}"), cure);
        }
        let columns = [0, 1, 2].map(|axis| {
            let sign = if signs[axis] < 0.0 { "-" } else { "" };
            format!("{sign}{}", NAMES[order[axis]])
        });
        let what = format!("exchanged axes of {name}: its x, y, z are in the columns of {}", columns.join(", "));
        let cure = match (signs == [1.0; 3], self.turn()) {
            (true, None) => "Exchange these columns of its readings, of forces and of moments.".to_owned(),
            (true, Some(turn)) => {
                format!("Exchange these columns of its readings, of forces and of moments; or {turn}.")
            }
            (false, Some(turn)) => format!("The sensor is turned against its frame: {turn}."),
            (false, None) => "Bring its columns, of forces and of moments, into a right-handed frame.".to_owned(),
        };
        (what, cure)
    }
}

impl ExchangedAxes {
    /// How its mounting is turned besides; `None` where no rotation does that.
    fn turn(self) -> Option<String> {
        let mut matrix = nalgebra::Matrix3::zeros();
        (0..3).for_each(|axis| matrix[(axis, self.order[axis])] = self.signs[axis]);
        (matrix.determinant() > 0.0).then(|| {
            let angles = nalgebra::Rotation3::from_matrix_unchecked(matrix).euler_angles();
            let [roll, pitch, yaw] = [angles.0, angles.1, angles.2].map(|angle| angle.to_degrees().round() + 0.0);
            format!("say that its mounting is turned by rpy_deg = [{roll}, {pitch}, {yaw}] besides")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::sarcos_with_instruments;

    /// A reversed sensor whose tool is known contradicts all other readings, as exchanged axes do.
    #[test]
    fn all_axes_the_other_way_round_are_a_reversed_sensor() {
        let session = sarcos_with_instruments().session(0);
        let all = ExchangedAxes::all(&session);
        let reversed = all.iter().filter(|axes| axes.order == ORDERS[0] && axes.signs == [-1.0; 3]);
        let [reversed] = reversed.collect::<Vec<_>>()[..] else { panic!("{all:?}") };
        assert_eq!(
            all.len(),
            6 * 8 - 1 + 3 + 3,
            "all but the session as it stands, and pairs of forces and of moments"
        );
        let made = reversed.made(&session);
        let first = session.instruments[reversed.instrument].first_reading;
        for (made, read) in made.poses.iter().zip(&session.poses) {
            for channel in first..first + 6 {
                let [made, read] = [made, read].map(|pose| pose.instruments[channel].map(|reading| reading.value));
                assert_eq!(made, read.map(|value| -value));
            }
        }
        let (what, cure) = reversed.words(&session);
        assert_eq!(what, "reversed force-torque sensor: wrist");
        assert!(cure.contains("sign = \"reversed\""), "{cure}");
    }
}
