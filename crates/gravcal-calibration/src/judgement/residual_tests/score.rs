//! The test of a term that the model lacks, from the fit that lacks it.
//!
//! With `W = M Z` (see [`ResidualMaker`]), made orthonormal, `a = Wᵀ r` and `r′ = r − W a`, what the larger fit would leave, channel `c`
//! scatters by
//!
//! ```text
//!     f_c = Σ_{i∈c} r′_i² / Σ_{i∈c} M′_ii        of its assumed variance
//! ```
//!
//! and `a` has the covariance `V = Σ_c f_c W_cᵀ W_c` if the term is not there. `F = aᵀ V⁻¹ a / k` has `k` and
//! `ν = (Σ v_c)² / Σ v_c²/ν_c` degrees of freedom (Satterthwaite; `v_c = f_c tr W_cᵀ W_c`, `ν_c` those of the channel). With one channel it
//! is the F test of the two fits. It needs no stated noise, and holds whether the stated noise is right or not. Under a loss each row counts in
//! both sums of `f_c` by its weight `w`, as the weighted residual times `√w` is what moves the estimate.
//!
//! **Neighbours that are alike.** Where those of `r′` are (see [`super::neighbours`]), poses are taken in blocks of neighbours and
//! `V = G/(G−1) Σ_b s_b s_bᵀ` with `s_b = Σ_{i∈b} W_i r′_i`. With `f = (Σ_b n_b)²/Σ_b n_b² − 1`, `n_b = Σ_{i∈b} |W_i|²`, as a term that is
//! seen in few blocks has few that tell its scatter, `F (f−k+1)/f` has `k` and `f − k + 1` degrees of freedom (Hotelling). Of the two
//! p-values the larger counts. Where the readings of a pose share errors (`Solved::pose_errors`), each pose is a block.

use gravcal_estimation::statistics::ResidualMaker;
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::neighbours::Neighbours;
use super::rows::{MANY, Rows};

/// What is seen of a term, in standard deviations of a reading, from which intervals cannot hold whatever it moves.
pub const MATTERS: f64 = 0.25;
/// A column of which the fit leaves a smaller share is in the model already, or all but.
pub const EXPLAINED: f64 = 1e-4;
/// Fewer degrees of freedom tell no noise.
pub const LEAST_FREEDOM: f64 = 4.0;
/// Blocks are no longer than leaves so many.
const LEAST_BLOCKS: usize = 10;
/// Poses in a block, at least.
const LEAST_LENGTH: usize = 5;
/// A channel with a smaller share of a term says nothing of it.
pub const SHARE: f64 = 0.1;

/// `F`, its degrees of freedom, and the p-value.
pub type Outcome = (f64, [f64; 2], f64);

/// A test's outcome.
#[derive(Clone, Debug)]
pub struct Score {
    pub statistic: f64,
    pub degrees_of_freedom: [f64; 2],
    pub blocks: Option<usize>,
    pub p_value: f64,
    /// The p-value if noise were the only error. Where the readings of a pose share errors, `p_value` tells whether a term is there, and this which
    /// of several is named first: scatter over poses grows with the very term that is missing.
    pub p_of_noise: f64,
    /// Estimate of each column's coefficient, 0 of those that the model has already.
    pub coefficients: Vec<f64>,
    /// Root mean square of what is seen of the term in the channel where most is, in standard deviations of a reading.
    pub in_noise: f64,
    /// By how much χ² falls.
    pub gain: f64,
}

