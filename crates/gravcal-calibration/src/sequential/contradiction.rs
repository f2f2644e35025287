//! A step whose readings rule out its model tells no number.
//!
//! Its χ² allows for the errors of what earlier steps froze ([`StepFit::chi_squared`]), so that these alone silence no step. Where
//! the noise is stated it is held against the distribution of χ², where step 1 found the noise in its own residuals against that of
//! the ratio of the two (F).

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

use super::carried::CarriedErrors;
use super::fitting::StepFit;
use super::found::Missing;

/// Probability below which readings rule out a step's model.
const SIGNIFICANCE: f64 = 1e-3;

/// How the noise of the readings is known that a step is held against.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NoiseScale {
    /// The session states it.
    Stated,
    /// From the residuals of step 1, with so many degrees of freedom.
    Found(usize),
    /// Not at all.
    Unknown,
}

impl NoiseScale {
    /// Probability that noise alone makes χ² as large.
    fn p_value(self, chi_squared: f64, degrees_of_freedom: usize) -> Option<f64> {
        let freedom = degrees_of_freedom as f64;
        match self {
            NoiseScale::Stated => Some(ChiSquared::new(freedom).ok()?.sf(chi_squared)),
            NoiseScale::Found(own) => Some(FisherSnedecor::new(freedom, own as f64).ok()?.sf(chi_squared / freedom)),
            NoiseScale::Unknown => None,
        }
    }
}

/// Refuses a step whose readings are no accident of its model.
///
/// `what`: "step 2", or what of it; `cure`: what would help.
pub(super) fn refuse_contradiction(
    fitted: &StepFit,
    earlier: &CarriedErrors,
    noise: NoiseScale,
    (what, cure): (&str, &str),
) -> Result<(), Missing> {
    let (chi_squared, freedom) = (fitted.chi_squared(earlier), fitted.degrees_of_freedom);
    match noise.p_value(chi_squared, freedom) {
        Some(p) if p < SIGNIFICANCE => {
            let against = match noise {
                NoiseScale::Found(_) => "held against the noise that step 1 found",
                _ => "held against their stated noise",
            };
            let why = format!(
                "its readings contradict the model of {what}: {against}, χ² is {chi_squared:.1} for {freedom} degrees of freedom, \
                 p < 0.001"
            );
            Err(Missing::new(why, cure))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_that_was_found_in_few_residuals_contradicts_later() {
        let p = |noise: NoiseScale| noise.p_value(30.0, 10);
        let [stated, many, few] =
            [NoiseScale::Stated, NoiseScale::Found(100_000), NoiseScale::Found(5)].map(|n| p(n).unwrap());
        assert!(stated < SIGNIFICANCE && (many / stated - 1.0).abs() < 0.02 && few > 0.1, "{stated} {many} {few}");
        assert_eq!(p(NoiseScale::Unknown), None);
        assert_eq!(NoiseScale::Stated.p_value(0.0, 0), None);
    }
}
