//! Robust losses: how much a residual far beyond its noise still counts.
//!
//! With `s = ‖r‖²` of the whitened residual (of one row where the noise is independent, of the whole factor where it
//! is correlated) a factor costs `½ ρ(s)` instead of `½ s`. Every loss has a *width* `c`, in standard deviations:
//!
//! | loss | ρ(s) | weight ρ′(s) |
//! |---|---|---|
//! | none | s | 1 |
//! | Huber | s up to c², 2c√s − c² beyond | 1, c/√s |
//! | Cauchy | c² ln(1 + s/c²) | 1/(1 + s/c²) |
//! | Tukey | c²/3 (1 − (1 − s/c²)³) up to c², c²/3 beyond | (1 − s/c²)², 0 |
//! | Geman-McClure | s c²/(s + c²) | (c²/(s + c²))² |
//!
//! Gradient `ρ′ Jᵀ r`; Hessian, without the second derivatives of r, `Jᵀ (ρ′ I + 2 ρ″ r rᵀ) J`. The second-order term
//! takes curvature away along r; it enters as far as it leaves [`LEAST_CURVATURE`] of the rest, so that the model
//! of the cost stays convex. (Triggs, McLauchlan, Hartley, Fitzgibbon, *Bundle adjustment: a modern synthesis*, 2000,
//! eq. 10 to 12; Huber, *Robust statistics*, 1981; Zhang, *Parameter estimation techniques*, 1997, table 1.)
//!
//! Huber's and Cauchy's widths matter little. Tukey's and Geman-McClure's cost is not convex: they need a start from
//! which good readings already look good.

use thiserror::Error;

/// Share of the first-order curvature that is kept along the residual.
const LEAST_CURVATURE: f64 = 0.1;

/// Widths between which a loss does anything but forget every reading or none, in standard deviations.
const NARROWEST: f64 = 1e-3;
const WIDEST: f64 = 1e6;

/// A robust loss with its width, in standard deviations of the reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Loss {
    /// The square: least squares.
    #[default]
    None,
    /// Quadratic up to the width, linear beyond.
    Huber(f64),
    /// Logarithmic: the log-likelihood of a Cauchy distribution.
    Cauchy(f64),
    /// Constant beyond the width: such readings count nothing.
    Tukey(f64),
    /// Bounded: the influence falls with the cube of the distance.
    GemanMcClure(f64),
}

/// A width that is none.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("the width {0} of a loss must be between {NARROWEST} and {WIDEST} standard deviations")]
pub struct LossWidth(pub f64);

/// ρ and its derivatives at one s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LossValue {
    pub value: f64,
    pub first: f64,
    pub second: f64,
}

impl Loss {
    /// The width, unless there is no loss.
    pub fn width(self) -> Option<f64> {
        match self {
            Loss::None => None,
            Loss::Huber(c) | Loss::Cauchy(c) | Loss::Tukey(c) | Loss::GemanMcClure(c) => Some(c),
        }
    }

    /// The same, if its width is one.
    ///
    /// # Errors
    /// Where the width is not between a thousandth of a standard deviation and a million of them.
    pub fn checked(self) -> Result<Self, LossWidth> {
        match self.width() {
            Some(width) if !(NARROWEST..=WIDEST).contains(&width) => Err(LossWidth(width)),
            _ => Ok(self),
        }
    }

    /// ρ, ρ′ and ρ″ at `s`, the squared norm of a whitened residual.
    pub(crate) fn at(self, s: f64) -> LossValue {
        let of = |value, first, second| LossValue { value, first, second };
        match self {
            Loss::None => of(s, 1.0, 0.0),
            Loss::Huber(c) if s <= c * c => of(s, 1.0, 0.0),
            Loss::Huber(c) => {
                let root = s.sqrt();
                of(2.0 * c * root - c * c, c / root, -0.5 * c / (s * root))
            }
            Loss::Cauchy(c) => {
                let weight = 1.0 / (1.0 + s / (c * c));
                of(c * c * (s / (c * c)).ln_1p(), weight, -weight * weight / (c * c))
            }
            Loss::Tukey(c) if s <= c * c => {
                let inner = 1.0 - s / (c * c);
                of(s / 3.0 * (1.0 + inner + inner * inner), inner * inner, -2.0 * inner / (c * c))
            }
            Loss::Tukey(c) => of(c * c / 3.0, 0.0, 0.0),
            Loss::GemanMcClure(c) => {
                let weight = c * c / (s + c * c);
                of(s * weight, weight * weight, -2.0 * weight * weight / (s + c * c))
            }
        }
    }