/// Tests columns together, by what the fit leaves of them; nothing where the model has them already, or too little is left to tell their size.
pub fn score(maker: &ResidualMaker, rows: &Rows, neighbours: &[Option<Neighbours>], left: &[Left]) -> Option<Score> {
    let terms = orthonormal(left);
    if terms.is_empty() {
        return None;
    }
    let r = maker.residuals();
    let (along, after) = split(maker, &terms);
    let Products { parts, spent, squares } = products(rows, &terms, &after);
    let scatter = Scatter::of(rows, parts, &spent, &squares)?;
    let alone = scatter.test(&along)?;
    let in_blocks = |length: usize| by_blocks(rows, &terms, &after, &along, length);
    let alike = alike(rows, neighbours, &terms, &after);
    let blocks = match alike {
        Some(length) => in_blocks(length),
        // Few poses that see a term tell nothing of what they share: the test of all of them stands then.
        None if rows.share_errors() => in_blocks(1).filter(|blocks| blocks.tested.is_some()),
        None => None,
    };
    let (statistic, degrees_of_freedom, p_value, blocks) = match blocks {
        None => (alone.0, alone.1, alone.2, None),
        Some(Blocks { tested: Some((statistic, freedom, p)), count }) if p > alone.2 => {
            (statistic, freedom, p, Some(count))
        }
        Some(Blocks { tested: Some(_), count }) => (alone.0, alone.1, alone.2, Some(count)),
        Some(Blocks { tested: None, .. }) => return None,
    };
    let seen = |row: usize| terms.iter().zip(along.iter()).map(|(term, a)| a * term[row]).sum();
    Some(Score {
        statistic,
        degrees_of_freedom,
        blocks,
        p_value,
        p_of_noise: if alike.is_none() { alone.2 } else { p_value },
        coefficients: coefficients(left, r),
        in_noise: scatter.largest_rms(rows, (0..r.len()).map(seen)),
        gain: along.norm_squared(),
    })
}

/// The residuals along unit vectors, and what is left of them without.
pub fn split(maker: &ResidualMaker, terms: &[Vec<f64>]) -> (DVector<f64>, Vec<f64>) {
    let r = maker.residuals();
    let along = DVector::from_iterator(terms.len(), terms.iter().map(|term| dot(term, r)));
    let mut after = r.to_vec();
    for (term, share) in terms.iter().zip(along.iter()) {
        after.iter_mut().zip(term).for_each(|(r, t)| *r -= share * t);
    }
    (along, after)
}

/// What a model lacks that has none of these columns, as unit vectors perpendicular to each other.
pub fn lacking(maker: &ResidualMaker, columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    orthonormal(&left_of(maker, columns))
}

/// What a fit leaves of a column of unit length; nothing where that is too little.
pub struct Left {
    length: f64,
    left: Option<Vec<f64>>,
}

/// That of each of some columns. Many at once take hardly longer than few.
pub fn left_of(maker: &ResidualMaker, mut columns: Vec<Vec<f64>>) -> Vec<Left> {
    let lengths: Vec<f64> = columns.iter().map(|column| dot(column, column).sqrt()).collect();
    let has_direction = |length: f64| length > 0.0 && length.is_finite();
    for (column, length) in columns.iter_mut().zip(&lengths) {
        // Zeros stay zeros.
        let length = if has_direction(*length) { *length } else { f64::INFINITY };
        column.iter_mut().for_each(|z| *z /= length);
    }
    maker.apply(&mut columns);
    let of_column = |(left, length): (Vec<f64>, f64)| {
        let enough = has_direction(length) && dot(&left, &left) > EXPLAINED;
        Left { length, left: enough.then_some(left) }
    };
    columns.into_iter().zip(lengths).map(of_column).collect()
}

/// Gram and Schmidt; columns that others make superfluous are left out.
fn orthonormal(left: &[Left]) -> Vec<Vec<f64>> {
    let mut terms: Vec<Vec<f64>> = Vec::new();
    for left in left.iter().filter_map(|left| left.left.as_ref()) {
        let mut term = left.clone();
        for known in &terms {
            let share = dot(known, &term);
            term.iter_mut().zip(known).for_each(|(t, k)| *t -= share * k);
        }
        let length = dot(&term, &term).sqrt();
        if length * length > EXPLAINED {
            term.iter_mut().for_each(|t| *t /= length);
            terms.push(term);
        }
    }
    terms
}

