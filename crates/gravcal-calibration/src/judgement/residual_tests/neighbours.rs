//! Whether the residuals of neighbouring poses are alike.
//!
//! ```text
//!     R = Σ r_t r_{t+1} / Σ r_t²,      E R = tr(M A)/m,      E R² = (tr(M A)² + 2 tr(M A M A))/(m (m + 2))
//! ```
//!
//! with `A` half of one beside the diagonal, `M` the residual maker among the channel's rows and `m` its trace: what a fit does to
//! residuals makes neighbours unlike, and is allowed for (Durbin and Watson, 1950). Of many rows `tr(M A M A)` is nearly that of `A`
//! times `(m/n)²`. With a term in the model, of which a unit vector `u` is left, `M` is less by `u uᵀ`, and
//!
//! ```text
//!     tr(M A M A) is less by 2 uᵀ A M A u − (uᵀ A u)²
//! ```
//!
//! Both moments are those of a residual maker that is a projector among the channel's rows. Where channels share unknowns it is one but for what other channels
//! tell of these, so that they hold for many more rows than unknowns.
//!
//! The rest is approximated by Student's t: `t = ρ √ν/√(1 − ρ²)` with `ρ = R − E R`, `ν = 1/var R − 1`.

use gravcal_estimation::statistics::ResidualMaker;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::rows::{MANY, Rows};

/// Rows up to which the variance is exact.
const EXACT: usize = 400;
/// Fewer neighbours say nothing.
const LEAST: usize = 8;
/// Probability below which neighbours are treated as alike, whether that is told or not.
const TREATED: f64 = 0.01;

/// What chance makes of a channel's neighbours.
#[derive(Clone, Debug)]
pub struct Neighbours {
    /// `tr(M A)` and `m`.
    product: f64,
    freedom: f64,
    /// `tr(M A M A)`.
    twice: f64,
    /// `ν`.
    student: f64,
}

impl Neighbours {
    /// Nothing where a channel has too few.
    pub fn of(maker: &ResidualMaker, rows: &Rows, channel: usize) -> Option<Neighbours> {
        let (own, pairs) = (rows.of_channel(channel), rows.pairs(channel));
        let freedom = rows.freedom()[channel];
        if pairs.len() < LEAST || freedom < LEAST as f64 {
            return None;
        }
        let product: f64 = pairs.iter().map(|(i, j)| maker.entry(*i, *j)).sum();
        let twice =
            if own.len() <= EXACT { of_products(maker, own, pairs) } else { of_many(own.len(), pairs.len(), freedom) };
        Neighbours::from_traces(product, freedom, twice)
    }

    fn from_traces(product: f64, freedom: f64, twice: f64) -> Option<Neighbours> {
        let square = (product * product + 2.0 * twice) / (freedom * (freedom + 2.0));
        let variance = square - (product / freedom).powi(2);
        let student = 1.0 / variance - 1.0;
        let tells = freedom >= LEAST as f64 && variance > 0.0 && student > 1.0;
        tells.then_some(Neighbours { product, freedom, twice, student })
    }

    /// The same where the model has a term, too. `maker`: without it; `term`: the unit vector that it leaves.
    pub fn with(&self, maker: &ResidualMaker, rows: &Rows, channel: usize, term: &[f64]) -> Option<Neighbours> {
        let (own, pairs) = (rows.of_channel(channel), rows.pairs(channel));
        let freedom = self.freedom - own.iter().map(|row| term[*row] * term[*row]).sum::<f64>();
        let product: f64 = pairs.iter().map(|(i, j)| term[*i] * term[*j]).sum();
        let twice = if own.len() <= EXACT {
            let mut beside = vec![0.0; term.len()];
            for (i, j) in pairs {
                beside[*i] += 0.5 * term[*j];
                beside[*j] += 0.5 * term[*i];
            }
            let mut left = [beside.clone()];
            maker.apply(&mut left);
            let both: f64 = beside.iter().zip(&left[0]).map(|(a, b)| a * b).sum();
            self.twice - 2.0 * both + product * product
        } else {
            of_many(own.len(), pairs.len(), freedom)
        };
        Neighbours::from_traces(self.product - product, freedom, twice)
    }

    /// The same where the tested terms are estimated, too: the mean is that without them.
    pub fn without(&self, pairs: &[(usize, usize)], terms: &[Vec<f64>]) -> Neighbours {
        let taken = |term: &Vec<f64>| pairs.iter().map(|(i, j)| term[*i] * term[*j]).sum::<f64>();
        Neighbours { product: self.product - terms.iter().map(taken).sum::<f64>(), ..self.clone() }
    }

    /// Correlation, Student's t, its degrees of freedom, and how probable such a likeness is.
    pub fn test(&self, rows: &Rows, channel: usize, residuals: &[f64]) -> Option<(f64, f64, f64, f64)> {
        let squares: f64 = rows.of_channel(channel).iter().map(|row| residuals[*row].powi(2)).sum();
        if squares <= 0.0 || !squares.is_finite() {
            return None;
        }
        let products: f64 = rows.pairs(channel).iter().map(|(i, j)| residuals[*i] * residuals[*j]).sum();
        let correlation = (products / squares - self.product / self.freedom).clamp(-0.999, 0.999);
        let t = correlation * self.student.sqrt() / (1.0 - correlation * correlation).sqrt();
        let p = StudentsT::new(0.0, 1.0, self.student.min(MANY)).ok()?.sf(t);
        p.is_finite().then_some((correlation, t, self.student, p))
    }

    /// The correlation, where neighbours are to be treated as alike.
    pub fn alike(&self, rows: &Rows, channel: usize, residuals: &[f64]) -> Option<f64> {
        let (correlation, _, _, p) = self.test(rows, channel, residuals)?;
        (p < TREATED).then_some(correlation)
    }
}

/// What `tr(M A M A)` is nearly of many rows.
fn of_many(rows: usize, pairs: usize, freedom: f64) -> f64 {
    0.5 * pairs as f64 * (freedom / rows as f64).powi(2)
}

/// `tr(M A M A)` among the rows of a channel.
fn of_products(maker: &ResidualMaker, own: &[usize], pairs: &[(usize, usize)]) -> f64 {
    let count = own.len();
    let place = |row: usize| own.binary_search(&row).ok();
    let mut m = vec![0.0; count * count];
    for (i, row) in own.iter().enumerate() {
        for (j, other) in own[..=i].iter().enumerate() {
            let entry = maker.entry(*row, *other);
            (m[i * count + j], m[j * count + i]) = (entry, entry);
        }
    }
    let mut product = vec![0.0; count * count];
    for (i, j) in pairs.iter().filter_map(|(i, j)| Some((place(*i)?, place(*j)?))) {
        for k in 0..count {
            product[k * count + j] += 0.5 * m[k * count + i];
            product[k * count + i] += 0.5 * m[k * count + j];
        }
    }
    (0..count)
        .flat_map(|i| (0..count).map(move |j| (i, j)))
        .map(|(i, j)| product[i * count + j] * product[j * count + i])
        .sum()
}
