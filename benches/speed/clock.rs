//! Times of repeated runs: the processor time of this program, which other programs on the machine disturb less than
//! they disturb the time on the wall.

use std::hint::black_box;

use cpu_time::ProcessTime;

/// Runs of which the median is taken.
const RUNS: usize = 7;

/// Median time of one run, s.
pub fn median_seconds<T>(mut run: impl FnMut() -> T) -> f64 {
    let mut seconds = [0.0; RUNS];
    for second in &mut seconds {
        let start = ProcessTime::now();
        black_box(run());
        *second = start.elapsed().as_secs_f64();
    }
    seconds.sort_by(f64::total_cmp);
    seconds[RUNS / 2]
}

/// Seconds, told in microseconds.
pub fn microseconds(seconds: f64) -> String {
    format!("{:.2}", seconds * 1e6)
}
