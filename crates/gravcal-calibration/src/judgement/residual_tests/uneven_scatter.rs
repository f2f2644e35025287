//! The test of a term where readings scatter more where the term is large.
//!
//! Friction that is left at rest grows with what a gear carries, and so do other errors of real arms. Readings at large torques scatter most then, and what
//! grows faster than the torque, as its square does, is seen in few of them: beside a scatter that is taken to be the same in all, chance passes for a term. With
//! `W` the unit vectors that the fit leaves of a term and `r′` what is left with it, of the variances `M′_ii`, the squares of residuals are held against those of the
//! term, `w_i² = Σ_k W_ik²`, in the channels that say something of it: the slope of the one over the other by Student's t (Koenker, 1981). Where there is one,
//!
//! ```text
//!     V = Σ_i W_i W_iᵀ r′_i² / M′_ii,      F = aᵀ V⁻¹ a (f−k+1)/(f k)      with k and f − k + 1 degrees of freedom, f = (Σ w_i²)²/Σ w_i⁴ − 1
//! ```
//!
//! (White, 1980; MacKinnon and White, 1985, HC2; Hotelling).

use gravcal_estimation::statistics::ResidualMaker;
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::rows::Rows;
use super::score::{LEAST_FREEDOM, Outcome, SHARE, split, tested};

/// Probability below which the scatter is taken to grow with the term.
const TREATED: f64 = 0.001;
/// A residual of which the fit leaves a smaller share says nothing.
const LEFT: f64 = 0.05;

/// A reading: the square of its residual over the variance that the fit leaves, and of the term.
struct Seen {
    row: usize,
    square: f64,
    term: f64,
}

/// Tests a term, of which these unit vectors are left, where the scatter grows with it; nothing where it does not. `maker`: without the term.
pub fn test(maker: &ResidualMaker, rows: &Rows, terms: &[Vec<f64>]) -> Option<Outcome> {
    let (along, after) = split(maker, terms);
    let diagonal = maker.diagonal();
    let of_row = |row: usize| {
        let term: f64 = terms.iter().map(|term| term[row] * term[row]).sum();
        let left = diagonal[row] - term;
        (left > LEFT).then(|| Seen { row, square: after[row].powi(2) / left, term })
    };
    let seen: Vec<Seen> = (0..after.len()).filter_map(of_row).collect();
    let grows = (0..rows.channels()).any(|channel| {
        let own: Vec<&Seen> = seen.iter().filter(|seen| rows.owner(seen.row) == channel).collect();
        let share = own.iter().map(|seen| seen.term).sum::<f64>() / terms.len().max(1) as f64;
        share > SHARE && grows_with_term(&own)
    });
    if !grows {
        return None;
    }
    let mut covariance = DMatrix::zeros(terms.len(), terms.len());
    for Seen { row, square, .. } in &seen {
        let of_row = DVector::from_iterator(terms.len(), terms.iter().map(|term| term[*row]));
        covariance.ger(*square, &of_row, &of_row, 1.0);
    }
    let sum = |power: i32| seen.iter().map(|seen| seen.term.powi(power)).sum::<f64>();
    let informative = sum(1).powi(2) / sum(2) - 1.0;
    let freedom = informative - terms.len() as f64 + 1.0;
    if freedom < LEAST_FREEDOM {
        return None;
    }
    tested(&along, covariance, freedom, freedom / informative)
}

/// Whether squares of residuals grow with those of the term.
fn grows_with_term(own: &[&Seen]) -> bool {
    let count = own.len() as f64;
    let mean = |of: &dyn Fn(&Seen) -> f64| own.iter().map(|seen| of(seen)).sum::<f64>() / count;
    let (square, term) = (mean(&|seen| seen.square), mean(&|seen| seen.term));
    let both = mean(&|seen| (seen.square - square) * (seen.term - term));
    let correlation =
        both / (mean(&|seen| (seen.square - square).powi(2)) * mean(&|seen| (seen.term - term).powi(2))).sqrt();
    let t = correlation * (count - 2.0).sqrt() / (1.0 - correlation * correlation).sqrt();
    let p = StudentsT::new(0.0, 1.0, count - 2.0).map(|student| student.sf(t));
    p.is_ok_and(|p| p < TREATED)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_pcg::Pcg64;

    use super::*;
    use crate::judgement::residual_tests::score::{lacking, tests::level};
    use gravcal_estimation::RankAnalysis;
    use gravcal_estimation::statistics::Solution;

    const COUNT: usize = 60;

    /// Tests whether readings go with the square of where they are; of a scatter that grows with it by so much.
    fn of_square(seed: u64, growth: f64, size: f64) -> Option<Outcome> {
        let mut random = Pcg64::seed_from_u64(seed);
        let at: Vec<f64> = (0..COUNT).map(|_| random.sample(StandardNormal)).collect();
        let reading = |x: &f64| {
            let noise: f64 = random.sample(StandardNormal);
            (1.0 + growth * x * x) * noise + size * x * x
        };
        let (problem, values) = level(&at.iter().map(reading).collect::<Vec<f64>>());
        let analysis = RankAnalysis::new(&problem, &values).unwrap();
        let maker = ResidualMaker::new(&Solution { problem: &problem, values: &values, analysis: &analysis }).unwrap();
        let terms = lacking(&maker, vec![at.iter().map(|x| x * x).collect()]);
        test(&maker, &Rows::plain(COUNT, &maker), &terms)
    }

    #[test]
    fn chance_at_large_readings_passes_for_no_term() {
        let p: Vec<f64> = (0..2000).filter_map(|seed| of_square(seed, 2.0, 0.0)).map(|tested| tested.2).collect();
        assert!(p.len() > 1000, "{}", p.len());
        let below = p.iter().filter(|p| **p < 0.001).count();
        assert!(below < p.len() / 100, "{below} of {}", p.len());
    }

    #[test]
    fn a_scatter_that_is_the_same_everywhere_has_no_such_test() {
        let tested = (0..200).filter(|seed| of_square(*seed, 0.0, 1.0).is_some()).count();
        assert!(tested < 20, "{tested}");
    }
}
