//! The test of a term where the noise of a channel is of first order from pose to pose.
//!
//! Noise that is slower than the bins of a slow sweep, or the windows of an arm in motion, makes neighbours alike. Blocks of poses allow for it where many of
//! them see a term ([`super::score`]). A term of one sweep is seen in few, and their scatter about a level of their own is too small. So with
//! `R_ij = ρ^|i−j|` between the poses of a table, and `W` the unit vectors that the fit leaves of a term, `a = Wᵀ r` has the covariance
//!
//! ```text
//!     V = Σ_c f_c W_cᵀ R_c W_c        if the term is not there
//! ```
//!
//! and `F = aᵀ V⁻¹ a / k`. A fit makes neighbours less alike than their noise is. With `U` what it spans, the term with it, `M = I − U Uᵀ` and `A` half of
//! one beside the diagonal, residuals of channel `c` have
//!
//! ```text
//!     E Σ r_t r_{t+1} = f tr (M R M A)_c,      E Σ r_t² = f tr (M R M)_c
//! ```
//!
//! so that `ρ` is the one whose ratio of the two is theirs, and `f` follows. For what a channel shares with others `R` is taken to be the same in all. A
//! channel's variance is known as well as `ν (1 − ρ²)/(1 + ρ²)` independent readings tell it (Bartlett, 1946).

use gravcal_estimation::statistics::ResidualMaker;
use nalgebra::DMatrix;

use super::neighbours::Neighbours;
use super::rows::Rows;
use super::score::{Outcome, split, tested};

/// Correlations of neighbours for which it is computed what a fit leaves; in between it is taken for linear. Noise that is slower passes for noise of the last one: it
/// can hardly be told from a zero that drifts.
const CORRELATIONS: [f64; 8] = [0.0, 0.3, 0.5, 0.7, 0.82, 0.9, 0.95, 0.98];

/// Sums over the residuals of a channel that are expected of noise of unit variance: of products of neighbours, and of squares.
#[derive(Clone, Copy, Debug, Default)]
struct Expected {
    products: f64,
    squares: f64,
}

/// Noise of a channel.
struct Noise {
    /// `ρ`
    correlation: f64,
    /// `f`
    variance: f64,
    freedom: f64,
}

/// Tests a term, of which these unit vectors are left, where neighbours are alike; nothing where they are not, or blocks are eliminated, whose part of `U` is not
/// at hand. `maker`: without the term.
pub fn test(
    maker: &ResidualMaker,
    rows: &Rows,
    neighbours: &[Option<Neighbours>],
    terms: &[Vec<f64>],
) -> Option<Outcome> {
    let (along, after) = split(maker, terms);
    let is_alike = |channel: &usize| {
        let known = neighbours[*channel].as_ref().map(|known| known.without(rows.pairs(*channel), terms));
        known.and_then(|known| known.alike(rows, *channel, &after)).is_some()
    };
    let alike: Vec<usize> = (0..rows.channels()).filter(is_alike).collect();
    if alike.is_empty() || terms.is_empty() || maker.has_eliminated() {
        return None;
    }
    let basis = basis(maker, terms);
    let observed: Vec<f64> = alike.iter().map(|channel| ratio(rows, *channel, &after)).collect();
    let mut left: Vec<Vec<Expected>> = Vec::new();
    for correlation in CORRELATIONS {
        left.push(expected(&basis, rows, &alike, correlation));
        let reached = |(expected, observed): (&Expected, &f64)| expected.products > observed * expected.squares;
        if left.len() > 1 && left[left.len() - 1].iter().zip(&observed).all(reached) {
            break;
        }
    }
    let mut covariance = DMatrix::zeros(terms.len(), terms.len());
    let (mut sum, mut squares) = (0.0, 0.0);
    for owner in 0..rows.owners() {
        let noise = match alike.iter().position(|channel| *channel == owner) {
            Some(place) => {
                let left: Vec<Expected> = left.iter().map(|of| of[place]).collect();
                Noise::of(rows, owner, &after, &left)
            }
            None => Noise::independent(rows, owner, terms, &after),
        };
        let part = noise.variance * products(rows, owner, terms, noise.correlation);
        let own: f64 = part.trace();
        sum += own;
        squares += own * own / noise.freedom;
        covariance += part;
    }
    tested(&along, covariance, sum * sum / squares, 1.0)
}

