//! What a residual of one's own is: rows that tie poses together, each with a value and its derivatives.

use std::fmt::Debug;

use super::scene::Scene;
use crate::session::Pose;

/// `f`: prediction less reading, with parameters `x` in which it may be nonlinear; derivatives by hand. A
/// [`ResidualFormula`](super::ResidualFormula) needs none.
pub trait ResidualTerm: Debug + Send + Sync {
    /// What it depends on besides its parameters.
    fn sees(&self) -> Sees;

    /// Its rows: each with the poses that it ties together, by their places in `poses`, and its standard deviation. Called whenever poses
    /// change, so it must not depend on anything else.
    fn ties(&self, poses: &[Pose]) -> Vec<Tie>;

    /// `f` of one row; `at`: its poses, in the order of the tie. `slopes`, where wanted, come as zeros and are filled with all derivatives.
    ///
    /// Where `f` is not defined it is not finite; a solver shortens its step then.
    fn value(&self, tie: &Tie, at: &[Scene<'_>], x: &[f64], slopes: Option<Slopes<'_>>) -> f64;

    /// Whether it holds its derivatives against differences itself: then no session does.
    fn checks_derivatives(&self) -> bool {
        false
    }

    /// Whether its rows come of few calls of [`values`](Self::values), as where a call is dear. They are one factor then.
    fn is_batched(&self) -> bool {
        false
    }

    /// The values of several rows; `slopes`: one a row, or none where they are not wanted.
    fn values(&self, rows: &[ResidualRow<'_>], x: &[f64], values: &mut [f64], slopes: &mut [Slopes<'_>]) {
        let mut slopes = slopes.iter_mut();
        for (ResidualRow { tie, at }, value) in rows.iter().zip(values) {
            *value = self.value(tie, at, x, slopes.next().map(Slopes::reborrow));
        }
    }
}

/// A row with the poses that it ties together.
#[derive(Clone, Copy, Debug)]
pub struct ResidualRow<'a> {
    /// The row.
    pub tie: &'a Tie,
    /// Its poses, in the order of the tie.
    pub at: &'a [Scene<'a>],
}

/// One row of a residual.
#[derive(Clone, Debug, PartialEq)]
pub struct Tie {
    /// The poses that it ties together: one, for an instrument.
    pub poses: Vec<usize>,
    /// Standard deviation of the row, in its unit.
    pub std: f64,
    /// Which of several rows of the same poses it is, where its author tells them apart.
    pub axis: usize,
}

impl Tie {
    /// A row of these poses.
    pub fn new(poses: impl Into<Vec<usize>>, std: f64) -> Tie {
        Tie { poses: poses.into(), std, axis: 0 }
    }

    /// The same as one of several rows of its poses.
    #[must_use]
    pub fn of_axis(self, axis: usize) -> Tie {
        Tie { axis, ..self }
    }

    /// A row of its own for each pose in which a column has a number.
    pub fn in_each(poses: &[Pose], column: usize, std: f64) -> Vec<Tie> {
        let has_number = |pose: &Pose| pose.conditions.further.get(column).is_some_and(|number| number.is_finite());
        (0..poses.len()).filter(|place| has_number(&poses[*place])).map(|place| Tie::new([place], std)).collect()
    }
}

/// What a residual depends on besides its parameters and columns: the problem is built after it, and what is not named here is not a number
/// in [`Scene`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sees {
    pub(crate) gravity: bool,
    pub(crate) joints: Vec<usize>,
}

impl Sees {
    /// Parameters and columns alone.
    pub fn nothing() -> Sees {
        Sees::default()
    }

    /// Gravity in the base's frame, too.
    #[must_use]
    pub fn gravity(self) -> Sees {
        Sees { gravity: true, ..self }
    }

    /// The true coordinates of these joints, too.
    #[must_use]
    pub fn coordinates(mut self, joints: &[usize]) -> Sees {
        for joint in joints {
            if !self.joints.contains(joint) {
                self.joints.push(*joint);
            }
        }
        self.joints.sort_unstable();
        self
    }

    /// Joints whose coordinates it depends on, ascending.
    pub fn joints(&self) -> &[usize] {
        &self.joints
    }

    /// Whether it depends on gravity.
    pub fn sees_gravity(&self) -> bool {
        self.gravity
    }
}

/// The derivatives of a row.
#[derive(Debug)]
pub struct Slopes<'a> {
    /// By each of its parameters, in their order.
    pub by_parameter: &'a mut [f64],
    /// By each component of gravity.
    pub by_gravity: &'a mut [f64; 3],
    /// By the true coordinate of each joint in the first pose of the tie, then in the second, and so on; only of those that [`Sees`] names.
    pub by_coordinate: &'a mut [f64],
}

impl Slopes<'_> {
    /// The same for somebody else to fill.
    pub fn reborrow(&mut self) -> Slopes<'_> {
        let Slopes { by_parameter, by_gravity, by_coordinate } = self;
        Slopes { by_parameter, by_gravity, by_coordinate }
    }
}
