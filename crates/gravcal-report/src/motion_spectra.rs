//! Spectra of what an arm in motion reads and of what the model leaves of it.
//!
//! Windows follow each other evenly, so that their readings and their residuals are series in time; what rests, or was not recorded, cuts
//! them into runs.

use std::collections::BTreeMap;

use gravcal_calibration::result::ReadingResidual;
use gravcal_recording::MotionWindows;
use gravcal_robot_model::Session;
use gravcal_robot_model::session::ReadingId;

use crate::spectrum::spectrum;

/// Windows follow each other by their step, but for this share of it.
const EVEN: f64 = 0.01;

/// Amplitude spectral densities of one channel, in its unit over √Hz.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionSpectra {
    /// Hz, ascending in equal steps from the first of them.
    pub frequency: Vec<f64>,
    /// Of the readings.
    pub reading: Vec<f64>,
    /// Of the residuals.
    pub residual: Vec<f64>,
    /// Beyond it windows let little pass, Hz.
    pub cut_off: f64,
}

impl MotionSpectra {
    /// Amplitudes of sines that would have the residuals' densities, in the unit of the channel: a sine of amplitude `A` has `A/√(3 Δf)` where
    /// it is, frequencies `Δf` apart.
    pub fn residual_amplitudes(&self) -> Vec<f64> {
        let step = self.frequency.first().copied().unwrap_or(0.0);
        self.residual.iter().map(|density| density * (3.0 * step).sqrt()).collect()
    }
}

/// Those of a channel whose residuals these are, by pose; nothing where it has too few windows that follow each other.
pub fn motion_spectra(session: &Session, own: &BTreeMap<usize, &ReadingResidual>) -> Option<MotionSpectra> {
    let windows = session.searched.iter().find_map(|searched| searched.windows.as_deref())?;
    let runs = runs(session, windows, own);
    let series = |of: &dyn Fn(usize) -> f64| -> Vec<Vec<f64>> {
        runs.iter().map(|run| run.iter().map(|pose| of(*pose)).collect()).collect()
    };
    let channel = own.values().next()?.id.channel;
    let rate = 1.0 / windows.step();
    let reading = |pose: usize| session.reading(ReadingId { pose, channel }).map_or(f64::NAN, |reading| reading.value);
    let reading = spectrum(&series(&reading), rate)?;
    let residual = spectrum(&series(&|pose| own[&pose].residual), rate)?;
    Some(MotionSpectra {
        frequency: reading.frequency,
        reading: reading.density,
        residual: residual.density,
        cut_off: windows.cut_off(),
    })
}

/// Poses that are windows one after the other.
fn runs(session: &Session, windows: &MotionWindows, own: &BTreeMap<usize, &ReadingResidual>) -> Vec<Vec<usize>> {
    let time = |pose: usize| session.poses[pose].conditions.time.unwrap_or(f64::NAN);
    let follows = |a: usize, b: usize| {
        let apart = (time(b) - time(a)) / windows.step();
        session.poses[a].table == session.poses[b].table && (apart - 1.0).abs() < EVEN
    };
    let moving: Vec<usize> = own.keys().copied().filter(|pose| session.poses[*pose].course.is_some()).collect();
    moving.chunk_by(|a, b| follows(*a, *b)).map(<[usize]>::to_vec).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use gravcal_recording::Course;
    use gravcal_robot_model::session::Searched;
    use gravcal_session::simulation::Simulation;

    use super::*;

    /// 60 windows every tenth of a second, with a pause after the fortieth.
    fn session() -> Session {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments/sarcos-shoulder/simulation.toml");
        let mut session = Simulation::read(&path).unwrap().session(0);
        session.poses.truncate(60);
        for (number, pose) in session.poses.iter_mut().enumerate() {
            let pause = if number < 40 { 0.0 } else { 2.0 };
            pose.conditions.time = Some(0.1 * number as f64 + pause);
            pose.course = Some(Arc::new(Course::of(&[])));
            pose.table = 0;
        }
        let windows = Some(Box::new(MotionWindows { length: 0.64, ..MotionWindows::default() }));
        let path = "moving.csv".into();
        session.searched = vec![Searched { path, windows, ..Searched::default() }];
        session
    }

    fn residual(pose: usize) -> ReadingResidual {
        let id = ReadingId { pose, channel: 0 };
        let residual = (pose % 4) as f64 - 1.5;
        ReadingResidual { id, residual, nominal_residual: 0.0, std: 1.0, weight: 1.0, torque: None }
    }

    #[test]
    fn windows_that_follow_each_other_are_a_run() {
        let session = session();
        let all: Vec<ReadingResidual> = (0..60).filter(|pose| *pose != 50).map(residual).collect();
        let own: BTreeMap<usize, &ReadingResidual> = all.iter().map(|residual| (residual.id.pose, residual)).collect();
        let windows = session.searched[0].windows.as_deref().unwrap();
        assert!((windows.step() - 0.1).abs() < 1e-12 && (windows.cut_off() - 2.5).abs() < 1e-12);
        let lengths: Vec<usize> = runs(&session, windows, &own).iter().map(Vec::len).collect();
        assert_eq!(lengths, [40, 10, 9]);
        assert_eq!(motion_spectra(&session, &own).unwrap().cut_off, windows.cut_off());
        let few: BTreeMap<usize, &ReadingResidual> = own.into_iter().filter(|(pose, _)| *pose < 12).collect();
        assert!(motion_spectra(&session, &few).is_none());
    }

    #[test]
    fn poses_have_no_spectrum() {
        let mut session = session();
        session.searched.clear();
        let one = residual(0);
        assert!(motion_spectra(&session, &BTreeMap::from([(0, &one)])).is_none());
    }

    /// The amplitude of a sine is that of the sine, whatever the number of windows.
    #[test]
    fn a_sine_has_its_amplitude() {
        let session = session();
        let swing = |pose: usize| ReadingResidual {
            residual: 0.3 * (std::f64::consts::TAU * pose as f64 / 4.0).sin(),
            ..residual(pose)
        };
        let all: Vec<ReadingResidual> = (0..40).map(swing).collect();
        let own: BTreeMap<usize, &ReadingResidual> = all.iter().map(|residual| (residual.id.pose, residual)).collect();
        let spectra = motion_spectra(&session, &own).unwrap();
        let amplitudes = spectra.residual_amplitudes();
        let peak = (0..amplitudes.len()).max_by(|a, b| amplitudes[*a].total_cmp(&amplitudes[*b])).unwrap();
        assert!((spectra.frequency[peak] - 2.5).abs() < 1e-9 && (amplitudes[peak] - 0.3).abs() < 1e-9, "{spectra:?}");
    }
}
