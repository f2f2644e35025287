//! What of an arm in motion tells less than it seems to: joints that move in proportion, a period that repeats, windows in which a joint rests.

use std::collections::BTreeMap;

use gravcal_recording::file_name;

use super::contents::Session;
use super::pose::Pose;

/// Velocities of two joints are in proportion where this share of one's square is not explained by the other, or less.
const PROPORTION: f64 = 1e-3;
/// Positions repeat where they differ by less than this share of their spread (root mean square), a period later.
const REPEATS: f64 = 0.03;
/// Lags are tried from where positions have once differed by this share of their spread; and only as long as so large a part overlaps.
const APART: f64 = 0.5;
const OVERLAP: f64 = 0.15;
/// Quarters of a step by which a lag is refined.
const FINER: usize = 4;
/// Fewer windows tell nothing of all this.
const FEWEST: usize = 30;
/// A joint is said to rest from this share of the windows on.
const RESTS: f64 = 0.1;

impl Session {
    /// What should be known of its windows, in sentences.
    pub fn motion_notes(&self) -> Vec<String> {
        let windows: Vec<&Pose> = self.poses.iter().filter(|pose| pose.course.is_some()).collect();
        if windows.len() < FEWEST {
            return Vec::new();
        }
        let proportions = self.in_proportion(&windows).into_iter().chain(self.resting(&windows));
        proportions.chain(self.repeated_periods()).collect()
    }

    fn in_proportion(&self, windows: &[&Pose]) -> Option<String> {
        let n = self.joints.len();
        let product = |a: usize, b: usize| -> f64 {
            windows
                .iter()
                .filter_map(|pose| Some(pose.conditions.velocity.get(a)? * pose.conditions.velocity.get(b)?))
                .sum()
        };
        let squares: Vec<f64> = (0..n).map(|joint| product(joint, joint)).collect();
        let alike = |a: usize, b: usize| {
            squares[a] > 0.0
                && squares[b] > 0.0
                && product(a, b).powi(2) >= (1.0 - PROPORTION) * squares[a] * squares[b]
        };
        let name = |joint: usize| self.robot.chain.joints()[joint].name.as_str();
        let pairs = (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b))).filter(|(a, b)| alike(*a, *b));
        let pairs: Vec<String> = pairs.map(|(a, b)| format!("{} and {}", name(a), name(b))).collect();
        (!pairs.is_empty()).then(|| {
            format!(
                "Joints that move in proportion all the time: {}. What inertia and friction of one do is not told from the other's: move them at \
                 other frequencies.",
                pairs.join(", ")
            )
        })
    }

    /// Joints with friction whose torque does not count in many windows, as it has no known sign there.
    fn resting(&self, windows: &[&Pose]) -> Option<String> {
        let frictional = self.terms.with_friction();
        let reported = |joint: usize| {
            let read = windows.iter().filter(|pose| pose.torque[joint].is_some()).count();
            let rests = windows.len() - read;
            let counts = frictional.contains(&joint) && read > 0 && rests as f64 > RESTS * windows.len() as f64;
            counts.then(|| format!("{} in {rests}", self.robot.chain.joints()[joint].name))
        };
        let resting: Vec<String> = (0..self.joints.len()).filter_map(reported).collect();
        (!resting.is_empty()).then(|| {
            format!(
                "Joints that rest in many of the {} windows: {}. There friction has no known sign, and their torques do not count: let them \
                 turn back quickly.",
                windows.len(),
                resting.join(", ")
            )
        })
    }

    /// Of each file, whether its motion repeats; what is predicted counts, too.
    fn repeated_periods(&self) -> Vec<String> {
        let mut files: BTreeMap<&std::path::Path, Vec<&Pose>> = BTreeMap::new();
        for pose in self.poses.iter().chain(&self.validation).filter(|pose| pose.course.is_some()) {
            files.entry(&self.tables[pose.table].path).or_default().push(pose);
        }
        let reported = |(path, windows): (&std::path::Path, Vec<&Pose>)| {
            let period = repeated_period(&windows)?;
            Some(format!(
                "{}: the motion repeats after {period:.2} s. Another period of the same motion averages noise, and tells no more of the model; a \
                 part of it that is held out or predicted has been seen.",
                file_name(path)
            ))
        };
        files.into_iter().filter_map(reported).collect()
    }
}

/// Positions of all joints, each by its spread, at even steps; nothing where nothing is read.
struct Even {
    step: f64,
    at: Vec<Option<Vec<f64>>>,
}

