//! The methods beside each other, on the problem as the program solves it: with its reference.

use gravcal_estimation::{Problem, Solver, Values};
use gravcal_solvers::{Dogleg, GaussNewton, LevenbergMarquardt, VariableProjection};

use crate::table::{heading, print_row};
use crate::{solved, stopping};

/// Prints what each takes.
pub fn compare(poses: usize, problem: &Problem, initial: &Values) -> Result<(), String> {
    let stopping = stopping();
    let methods: [Box<dyn Solver>; 4] = [
        Box::new(LevenbergMarquardt { stopping }),
        Box::new(GaussNewton { stopping }),
        Box::new(Dogleg { stopping }),
        Box::new(VariableProjection { stopping }),
    ];
    heading("time / first");
    let mut first = None;
    for method in methods {
        let row = solved(method.as_ref(), problem, initial)?;
        let ratio = row.seconds / *first.get_or_insert(row.seconds);
        print_row(method.name(), poses, &row, &format!("{ratio:.1}"));
    }
    Ok(())
}
