//! Residuals without derivatives by hand: the same dual numbers as in [`gravcal_estimation::Automatic`].

use std::fmt::Debug;

use gravcal_estimation::Number;
use num_dual::DualSVec64;

use super::scene::{Lifted, Scene};
use super::term::{ResidualTerm, Sees, Slopes, Tie};
use crate::session::Pose;

/// Derivatives that one evaluation gives.
const DIRECTIONS: usize = 8;

type Dual = DualSVec64<DIRECTIONS>;

/// `f(x; …)` of a [`ResidualTerm`], as a function of generic numbers. [`DifferentiatedResidual`] makes it a term.
///
/// It must be differentiable where it is evaluated; a branch on values is differentiated as the branch taken. A number stands left of a
/// constant (`x * 2.0`, not `2.0 * x`).
pub trait ResidualFormula: Debug + Send + Sync {
    /// What it depends on besides its parameters.
    fn sees(&self) -> Sees;

    /// Its rows: see [`ResidualTerm::ties`].
    fn ties(&self, poses: &[Pose]) -> Vec<Tie>;

    /// `f` of one row: prediction less reading.
    fn value<N: Number>(&self, tie: &Tie, at: &[Scene<'_, N>], x: &[N]) -> N;
}

/// A [`ResidualFormula`] as a [`ResidualTerm`]: derivatives are exact to rounding. Its value has the same bits with and without them.
#[derive(Clone, Debug)]
pub struct DifferentiatedResidual<F>(pub F);

impl<F: ResidualFormula> ResidualTerm for DifferentiatedResidual<F> {
    fn sees(&self) -> Sees {
        self.0.sees()
    }

    fn ties(&self, poses: &[Pose]) -> Vec<Tie> {
        self.0.ties(poses)
    }

    fn value(&self, tie: &Tie, at: &[Scene<'_>], x: &[f64], slopes: Option<Slopes<'_>>) -> f64 {
        if let Some(slopes) = slopes {
            self.differentiate(tie, at, x, slopes);
        }
        self.0.value(tie, at, x)
    }
}

impl<F: ResidualFormula> DifferentiatedResidual<F> {
    fn differentiate(&self, tie: &Tie, at: &[Scene<'_>], x: &[f64], slopes: Slopes<'_>) {
        let sees = self.0.sees();
        let joints = slopes.by_coordinate.len() / at.len().max(1);
        let gravity = at.first().filter(|_| sees.gravity).map(|scene| scene.plain().1);
        let coordinates = at.iter().flat_map(|scene| sees.joints.iter().map(|joint| scene.plain().0[*joint]));
        // Parameters, gravity, then the coordinates of each pose.
        let values: Vec<f64> = x.iter().copied().chain(gravity.into_iter().flatten()).chain(coordinates).collect();
        let behind_gravity = x.len() + if gravity.is_some() { 3 } else { 0 };
        let mut set = |place: usize, slope: f64| match place.checked_sub(behind_gravity) {
            Some(place) => {
                let (scene, joint) = (place / sees.joints.len(), sees.joints[place % sees.joints.len()]);
                slopes.by_coordinate[scene * joints + joint] = slope;
            }
            None if place < x.len() => slopes.by_parameter[place] = slope,
            None => slopes.by_gravity[place - x.len()] = slope,
        };
        for first in (0..values.len()).step_by(DIRECTIONS) {
            let own = first..values.len().min(first + DIRECTIONS);
            let lift = |(place, value): (usize, &f64)| {
                let number = Dual::from_re(*value);
                if own.contains(&place) { number.derivative(place - first) } else { number }
            };
            let numbers: Vec<Dual> = values.iter().enumerate().map(lift).collect();
            let (parameters, rest) = numbers.split_at(x.len());
            let (gravity, rest) = rest.split_at(behind_gravity - x.len());
            let of_joints = |number: (usize, &Dual)| (sees.joints[number.0 % sees.joints.len()], *number.1);
            let coordinates: Vec<(usize, Dual)> = rest.iter().enumerate().map(of_joints).collect();
            let found = self.0.value(tie, &lifted_scenes(at, gravity, &coordinates), parameters);
            // A value without derivative part does not depend on these.
            if let Some(derivatives) = &found.eps.0 {
                own.zip(derivatives.iter()).for_each(|(place, slope)| set(place, *slope));
            }
        }
    }
}

/// `coordinates`: of as many joints for each scene.
fn lifted_scenes<'a>(at: &[Scene<'a>], gravity: &[Dual], coordinates: &'a [(usize, Dual)]) -> Vec<Scene<'a, Dual>> {
    let gravity = <[Dual; 3]>::try_from(gravity).ok();
    let seen = coordinates.len() / at.len().max(1);
    let of_scene = |(index, scene): (usize, &Scene<'a>)| {
        scene.lifted(Lifted { gravity, coordinates: &coordinates[index * seen..(index + 1) * seen] })
    };
    at.iter().enumerate().map(of_scene).collect()
}
