//! First and second derivatives by time of what is known at moments: those of the polynomial that is nearest to the moments beside.

use std::ops::Range;

use nalgebra::DMatrix;

/// Degree of the polynomial.
const DEGREE: usize = 4;
/// By which share of the usual one a step between two moments of a run may differ from it.
const UNEVEN: f64 = 0.5;

/// The value, and first and second derivatives by time, as sums over moments that follow each other.
#[derive(Clone, Debug)]
pub(super) struct Derivatives {
    pub moments: Range<usize>,
    pub value: Vec<f64>,
    pub first: Vec<f64>,
    pub second: Vec<f64>,
}

/// Of each of some moments at these times, s, over at most `width` of them that follow each other in a run: a run ends where the next step is another than usual, and before the moments `changes`.
pub(super) fn derivatives(times: &[f64], changes: &[usize], width: usize) -> Vec<Derivatives> {
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let usual = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    let follows = |moment: usize| {
        let step = times[moment] - times[moment - 1];
        (step - usual).abs() < UNEVEN * usual && !changes.contains(&moment)
    };
    let mut all = Vec::with_capacity(times.len());
    let mut first = 0;
    for end in 1..=times.len() {
        if end == times.len() || !follows(end) {
            all.extend((first..end).map(|moment| derivatives_at(times, first..end, moment, width)));
            first = end;
        }
    }
    all
}

/// Those of the polynomial that is nearest to the moments of a run next to one: with `x_k` the times of these beside it and `V_kp = x_k^p`, the rows of
/// `(VᵀV)⁻¹ Vᵀ` for the first and the second power, times one and two.
fn derivatives_at(times: &[f64], run: Range<usize>, moment: usize, width: usize) -> Derivatives {
    let count = run.len().min(width);
    let first = moment.saturating_sub(width / 2).clamp(run.start, run.end - count);
    let moments = first..first + count;
    let itself = moments.clone().map(|other| f64::from(u8::from(other == moment))).collect();
    let none =
        Derivatives { moments: moments.clone(), value: itself, first: vec![0.0; count], second: vec![0.0; count] };
    if count < 3 {
        return none;
    }
    let unit = (times[moments.end - 1] - times[first]) / (count - 1) as f64;
    let powers = DMatrix::from_fn(count, DEGREE.min(count - 1) + 1, |place, power| {
        ((times[first + place] - times[moment]) / unit).powi(power as i32)
    });
    let Some(nearest) = (powers.transpose() * &powers).try_inverse().map(|inverse| inverse * powers.transpose()) else {
        return none;
    };
    let row = |power: usize, times: f64| nearest.row(power).iter().map(|weight| times * weight).collect();
    Derivatives { moments, value: row(0, 1.0), first: row(1, 1.0 / unit), second: row(2, 2.0 / (unit * unit)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a quartic they are exact, at the ends of a run, too; no run reaches over a gap, over time that goes back or hardly goes on, or into another load.
    #[test]
    fn torques_are_differentiated_within_their_run() {
        let step = 0.02;
        let times: Vec<f64> = (0..60)
            .map(|k| match k {
                0..14 => step * f64::from(k),
                14..26 => step * f64::from(k) + 0.5,
                26..34 => step * f64::from(k - 26),
                34..40 => step * f64::from(k - 26) + 0.3,
                _ => step * f64::from(k - 27) + 0.301,
            })
            .collect();
        let value = |t: f64| 0.3 - 2.0 * t + 5.0 * t * t - 7.0 * t.powi(3) + 11.0 * t.powi(4);
        let first = |t: f64| -2.0 + 10.0 * t - 21.0 * t * t + 44.0 * t.powi(3);
        let second = |t: f64| 10.0 - 42.0 * t + 132.0 * t * t;
        let run_of = |moment: usize| {
            [0..14, 14..26, 26..34, 34..40, 40..50, 50..60].into_iter().find(|run| run.contains(&moment)).unwrap()
        };
        for width in [9, 17] {
            for (moment, Derivatives { moments, value: by_value, first: by_first, second: by_second }) in
                derivatives(&times, &[50], width).iter().enumerate()
            {
                let run = run_of(moment);
                assert!(
                    moments.start >= run.start && moments.end <= run.end && moments.contains(&moment),
                    "{moments:?}"
                );
                assert_eq!(moments.len(), run.len().min(width));
                let sum =
                    |weights: &[f64]| -> f64 { moments.clone().zip(weights).map(|(k, w)| w * value(times[k])).sum() };
                let (found, expected) =
                    ([sum(by_first), sum(by_second)], [first(times[moment]), second(times[moment])]);
                assert!((sum(by_value) - value(times[moment])).abs() < 1e-9, "{moment}");
                assert!((found[0] - expected[0]).abs() < 1e-8, "{moment}: {found:?} {expected:?}");
                assert!((found[1] - expected[1]).abs() < 1e-6, "{moment}: {found:?} {expected:?}");
            }
        }
    }

    #[test]
    fn two_moments_tell_no_derivative() {
        for (moment, Derivatives { value, first, second, .. }) in derivatives(&[0.0, 0.1], &[], 9).iter().enumerate() {
            assert_eq!((first, second), (&vec![0.0; 2], &vec![0.0; 2]));
            assert_eq!([value[moment], value[1 - moment]], [1.0, 0.0]);
        }
    }
}
