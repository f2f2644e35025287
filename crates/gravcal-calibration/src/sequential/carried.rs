//! Errors that the results of earlier steps have, to first order: what a step allows for when it judges its own readings.
//!
//! A step finds `x` from its readings and from `f`, which earlier steps froze. An error `δf` moves what it finds by `A δf`, so that
//!
//! ```text
//!     cov(x) = (JᵀJ)⁻¹ + A cov(f) Aᵀ,     cov(x, f) = A cov(f)
//! ```
//!
//! Readings of different steps are taken as independent. Step 1 and step 2 may read the same sweeps of joint 2: then step 2 allows
//! for a little more than there is.

use std::ops::Range;

use gravcal_estimation::BlockId;
use gravcal_robot_model::parameter::SensorParameter;
use nalgebra::DMatrix;

use super::fitting::StepFit;

/// The covariance of everything that steps find, in inside units; zero of what is exact or was not found.
#[derive(Clone, Debug)]
pub(super) struct CarriedErrors {
    covariance: DMatrix<f64>,
}

/// Where the numbers of a parameter of a sensor stand.
pub(super) fn place(joint: usize, quantity: SensorParameter) -> Range<usize> {
    let at = SensorParameter::ALL.len() * joint + quantity as usize;
    at..at + 1
}

impl CarriedErrors {
    /// Before any step.
    pub fn none(joints: usize) -> Self {
        let size = SensorParameter::ALL.len() * joints + 3;
        CarriedErrors { covariance: DMatrix::zeros(size, size) }
    }

    /// Where the numbers of gravity stand.
    pub fn gravity(&self) -> Range<usize> {
        let size = self.covariance.nrows();
        size - 3..size
    }

    /// These numbers are exact after all.
    pub fn forget(&mut self, places: Range<usize>) {
        self.covariance.rows_mut(places.start, places.len()).fill(0.0);
        self.covariance.columns_mut(places.start, places.len()).fill(0.0);
    }

    /// The covariance of some numbers.
    pub fn of(&self, places: &[usize]) -> DMatrix<f64> {
        self.covariance.select_rows(places).select_columns(places)
    }

    /// Takes what a step found: blocks, and where their numbers are to stand.
    pub fn take(&mut self, fitted: &StepFit, found: &[(BlockId, Range<usize>)]) {
        let to: Vec<usize> = found.iter().flat_map(|(_, places)| places.clone()).collect();
        let from = fitted.frozen_places();
        let (own, by_frozen) = fitted.errors_of(found.iter().map(|(id, _)| *id));
        let with_all = &by_frozen * self.covariance.select_rows(&from);
        let among = own + with_all.select_columns(&from) * by_frozen.transpose();
        for (i, row) in to.iter().enumerate() {
            self.covariance.row_mut(*row).copy_from(&with_all.row(i));
            self.covariance.column_mut(*row).copy_from(&with_all.row(i).transpose());
        }
        for (i, row) in to.iter().enumerate() {
            for (j, column) in to.iter().enumerate() {
                self.covariance[(*row, *column)] = among[(i, j)];
            }
        }
    }
}
