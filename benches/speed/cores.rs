//! One solve, and judging its end, on one thread and on two in turns: time on the wall. What share of it is serial follows from
//!
//! ```text
//!     T_2 / T_1 = s + (1 - s) / 2
//! ```
//!
//! (Amdahl 1967), and holds waiting and what threads take from each other as well.

use std::time::Instant;

use gravcal_estimation::statistics::StatisticsError;
use gravcal_estimation::{Estimate, Problem, SolveContext, Solver, Values};
use gravcal_identification::Known;
use gravcal_solvers::LevenbergMarquardt;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::stopping;

/// Turns, and the time that they fill together, s.
const LEAST_TURNS: usize = 15;
const ENOUGH: f64 = 2.0;

/// So many threads.
pub fn pool(threads: usize) -> Result<ThreadPool, String> {
    ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| e.to_string())
}

/// Prints how many times faster two threads are than one.
pub fn compare(joint: &Problem, initial: &Values, pools: [&ThreadPool; 2]) -> Result<(), String> {
    let solver = LevenbergMarquardt { stopping: stopping() };
    let solve = || solver.solve(joint, initial, &mut SolveContext::default()).map_err(|e| e.to_string());
    let judge = |end: &Estimate| Known::at::<StatisticsError>(joint, end).map_err(|e| e.to_string());
    let ends = pools.map(|pool| pool.install(solve));
    let [one, two] = ends;
    let (one, two) = (one?, two?);
    if one.values.as_slice() != two.values.as_slice() {
        return Err("two threads lead elsewhere than one".into());
    }
    judge(&one)?;
    print("solve", in_turns(pools, &solve));
    print("judge", in_turns(pools, &|| judge(&one)));
    Ok(())
}

fn print(what: &str, [one, two]: [f64; 2]) {
    let serial = 2.0 * two / one - 1.0;
    println!(
        "  {what} on one thread {:.2} ms, on two {:.2} ms: {:.2} times faster, serial share {:.1} %",
        1e3 * one,
        1e3 * two,
        one / two,
        100.0 * serial
    );
}

/// Shortest times on the wall, which other programs on the machine disturb least.
fn in_turns<T: Send>(pools: [&ThreadPool; 2], work: &(impl Fn() -> T + Sync)) -> [f64; 2] {
    let mut shortest = [f64::INFINITY; 2];
    let began = Instant::now();
    let mut turns = 0;
    while turns < LEAST_TURNS || began.elapsed().as_secs_f64() < ENOUGH {
        for (shortest, pool) in shortest.iter_mut().zip(pools) {
            let start = Instant::now();
            std::hint::black_box(pool.install(work));
            *shortest = shortest.min(start.elapsed().as_secs_f64());
        }
        turns += 1;
    }
    shortest
}
