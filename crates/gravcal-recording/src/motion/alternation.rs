//! Readings that go back and forth from row to row, as where two sources fill one column by turns: two nodes that publish on one topic, or two
//! recordings in one.
//!
//! Second differences `e_t = y_{t+1} − 2 y_t + y_{t−1}` hold next to nothing of a motion. Of white noise of variance σ² and an alternation by ±a
//!
//! ```text
//!     r = Σ e_t e_{t+1} / Σ e_t² = −(16 a² + 4 σ²)/(16 a² + 6 σ²)
//! ```
//!
//! `r` is −2/3 without an alternation, and below −0.9 from `a = σ` on. A few outliers may make it so, and so may a clock that is coarser or less even than
//! the readings of a motion. So the readings themselves must go to and fro, too: of white noise 65 % turn where the one before went the other way, with an
//! alternation by σ nine in ten, and of readings in steps that mostly stay where they are, or go on, hardly any.

use super::channels::Channels;

/// `r` from which on downwards readings alternate.
const BY_TURNS: f64 = -0.9;
/// Share of readings that turn.
const TURNS: f64 = 0.8;
/// Fewer differences show nothing: `r` of white noise scatters by less than `1/√n`.
const FEWEST: u64 = 500;
/// Readings of a channel that are judged together, and of how many such stretches one is looked at.
const STRETCH: u64 = 4096;
const OF_STRETCHES: u64 = 4;

/// Watches the readings of a recording.
#[derive(Clone, Debug)]
pub(crate) struct Alternation {
    channels: Vec<Course>,
}

/// The last readings of a channel and its sums.
#[derive(Clone, Debug, Default)]
struct Course {
    /// Of all readings so far.
    taken: u64,
    last: [f64; 2],
    readings: u64,
    /// The last second difference.
    bent: f64,
    products: f64,
    squares: f64,
    /// How many readings go the other way than the one before.
    turns: u64,
    alternates: bool,
}

impl Alternation {
    pub fn new(channels: usize) -> Alternation {
        Alternation { channels: vec![Course::default(); channels] }
    }

    /// Takes the values of a row; NaN where it says nothing.
    pub fn take(&mut self, values: &[f64]) {
        for (course, value) in self.channels.iter_mut().zip(values).filter(|(_, value)| value.is_finite()) {
            course.take(*value);
        }
    }

    /// The columns whose readings alternate.
    pub fn columns(&mut self, channels: &Channels) -> Vec<String> {
        self.channels.iter_mut().for_each(Course::judge);
        let found = self.channels.iter().zip(&channels.list).filter(|(course, _)| course.alternates);
        found.map(|(_, channel)| channel.column.clone()).collect()
    }
}

impl Course {
    fn take(&mut self, value: f64) {
        self.taken += 1;
        if (self.taken / STRETCH).is_multiple_of(OF_STRETCHES) {
            self.look_at(value);
        } else if self.readings > 0 {
            self.judge();
        }
    }

    fn look_at(&mut self, value: f64) {
        let [before, last] = self.last;
        self.last = [last, value];
        self.readings += 1;
        if self.readings < 3 {
            return;
        }
        let bent = value - 2.0 * last + before;
        self.turns += u64::from((value - last) * (last - before) < 0.0);
        if self.readings > 3 {
            self.products += bent * self.bent;
            self.squares += bent * bent;
        }
        self.bent = bent;
    }

    /// Judges what was seen, and begins anew.
    fn judge(&mut self) {
        let by_turns = self.products < BY_TURNS * self.squares && self.turns as f64 > TURNS * self.readings as f64;
        let alternates = self.readings >= FEWEST && by_turns;
        *self = Course { taken: self.taken, alternates: self.alternates || alternates, ..Course::default() };
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;

    /// A sine and noise of standard deviation one, with another source by turns that reads `apart` more.
    fn alternates(apart: f64, rows: usize) -> bool {
        let mut random = Pcg64::seed_from_u64(7);
        let mut watch = Alternation::new(1);
        for row in 0..rows {
            let noise: f64 = (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
            let other = if row % 2 == 1 { apart } else { 0.0 };
            watch.take(&[100.0 * (0.01 * row as f64).sin() + noise + other]);
        }
        watch.channels[0].judge();
        watch.channels[0].alternates
    }

    #[test]
    fn readings_of_two_sources_alternate_and_those_of_one_do_not() {
        // ± a is half of what they are apart.
        assert!(alternates(3.0, 5000) && alternates(20.0, 600) && alternates(20.0, 60_000));
        assert!(!alternates(0.0, 5000) && !alternates(1.0, 5000) && !alternates(0.0, 60_000));
    }

    /// Sharp steps to and fro where a recording begins.
    #[test]
    fn outliers_are_no_other_source() {
        let mut random = Pcg64::seed_from_u64(8);
        let mut watch = Alternation::new(1);
        for row in 0..800 {
            let noise: f64 = (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
            let outlier = if (10..20).contains(&row) { 300.0 * f64::from(row % 2) } else { 0.0 };
            watch.take(&[noise + outlier]);
        }
        let Course { products, squares, .. } = watch.channels[0];
        assert!(products < BY_TURNS * squares);
        watch.channels[0].judge();
        assert!(!watch.channels[0].alternates);
    }

    /// Motion that is read in steps, at a coarse clock, or at uneven times; and a count that flickers once.
    #[test]
    fn motion_read_coarsely_is_no_other_source() {
        let alternates = |reading: &dyn Fn(f64) -> f64| {
            let mut watch = Alternation::new(1);
            (0..4000).for_each(|row| watch.take(&[reading(f64::from(row))]));
            watch.channels[0].judge();
            watch.channels[0].alternates
        };
        for speed in [0.46, 0.48, 2.5] {
            assert!(!alternates(&|row| (speed * row).floor()), "{speed}");
        }
        assert!(!alternates(&|row| (1e-3 * (0.5 * row).floor()).sin()));
        assert!(!alternates(&|row| (1e-3 * (row + 0.1 * (row % 2.0))).sin()));
        assert!(!alternates(&|row| if (100.0..109.0).contains(&row) { row % 2.0 } else { 0.0 }));
    }

    #[test]
    fn few_readings_and_such_as_never_change_show_nothing() {
        assert!(!alternates(20.0, 400));
        let mut watch = Alternation::new(1);
        (0..5000).for_each(|_| watch.take(&[1.0]));
        assert!(!watch.channels[0].alternates);
    }
}
