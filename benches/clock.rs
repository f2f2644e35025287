//! Times of repeated runs: the processor time of this program, which other programs on the machine disturb less than
//! they disturb the time on the wall.

use std::hint::black_box;

use cpu_time::ProcessTime;

/// Fewest runs of which the median is taken, and the time that short ones fill together, s.
const RUNS: usize = 7;
const ENOUGH: f64 = 0.2;

/// Median time of one run, s.
pub fn median_seconds<T>(mut run: impl FnMut() -> T) -> f64 {
    let mut seconds: Vec<f64> = Vec::new();
    while seconds.len() < RUNS || seconds.iter().sum::<f64>() < ENOUGH {
        let start = ProcessTime::now();
        black_box(run());
        seconds.push(start.elapsed().as_secs_f64());
    }
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}

/// Seconds, told in microseconds.
pub fn microseconds(seconds: f64) -> String {
    format!("{:.2}", seconds * 1e6)
}