fn coefficients(left: &[Left], r: &[f64]) -> Vec<f64> {
    let known: Vec<(usize, &Vec<f64>)> =
        left.iter().enumerate().filter_map(|(place, left)| Some((place, left.left.as_ref()?))).collect();
    let gram = DMatrix::from_fn(known.len(), known.len(), |i, j| dot(known[i].1, known[j].1));
    let right = DVector::from_iterator(known.len(), known.iter().map(|(_, w)| -dot(w, r)));
    let mut coefficients = vec![0.0; left.len()];
    // Where columns are all but one, the shortest of their combinations.
    if let Ok(solved) = gram.svd(true, true).solve(&right, EXPLAINED) {
        known.iter().zip(solved.iter()).for_each(|((place, _), a)| coefficients[*place] = a / left[*place].length);
    }
    coefficients
}

/// `W_cᵀ W_c` of terms, and the squares of what is left after them, by owner of rows.
fn products(rows: &Rows, terms: &[Vec<f64>], after: &[f64]) -> Products {
    let count = terms.len();
    let mut spent = vec![0.0; rows.owners()];
    let mut parts = vec![vec![0.0; count * count]; rows.owners()];
    let mut squares = vec![0.0; rows.owners()];
    let mut of_row = vec![0.0; count];
    for (row, r) in after.iter().enumerate() {
        let owner = rows.owner(row);
        squares[owner] += rows.count(row) * r * r;
        of_row.iter_mut().zip(terms).for_each(|(entry, term)| *entry = term[row]);
        spent[owner] += rows.count(row) * of_row.iter().map(|entry| entry * entry).sum::<f64>();
        for (sums, a) in parts[owner].chunks_exact_mut(count).zip(&of_row) {
            sums.iter_mut().zip(&of_row).for_each(|(sum, b)| *sum += a * b);
        }
    }
    let parts = parts.iter().map(|sums| DMatrix::from_column_slice(count, count, sums)).collect();
    Products { parts, spent, squares }
}

/// Sums over the rows of each owner.
struct Products {
    /// `W_cᵀ W_c`.
    parts: Vec<DMatrix<f64>>,
    /// Degrees of freedom that the terms take, rows counted by their weights.
    spent: Vec<f64>,
    /// Of `r′`, likewise.
    squares: Vec<f64>,
}

/// How channels scatter about the larger fit.
pub struct Scatter {
    /// `f_c` and `ν_c`, by owner of rows: see [`Rows`].
    channels: Vec<(f64, f64)>,
    /// `W_cᵀ W_c`.
    parts: Vec<DMatrix<f64>>,
}

impl Scatter {
    /// `parts`: `W_cᵀ W_c`; `spent`: degrees of freedom that the terms take; `squares`: of `r′`, by owner of rows.
    pub fn of(rows: &Rows, parts: Vec<DMatrix<f64>>, spent: &[f64], squares: &[f64]) -> Option<Scatter> {
        let freedom: Vec<f64> =
            rows.freedom().iter().zip(spent).map(|(freedom, spent)| (freedom - spent).max(0.0)).collect();
        let all = |of: &[f64]| (0..rows.channels()).map(|owner| of[owner]).sum::<f64>();
        let common = all(squares) / all(&freedom);
        // Knowledge has freedom without end, and next to it the scatter of a few readings passes for known.
        if !common.is_finite() || common <= 0.0 || all(&freedom) < LEAST_FREEDOM {
            return None;
        }
        let channel = |owner: usize| match freedom[owner] {
            // Knowledge keeps its stated noise.
            _ if owner >= rows.channels() => (1.0, f64::INFINITY),
            // Of few degrees of freedom the scatter is anything, and where that is next to nothing everything stands out from it.
            own if own < LEAST_FREEDOM => (common, all(&freedom)),
            own => (squares[owner] / own, own),
        };
        Some(Scatter { channels: (0..rows.owners()).map(channel).collect(), parts })
    }

    pub fn test(&self, along: &DVector<f64>) -> Option<Outcome> {
        let count = along.len();
        let mut covariance = DMatrix::zeros(count, count);
        let (mut sum, mut squares) = (0.0, 0.0);
        for ((f, freedom), part) in self.channels.iter().zip(&self.parts) {
            covariance += part * *f;
            let own = f * part.trace();
            sum += own;
            squares += own * own / freedom;
        }
        let freedom = sum * sum / squares;
        if freedom.is_nan() || freedom < LEAST_FREEDOM {
            return None;
        }
        tested(along, covariance, freedom, 1.0)
    }