impl Noise {
    /// The one of which these are the residuals. `left`: what is expected of the first [`CORRELATIONS`], two at least.
    fn of(rows: &Rows, channel: usize, after: &[f64], left: &[Expected]) -> Noise {
        let squares: f64 = rows.of_channel(channel).iter().map(|row| rows.count(*row) * after[*row].powi(2)).sum();
        let ratio = ratio(rows, channel, after);
        let share = |place: usize| {
            let [low, high] = [place, place + 1].map(|at| left[at].products / left[at].squares);
            ((ratio - low) / (high - low)).clamp(0.0, 1.0)
        };
        let last = left.len() - 2;
        let place = (0..last).find(|place| share(*place) < 1.0).unwrap_or(last);
        let between = |low: f64, high: f64| low + share(place) * (high - low);
        let correlation = between(CORRELATIONS[place], CORRELATIONS[place + 1]);
        let independent = (1.0 - correlation * correlation) / (1.0 + correlation * correlation);
        // Rows that count less tell less of the squares, too.
        let counted = rows.of_channel(channel).iter().map(|row| rows.count(*row)).sum::<f64>()
            / rows.of_channel(channel).len() as f64;
        Noise {
            correlation,
            variance: squares / counted / between(left[place].squares, left[place + 1].squares),
            freedom: (rows.freedom()[channel] * independent).max(1.0),
        }
    }

    /// That of a channel whose neighbours are not alike; knowledge keeps its stated noise.
    fn independent(rows: &Rows, owner: usize, terms: &[Vec<f64>], after: &[f64]) -> Noise {
        let of_owner = (0..after.len()).filter(|row| rows.owner(*row) == owner);
        let (mut freedom, mut squares) = (rows.freedom()[owner], 0.0);
        for row in of_owner {
            squares += rows.count(row) * after[row].powi(2);
            freedom -= rows.count(row) * terms.iter().map(|term| term[row].powi(2)).sum::<f64>();
        }
        match owner < rows.channels() && freedom >= 1.0 {
            true => Noise { correlation: 0.0, variance: squares / freedom, freedom },
            false => Noise { correlation: 0.0, variance: 1.0, freedom: f64::INFINITY },
        }
    }
}

/// Of products of neighbours over squares.
fn ratio(rows: &Rows, channel: usize, after: &[f64]) -> f64 {
    let squares: f64 = rows.of_channel(channel).iter().map(|row| after[*row].powi(2)).sum();
    rows.pairs(channel).iter().map(|(i, j)| after[*i] * after[*j]).sum::<f64>() / squares
}

/// `U`, with the terms.
fn basis(maker: &ResidualMaker, terms: &[Vec<f64>]) -> DMatrix<f64> {
    let of_row = |row: usize| maker.basis_row(row).chain(terms.iter().map(move |term| term[row]));
    let rows: Vec<Vec<f64>> = (0..maker.residuals().len()).map(|row| of_row(row).collect()).collect();
    DMatrix::from_row_iterator(rows.len(), rows.first().map_or(0, Vec::len), rows.iter().flatten().copied())
}

/// What is expected of the residuals of each of these channels, where neighbours in all of them are correlated so.
fn expected(u: &DMatrix<f64>, rows: &Rows, alike: &[usize], correlation: f64) -> Vec<Expected> {
    let width = u.ncols();
    let mut smoothed = u.clone();
    for mut column in smoothed.column_iter_mut() {
        alike.iter().for_each(|channel| correlate(rows, *channel, correlation, column.as_mut_slice()));
    }
    let within = u.transpose() * &smoothed;
    let of_channel = |channel: &usize| {
        let own = rows.of_channel(*channel);
        let (u, smoothed) = (u.select_rows(own), smoothed.select_rows(own));
        let mut beside = DMatrix::zeros(own.len(), width);
        let pairs = rows.pairs(*channel);
        let place = |row: &usize| own.binary_search(row).ok();
        for (i, j) in pairs.iter().filter_map(|(i, j)| Some((place(i)?, place(j)?))) {
            for column in 0..width {
                beside[(i, column)] += 0.5 * u[(j, column)];
                beside[(j, column)] += 0.5 * u[(i, column)];
            }
        }
        Expected {
            products: pairs.len() as f64 * correlation - 2.0 * beside.dot(&smoothed)
                + (u.transpose() * &beside).dot(&within),
            squares: own.len() as f64 - 2.0 * u.dot(&smoothed) + (u.transpose() * &u).dot(&within),
        }
    };
    alike.iter().map(of_channel).collect()
}

/// `W_cᵀ R_c W_c`.
fn products(rows: &Rows, owner: usize, terms: &[Vec<f64>], correlation: f64) -> DMatrix<f64> {
    let own: Vec<usize> = (0..terms[0].len()).filter(|row| rows.owner(*row) == owner).collect();
    let w = DMatrix::from_fn(own.len(), terms.len(), |place, term| terms[term][own[place]]);
    let correlated = |term: &Vec<f64>| {
        let mut correlated = term.clone();
        if correlation > 0.0 {
            correlate(rows, owner, correlation, &mut correlated);
        }
        correlated
    };
    let correlated: Vec<Vec<f64>> = terms.iter().map(correlated).collect();
    w.transpose() * DMatrix::from_fn(own.len(), terms.len(), |place, term| correlated[term][own[place]])
}

