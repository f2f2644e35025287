//! How rows come by a recording's clock, for whoever reads why nothing was found: at which rate, or in bursts.
//!
//! A recorder that stamps rows when it gets them may get several at once. Then most steps of the clock are next to nothing, and nearly all time
//! passes between bursts.

use std::fmt;

use super::median;

/// How long an arm should stand, s, which takes some of it to settle; and how many samples: eight blocks of four ([`crate::still`]), and those
/// between motion and standstill.
const STAND: f64 = 0.5;
pub(crate) const STANDING_SAMPLES: f64 = 40.0;
/// A column that says something in less than this share of the rows is told with its own rate.
const SELDOM: f64 = 0.8;
/// Steps that are looked at.
const FIRST: usize = 20_000;
/// A step so many times the median one is a pause, or the time from burst to burst.
const PAUSE: f64 = 5.0;
/// Pauses are bursts' where there are so many, all together and among the steps, and so much of the time passes in them.
const FEWEST: usize = 5;
const OF_STEPS: f64 = 0.01;
const OF_TIME: f64 = 0.5;
/// No recording has rows so far apart, s.
const HARDLY_SECONDS: f64 = 1.5;
/// Nor so near each other, s: drives are controlled at some 10 kHz.
const HARDLY_APART: f64 = 3e-5;
/// A larger share of rows that go backwards in time is no jump of the clock.
const UNORDERED: f64 = 0.01;

/// How rows come by a recording's clock.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RowClock {
    /// Name of its column.
    pub column: String,
    /// Rows a second; of bursts, in all. Zero where the clock stands.
    pub rate: f64,
    /// Where rows come in bursts: how many in one, and from one to the next, s.
    pub bursts: Option<(f64, f64)>,
    /// The column that says something most seldom, of those that must stand, and how often a second; `None` where nearly every row says
    /// all of them. Two topics have rows of their own, at their own rates.
    pub seldom: Option<(String, f64)>,
    /// Share of the rows that say where the first joint is whose time is less than that of the one before.
    pub backwards: f64,
}

impl RowClock {
    /// What to do where neither standstills nor slow sweeps are found.
    pub fn advice(&self) -> String {
        self.cure(&format!(
            "let the arm stand for {:.1} s or more in each pose (readings.still), or move one joint slowly to and fro while the others stand \
             (readings.sweeps)",
            STAND.max(STANDING_SAMPLES / self.seldom.as_ref().map_or(self.rate, |(_, rate)| *rate))
        ))
    }

    /// What can hardly be of these times, and what to do.
    pub fn doubt(&self) -> Option<String> {
        let RowClock { column, rate, backwards, .. } = self;
        if *backwards > UNORDERED {
            return Some(format!(
                "the clock `{column}` goes backwards in {:.0} % of the rows: they are not in the order of time. Sort them by it.",
                100.0 * backwards
            ));
        }
        if *rate <= 0.0 {
            return None;
        }
        let apart = rate.recip();
        let unit = if apart > HARDLY_SECONDS {
            "unit = \"ms\" }, or µs, or ns"
        } else if apart < HARDLY_APART && self.bursts.is_none() {
            // Of bursts the rate is that of all rows.
            "unit = \"s\" }, or ms, or µs"
        } else {
            return None;
        };
        Some(format!(
            "by the clock `{column}` rows are {apart:.3e} s apart: is its unit right? Say it (readings.time = {{ column = \"{column}\", {unit})."
        ))
    }

    /// The same where the slowest column says something a second so many times.
    pub(crate) fn with_slowest(self, column: &str, rate: f64) -> RowClock {
        let seldom = (rate < SELDOM * self.rate).then(|| (column.to_owned(), rate));
        RowClock { seldom, ..self }
    }

    /// What to do where rows come too seldom or end too soon: `otherwise`, but of times that can hardly be, and of bursts, something else.
    pub(crate) fn cure(&self, otherwise: &str) -> String {
        if let Some(doubt) = self.doubt() {
            return doubt.trim_end_matches('.').to_owned();
        }
        match self.bursts {
            None => otherwise.to_owned(),
            Some((_, apart)) if apart > HARDLY_SECONDS => "is the unit of the clock right? say it: readings.time = { column = \"…\", unit = \"ms\" }, or µs, or ns".to_owned(),
            Some(_) => "these are times at which rows were received or written: name a column with the times at which they were measured \
                        (readings.time = { column = \"…\", unit = \"s\" }), record those (header.stamp), or, where rows are evenly spaced, \
                        write such times"
                .to_owned(),
        }
    }
}

impl fmt::Display for RowClock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let RowClock { column, rate, bursts, seldom, .. } = self;
        match bursts {
            Some((rows, apart)) => write!(
                f,
                "by its clock `{column}` rows come in bursts of about {rows:.0}, {apart:.3} s apart ({} Hz in all)",
                hertz(*rate)
            ),
            None => write!(f, "by its clock `{column}` rows come at {} Hz", hertz(*rate)),
        }?;
        match seldom {
            Some((slowest, rate)) => write!(f, ", and `{slowest}` in {} of them a second", hertz(*rate)),
            None => Ok(()),
        }
    }
}