    /// Root mean square of a vector in the channel where it is largest beside its scatter, which is at least the assumed one.
    fn largest_rms(&self, rows: &Rows, seen: impl Iterator<Item = f64>) -> f64 {
        let mut squares = vec![(0.0, 0.0); rows.owners()];
        for (row, seen) in seen.enumerate() {
            let (sum, count) = &mut squares[rows.owner(row)];
            *sum += seen * seen;
            *count += 1.0;
        }
        let rms = |((sum, count), (f, _)): (&(f64, f64), &(f64, f64))| {
            if *count > 0.0 { sum / count / f.max(1.0) } else { 0.0 }
        };
        squares.iter().zip(&self.channels).take(rows.channels()).map(rms).fold(0.0, f64::max).sqrt()
    }
}

/// `F` of coefficients of which this is the covariance if their terms are not there, its degrees of freedom, and the p-value.
pub fn tested(along: &DVector<f64>, covariance: DMatrix<f64>, freedom: f64, factor: f64) -> Option<Outcome> {
    let count = along.len() as f64;
    let solved = covariance.cholesky()?.solve(along);
    let statistic = factor * along.dot(&solved) / count;
    if !statistic.is_finite() {
        return None;
    }
    // Beyond that F is χ²/k, and its series are slow.
    let freedom = freedom.min(MANY);
    let p = FisherSnedecor::new(count, freedom).ok()?.sf(statistic);
    p.is_finite().then_some((statistic, [count, freedom], p))
}

/// Poses in a block where neighbours are alike in a channel that says something of the term; nothing where they are not.
fn alike(rows: &Rows, neighbours: &[Option<Neighbours>], terms: &[Vec<f64>], after: &[f64]) -> Option<usize> {
    let share = |channel: usize| {
        let own = rows.of_channel(channel).iter();
        own.map(|row| terms.iter().map(|term| term[*row] * term[*row]).sum::<f64>()).sum::<f64>() / terms.len() as f64
    };
    let correlation = |channel: usize| {
        let known = neighbours[channel].as_ref().filter(|_| share(channel) > SHARE)?;
        known.without(rows.pairs(channel), terms).alike(rows, channel, after)
    };
    let largest = (0..rows.channels()).filter_map(correlation).reduce(f64::max)?;
    let largest = largest.min(0.95);
    Some(((3.0 * (1.0 + largest) / (1.0 - largest)).ceil() as usize).max(LEAST_LENGTH))
}

struct Blocks {
    tested: Option<Outcome>,
    count: usize,
}

fn by_blocks(rows: &Rows, terms: &[Vec<f64>], after: &[f64], along: &DVector<f64>, length: usize) -> Option<Blocks> {
    let (poses, terms_count) = (rows.poses(), terms.len());
    // Longer blocks than leave enough of them say less than shorter ones.
    let length = length.min((poses / LEAST_BLOCKS).max(LEAST_LENGTH));
    let count = poses / length;
    if count < LEAST_BLOCKS {
        return Some(Blocks { tested: None, count });
    }
    let mut scores: Vec<DVector<f64>> = vec![DVector::zeros(terms_count); count];
    let mut sizes = vec![0.0; count];
    for (row, r) in after.iter().enumerate() {
        let Some(place) = rows.place(row) else { continue };
        let block = (place / length).min(count - 1);
        terms.iter().enumerate().for_each(|(k, term)| scores[block][k] += term[row] * r);
        sizes[block] += terms.iter().map(|term| term[row] * term[row]).sum::<f64>();
    }
    let of_blocks = count as f64;
    let squares = scores.iter().fold(DMatrix::zeros(terms_count, terms_count), |sum, s| sum + s * s.transpose());
    let covariance = squares * (of_blocks / (of_blocks - 1.0));
    let informative = sizes.iter().sum::<f64>().powi(2) / sizes.iter().map(|n| n * n).sum::<f64>() - 1.0;
    let freedom = informative - terms_count as f64 + 1.0;
    let enough = freedom >= LEAST_FREEDOM + 2.0 * (terms_count as f64 - 1.0);
    let tested = enough.then(|| tested(along, covariance, freedom, freedom / informative)).flatten();
    Some(Blocks { tested, count })
}

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
pub(super) mod tests {
    use gravcal_estimation::statistics::Solution;
    use gravcal_estimation::{Block, Factor, Noise, Problem, ProblemBuilder, RankAnalysis, Values};
    use gravcal_robot_model::residuals::Prior;
    use gravcal_solvers::LevenbergMarquardt;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_pcg::Pcg64;

