//! What a torque sensor keeps of the load before: hysteresis and creep.
//!
//! ```text
//!     reading = y − h s − c e        y: the reading of a sensor that keeps nothing
//!     s  goes with y, from −w to w                       a stop (Brokate and Sprekels 1996, section 2.1): half a loop is h w high
//!     de/dt = dy/dt − e/T                                what has not crept yet
//! ```

use serde::Serialize;

/// Hysteresis of all torque sensors.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Hysteresis {
    /// `h`.
    pub share: f64,
    /// `w` of each joint, unit of the reading.
    pub over: Vec<f64>,
}

/// Creep of all torque sensors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Creep {
    /// `c`.
    pub share: f64,
    /// `T`, s.
    #[serde(rename = "time_constant_s")]
    pub time_constant: f64,
}

/// What the torque sensors of one recorded session keep.
pub(super) struct Kept<'a> {
    hysteresis: Option<&'a Hysteresis>,
    creep: Option<Creep>,
    /// Time, s, and readings.
    latest: Option<(f64, Vec<f64>)>,
    stops: Vec<f64>,
    not_crept: Vec<f64>,
}

impl<'a> Kept<'a> {
    pub fn new(hysteresis: Option<&'a Hysteresis>, creep: Option<Creep>) -> Kept<'a> {
        Kept { hysteresis, creep, latest: None, stops: Vec::new(), not_crept: Vec::new() }
    }

    /// What readings lack, by joint; `time`: s, no less than before.
    pub fn lacks(&mut self, readings: &[f64], time: f64) -> Vec<f64> {
        if self.hysteresis.is_none() && self.creep.is_none() {
            return vec![0.0; readings.len()];
        }
        // A sensor has kept nothing before the first.
        let (before, latest) =
            self.latest.replace((time, readings.to_vec())).unwrap_or_else(|| (time, readings.to_vec()));
        self.stops.resize(readings.len(), 0.0);
        self.not_crept.resize(readings.len(), 0.0);
        let mut lacks = vec![0.0; readings.len()];
        for (joint, (reading, latest)) in readings.iter().zip(latest).enumerate() {
            if let Some(Hysteresis { share, over }) = self.hysteresis {
                let stop = &mut self.stops[joint];
                *stop = (*stop + reading - latest).clamp(-over[joint], over[joint]);
                lacks[joint] += share * *stop;
            }
            if let Some(Creep { share, time_constant }) = self.creep {
                let not_crept = &mut self.not_crept[joint];
                *not_crept = *not_crept * ((before - time) / time_constant).exp() + reading - latest;
                lacks[joint] += share * *not_crept;
            }
        }
        lacks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Up and down again far enough: the loop is `2 h w` high, and as wide as the way on which it builds up.
    #[test]
    fn a_loop_is_as_high_as_its_share_of_what_it_builds_up_over() {
        let hysteresis = Hysteresis { share: 0.1, over: vec![0.5] };
        let mut kept = Kept::new(Some(&hysteresis), None);
        let mut lacks = |reading: f64| kept.lacks(&[reading], 0.0)[0];
        let up: Vec<f64> = [0.0, 0.25, 1.0, 3.0].into_iter().map(&mut lacks).collect();
        let down: Vec<f64> = [2.75, 2.5, 2.0, 0.0].into_iter().map(&mut lacks).collect();
        for (found, expected) in up.into_iter().chain(down).zip([0.0, 0.025, 0.05, 0.05, 0.025, 0.0, -0.05, -0.05]) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }

    /// After a step a sensor lacks its share, and a third of that after the time constant.
    #[test]
    fn what_has_not_crept_dies_away() {
        let mut kept = Kept::new(None, Some(Creep { share: 0.01, time_constant: 2.0 }));
        kept.lacks(&[0.0, 5.0], 3.0);
        assert_eq!(kept.lacks(&[10.0, 5.0], 3.1), [0.1, 0.0]);
        // In the next table, say, or a sample later.
        let last = (1..=2).map(|second| kept.lacks(&[10.0, 5.0], 3.1 + f64::from(second))).last().unwrap();
        assert!((last[0] - 0.1 * (-1.0_f64).exp()).abs() < 1e-12 && last[1] == 0.0, "{last:?}");
    }
}
