//! Rows of a residual of one's own.
//!
//! ```text
//!     r = f(x; g, θ_1, θ_2, …),     θ_p,j = s_j q_p,j + o_j + Σ f(x; q_p, conditions) + δ_p,j
//! ```
//!
//! over the poses p that a row ties together: see [`residual_models`](crate::residual_models). `δ` are errors of positions, where these are
//! unknowns.

use std::sync::Arc;

use gravcal_dynamics::Chain;
use gravcal_estimation::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};
use gravcal_recording::Conditions;

use super::instrument::{Further, PositionTerms};
use crate::residual_models::{ResidualInUse, ResidualRow, Scene, Slopes, Tie};

/// A pose of a row.
#[derive(Clone, Debug)]
pub struct ModelledScene {
    /// Position readings of all joints.
    pub position: Vec<f64>,
    /// What the table says of the pose.
    pub conditions: Conditions,
    /// Joint, stored column and coefficient of each term of `θ_j = Σ coefficient · x`.
    pub coordinates: Vec<(usize, usize, f64)>,
    /// What position sensors do beyond; their columns are counted as the others.
    pub terms: PositionTerms,
}

/// Rows, mostly one.
#[derive(Clone, Debug)]
pub struct ModelledResidual {
    chain: Arc<Chain>,
    residual: Arc<ResidualInUse>,
    /// Each with the poses of its tie, in its order.
    rows: Vec<(Tie, Vec<ModelledScene>)>,
    blocks: Vec<BlockId>,
    /// First stored column of its own parameters, which are a number each.
    own: usize,
}

/// The coordinates of all joints in each pose of a row, one after the other, and how each depends on parameters of position sensors.
struct Positions {
    coordinates: Vec<f64>,
    further: Vec<Vec<Further>>,
}

/// The derivatives of a row.
struct Derivatives {
    by_parameter: Vec<f64>,
    by_gravity: [f64; 3],
    by_coordinate: Vec<f64>,
}

impl ModelledResidual {
    /// `blocks`: gravity first where it is seen, and from stored column `own` on the parameters of the residual.
    pub fn new(
        (chain, residual): (Arc<Chain>, Arc<ResidualInUse>),
        rows: Vec<(Tie, Vec<ModelledScene>)>,
        (blocks, own): (Vec<BlockId>, usize),
    ) -> ModelledResidual {
        ModelledResidual { chain, residual, rows, blocks, own }
    }

    fn own(&self) -> std::ops::Range<usize> {
        self.own..self.own + self.residual.places.len()
    }

    fn positions(&self, scenes: &[ModelledScene], x: &[f64]) -> Positions {
        let joints = self.chain.joint_count();
        let mut coordinates = vec![0.0; joints * scenes.len()];
        let mut further = Vec::new();
        for (index, scene) in scenes.iter().enumerate() {
            let own = &mut coordinates[index * joints..(index + 1) * joints];
            for (joint, column, coefficient) in &scene.coordinates {
                own[*joint] += coefficient * x[*column];
            }
            further.push(scene.terms.add_to(own, x));
        }
        Positions { coordinates, further }
    }

    /// Evaluates all rows where joints are there.
    fn values(&self, positions: &[Positions], x: &[f64], values: &mut [f64], derivatives: &mut [Derivatives]) {
        let joints = self.chain.joint_count();
        let mut gravity = if self.residual.sees.sees_gravity() { [x[0], x[1], x[2]] } else { [f64::NAN; 3] };
        let mut seen: Vec<Vec<f64>> = positions.iter().map(|positions| positions.coordinates.clone()).collect();
        for (coordinates, (_, scenes)) in seen.iter_mut().zip(&self.rows) {
            for scene in 0..scenes.len() {
                self.residual.hide_unseen(&mut coordinates[scene * joints..(scene + 1) * joints], &mut gravity);
            }
        }
        let mut at: Vec<Vec<Scene<'_>>> = Vec::with_capacity(self.rows.len());
        for (coordinates, (_, scenes)) in seen.iter().zip(&self.rows) {
            let of_row = scenes.iter().enumerate().map(|(index, scene)| {
                let coordinates = &coordinates[index * joints..(index + 1) * joints];
                Scene::new(&self.chain, (coordinates, &scene.position), gravity, &scene.conditions)
            });
            at.push(of_row.collect());
        }
        let rows: Vec<ResidualRow<'_>> =
            self.rows.iter().zip(&at).map(|((tie, _), at)| ResidualRow { tie, at }).collect();
        let mut slopes: Vec<Slopes<'_>> = derivatives.iter_mut().map(Derivatives::slopes).collect();
        self.residual.values(&rows, &x[self.own()], values, &mut slopes);
    }