    use super::super::bound::{Bound, Sums};
    use super::*;
    use gravcal_identification::SolveEnvironment;

    /// A level read by rows of unit noise.
    pub fn level(y: &[f64]) -> (Problem, Values) {
        let mut builder = ProblemBuilder::new();
        let id = builder.add_block(Block::scalar("level", ""), &[0.0]);
        for y in y {
            builder.add_factor(Factor::new(Prior::new(id, vec![*y]), Noise::independent(&[1.0]).unwrap()));
        }
        let (problem, initial) = builder.build().unwrap();
        let solver = LevenbergMarquardt::default();
        let values = SolveEnvironment::new(&solver, &|_: &str| {}).solve(&problem, &initial).unwrap().values;
        (problem, values)
    }

    fn scored(y: &[f64], columns: &[Vec<f64>]) -> Option<Score> {
        let (problem, values) = level(y);
        let analysis = RankAnalysis::new(&problem, &values).unwrap();
        let maker = ResidualMaker::new(&Solution { problem: &problem, values: &values, analysis: &analysis }).unwrap();
        let rows = Rows::plain(y.len(), &maker);
        let neighbours = [Neighbours::of(&maker, &rows, 0)];
        score(&maker, &rows, &neighbours, &left_of(&maker, columns.to_vec()))
    }

    fn noise(seed: u64, count: usize) -> Vec<f64> {
        let mut random = Pcg64::seed_from_u64(seed);
        (0..count).map(|_| random.sample(StandardNormal)).collect()
    }

    fn times(count: usize) -> Vec<f64> {
        (0..count).map(|t| t as f64).collect()
    }

    /// The textbook's test of the slope of a line.
    #[test]
    fn of_one_channel_it_is_the_f_test_of_the_two_fits() {
        let y = [0.3, -0.2, 0.9, 0.4, 1.3, 0.8, 1.9, 1.1, 1.4, 2.2];
        let score = scored(&y, &[times(10)]).unwrap();
        let (mean_t, mean_y) = (4.5, y.iter().sum::<f64>() / 10.0);
        let sum = |of: &dyn Fn(f64, f64) -> f64| {
            y.iter().enumerate().map(|(t, y)| of(t as f64 - mean_t, y - mean_y)).sum::<f64>()
        };
        let slope = sum(&|t, y| t * y) / sum(&|t, _| t * t);
        let left = sum(&|t, y| (y - slope * t).powi(2));
        let f = (sum(&|_, y| y * y) - left) / (left / 8.0);
        assert!((score.statistic / f - 1.0).abs() < 1e-9, "{} {f}", score.statistic);
        assert!((score.degrees_of_freedom[0], score.degrees_of_freedom[1].round()) == (1.0, 8.0));
        // The residual is prediction less reading: what the model lacks has the sign of the readings.
        let (estimated, expected) = (score.coefficients[0], slope);
        assert!((estimated - expected).abs() < 1e-9, "{estimated} {expected}");
        let p = FisherSnedecor::new(1.0, 8.0).unwrap().sf(f);
        assert!((score.p_value / p - 1.0).abs() < 1e-6);
    }

    #[test]
    fn what_the_model_has_already_is_not_tested() {
        let y = noise(1, 20);
        assert!(scored(&y, &[vec![2.0; 20]]).is_none());
        assert!(scored(&y, &[vec![0.0; 20]]).is_none());
        // Of columns that say the same, one counts.
        let both = scored(&y, &[times(20), times(20)]).unwrap();
        assert_eq!(both.degrees_of_freedom[0], 1.0);
        assert!(scored(&[0.5; 20], &[times(20)]).is_none(), "nothing scatters");
    }

