//! From a model to a residual of a session: what any crate may declare is checked here.

use std::sync::Arc;

use super::derivative_check::check_residual_derivatives;
use super::model::{DeclaredResidual, ResidualModel, Setting};
use super::scene::{Scene, only_seen};
use super::term::{ResidualRow, ResidualTerm, Sees, Slopes, Tie};
use crate::parameter::Parameter;
use crate::sensors::{Options, RefusedOption, TOLERANCE, WrongDerivative, check_parameters, declared_parameter};
use crate::session::Pose;

/// A residual of a session.
#[derive(Clone, Debug)]
pub struct ResidualInUse {
    /// Its name in the session.
    pub name: String,
    /// The name of its model.
    pub model: String,
    /// What it depends on besides its parameters.
    pub sees: Sees,
    /// Places of its parameters among the further ones of the session, in the order in which it takes them.
    pub places: Vec<usize>,
    term: Arc<dyn ResidualTerm>,
}

impl ResidualInUse {
    /// Its rows in these poses. Rows that tie poses that there are not, or none, are none; nor are those of an arm in motion.
    pub fn ties(&self, poses: &[Pose]) -> Vec<Tie> {
        let stands = |place: &usize| poses.get(*place).is_some_and(|pose| pose.course.is_none());
        let mut ties = self.term.ties(poses);
        ties.retain(|tie| !tie.poses.is_empty() && tie.poses.iter().all(stands));
        ties
    }

    /// Whether the derivatives of a row are what differences say, unless the residual looks after that itself. `x`: its parameters.
    ///
    /// # Errors
    /// The first that is not.
    pub fn check_derivatives(&self, tie: &Tie, at: &[Scene<'_>], x: &[f64]) -> Result<(), WrongDerivative> {
        match self.term.checks_derivatives() {
            true => Ok(()),
            false => check_residual_derivatives(self.term.as_ref(), (tie, at), x, TOLERANCE),
        }
    }

    /// The value of a row.
    pub fn value(&self, tie: &Tie, at: &[Scene<'_>], x: &[f64], slopes: Option<Slopes<'_>>) -> f64 {
        self.term.value(tie, at, x, slopes)
    }

    /// Whether its rows are to be computed together: see [`ResidualTerm::is_batched`].
    pub fn is_batched(&self) -> bool {
        self.term.is_batched()
    }

    /// The values of several rows: see [`ResidualTerm::values`].
    pub fn values(&self, rows: &[ResidualRow<'_>], x: &[f64], values: &mut [f64], slopes: &mut [Slopes<'_>]) {
        self.term.values(rows, x, values, slopes);
    }

    /// Makes no numbers of coordinates of joints, and of gravity, that it does not see.
    pub fn hide_unseen(&self, coordinates: &mut [f64], gravity: &mut [f64; 3]) {
        only_seen(&self.sees, coordinates);
        if !self.sees.gravity {
            *gravity = [f64::NAN; 3];
        }
    }
}

/// What a model declares for one `[[residual]]` called `name`: its residual, and its parameters, whose places are not known yet.
pub fn declare_residual(
    model: &dyn ResidualModel,
    setting: &Setting<'_>,
    (name, options): (&str, &Options),
) -> Result<(ResidualInUse, Vec<Parameter>), RefusedOption> {
    let DeclaredResidual { parameters, term } = model.declare(setting, options)?;
    check_parameters(&parameters)?;
    let sees = term.sees();
    let count = setting.chain().joint_count();
    if let Some(joint) = sees.joints.iter().find(|joint| **joint >= count) {
        let message = format!("the model sees joint number {joint}, counted from 0, but the robot has {count} joints");
        return Err(RefusedOption::new("kind", message));
    }
    let parameters = parameters.into_iter().map(|spec| declared_parameter(name, spec, false)).collect();
    let residual =
        ResidualInUse { name: name.to_owned(), model: model.name().to_owned(), sees, places: Vec::new(), term };
    Ok((residual, parameters))
}
