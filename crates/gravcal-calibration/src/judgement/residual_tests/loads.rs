//! What is stated of loads without a standard deviation: a mass, a place, a distance between two.

use gravcal_estimation::{BlockId, EvaluateError, Values};
use gravcal_robot_model::session::{LoadDistance, Session};

use crate::joint::{Solved, State, build_problem};

/// Step of a mass and of a distance, as a share of it, and of a place, m.
const MORE: f64 = 0.01;
const ASIDE: f64 = 1e-4;

/// Columns: what a unit of it does to the whitened residuals. Empty of what is an unknown.
#[derive(Clone, Debug, Default)]
pub struct StatedLoad {
    /// Of its mass, kg⁻¹.
    pub mass: Vec<Vec<f64>>,
    /// Of its place along the axes of the link, m⁻¹.
    pub placement: Vec<Vec<f64>>,
}

/// By load; `rows`: of the problem that is judged, whose first ones are the readings.
///
/// # Errors
/// Where a residual cannot be evaluated beside the solution.
pub fn stated_loads(session: &Session, solved: &Solved, rows: usize) -> Result<Vec<StatedLoad>, EvaluateError> {
    let of = |load: usize| {
        let (mass, placement) = (heavier(session, solved, load, rows)?, aside(session, solved, load, rows)?);
        Ok(StatedLoad { mass: mass.into_iter().collect(), placement })
    };
    (0..session.loads.len()).map(of).collect()
}

/// Of each stated distance, what a metre more of it does to the whitened residuals: one column, or none where its standard deviation is stated, or where it ties no
/// placement to another.
///
/// # Errors
/// Where a residual cannot be evaluated beside the solution.
pub fn stated_distances(session: &Session, solved: &Solved, rows: usize) -> Result<Vec<Vec<Vec<f64>>>, EvaluateError> {
    let of = |stated: &LoadDistance| {
        let Some(displacement) = displacement(solved, stated) else { return Ok(Vec::new()) };
        let longer = |values: &mut Values, by: f64| {
            let other = values.get(displacement).iter().map(|along| (1.0 + by / stated.distance) * along);
            let other: Vec<f64> = other.collect();
            values.set(displacement, &other);
        };
        Ok(vec![solved.slope(rows, MORE * stated.distance, longer)?])
    };
    session.load_distances.iter().map(of).collect()
}

/// The vector of stated length between two placements, of which one is the other and this.
fn displacement(solved: &Solved, stated: &LoadDistance) -> Option<BlockId> {
    let [a, b] = stated.between.map(|load| solved.built.variables.loads[load].as_deref());
    let beyond = |one: &[BlockId], other: &[BlockId]| {
        other.strip_prefix(one).and_then(|rest| match rest {
            [displacement] => Some(*displacement),
            _ => None,
        })
    };
    let ends = a.zip(b).filter(|_| stated.std.is_none());
    ends.and_then(|(a, b)| beyond(a, b).or_else(|| beyond(b, a)))
}

/// What a kilogram more does; nothing where the mass is an unknown or nobody carries it, and where moments are described by sweep, which tell loads of one
/// mass alone.
fn heavier(session: &Session, solved: &Solved, load: usize, rows: usize) -> Result<Option<Vec<f64>>, EvaluateError> {
    let is_stated = !session.loads[load].is_unknown() && session.load_mass(load).is_none();
    let variables = &solved.built.variables;
    if !is_stated || variables.loads[load].is_none() || variables.inertia.is_empty() {
        return Ok(None);
    }
    let (mut heavier, step) = (session.clone(), MORE * session.loads[load].mass);
    heavier.loads[load].mass += step;
    let state = solved.state(&State::nominal(session));
    let Ok(built) = build_problem(&heavier, solved.readings(), &state) else { return Ok(None) };
    let here = solved.built.problem.residuals(&solved.estimate.values)?;
    let there = built.problem.residuals(&solved.estimate.values)?;
    let slopes = there.iter().zip(&here).map(|(there, here)| (there - here) / step);
    let mut slopes: Vec<f64> = slopes.take(solved.built.rows.len()).collect();
    slopes.resize(rows, 0.0);
    Ok(Some(slopes))
}

/// What a metre along each axis does; nothing where the place is an unknown.
fn aside(session: &Session, solved: &Solved, load: usize, rows: usize) -> Result<Vec<Vec<f64>>, EvaluateError> {
    let is_stated = session.loads[load].position.is_some() && session.loads[load].position_std.is_none();
    // With a position of its own a load is tied to no other: its placement is one block.
    let (true, Some(&[placement])) = (is_stated, solved.built.variables.loads[load].as_deref()) else {
        return Ok(Vec::new());
    };
    let along = |axis: usize| {
        solved.slope(rows, ASIDE, |values, by| {
            let mut position = values.get(placement).to_vec();
            position[axis] += by;
            values.set(placement, &position);
        })
    };
    (0..3).map(along).collect()
}
