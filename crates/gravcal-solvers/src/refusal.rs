//! What no unconstrained method can take.

use gravcal_estimation::{Problem, Unsupported};

/// Refuses a problem with constraints.
///
/// # Errors
/// Names them.
pub fn refuse_constraints(solver: &'static str, problem: &Problem) -> Result<(), Unsupported> {
    let names: Vec<String> = problem.constraints().iter().map(|c| format!("`{}`", c.name)).collect();
    let constraints = match names.as_slice() {
        [] => return Ok(()),
        [only] => format!("a constraint ({only})"),
        several => format!("{} constraints ({})", several.len(), several.join(", ")),
    };
    Err(Unsupported { solver, reason: format!("it has {constraints}: clarabel can take them") })
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::{Constraint, SolveContext};

    use crate::testing::{DESCENTS, builder, linear};

    #[test]
    fn every_unconstrained_method_names_the_constraints_that_it_cannot_take() {
        let (mut builder, blocks) = builder(vec![linear("mass", 1.0)], 1, |x, r, j| {
            (r[0], j[0]) = (x[0] - 2.0, 1.0);
            Ok(())
        });
        builder.add_constraint(Constraint::bound("mass is positive", blocks[0], 0, 0.0, f64::INFINITY));
        builder.add_constraint(Constraint::bound("mass is known", blocks[0], 0, 1.0, 3.0));
        let (problem, initial) = builder.build().unwrap();
        for solver in DESCENTS {
            let refused = solver.build().check(&problem).unwrap_err().to_string();
            let reported = "it has 2 constraints (`mass is positive`, `mass is known`): clarabel can take them";
            assert_eq!(refused, format!("{solver} cannot take this problem: {reported}"));
            let solved = solver.build().solve(&problem, &initial, &mut SolveContext::default());
            assert_eq!(solved.unwrap_err().to_string(), refused);
        }
    }
}