    /// But for what a test in blocks adds.
    #[test]
    fn sums_over_channels_tell_the_p_value() {
        for seed in 0..20 {
            let (problem, values) = level(&noise(seed, 60));
            let analysis = RankAnalysis::new(&problem, &values).unwrap();
            let maker =
                ResidualMaker::new(&Solution { problem: &problem, values: &values, analysis: &analysis }).unwrap();
            let rows = Rows::plain(60, &maker);
            let sums = Sums::of(&maker, &rows);
            let columns = [times(60), times(60).iter().map(|t| (0.2 * t).sin()).collect()];
            let p = score(&maker, &rows, &[None], &left_of(&maker, columns.to_vec())).unwrap().p_value;
            let bound = sums.bound(&maker, &rows, &columns);
            assert!(matches!(bound, Bound::Least(least) if least < p && least > 0.999_99 * p), "{seed}: {p}");
            assert!(matches!(sums.bound(&maker, &rows, &[vec![2.0; 60]]), Bound::InModel));
            assert!(matches!(sums.bound(&maker, &rows, &[vec![f64::INFINITY; 60]]), Bound::Open));
        }
    }

    /// White noise of any size, and noise whose neighbours are alike: few trends are seen in either.
    #[test]
    fn p_values_are_evenly_spread_whatever_the_noise() {
        let share = |make: &dyn Fn(u64) -> Vec<f64>, level: f64| {
            let trials = 600;
            let below = |seed: &u64| scored(&make(*seed), &[times(150)]).is_some_and(|score| score.p_value < level);
            (0..trials).filter(below).count() as f64 / trials as f64
        };
        let white = |seed: u64| noise(seed, 150).iter().map(|e| 3.0 * e).collect::<Vec<f64>>();
        assert!((0.03..0.075).contains(&share(&white, 0.05)), "{}", share(&white, 0.05));
        let coloured = |seed: u64| {
            let mut at = 0.0;
            let step = |e: &f64| {
                at = 0.8 * at + e;
                at
            };
            noise(seed, 150).iter().map(step).collect::<Vec<f64>>()
        };
        assert!(share(&coloured, 0.001) < 0.03, "{}", share(&coloured, 0.001));
    }

    /// Of few rows exactly, of many roughly, with each term as if the model had had it from the start.
    #[test]
    fn neighbours_follow_the_terms_of_a_model() {
        for count in [60, 600] {
            let (problem, values) = level(&noise(3, count));
            let analysis = RankAnalysis::new(&problem, &values).unwrap();
            let maker =
                ResidualMaker::new(&Solution { problem: &problem, values: &values, analysis: &analysis }).unwrap();
            let mut rows = Rows::plain(count, &maker);
            let term = lacking(&maker, vec![times(count)]).remove(0);
            let known = Neighbours::of(&maker, &rows, 0).unwrap().with(&maker, &rows, 0, &term).unwrap();
            let maker = maker.with(&[term]);
            rows.count_freedom(&maker);
            let anew = Neighbours::of(&maker, &rows, 0).unwrap();
            let tests = [known, anew].map(|known| known.test(&rows, 0, maker.residuals()).unwrap());
            let [known, anew] = tests.map(|(correlation, t, freedom, p)| [correlation, t, freedom, p]);
            assert!(known.iter().zip(anew).all(|(a, b)| (a - b).abs() < 1e-9 * b.abs()), "{known:?} {anew:?}");
        }
    }

    #[test]
    fn neighbours_of_white_noise_are_alike_by_chance_alone() {
        let below = |seed: &u64| {
            let y = noise(*seed, 30);
            let (problem, values) = level(&y);
            let analysis = RankAnalysis::new(&problem, &values).unwrap();
            let maker =
                ResidualMaker::new(&Solution { problem: &problem, values: &values, analysis: &analysis }).unwrap();
            let rows = Rows::plain(30, &maker);
            let known = Neighbours::of(&maker, &rows, 0).unwrap();
            known.test(&rows, 0, maker.residuals()).unwrap().3 < 0.05
        };
        let share = (0..1000).filter(below).count() as f64 / 1000.0;
        assert!((0.03..0.07).contains(&share), "{share}");
    }
}
