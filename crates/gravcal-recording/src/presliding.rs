//! Friction builds up before a joint slides: it follows the joint's way, and not its time.
//!
//! ```text
//!     dz/dq = (sgn q̇ − z) / x         z: from −1 to 1; x: the travel over which it builds up       (Dahl, 1968)
//! ```
//!
//! From one sample to the next a joint goes one way by `Δ`, and the step is exact: `z⁺ = s + (z − s) e^(−|Δ|/x)`, `s = sgn Δ`. As `x` is not known
//! when a recording is read, `z` is followed for several, `x_k = 0.1 mrad (2ᵏ − 1)`; between them its mean over a window is a cubic in
//! `log₂(1 + x / 0.1 mrad)`, in which they are evenly spaced.

/// Travels that are followed; the first is zero: all of friction is there at once.
const TRAVELS: usize = 8;
/// The least of them above zero, rad or m.
const LEAST: f64 = 1e-4;
/// From a joint's start on `z` is not known before it went so many times the longest.
const SETTLED: f64 = 5.0;

/// `z` of one joint, sample by sample.
#[derive(Clone, Debug)]
pub struct DahlFriction {
    /// rad or m in a unit of the position reading.
    gain: f64,
    at: Option<f64>,
    /// How far the joint went, rad or m.
    way: f64,
    states: [f64; TRAVELS],
}

/// `z` by its travel: at a moment, or the mean over a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Presliding([f64; TRAVELS]);

/// `x_k`, rad or m.
fn travel(place: usize) -> f64 {
    LEAST * (f64::from(1u32 << place) - 1.0)
}

impl DahlFriction {
    /// A joint whose start is not known. `gain`: rad or m in a unit of its position reading; where it is negative, the coordinate falls as the reading rises.
    pub fn new(gain: f64) -> DahlFriction {
        DahlFriction { gain, at: None, way: 0.0, states: [0.0; TRAVELS] }
    }

    /// The joint's next position reading.
    pub fn go(&mut self, position: f64) {
        let Some(before) = self.at.replace(position) else { return };
        let step = self.gain * (position - before);
        let (far, sign) = (step.abs(), step.signum());
        if far > 0.0 {
            self.way += far;
            for (place, state) in self.states.iter_mut().enumerate() {
                // Of no travel exp(−∞).
                *state = sign + (*state - sign) * (-far / travel(place)).exp();
            }
        }
    }

    /// `z` at the last position; `None` before the joint went far enough to forget its start.
    pub fn state(&self) -> Option<Presliding> {
        (self.way >= SETTLED * travel(TRAVELS - 1)).then_some(Presliding(self.states))
    }
}

impl Presliding {
    /// The mean of states that count so much each; the weights sum to one.
    pub fn mean(weighted: impl IntoIterator<Item = (f64, Presliding)>) -> Presliding {
        let mut mean = [0.0; TRAVELS];
        for (weight, Presliding(states)) in weighted {
            mean.iter_mut().zip(states).for_each(|(mean, state)| *mean += weight * state);
        }
        Presliding(mean)
    }

