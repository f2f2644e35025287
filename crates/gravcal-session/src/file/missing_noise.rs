//! Readings without a standard deviation in a channel whose others have one.
//!
//! A standstill in which a reading never changes tells nothing of its noise, nor does an empty cell of a column of standard deviations. Where
//! no reading of a channel tells its noise, it is estimated from the residuals; were it for a single reading, nothing would test how well all the
//! others are explained. So what is missing is the root mean square of what the others have.

use gravcal_recording::Reading;
use gravcal_robot_model::session::Pose;

/// Gives each such reading the standard deviation of the others of its channel.
pub(super) fn fill_in(poses: &mut [Pose]) {
    let (joints, axes) = poses.first().map_or((0, 0), |pose| (pose.torque.len(), pose.instruments.len()));
    (0..joints).for_each(|joint| fill_in_channel(poses, |pose| pose.torque[joint].as_mut()));
    (0..axes).for_each(|axis| fill_in_channel(poses, |pose| pose.instruments[axis].as_mut()));
}

fn fill_in_channel(poses: &mut [Pose], reading: impl Fn(&mut Pose) -> Option<&mut Reading>) {
    let stated: Vec<f64> = poses.iter_mut().filter_map(|pose| reading(pose)?.std).collect();
    if stated.is_empty() {
        return;
    }
    let mean = (stated.iter().map(|std| std * std).sum::<f64>() / stated.len() as f64).sqrt();
    for reading in poses.iter_mut().filter_map(&reading) {
        reading.std.get_or_insert(mean);
    }
}

#[cfg(test)]
mod tests {
    use gravcal_recording::Conditions;

    use super::*;

    fn filled(stds: [Option<f64>; 3]) -> Vec<Option<f64>> {
        let pose = |std: Option<f64>| Pose {
            table: 0,
            line: 1,
            sweep_label: None,
            load: None,
            position: vec![0.0; 2],
            orientation: None,
            torque: vec![None, Some(Reading { value: 1.0, std })],
            instruments: vec![Some(Reading { value: 2.0, std })],
            conditions: Conditions::default(),
            course: None,
        };
        let mut poses: Vec<Pose> = stds.map(pose).into();
        fill_in(&mut poses);
        let torques = poses.iter().map(|pose| pose.torque[1].unwrap().std).collect();
        let instruments: Vec<Option<f64>> = poses.iter().map(|pose| pose.instruments[0].unwrap().std).collect();
        assert_eq!(instruments, torques);
        torques
    }

    #[test]
    fn a_reading_without_noise_has_that_of_the_others() {
        let root_mean_square = Some(12.5_f64.sqrt());
        assert_eq!(filled([Some(3.0), None, Some(4.0)]), [Some(3.0), root_mean_square, Some(4.0)]);
        assert_eq!(filled([None; 3]), [None; 3], "nothing tells it");
    }
}