    fn write(&self, row: &mut [f64], at: (&[ModelledScene], Positions), derivatives: &Derivatives) {
        let (scenes, Positions { further, .. }) = at;
        let Derivatives { by_parameter, by_gravity, by_coordinate } = derivatives;
        if self.residual.sees.sees_gravity() {
            row[..3].copy_from_slice(by_gravity);
        }
        row[self.own()].copy_from_slice(by_parameter);
        let joints = self.chain.joint_count();
        for (index, (scene, further)) in scenes.iter().zip(further).enumerate() {
            let by_joint = &by_coordinate[index * joints..(index + 1) * joints];
            for (joint, column, coefficient) in &scene.coordinates {
                row[*column] += coefficient * by_joint[*joint];
            }
            for Further { joint, place, slope } in further {
                row[place] += slope * by_joint[joint];
            }
        }
    }

    fn check(&self, numbers: &[f64]) -> Result<(), EvaluateError> {
        match numbers.iter().all(|number| number.is_finite()) {
            true => Ok(()),
            false => Err(EvaluateError(format!("residual {} is not defined there", self.residual.name))),
        }
    }
}

impl Derivatives {
    fn slopes(&mut self) -> Slopes<'_> {
        let Derivatives { by_parameter, by_gravity, by_coordinate } = self;
        Slopes { by_parameter, by_gravity, by_coordinate }
    }
}