    /// Puts the loss into correlated whitened rows of a Jacobian (row-major) and its residual: afterwards their products
    /// are the gradient and the curvature of the cost. `J̃ = √ρ′ J + (b − √ρ′) r (rᵀJ)/s`: only the part along r loses
    /// curvature.
    pub(crate) fn correct_together(self, jacobian: &mut [f64], r: &mut [f64]) {
        if self == Loss::None || jacobian.is_empty() {
            return;
        }
        let width = jacobian.len() / r.len();
        let s = r.iter().map(|r| r * r).sum();
        let value = self.at(s);
        let (residual, along) = value.correction(s);
        let across = value.first.max(0.0).sqrt();
        for column in 0..width {
            let projection: f64 = jacobian.chunks_exact(width).zip(&*r).map(|(row, r)| row[column] * r).sum();
            let extra = if s > 0.0 { (along - across) * projection / s } else { 0.0 };
            for (row, r) in jacobian.chunks_exact_mut(width).zip(&*r) {
                row[column] = across * row[column] + extra * r;
            }
        }
        r.iter_mut().for_each(|r| *r *= residual);
    }
}

impl LossValue {
    /// Factors `(a, b)` of the corrected residual `a r` and of the part of J along r, which becomes `b` times itself
    /// while the rest becomes `√ρ′` times itself: then `J̃ᵀ r̃` is the gradient and `J̃ᵀ J̃` the Hessian.
    pub(crate) fn correction(self, s: f64) -> (f64, f64) {
        if self.first <= 0.0 {
            return (0.0, 0.0);
        }
        let curvature = (1.0 + 2.0 * s * self.second / self.first).max(LEAST_CURVATURE);
        ((self.first / curvature).sqrt(), (self.first * curvature).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Loss; 5] = [Loss::None, Loss::Huber(1.3), Loss::Cauchy(2.4), Loss::Tukey(4.7), Loss::GemanMcClure(2.0)];

    #[test]
    fn derivatives_are_those_of_the_value() {
        for loss in ALL {
            for s in [0.01, 0.5, 1.0, 3.0, 9.0, 21.0, 40.0] {
                let h = 1e-5 * s;
                let slope = |f: fn(LossValue) -> f64| (f(loss.at(s + h)) - f(loss.at(s - h))) / (2.0 * h);
                assert!((slope(|v| v.value) - loss.at(s).first).abs() < 1e-8, "{loss:?} at {s}");
                assert!((slope(|v| v.first) - loss.at(s).second).abs() < 1e-7, "{loss:?} at {s}");
            }
        }
    }

    #[test]
    fn every_loss_is_the_square_for_small_residuals() {
        for loss in ALL {
            assert!((loss.at(1e-9).value / 1e-9 - 1.0).abs() < 1e-8);
        }
    }

    #[test]
    fn a_width_must_be_one_of_a_reading() {
        for width in [1e200, 1e-200, 1e-4, f64::INFINITY] {
            assert_eq!(Loss::Cauchy(width).checked(), Err(LossWidth(width)));
        }
        assert_eq!(Loss::Huber(0.0).checked(), Err(LossWidth(0.0)));
        assert!(Loss::Tukey(f64::NAN).checked().is_err());
        assert_eq!(Loss::Cauchy(2.0).checked(), Ok(Loss::Cauchy(2.0)));
    }
}
