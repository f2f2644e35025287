//! Nonlinear regression of the Statistical Reference Datasets of NIST: 27 data sets with certified parameters.
//!
//! ```text
//!     y_i = f(x_i; b) + e_i,      minimise over b  Σ_i (f(x_i; b) − y_i)²
//! ```
//!
//! The certified values were computed with 500 digits and are printed with 11 (NIST/ITL, *Statistical Reference
//! Datasets*, nonlinear least squares regression, www.itl.nist.gov/div898/strd/nls/nls_info.shtml). The standard
//! deviations are those of the linearized model with the residual variance `s² = Σ r² / (observations − parameters)`.
//! Each data set has a start that is far and one that is near. The files are read, not held here.

mod certified;
mod file;
mod models;
mod regression;

use std::path::Path;
use std::sync::Arc;

pub use certified::Certified;
pub use file::FileError;
pub(super) use regression::Regression;

use super::{Equations, Minimum, PublishedProblem, Start};
use crate::{EvaluateError, Problem, RankAnalysis, Values};
use file::Contents;
use models::{DATA_SETS, Model};

/// Digits of the certified values.
pub const CERTIFIED_DIGITS: f64 = 11.0;

/// A data set, its model, and what NIST certifies.
#[derive(Clone, Debug)]
pub struct CertifiedProblem {
    /// The problem with its two starts.
    pub problem: PublishedProblem,
    /// What is to be found.
    pub certified: Certified,
    /// Terms that may stand in any order, see [`Model::interchangeable`].
    interchangeable: &'static [&'static [usize]],
}

/// Correct digits, as logarithms of relative errors: see [`log_relative_error`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Digits {
    /// Of the worst parameter.
    pub parameters: f64,
    /// Of the worst standard deviation.
    pub standard_deviations: f64,
    /// Of the residual sum of squares.
    pub sum_of_squares: f64,
}

/// Reads all data sets from the folder that holds their files, `Misra1a.dat` and so on.
///
/// # Errors
/// The first file that is absent or does not hold what it should.
pub fn read(folder: &Path) -> Result<Vec<CertifiedProblem>, FileError> {
    DATA_SETS.into_iter().map(|(name, model)| read_one(folder, name, model)).collect()
}

fn read_one(folder: &Path, name: &str, model: Model) -> Result<CertifiedProblem, FileError> {
    let Contents { starts, certified, regression } = file::read(folder.join(format!("{name}.dat")), model)?;
    let start = |(k, values)| Start { name: format!("start {}", k + 1), values, unreachable: None };
    let problem = PublishedProblem {
        name: name.to_owned(),
        source: format!("NIST/ITL StRD, nonlinear regression, {name}.dat"),
        parameters: (1..=certified.parameters.len()).map(|k| format!("b{k}")).collect(),
        linear: model.linear().to_vec(),
        rows: regression.responses.len(),
        starts: starts.into_iter().enumerate().map(start).collect(),
        minima: vec![Minimum {
            sum_of_squares: certified.sum_of_squares,
            parameters: Some(certified.parameters.clone()),
        }],
        equations: Equations::Nist(Arc::new(regression)),
    };
    Ok(CertifiedProblem { problem, certified, interchangeable: model.interchangeable() })
}

impl CertifiedProblem {
    /// How many digits of the certified values are right at `values` of the built problem, in whichever order its
    /// interchangeable terms stand.
    ///
    /// # Errors
    /// Where the model has no value there.
    pub fn digits(&self, built: &Problem, values: &Values) -> Result<Digits, EvaluateError> {
        let certified = &self.certified;
        let sum_of_squares = 2.0 * built.cost(values)?;
        let variance = sum_of_squares / certified.degrees_of_freedom;
        let covariance = RankAnalysis::new(built, values)?.covariance().scaled(variance);
        let order = self.order(values.as_slice());
        let parameters: Vec<f64> = order.iter().map(|k| values.as_slice()[*k]).collect();
        let deviations: Vec<f64> = order.iter().map(|k| covariance.std(*k)).collect();
        Ok(Digits {
            parameters: worst(&parameters, &certified.parameters),
            standard_deviations: worst(&deviations, &certified.standard_deviations),
            sum_of_squares: log_relative_error(sum_of_squares, certified.sum_of_squares),
        })
    }