/// With three digits, or all before the point.
fn hertz(rate: f64) -> String {
    let decimals = if rate >= 100.0 { 0 } else { 2 };
    let text = format!("{rate:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Steps of a clock from row to row, in memory that does not grow.
#[derive(Clone, Debug, Default)]
pub(crate) struct ClockSteps {
    last: Option<f64>,
    steps: Vec<f64>,
    /// Of rows that say where the first joint is: the last time, how many there are, and how many go backwards.
    of_first: (Option<f64>, u64, u64),
}

impl ClockSteps {
    /// `says_first`: whether the row says where the first joint is; topics come with delays of their own.
    pub fn take(&mut self, time: f64, says_first: bool) {
        if says_first {
            let (last, rows, backwards) = self.of_first;
            let goes_back = last.is_some_and(|last| time < last);
            self.of_first = (Some(time), rows + 1, backwards + u64::from(goes_back));
        }
        if self.steps.len() < FIRST
            && let Some(last) = self.last.replace(time)
        {
            self.steps.push(time - last);
        }
        self.last = Some(time);
    }

    /// What they come to, of the clock in this column.
    pub fn clock(&self, column: &str) -> RowClock {
        let steps: Vec<f64> = self.steps.iter().copied().filter(|step| *step >= 0.0).collect();
        let (_, rows, backwards) = self.of_first;
        let backwards = backwards as f64 / rows.max(1) as f64;
        let forward: Vec<f64> = steps.iter().copied().filter(|step| *step > 0.0).collect();
        let column = column.to_owned();
        if forward.is_empty() {
            return RowClock { column, backwards, ..RowClock::default() };
        }
        let usual = median(forward.clone());
        let whole: f64 = forward.iter().sum();
        let (count, standing) = (steps.len() as f64, steps.len() - forward.len());
        let pauses: Vec<f64> = forward.iter().copied().filter(|step| *step > PAUSE * usual).collect();
        let paused: f64 = pauses.iter().sum();
        let are_bursts = pauses.len() >= FEWEST && pauses.len() as f64 >= OF_STEPS * count && paused > OF_TIME * whole;
        if are_bursts {
            let (rows, apart) = ((count + 1.0) / (pauses.len() + 1) as f64, whole / pauses.len() as f64);
            return RowClock { column, rate: rows / apart, bursts: Some((rows, apart)), seldom: None, backwards };
        }
        // Rows of one time.
        if standing >= forward.len() {
            let rows = (count + 1.0) / (forward.len() + 1) as f64;
            return RowClock { column, rate: rows / usual, bursts: Some((rows, usual)), seldom: None, backwards };
        }
        RowClock { column, rate: usual.recip(), bursts: None, seldom: None, backwards }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(times: impl Iterator<Item = f64>) -> String {
        let mut steps = ClockSteps::default();
        times.for_each(|time| steps.take(time, true));
        steps.clock("t").to_string()
    }

    #[test]
    fn even_rows_have_a_rate_whatever_pauses_there_are() {
        assert_eq!(clock((0..50).map(|row| 0.2 * f64::from(row))), "by its clock `t` rows come at 5 Hz");
        let with_pauses = (0..3000).map(|row| 0.002 * f64::from(row) + 60.0 * f64::from(row / 500));
        assert_eq!(clock(with_pauses), "by its clock `t` rows come at 500 Hz");
    }

    /// The arm must stand as long as the slowest column needs.
    #[test]
    fn a_column_that_says_something_seldom_has_its_own_rate() {
        let clock = RowClock { column: "t".to_owned(), rate: 100.0, ..RowClock::default() };
        let slow = clock.clone().with_slowest("tau", 20.0);
        assert_eq!(slow.to_string(), "by its clock `t` rows come at 100 Hz, and `tau` in 20 of them a second");
        assert!(slow.advice().starts_with("let the arm stand for 2.0 s or more"), "{}", slow.advice());
        assert_eq!(clock.clone().with_slowest("tau", 99.0), clock);
    }

    #[test]
    fn times_that_can_hardly_be_are_doubted() {
        let doubt = |times: &mut dyn Iterator<Item = f64>| {
            let mut steps = ClockSteps::default();
            times.for_each(|time| steps.take(time, true));
            steps.clock("t").doubt()
        };
        assert_eq!(doubt(&mut (0..500).map(f64::from)), None);
        let shuffled = doubt(&mut (0..500).map(|row| f64::from(row ^ 1))).unwrap();
        assert!(shuffled.starts_with("the clock `t` goes backwards in 50 % of the rows"), "{shuffled}");
        let nanoseconds = doubt(&mut (0..500).map(|row| 1e3 * f64::from(row))).unwrap();
        assert!(nanoseconds.contains("rows are 1.000e3 s apart: is its unit right?"), "{nanoseconds}");
        let seconds = doubt(&mut (0..500).map(|row| 5e-6 * f64::from(row))).unwrap();
        assert!(seconds.contains("rows are 5.000e-6 s apart") && seconds.contains("unit = \"s\""), "{seconds}");
        assert_eq!(doubt(&mut (0..500).map(|row| 1e-4 * f64::from(row))), None);
        let clock = RowClock { column: "t".to_owned(), rate: 0.05, backwards: 0.4, ..RowClock::default() };
        assert!(clock.advice().ends_with("they are not in the order of time. Sort them by it"), "{}", clock.advice());
    }

    #[test]
    fn rows_of_equal_or_nearly_equal_times_are_bursts() {
        let bursts = "by its clock `t` rows come in bursts of about 10, 0.100 s apart (100 Hz in all)";
        assert_eq!(clock((0..1000).map(|row| 0.1 * f64::from(row / 10))), bursts);
        assert_eq!(clock((0..1000).map(|row| 0.1 * f64::from(row / 10) + 1e-5 * f64::from(row % 10))), bursts);
    }
}
