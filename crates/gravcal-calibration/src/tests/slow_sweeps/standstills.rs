//! The same joints standing: friction at rest holds a part of what they carry, another one in each standstill, and the mean of a
//! standstill is known much better than that.

use super::*;
use crate::result::{UnexplainedResult, Verdict};

/// Largest part of the friction that holds at rest.
const HELD: f64 = 0.2;
const STANDSTILLS: u32 = 24;

impl Recorder {
    fn stand(&mut self, seconds: f64, held: [f64; 2]) {
        self.direction = held;
        (0..(seconds * RATE) as u32).for_each(|_| self.row());
    }

    /// Standstills at places spread evenly.
    fn standstills(&mut self, seconds: f64, seed: u64) {
        // Apart from the noise, of which longer standstills draw more.
        let mut friction = Pcg64::seed_from_u64(100 + seed);
        for k in 0..STANDSTILLS {
            let place = |step: f64| 1.3 * (2.0 * (f64::from(k) * step).fract() - 1.0);
            self.go(0, place(0.754_877_666), 2.0);
            self.go(1, place(0.569_840_291), 2.0);
            self.stand(seconds, [0, 1].map(|_| HELD * friction.random_range(-1.0..1.0)));
        }
    }
}

fn standing(seed: u64, seconds: f64) -> EstimatorResult {
    let folder = tempfile::tempdir().unwrap();
    let text = SESSION.replace("sweeps = {}", "still = {}").replace("MODELS", "");
    let mut recorder = recorder(folder.path(), seed, &text);
    recorder.standstills(seconds, seed);
    let (session, result) = result_of(folder.path(), &recorder);
    assert_eq!(session.poses.len(), STANDSTILLS as usize, "{:?}", session.searched);
    assert_eq!(result.verdict, Verdict::Determined, "{} {:?}", result.termination, result.notes);
    result
}

fn unexplained(result: &EstimatorResult) -> Vec<UnexplainedResult> {
    result.fit.as_ref().unwrap().joints.iter().filter_map(|joint| joint.unexplained).collect()
}

#[test]
fn friction_at_rest_is_reported_and_errors_are_as_they_say() {
    let mut squares = Vec::new();
    for seed in 0..12 {
        let result = standing(seed, 1.0);
        for (reported, joint) in unexplained(&result).iter().zip(&TRUTH) {
            let truth = HELD * joint.friction / 3_f64.sqrt();
            assert!((0.5..1.6).contains(&(reported.std / truth)) && reported.times_noise > 1.5, "{reported:?} {truth}");
            assert!(reported.share_of_gravity.unwrap() < 0.1, "{reported:?}");
        }
        for name in AFFINE {
            let found = result.parameter(name).unwrap();
            squares.push(((found.value.unwrap() - truth(name)) / found.std.unwrap()).powi(2));
        }
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!((0.7..1.35).contains(&rms), "{rms}");
}

#[test]
fn longer_standstills_are_neither_refused_nor_worse() {
    let longer = |seed: u64| {
        let [short, long] = [1.0, 6.0].map(|seconds| standing(seed, seconds));
        AFFINE.map(|name| [&short, &long].map(|result| result.parameter(name).unwrap().std.unwrap().ln()))
    };
    // In the mean of some sessions, as how far each one's joints happen to be held is chance.
    let sessions: Vec<_> = (1..7).map(longer).collect();
    for (place, name) in AFFINE.iter().enumerate() {
        let logarithms = sessions.iter().map(|of_names| of_names[place][1] - of_names[place][0]);
        let ratio = (logarithms.sum::<f64>() / sessions.len() as f64).exp();
        assert!(ratio < 1.05, "{name}: {ratio}");
    }
}