/// Puts `R_c x` in the place of a channel's rows of `x`: two sums along the poses of each table, one each way.
fn correlate(rows: &Rows, channel: usize, correlation: f64, x: &mut [f64]) {
    for sequence in rows.sequences(channel) {
        let along = |order: &mut dyn Iterator<Item = &usize>| {
            let mut sum = 0.0;
            let summed = |row: &usize| {
                sum = x[*row] + correlation * sum;
                sum
            };
            order.map(summed).collect::<Vec<f64>>()
        };
        let (forth, back) = (along(&mut sequence.iter()), along(&mut sequence.iter().rev()));
        for ((row, forth), back) in sequence.iter().zip(forth).zip(back.into_iter().rev()) {
            x[*row] = forth + back - x[*row];
        }
    }
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::RankAnalysis;
    use gravcal_estimation::statistics::Solution;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_pcg::Pcg64;

    use super::*;
    use crate::judgement::residual_tests::score::{lacking, tests::level};

    const SWEEPS: usize = 6;
    const BINS: usize = 50;

    /// Noise of first order in each sweep, for itself.
    fn noise(seed: u64, correlation: f64) -> Vec<f64> {
        let mut random = Pcg64::seed_from_u64(seed);
        let mut at: f64 = random.sample(StandardNormal);
        let step = |place: usize| {
            let new: f64 = random.sample(StandardNormal);
            at = if place.is_multiple_of(BINS) {
                new
            } else {
                correlation * at + (1.0 - correlation * correlation).sqrt() * new
            };
            at
        };
        (0..SWEEPS * BINS).map(step).collect()
    }

    /// Tests whether sweeps have levels of their own.
    fn of_levels(y: &[f64]) -> Option<Outcome> {
        let (problem, values) = level(y);
        let analysis = RankAnalysis::new(&problem, &values).unwrap();
        let maker = ResidualMaker::new(&Solution { problem: &problem, values: &values, analysis: &analysis }).unwrap();
        let rows = Rows::of_sweeps(SWEEPS, BINS, &maker);
        let neighbours = [Neighbours::of(&maker, &rows, 0)];
        let of_sweep = |sweep: usize| (0..y.len()).map(|row| f64::from(u8::from(row / BINS == sweep))).collect();
        test(&maker, &rows, &neighbours, &lacking(&maker, (1..SWEEPS).map(of_sweep).collect()))
    }

    #[test]
    fn p_values_are_evenly_spread_where_neighbours_are_alike() {
        for correlation in [0.5, 0.8] {
            let of = |seed: u64| of_levels(&noise(seed, correlation)).unwrap().2;
            let p: Vec<f64> = (0..1000).map(of).collect();
            let below = |level: f64| p.iter().filter(|p| **p < level).count() as f64 / p.len() as f64;
            // Monte Carlo errors: 0.7 % and 0.1 %. That ρ is found from few sweeps is not allowed for.
            assert!((0.025..0.09).contains(&below(0.05)), "{correlation}: {}", below(0.05));
            assert!(below(0.001) < 0.006, "{correlation}: {}", below(0.001));
        }
    }

    #[test]
    fn a_sweep_at_another_level_is_seen() {
        let mut seen = 0;
        for seed in 0..20 {
            let mut y = noise(seed, 0.6);
            y[..BINS].iter_mut().for_each(|y| *y += 2.5);
            seen += usize::from(of_levels(&y).unwrap().2 < 1e-4);
        }
        assert!(seen >= 18, "{seen} of 20");
    }

    #[test]
    fn white_noise_has_no_such_test() {
        let tested = (0..100).filter(|seed| of_levels(&noise(*seed, 0.0)).is_some()).count();
        assert!(tested <= 5, "{tested}");
    }

    /// `R` as a matrix, within each sweep.
    #[test]
    fn sums_each_way_are_the_correlations() {
        let (problem, values) = level(&noise(1, 0.0));
        let analysis = RankAnalysis::new(&problem, &values).unwrap();
        let maker = ResidualMaker::new(&Solution { problem: &problem, values: &values, analysis: &analysis }).unwrap();
        let rows = Rows::of_sweeps(SWEEPS, BINS, &maker);
        let x: Vec<f64> = (0..SWEEPS * BINS).map(|row| (0.7 * row as f64).sin()).collect();
        let mut correlated = x.clone();
        correlate(&rows, 0, 0.8, &mut correlated);
        for (i, correlated) in correlated.iter().enumerate() {
            let same = |j: &usize| i / BINS == j / BINS;
            let expected: f64 = (0..x.len()).filter(same).map(|j| 0.8_f64.powi(i.abs_diff(j) as i32) * x[j]).sum();
            assert!((correlated - expected).abs() < 1e-12, "{i}: {correlated} {expected}");
        }
    }
}
