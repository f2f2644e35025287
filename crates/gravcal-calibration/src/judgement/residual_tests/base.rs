//! A base that gives way under the arm.
//!
//! The weight of the arm and its load turns the base by `δ`, which the base sees as gravity that is turned back:
//!
//! ```text
//!     δ = C m,     m = c × g,     g → g − δ × g          c: the first moment of all that hangs on the base, kg·m; C: rad/(N·m)
//! ```
//!
//! `m` and what is felt of `δ` are perpendicular to gravity. What is the same in all poses is a part of gravity. One number `C` is looked for, alike whichever
//! way the moment points: where errors of neighbours are alike, few blocks tell of more than one.

use std::array::from_fn;

use gravcal_estimation::EvaluateError;
use gravcal_robot_model::session::Session;
use nalgebra::Vector3;

use crate::joint::{Solved, State, inertia_in_pose};

/// Step by which gravity is turned, rad.
const STEP: f64 = 1e-4;

/// What turns of gravity do to the whitened residuals.
pub struct TurnedGravity {
    /// For each radian about two axes perpendicular to it.
    pub columns: [Vec<f64>; 2],
    axes: [Vector3<f64>; 2],
}

impl TurnedGravity {
    /// `rows`: of the problem that is judged, whose first ones are the readings.
    pub fn new(solved: &Solved, rows: usize) -> Result<TurnedGravity, EvaluateError> {
        let block = solved.built.variables.gravity;
        let g = Vector3::from_column_slice(solved.estimate.values.get(block));
        let across = g.cross(&Vector3::ith(g.iamin(), 1.0)).normalize();
        let axes = [across, g.cross(&across).normalize()];
        let of_axis = |axis: Vector3<f64>| {
            solved.slope(rows, STEP, |values, angle| values.set(block, (g + angle * axis.cross(&g)).as_slice()))
        };
        Ok(TurnedGravity { columns: [of_axis(axes[0])?, of_axis(axes[1])?], axes })
    }

    /// What a base does to the whitened residuals that turns by a radian under the largest moment of the arm; nothing where there is no moment.
    pub fn leaning(&self, session: &Session, solved: &Solved) -> Vec<Vec<f64>> {
        let state = solved.state(&State::nominal(session));
        let moments: Vec<[f64; 2]> = (0..session.poses.len()).map(|pose| self.moment(session, &state, pose)).collect();
        let largest = moments.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max);
        if largest == 0.0 {
            return Vec::new();
        }
        let mut column = vec![0.0; self.columns[0].len()];
        for (row, id) in solved.built.rows.iter().enumerate() {
            let [x, y] = moments[id.pose];
            column[row] = -(self.columns[0][row] * x + self.columns[1][row] * y) / largest;
        }
        vec![column]
    }

    /// About the base's origin and along the axes, N·m.
    fn moment(&self, session: &Session, state: &State, pose: usize) -> [f64; 2] {
        let own = &session.poses[pose];
        let coordinates = session.terms.coordinates(&own.position, &own.conditions, state);
        let frames = session.robot.chain.forward(&coordinates);
        let bodies = inertia_in_pose(session, state, pose);
        let first_moment: Vector3<f64> = frames
            .iter()
            .zip(&bodies)
            .map(|(frame, [mass, moment @ ..])| {
                *mass * Vector3::from(frame.translation()) + Vector3::from(frame.rotate_vector(*moment))
            })
            .sum();
        let moment = first_moment.cross(&Vector3::from(state.gravity));
        from_fn(|axis| self.axes[axis].dot(&moment))
    }
}