impl Residual for ModelledResidual {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        self.rows.len()
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let x = x.as_slice();
        let positions: Vec<Positions> = self.rows.iter().map(|(_, scenes)| self.positions(scenes, x)).collect();
        let Some(mut rows) = jacobian else {
            self.values(&positions, x, residual, &mut []);
            return self.check(residual);
        };
        let zeros = |positions: &Positions| Derivatives {
            by_parameter: vec![0.0; self.own().len()],
            by_gravity: [0.0; 3],
            by_coordinate: vec![0.0; positions.coordinates.len()],
        };
        let mut derivatives: Vec<Derivatives> = positions.iter().map(zeros).collect();
        self.values(&positions, x, residual, &mut derivatives);
        self.check(residual)?;
        for (index, (positions, derivatives)) in positions.into_iter().zip(&derivatives).enumerate() {
            let row = rows.row(index);
            self.write(row, (&self.rows[index].1, positions), derivatives);
            self.check(row)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use gravcal_dynamics::{DhConvention, DhRow, JointKind, Link, chain_from_dh};
    use gravcal_estimation::Number;

    use super::*;
    use crate::residual_models::{
        DeclaredResidual, DifferentiatedResidual, ResidualFormula, ResidualModel, Sees, Setting,
        check_residual_derivatives, declare_residual,
    };
    use crate::residuals::testing::{check_at_random_points, ids};
    use crate::sensors::{Options, ParameterSpec, RefusedOption};
    use crate::session::Pose;

    /// `|p₁ − p₂| + (v₁ · e_x) x₁ + x₀ θ₁`: all that a formula can see, in two poses.
    #[derive(Clone, Debug)]
    struct Everything;

    impl ResidualFormula for Everything {
        fn sees(&self) -> Sees {
            Sees::nothing().gravity().coordinates(&[2, 1, 0])
        }

        fn ties(&self, _: &[Pose]) -> Vec<Tie> {
            Vec::new()
        }

        fn value<N: Number>(&self, _: &Tie, at: &[Scene<'_, N>], x: &[N]) -> N {
            let points = [0, 1].map(|scene| at[scene].frame(2).point([x[1], N::from(0.2), N::from(0.3)]));
            let apart = (0..3).map(|axis| points[0][axis] - points[1][axis]).fold(N::from(0.1), |sum, d| sum + d * d);
            apart.sqrt() + at[0].gravity_on(2)[0] * x[1] + x[0] * at[1].coordinate(1) - at[1].column(0)
        }
    }

    impl ResidualModel for Everything {
        fn name(&self) -> &str {
            "everything"
        }

        fn help(&self) -> &str {
            ""
        }

        fn declare(&self, _: &Setting<'_>, _: &Options) -> Result<DeclaredResidual, RefusedOption> {
            let parameter = |name: &str| ParameterSpec::new(name, "1", crate::parameter::Limit::Absolute(1.0));
            Ok(DeclaredResidual::new([parameter("a"), parameter("b")], DifferentiatedResidual(Everything)))
        }
    }

    fn chain() -> Chain {
        let row = |i: usize, kind| DhRow {
            name: format!("joint{i}"),
            kind,
            a: 0.1,
            alpha: 0.7 + i as f64,
            d: 0.2,
            theta: 0.1,
            limits: None,
            link: Link { name: format!("link{i}"), inertia: None },
        };
        let kinds = [JointKind::Revolute, JointKind::Prismatic, JointKind::Revolute];
        let rows: Vec<DhRow> = kinds.into_iter().enumerate().map(|(i, kind)| row(i, kind)).collect();
        chain_from_dh("base", DhConvention::Standard, &rows).unwrap()
    }

    #[test]
    fn derivatives_by_everything_that_a_row_can_see() {
        let chain = chain();
        let conditions = Conditions { further: vec![0.5], ..Conditions::default() };
        let position = [[0.3, 0.1, -0.4], [-0.7, 0.2, 0.9]];
        let scene =
            |index: usize| Scene::new(&chain, (&position[index], &position[index]), [1.0, -2.0, 9.0], &conditions);
        let tie = Tie::new([0, 1], 1.0);
        check_residual_derivatives(
            &DifferentiatedResidual(Everything),
            (&tie, &[scene(0), scene(1)]),
            &[0.4, 0.2],
            1e-6,
        )
        .unwrap();

        // Gravity, gain and offset of each joint, its own two, and an error of the last joint's position in the second pose.
        let lengths = [3, 1, 1, 1, 1, 1, 1, 1, 1, 2];
        let setting = Setting::new(&chain, &[], 0);
        let (mut residual, _) = declare_residual(&Everything, &setting, ("all", &Options::default())).unwrap();
        residual.places = vec![0, 1];
        let scene = |index: usize| {
            let affine = |joint: usize| [(joint, 3 + 2 * joint, position[index][joint]), (joint, 4 + 2 * joint, 1.0)];
            let mut coordinates: Vec<_> = (0..3).flat_map(affine).collect();
            coordinates.extend((index == 1).then_some((2, 12, 1.0)));
            ModelledScene {
                position: position[index].to_vec(),
                conditions: conditions.clone(),
                coordinates,
                terms: PositionTerms::default(),
            }
        };
        let swapped = (Tie::new([1, 0], 1.0), vec![scene(1), scene(0)]);
        let rows = vec![(tie, vec![scene(0), scene(1)]), swapped];
        let rows = ModelledResidual::new((Arc::new(chain.clone()), Arc::new(residual)), rows, (ids(&lengths), 9));
        assert_eq!(rows.len(), 2);
        check_at_random_points(&rows, &lengths, &[0.5; 13]);
    }
}
