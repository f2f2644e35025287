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
const TREATED: f64 = 0.05;
/// A residual of which the fit and the term leave a smaller share is counted as if they left so much.
const LEFT: f64 = 0.05;

/// A reading: the square of its residual over the variance that the fit leaves, and of the term.
struct Seen {
    row: usize,
    square: f64,
    term: f64,
}

/// Tests a term, of which these unit vectors are left, where the scatter grows with it; nothing where it does not. Where the scatter grows and so few readings see
/// the term that they do not tell how far, nothing is sure of it: `p = 1`. `maker`: without the term.
pub fn test(maker: &ResidualMaker, rows: &Rows, terms: &[Vec<f64>]) -> Option<Outcome> {
    let (along, after) = split(maker, terms);
    let diagonal = maker.diagonal();
    let of_row = |row: usize| {
        let term: f64 = terms.iter().map(|term| term[row] * term[row]).sum();
        Seen { row, square: after[row].powi(2) / (diagonal[row] - term).max(LEFT), term }
    };
    let seen: Vec<Seen> = (0..after.len()).map(of_row).collect();
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
        return Some((0.0, [terms.len() as f64, freedom.max(1.0)], 1.0));
    }
    tested(&along, covariance, freedom, freedom / informative)
}

/// Whether squares of residuals grow with those of the term.
fn grows_with_term(own: &[&Seen]) -> bool {
    let count = own.len() as f64;
    let mean = |of: &dyn Fn(&Seen) -> f64| own.iter().map(|seen| of(seen)).sum::<f64>() / count;
    let (square, term) = (mean(&|seen| seen.square), mean(&|seen| seen.term));
    let both = mean(&|seen| (seen.square - square) * (seen.term - term));
    let spread = (mean(&|seen| (seen.square - square).powi(2)) * mean(&|seen| (seen.term - term).powi(2))).sqrt();
    if spread.is_nan() || spread <= 0.0 || count < LEAST_FREEDOM {
        return false;
    }
    let correlation = (both / spread).clamp(-0.999_999, 0.999_999);
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
    use crate::judgement::residual_tests::score::{lacking, left_of, score, tests::level};
    use gravcal_estimation::RankAnalysis;
    use gravcal_estimation::statistics::Solution;

    const COUNT: usize = 60;

    /// Whether readings go with the square of where they are, of a scatter that grows with it by so much: the p-value of one scatter, and of this test.
    fn of_square(seed: u64, growth: f64, size: f64) -> (f64, Option<f64>) {
        let mut random = Pcg64::seed_from_u64(seed);
        let at: Vec<f64> = (0..COUNT).map(|_| random.sample(StandardNormal)).collect();
        let reading = |x: &f64| {
            let noise: f64 = random.sample(StandardNormal);
            (1.0 + growth * x * x) * noise + size * x * x
        };
        let (problem, values) = level(&at.iter().map(reading).collect::<Vec<f64>>());
        let analysis = RankAnalysis::new(&problem, &values).unwrap();
        let maker = ResidualMaker::new(&Solution { problem: &problem, values: &values, analysis: &analysis }).unwrap();
        let (rows, column) = (Rows::plain(COUNT, &maker), at.iter().map(|x| x * x).collect::<Vec<f64>>());
        let one_scatter = score(&maker, &rows, &[None], &left_of(&maker, vec![column.clone()])).unwrap().p_value;
        (one_scatter, test(&maker, &rows, &lacking(&maker, vec![column])).map(|tested| tested.2))
    }

    #[test]
    fn chance_at_large_readings_passes_for_a_term_more_seldom() {
        let both: Vec<(f64, f64)> = (0..2000)
            .map(|seed| of_square(seed, 2.0, 0.0))
            .map(|(one_scatter, tested)| (one_scatter, tested.map_or(one_scatter, |p| p.max(one_scatter))))
            .collect();
        let [before, after] =
            [both.iter().filter(|(p, _)| *p < 0.001).count(), both.iter().filter(|(_, p)| *p < 0.001).count()];
        assert!(before > 300 && after < 120, "{before} {after} of 2000");
    }

    #[test]
    fn what_is_there_is_seen_whatever_the_scatter() {
        let seen = (0..200).filter(|seed| {
            let (one_scatter, tested) = of_square(*seed, 0.0, 1.0);
            tested.map_or(one_scatter, |p| p.max(one_scatter)) < 0.001
        });
        assert!(seen.count() > 180);
    }

    #[test]
    fn a_scatter_that_is_the_same_everywhere_seldom_has_such_a_test() {
        let tested = (0..500).filter(|seed| of_square(*seed, 0.0, 1.0).1.is_some()).count();
        assert!(tested < 50, "{tested}");
    }
}