impl Even {
    fn of(windows: &[&Pose]) -> Option<Even> {
        let mut timed: Vec<(f64, &Vec<f64>)> =
            windows.iter().filter_map(|pose| Some((pose.conditions.time?, &pose.position))).collect();
        timed.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut steps: Vec<f64> = timed.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
        steps.sort_by(f64::total_cmp);
        let step = steps.get(steps.len() / 2).copied().filter(|step| *step > 0.0)?;
        let (first, last) = (timed.first()?.0, timed.last()?.0);
        let count = ((last - first) / step) as usize + 1;
        // Stamps of another day: a motion that long repeats nothing that is looked for.
        if count > 20 * timed.len() {
            return None;
        }
        let joints = timed[0].1.len();
        let mean = |j: usize| timed.iter().map(|(_, q)| q[j]).sum::<f64>() / timed.len() as f64;
        let means: Vec<f64> = (0..joints).map(mean).collect();
        let spread =
            |j: usize| (timed.iter().map(|(_, q)| (q[j] - means[j]).powi(2)).sum::<f64>() / timed.len() as f64).sqrt();
        let moved: Vec<(usize, f64)> =
            (0..joints).map(|j| (j, spread(j))).filter(|(_, spread)| *spread > 0.0).collect();
        let mut before = 0;
        let at = (0..count).map(|place| {
            let time = first + step * place as f64;
            while before + 2 < timed.len() && timed[before + 1].0 <= time {
                before += 1;
            }
            let (a, b) = (timed.get(before)?, timed.get(before + 1)?);
            let share = (time - a.0) / (b.0 - a.0);
            let near = b.0 - a.0 < 1.5 * step && (-1e-6..=1.0 + 1e-6).contains(&share);
            near.then(|| moved.iter().map(|(j, spread)| (a.1[*j] + share * (b.1[*j] - a.1[*j])) / spread).collect())
        });
        Some(Even { step, at: at.collect() })
    }

    /// Root mean square of what positions differ by after so many quarters of a step, in their spreads; nothing where too little overlaps.
    fn difference(&self, quarters: usize) -> Option<f64> {
        let (whole, share) = (quarters / FINER, (quarters % FINER) as f64 / FINER as f64);
        let (mut sum, mut count) = (0.0, 0);
        for place in 0..self.at.len().saturating_sub(whole + 1) {
            let (Some(now), Some(a), Some(b)) = (&self.at[place], &self.at[place + whole], &self.at[place + whole + 1])
            else {
                continue;
            };
            let later = a.iter().zip(b).map(|(a, b)| a + share * (b - a));
            sum +=
                now.iter().zip(later).map(|(now, later)| (now - later).powi(2)).sum::<f64>() / now.len().max(1) as f64;
            count += 1;
        }
        (count >= FEWEST && count as f64 >= OVERLAP * self.at.len() as f64).then(|| (sum / count as f64).sqrt())
    }
}

/// The time after which all joints are where they were, s, if there is one.
fn repeated_period(windows: &[&Pose]) -> Option<f64> {
    if windows.len() < FEWEST {
        return None;
    }
    let even = Even::of(windows)?;
    let mut apart = false;
    for lag in 1.. {
        let difference = even.difference(FINER * lag)?;
        apart |= difference > APART;
        // Whole steps may miss a period by half of one.
        if apart && difference < APART / 2.0 {
            let near = FINER * (lag - 1)..=FINER * (lag + 1);
            let best = near
                .filter_map(|quarters| Some((quarters, even.difference(quarters)?)))
                .min_by(|a, b| a.1.total_cmp(&b.1))?;
            if best.1 < REPEATS {
                return Some(even.step * best.0 as f64 / FINER as f64);
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use gravcal_recording::{Conditions, Course};

    use super::*;

    /// Windows each twentieth of a second of two joints.
    fn windows(count: usize, position: impl Fn(f64) -> [f64; 2]) -> Vec<Pose> {
        let window = |place: usize| {
            let time = 0.05 * place as f64;
            Pose {
                table: 0,
                line: 0,
                sweep_label: None,
                load: None,
                position: position(time).to_vec(),
                orientation: None,
                torque: vec![None; 2],
                instruments: Vec::new(),
                conditions: Conditions { time: Some(time), ..Conditions::default() },
                course: Some(Arc::new(Course::of(&[]))),
            }
        };
        (0..count).map(window).collect()
    }

    fn period(windows: &[Pose]) -> Option<f64> {
        repeated_period(&windows.iter().collect::<Vec<_>>())
    }

    /// Twice through a motion of 8.02 s, whose period is no whole number of windows; and once.
    #[test]
    fn a_motion_that_repeats_is_reported_and_another_is_not() {
        let rate = std::f64::consts::TAU / 8.02;
        let position = |t: f64| {
            [(rate * t).sin() + 0.5 * (3.0 * rate * t).cos(), (2.0 * rate * t).cos() - 0.3 * (5.0 * rate * t).sin()]
        };
        let twice = windows(320, position);
        assert!((period(&twice).unwrap() - 8.02).abs() < 0.02, "{:?}", period(&twice));
        assert_eq!(period(&windows(160, position)), None);
        // The second time somewhat otherwise.
        let other = |t: f64| if t < 8.02 { position(t) } else { position(t).map(|q| 0.8 * q) };
        assert_eq!(period(&windows(320, other)), None);
        // With a part left out in the middle.
        let parts: Vec<Pose> =
            twice.iter().enumerate().filter(|(i, _)| !(150..170).contains(i)).map(|(_, pose)| pose.clone()).collect();
        assert!((period(&parts).unwrap() - 8.02).abs() < 0.02);
    }
}
