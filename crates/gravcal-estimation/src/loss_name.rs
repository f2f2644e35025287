//! Names of the losses, and the widths that go with them.
//!
//! The default width loses 5 % of the information where the noise is normal after all (an efficiency of 95 %):
//!
//! ```text
//!     efficiency = (E ψ′)² / E ψ²,   ψ(r) = ρ′(r²) r,   r normal with unit variance
//! ```
//!
//! Huber 1.345, Tukey 4.685 and Cauchy 2.385 are the usual ones (Holland and Welsch, *Robust regression using iteratively
//! reweighted least-squares*, 1977, table 1).

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use crate::Loss;

/// A loss without its width.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LossName {
    /// [`Loss::None`].
    None,
    /// [`Loss::Huber`].
    Huber,
    /// [`Loss::Cauchy`].
    Cauchy,
    /// [`Loss::Tukey`].
    Tukey,
    /// [`Loss::GemanMcClure`].
    GemanMcClure,
}

impl LossName {
    /// Every loss.
    pub const ALL: [LossName; 5] =
        [LossName::None, LossName::Huber, LossName::Cauchy, LossName::Tukey, LossName::GemanMcClure];

    /// The name in files.
    pub fn as_str(self) -> &'static str {
        match self {
            LossName::None => "none",
            LossName::Huber => "huber",
            LossName::Cauchy => "cauchy",
            LossName::Tukey => "tukey",
            LossName::GemanMcClure => "geman-mcclure",
        }
    }

    /// The loss of an efficiency of 95 %.
    pub fn efficient(self) -> Loss {
        self.with_width(match self {
            LossName::None => f64::INFINITY,
            LossName::Huber => 1.345,
            LossName::Cauchy => 2.3849,
            LossName::Tukey => 4.6851,
            LossName::GemanMcClure => 3.7874,
        })
    }

    /// The loss of this width, in standard deviations; see [`Loss::checked`].
    pub fn with_width(self, width: f64) -> Loss {
        match self {
            LossName::None => Loss::None,
            LossName::Huber => Loss::Huber(width),
            LossName::Cauchy => Loss::Cauchy(width),
            LossName::Tukey => Loss::Tukey(width),
            LossName::GemanMcClure => Loss::GemanMcClure(width),
        }
    }
}

impl Loss {
    /// Which loss it is.
    pub fn name(self) -> LossName {
        match self {
            Loss::None => LossName::None,
            Loss::Huber(_) => LossName::Huber,
            Loss::Cauchy(_) => LossName::Cauchy,
            Loss::Tukey(_) => LossName::Tukey,
            Loss::GemanMcClure(_) => LossName::GemanMcClure,
        }
    }
}

impl fmt::Display for LossName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// No loss has this name.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("unknown loss `{name}`; there is: {known}")]
pub struct UnknownLoss {
    name: String,
    known: String,
}

impl FromStr for LossName {
    type Err = UnknownLoss;

    fn from_str(name: &str) -> Result<Self, UnknownLoss> {
        LossName::ALL
            .into_iter()
            .find(|loss| loss.as_str() == name)
            .ok_or_else(|| UnknownLoss { name: name.to_owned(), known: LossName::ALL.map(LossName::as_str).join(", ") })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the trapezoidal rule, which converges fast for a smooth function that vanishes at both ends.
    fn efficiency(loss: Loss) -> f64 {
        const STEP: f64 = 1e-4;
        let (mut slope, mut square) = (0.0, 0.0);
        for k in -100_000..=100_000_i32 {
            let r = f64::from(k) * STEP;
            let density = STEP * (-0.5 * r * r).exp() / (2.0 * std::f64::consts::PI).sqrt();
            let value = loss.at(r * r);
            slope += density * (value.first + 2.0 * value.second * r * r);
            square += density * (value.first * r).powi(2);
        }
        slope * slope / square
    }

    #[test]
    fn default_widths_are_efficient_to_95_percent() {
        for name in &LossName::ALL[1..] {
            let found = efficiency(name.efficient());
            assert!((found - 0.95).abs() < 1e-4, "{name}: {found}");
        }
        assert!((efficiency(Loss::None) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn names_are_read_as_written() {
        for name in LossName::ALL {
            assert_eq!(name.as_str().parse(), Ok(name));
            assert_eq!(name.efficient().name(), name);
        }
        let error = "welsch".parse::<LossName>().unwrap_err().to_string();
        assert_eq!(error, "unknown loss `welsch`; there is: none, huber, cauchy, tukey, geman-mcclure");
    }
}