    /// Which of the found parameters stands for each certified one.
    fn order(&self, found: &[f64]) -> Vec<usize> {
        let sorted = |values: &[f64]| {
            let mut terms = self.interchangeable.to_vec();
            terms.sort_by(|a, b| values[a[0]].total_cmp(&values[b[0]]));
            terms.concat()
        };
        let mut order: Vec<usize> = (0..found.len()).collect();
        let pairs = sorted(&self.certified.parameters).into_iter().zip(sorted(found));
        pairs.for_each(|(certified, found)| order[certified] = found);
        order
    }

    /// Whether the certified values are reached: every parameter to 7 digits, every standard deviation to 5, the residual
    /// sum of squares to 8.
    ///
    /// Lanczos1 is judged by its parameters alone: its residuals of 1e-13 lie below the rounding of responses near one,
    /// so nobody has its sum of squares in double precision, nor the standard deviations that follow from it. Lanczos2,
    /// with residuals of 1e-6, leaves about ten digits, which is enough.
    pub fn reached(&self, digits: Digits) -> bool {
        let follow = digits.standard_deviations >= 5.0 && digits.sum_of_squares >= 8.0;
        digits.parameters >= 7.0 && (follow || self.problem.name == "Lanczos1")
    }
}

fn worst(found: &[f64], certified: &[f64]) -> f64 {
    found.iter().zip(certified).map(|(f, c)| log_relative_error(*f, *c)).fold(CERTIFIED_DIGITS, f64::min)
}

/// `−log10(|found − certified| / |certified|)`, the number of digits that agree, between none and
/// [`CERTIFIED_DIGITS`].
pub fn log_relative_error(found: f64, certified: f64) -> f64 {
    let digits = -((found - certified) / certified).abs().log10();
    // Not `clamp`: a NaN has no digit.
    if digits > 0.0 { digits.min(CERTIFIED_DIGITS) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    fn folder() -> PathBuf {
        let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
        std::env::var_os("GRAVCAL_SHARED_DATA").map_or_else(beside, PathBuf::from).join("nist_strd")
    }

    #[test]
    fn certified_parameters_give_the_certified_values() {
        if !folder().is_dir() {
            eprintln!("SKIPPED: no data sets at {}; set GRAVCAL_SHARED_DATA to the folder above", folder().display());
            return;
        }
        for certified in read(&folder()).unwrap() {
            let name = &certified.problem.name;
            let values = certified.certified.parameters.clone();
            let at = Start { name: "certified".into(), values, unreachable: None };
            let (built, values) = certified.problem.build(&at).unwrap();
            let digits = certified.digits(&built, &values).unwrap();
            assert_eq!(digits.parameters, CERTIFIED_DIGITS);
            // Eleven digits of the parameters leave Lanczos1 with another residual than its own.
            assert!(certified.reached(digits));
            assert!(digits.standard_deviations > 9.0 || name == "Lanczos1", "{name}: {digits:?}");
            assert!(digits.sum_of_squares > 9.0 || name == "Lanczos1", "{name}: {digits:?}");
        }
    }

    #[test]
    fn interchanged_terms_are_the_same_answer() {
        if !folder().is_dir() {
            eprintln!("SKIPPED: no data sets at {}; set GRAVCAL_SHARED_DATA to the folder above", folder().display());
            return;
        }
        let of_lanczos = |certified: &CertifiedProblem| certified.problem.name == "Lanczos2";
        let certified = read(&folder()).unwrap().into_iter().find(of_lanczos).unwrap();
        let mut values = certified.certified.parameters.clone();
        values.rotate_left(2);
        let at = Start { name: "turned".into(), values, unreachable: None };
        let (built, values) = certified.problem.build(&at).unwrap();
        assert!(certified.reached(certified.digits(&built, &values).unwrap()));
    }

    #[test]
    fn digits_are_counted_between_none_and_those_certified() {
        assert!((log_relative_error(1.001, 1.0) - 3.0).abs() < 1e-9);
        assert_eq!(log_relative_error(-2.0, -2.0), CERTIFIED_DIGITS);
        assert_eq!(log_relative_error(50.0, 1.0), 0.0);
        assert_eq!(log_relative_error(f64::NAN, 1.0), 0.0);
    }

    #[test]
    fn an_absent_folder_is_named() {
        let error = read(Path::new("nowhere")).unwrap_err().to_string();
        assert!(error.starts_with("cannot read nowhere/Misra1a.dat"), "{error}");
    }
}