    /// `z` for a travel, rad or m, and its slope by that. Straight on beyond the ends, below zero too, where an estimate may lie by chance.
    pub fn at(&self, travel: f64) -> (f64, f64) {
        let Presliding(states) = self;
        let (inside, last) = (travel.clamp(0.0, self::travel(TRAVELS - 1)), TRAVELS - 1);
        let place = (1.0 + inside / LEAST).log2();
        let first = (place.floor() as usize).min(last - 1);
        let slope = |k: usize| {
            let (before, after) = (k.saturating_sub(1), (k + 1).min(last));
            (states[after] - states[before]) / (after - before) as f64
        };
        let (u, [a, b], [da, db]) =
            (place - first as f64, [states[first], states[first + 1]], [slope(first), slope(first + 1)]);
        let (square, cube) = (3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db);
        let value = a + u * (da + u * (square + u * cube));
        let by_place = da + u * (2.0 * square + 3.0 * u * cube);
        let by_travel = by_place / ((LEAST + inside) * std::f64::consts::LN_2);
        (value + (travel - inside) * by_travel, by_travel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `z` of a joint that swings by 0.2 rad, at each of some samples.
    fn swinging(samples: usize) -> Vec<Presliding> {
        let mut friction = DahlFriction::new(1.0);
        (0..samples)
            .filter_map(|sample| {
                friction.go(0.2 * (0.01 * sample as f64).sin());
                friction.state()
            })
            .collect()
    }

    #[test]
    fn after_a_reversal_friction_builds_up_over_the_travel() {
        let mut friction = DahlFriction::new(0.5);
        friction.go(1.0);
        friction.go(2.0);
        let up = friction.state().unwrap();
        assert!((0..8).all(|k| (up.at(travel(k)).0 - 1.0).abs() < 1e-12));
        // Back by 3 mrad, in two steps: the way counts, not the samples.
        friction.go(2.0 - 0.002);
        friction.go(2.0 - 0.006);
        let back = friction.state().unwrap();
        for k in 1..8 {
            let expected = -1.0 + 2.0 * (-0.003 / travel(k)).exp();
            assert!((back.at(travel(k)).0 - expected).abs() < 1e-12);
        }
        assert_eq!(back.at(0.0).0, -1.0);
        // A joint that stays keeps what it had.
        friction.go(2.0 - 0.006);
        assert_eq!(friction.state().unwrap(), back);
    }

    #[test]
    fn before_a_joint_went_far_nothing_is_known() {
        let mut friction = DahlFriction::new(1.0);
        assert!(friction.state().is_none());
        friction.go(0.0);
        friction.go(0.05);
        assert!(friction.state().is_none());
        friction.go(0.0);
        assert!(friction.state().is_some());
    }

    /// Between the travels that are followed a mean over a window is that of the travel itself, nearly.
    #[test]
    fn means_between_travels_are_near_those_of_the_travel() {
        let states = swinging(1000);
        let window = &states[400..640];
        let mean = Presliding::mean(window.iter().map(|state| (1.0 / window.len() as f64, *state)));
        for asked in [0.2e-3, 0.5e-3, 1e-3, 2.2e-3, 5e-3, 1e-2] {
            let (mut z, mut at, mut sum, mut count) = (0.0, 0.0, 0.0, 0);
            let first = 1000 - states.len() + 400;
            for sample in 1..first + 240 {
                let to = 0.2 * (0.01 * sample as f64).sin();
                let sign = f64::signum(to - at);
                z = sign + (z - sign) * (-f64::abs(to - at) / asked).exp();
                at = to;
                if sample >= first {
                    (sum, count) = (sum + z, count + 1);
                }
            }
            let expected = sum / f64::from(count);
            assert!((mean.at(asked).0 - expected).abs() < 3e-3, "{asked}: {} {expected}", mean.at(asked).0);
        }
    }

    #[test]
    fn slopes_are_those_of_the_value_and_go_on_beyond_the_ends() {
        let states = swinging(700);
        let mean = Presliding::mean([(0.3, states[250]), (0.7, states[500])]);
        for asked in [-1e-4, 1e-5, 3e-4, 1.1e-3, 6e-3, 0.02] {
            let step = 1e-9;
            let rise = mean.at(asked + step).0 - mean.at(asked - step).0;
            let slope = mean.at(asked).1;
            assert!((rise / (2.0 * step) - slope).abs() < 1e-5 * slope.abs() + 1e-5, "{asked}: {slope}");
        }
        let ends = [(0.0, -1e-12), (travel(7), travel(7) + 1e-12)];
        assert!(ends.iter().all(|(inside, outside)| (mean.at(*inside).0 - mean.at(*outside).0).abs() < 1e-9));
    }
}
