//! The models of the 27 data sets, as their files print them.

use std::f64::consts::PI;

use crate::Number;

/// The data sets in NIST's order: lower, average and higher level of difficulty.
pub(super) const DATA_SETS: [(&str, Model); 27] = [
    ("Misra1a", Model::Misra1a),
    ("Chwirut2", Model::Chwirut),
    ("Chwirut1", Model::Chwirut),
    ("Lanczos3", Model::Lanczos),
    ("Gauss1", Model::Gauss),
    ("Gauss2", Model::Gauss),
    ("DanWood", Model::DanWood),
    ("Misra1b", Model::Misra1b),
    ("Kirby2", Model::Kirby2),
    ("Hahn1", Model::Hahn1),
    ("Nelson", Model::Nelson),
    ("MGH17", Model::Mgh17),
    ("Lanczos1", Model::Lanczos),
    ("Lanczos2", Model::Lanczos),
    ("Gauss3", Model::Gauss),
    ("Misra1c", Model::Misra1c),
    ("Misra1d", Model::Misra1d),
    ("Roszman1", Model::Roszman1),
    ("ENSO", Model::Enso),
    ("MGH09", Model::Mgh09),
    ("Thurber", Model::Hahn1),
    ("BoxBOD", Model::Misra1a),
    ("Rat42", Model::Rat42),
    ("MGH10", Model::Mgh10),
    ("Eckerle4", Model::Eckerle4),
    ("Rat43", Model::Rat43),
    ("Bennett5", Model::Bennett5),
];

/// A formula, named after the first of its data sets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Model {
    Misra1a,
    Misra1b,
    Misra1c,
    Misra1d,
    Chwirut,
    Lanczos,
    Gauss,
    DanWood,
    Kirby2,
    Hahn1,
    Nelson,
    Mgh09,
    Mgh10,
    Mgh17,
    Roszman1,
    Enso,
    Rat42,
    Rat43,
    Eckerle4,
    Bennett5,
}

impl Model {
    /// Number of parameters.
    pub(super) fn parameters(self) -> usize {
        match self {
            Model::Misra1a | Model::Misra1b | Model::Misra1c | Model::Misra1d | Model::DanWood => 2,
            Model::Chwirut | Model::Nelson | Model::Mgh10 | Model::Rat42 | Model::Eckerle4 | Model::Bennett5 => 3,
            Model::Mgh09 | Model::Roszman1 | Model::Rat43 => 4,
            Model::Kirby2 | Model::Mgh17 => 5,
            Model::Lanczos => 6,
            Model::Hahn1 => 7,
            Model::Gauss => 8,
            Model::Enso => 9,
        }
    }

    /// Indices of the parameters in which the prediction is affine.
    pub(super) fn linear(self) -> &'static [usize] {
        match self {
            Model::Chwirut => &[],
            Model::Misra1a | Model::Misra1b | Model::Misra1c | Model::Misra1d | Model::DanWood => &[0],
            Model::Mgh09 | Model::Mgh10 | Model::Rat42 | Model::Rat43 | Model::Eckerle4 | Model::Bennett5 => &[0],
            Model::Nelson | Model::Roszman1 => &[0, 1],
            Model::Kirby2 | Model::Mgh17 => &[0, 1, 2],
            Model::Lanczos => &[0, 2, 4],
            Model::Gauss => &[0, 2, 5],
            Model::Hahn1 => &[0, 1, 2, 3],
            Model::Enso => &[0, 1, 2, 4, 5, 7, 8],
        }
    }

    /// Terms of one form: interchanged they are the same model. Each lists its parameters, first one that tells it from the
    /// others.
    pub(super) fn interchangeable(self) -> &'static [&'static [usize]] {
        match self {
            Model::Lanczos => &[&[1, 0], &[3, 2], &[5, 4]],
            Model::Mgh17 => &[&[3, 1], &[4, 2]],
            Model::Gauss => &[&[3, 2, 4], &[6, 5, 7]],
            Model::Enso => &[&[3, 4, 5], &[6, 7, 8]],
            _ => &[],
        }
    }

    /// Number of predictors.
    pub(super) fn predictors(self) -> usize {
        if self == Model::Nelson { 2 } else { 1 }
    }

    /// What the model predicts, of the datum `y` of an observation.
    pub(super) fn response(self, y: f64) -> f64 {
        if self == Model::Nelson { y.ln() } else { y }
    }

    /// The response at the predictors `x` for the parameters b1, b2, … in `b`.
    pub(super) fn predict<N: Number>(self, b: &[N], predictors: &[f64]) -> N {
        let x = predictors[0];
        match self {
            Model::Misra1a => b[0] * (-(-b[1] * x).exp() + 1.0),
            Model::Misra1b => b[0] * (-(b[1] * x / 2.0 + 1.0).powi(-2) + 1.0),
            Model::Misra1c => b[0] * (-(b[1] * x * 2.0 + 1.0).powf(-0.5) + 1.0),
            Model::Misra1d => b[0] * b[1] * x / (b[1] * x + 1.0),
            Model::Chwirut => (-b[0] * x).exp() / (b[1] + b[2] * x),
            Model::Lanczos => b[0] * (-b[1] * x).exp() + b[2] * (-b[3] * x).exp() + b[4] * (-b[5] * x).exp(),
            Model::Gauss => b[0] * (-b[1] * x).exp() + peak(&b[2..5], x) + peak(&b[5..8], x),
            Model::DanWood => b[0] * (b[1] * x.ln()).exp(),
            Model::Kirby2 => polynomial(&b[..3], x) / (polynomial(&b[3..], x) * x + 1.0),
            Model::Hahn1 => polynomial(&b[..4], x) / (polynomial(&b[4..], x) * x + 1.0),
            Model::Nelson => b[0] - b[1] * x * (-b[2] * predictors[1]).exp(),
            Model::Mgh09 => b[0] * (b[1] * x + x * x) / (b[2] * x + b[3] + x * x),
            Model::Mgh10 => b[0] * (b[1] / (b[2] + x)).exp(),
            Model::Mgh17 => b[0] + b[1] * (-b[3] * x).exp() + b[2] * (-b[4] * x).exp(),
            Model::Roszman1 => b[0] - b[1] * x - (b[2] / (-b[3] + x)).atan() / PI,
            Model::Enso => {
                b[0] + wave(b[1], b[2], N::from(12.0), x) + wave(b[4], b[5], b[3], x) + wave(b[7], b[8], b[6], x)
            }
            Model::Rat42 => b[0] / ((b[1] - b[2] * x).exp() + 1.0),
            Model::Rat43 => b[0] / ((b[1] - b[2] * x).exp() + 1.0).powd(b[3].recip()),
            Model::Eckerle4 => b[0] / b[1] * (((-b[2] + x) / b[1]).powi(2) * -0.5).exp(),
            Model::Bennett5 => b[0] * (b[1] + x).powd(-b[2].recip()),
        }
    }
}

/// `c1 + c2 x + c3 x² + …`
fn polynomial<N: Number>(coefficients: &[N], x: f64) -> N {
    coefficients.iter().rev().fold(N::from(0.0), |sum, c| sum * x + *c)
}

/// `height · exp(−(x − centre)² / width²)`
fn peak<N: Number>(b: &[N], x: f64) -> N {
    b[0] * (-((-b[1] + x) / b[2]).powi(2)).exp()
}

/// `cosine · cos(2πx/period) + sine · sin(2πx/period)`
fn wave<N: Number>(cosine: N, sine: N, period: N, x: f64) -> N {
    let (s, c) = (period.recip() * (2.0 * PI * x)).sin_cos();
    cosine * c + sine * s
}
