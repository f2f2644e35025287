//! Columns of eliminated blocks after their elimination: what they are worth once the shared columns are known.
//!
//! With the factored component `[R_ee R_es]` (see `linearization/orthogonal.rs`) an eliminated column follows the shared ones and
//! has an uncertainty of its own,
//!
//! ```text
//!     δ_e = −R_ee⁻¹ R_es δ_s + R_ee⁻¹ ε,      cov δ_e = F Σ_ss Fᵀ + R_ee⁻¹ R_ee⁻ᵀ,      F = −R_ee⁻¹ R_es
//! ```
//!
//! so that the covariance of any columns is had without a matrix of all of them.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use crate::linearization::factor_component;
use crate::problem::Place;
use crate::{EvaluateError, Problem, Values};

/// A pivot below this share of its column says nothing.
const LEAST_PIVOT: f64 = 1e-9;
/// A component of more columns takes longer to factor than it takes room: it is one of many poses that something ties together.
const LARGE: usize = 64;
/// Threads that each remember the component that they asked for last.
const THREADS: usize = 64;

/// Where each column of a problem is found after elimination. Of most components nothing is kept: what their columns are made of is computed when
/// it is asked for.
#[derive(Debug)]
pub(crate) struct EliminatedColumns {
    problem: Problem,
    values: Values,
    /// Columns without effect.
    cleared: Vec<usize>,
    /// Place of each component's first column among those of all components, and their number.
    firsts: Vec<usize>,
    /// The component that a thread asked for last: most are asked for several times in a row.
    latest: [Mutex<Latest>; THREADS],
    /// Large ones, by index; nothing of others.
    kept: Vec<OnceLock<Arc<FactoredComponent>>>,
}

/// A component and its index, once one was asked for.
type Latest = Option<(usize, Arc<FactoredComponent>)>;

/// A component, by what it follows and what it knows by itself.
#[derive(Debug)]
struct FactoredComponent {
    /// Indices among the shared columns.
    touched: Arc<[usize]>,
    /// `F`, one row an eliminated column.
    response: Vec<Vec<f64>>,
    /// `R_ee⁻¹`, one row an eliminated column.
    own: Vec<Vec<f64>>,
}

/// A linear function of columns, by what it is made of.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reduced {
    /// Index among the shared columns and coefficient; an index may come more than once.
    pub shared: Vec<(usize, f64)>,
    /// Component and coefficients of its own unit errors.
    pub eliminated: Vec<(usize, Vec<f64>)>,
}

impl EliminatedColumns {
    /// `norms`: of all columns of J there.
    pub fn new(problem: &Problem, values: &Values, norms: &[f64]) -> Self {
        let mut firsts = vec![0];
        problem
            .structure()
            .components
            .iter()
            .for_each(|component| firsts.push(firsts[firsts.len() - 1] + component.columns.len()));
        let cleared = match problem.structure().components.is_empty() {
            true => Vec::new(),
            false => (0..norms.len()).filter(|column| norms[*column] == 0.0).collect(),
        };
        let components = &problem.structure().components;
        let has_large = components.iter().any(|component| component.columns.len() > LARGE);
        EliminatedColumns {
            problem: problem.clone(),
            values: values.clone(),
            cleared,
            firsts,
            latest: std::array::from_fn(|_| Mutex::default()),
            kept: std::iter::repeat_with(OnceLock::new).take(if has_large { components.len() } else { 0 }).collect(),
        }
    }

    fn component(&self, index: usize) -> Arc<FactoredComponent> {
        if self.problem.structure().components[index].columns.len() > LARGE {
            return Arc::clone(self.kept[index].get_or_init(|| Arc::new(self.computed(index))));
        }
        let thread = rayon::current_thread_index().unwrap_or(0) % THREADS;
        let mut latest = self.latest[thread].lock().unwrap_or_else(PoisonError::into_inner);
        match &*latest {
            Some((known, component)) if *known == index => Arc::clone(component),
            _ => {
                let component = Arc::new(self.computed(index));
                *latest = Some((index, Arc::clone(&component)));
                component
            }
        }
    }

    fn computed(&self, index: usize) -> FactoredComponent {
        let component = &self.problem.structure().components[index];
        let rows = factor_component(&self.problem, &self.values, component, &self.cleared);
        // They could be evaluated before.
        let none = || vec![f64::NAN; component.columns.len() * (component.columns.len() + component.shared.len() + 1)];
        FactoredComponent::new(component.columns.len(), &component.shared, &rows.unwrap_or_else(|_| none()))
    }

    /// Number of eliminated columns.
    pub fn count(&self) -> usize {
        self.firsts[self.firsts.len() - 1]
    }

    /// Number of all columns, eliminated or shared.
    pub fn columns(&self) -> usize {
        self.places().len()
    }

    fn places(&self) -> &[Place] {
        &self.problem.structure().places
    }

    /// Index of a column among the shared ones, if it is one.
    pub fn shared(&self, column: usize) -> Option<usize> {
        match self.places()[column] {
            Place::Shared(index) => Some(index),
            Place::Component { .. } => None,
        }
    }

    /// The components' own unit errors in a function: place among those of all components, and coefficient.
    pub fn own_entries(&self, function: &Reduced) -> Vec<(usize, f64)> {
        let first = |component: usize| self.firsts[component];
        let of_component = |(component, own): &(usize, Vec<f64>)| {
            own.iter().enumerate().map(|(k, c)| (first(*component) + k, *c)).collect::<Vec<_>>()
        };
        function.eliminated.iter().flat_map(of_component).collect()
    }

    /// What a linear function of columns is made of.
    pub fn reduce(&self, function: impl IntoIterator<Item = (usize, f64)>) -> Reduced {
        let mut reduced = Reduced::default();
        for (column, coefficient) in function {
            match self.places()[column] {
                Place::Shared(index) => reduced.shared.push((index, coefficient)),
                Place::Component { component, index } => {
                    self.component(component).add(component, index, coefficient, &mut reduced);
                }
            }
        }
        reduced
    }

    /// Linear functions, each with a coefficient for every column, as functions of the shared columns that the eliminated ones follow. What is a
    /// component's own is left out. Each component is asked for once.
    pub fn on_shared(&self, functions: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let structure = self.problem.structure();
        let own = |function: &Vec<f64>| structure.shared.iter().map(|column| function[*column]).collect();
        let mut on_shared: Vec<Vec<f64>> = functions.iter().map(own).collect();
        for (index, component) in structure.components.iter().enumerate() {
            let factored = self.component(index);
            for (function, on_shared) in functions.iter().zip(&mut on_shared) {
                for (column, response) in component.columns.iter().zip(&factored.response) {
                    let followed = factored.touched.iter().zip(response);
                    followed.for_each(|(shared, response)| on_shared[*shared] += function[*column] * response);
                }
            }
        }
        on_shared
    }
}

/// # Errors
/// Names a column of a component, of which `[R_ee R_es …]` are the rows, that the component's factors do not determine.
pub(crate) fn check(problem: &Problem, columns: &[usize], rows: &[f64]) -> Result<(), EvaluateError> {
    let eliminated = columns.len();
    let width = rows.len() / eliminated.max(1);
    let norm = |j: usize| (0..eliminated).map(|i| rows[i * width + j].powi(2)).sum::<f64>().sqrt();
    let weak = (0..eliminated).find(|i| rows[i * width + i].abs() <= LEAST_PIVOT * norm(*i));
    weak.map_or(Ok(()), |index| Err(undetermined(problem, columns[index])))
}

fn undetermined(problem: &Problem, column: usize) -> EvaluateError {
    let name = &problem.block(problem.columns()[column].block).name;
    EvaluateError(format!(
        "the eliminated block `{name}` is not determined by its own factors: give it a prior, or do not mark it as eliminated"
    ))
}

impl FactoredComponent {
    fn new(eliminated: usize, touched: &Arc<[usize]>, rows: &[f64]) -> Self {
        let width = eliminated + touched.len() + 1;
        let entry = |i: usize, j: usize| rows[i * width + j];
        // Back substitution of [I −R_es], one row after the other from the last.
        let mut solved = vec![vec![0.0; eliminated + touched.len()]; eliminated];
        for i in (0..eliminated).rev() {
            let mut row: Vec<f64> = (0..eliminated + touched.len())
                .map(|j| if j < eliminated { f64::from(i == j) } else { -entry(i, j) })
                .collect();
            for (k, below) in solved.iter().enumerate().skip(i + 1) {
                row.iter_mut().zip(below).for_each(|(sum, value)| *sum -= entry(i, k) * value);
            }
            row.iter_mut().for_each(|value| *value /= entry(i, i));
            solved[i] = row;
        }
        let response = solved.iter().map(|row| row[eliminated..].to_vec()).collect();
        solved.iter_mut().for_each(|row| row.truncate(eliminated));
        FactoredComponent { touched: Arc::clone(touched), response, own: solved }
    }

    fn add(&self, component: usize, index: usize, coefficient: f64, reduced: &mut Reduced) {
        let followed = self.touched.iter().zip(&self.response[index]);
        reduced.shared.extend(followed.map(|(shared, response)| (*shared, coefficient * response)));
        let at = reduced.eliminated.iter().position(|(known, _)| *known == component).unwrap_or_else(|| {
            reduced.eliminated.push((component, vec![0.0; self.own.len()]));
            reduced.eliminated.len() - 1
        });
        reduced.eliminated[at].1.iter_mut().zip(&self.own[index]).for_each(|(sum, own)| *sum += coefficient * own);
    }
}

impl Reduced {
    /// Covariance with another function that is due to the components' own errors.
    pub fn own_covariance(&self, other: &Reduced) -> f64 {
        let same = |component: usize| other.eliminated.iter().find(|(known, _)| *known == component);
        let pairs = self.eliminated.iter().filter_map(|(component, a)| Some((a, &same(*component)?.1)));
        pairs.map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::LARGE;
    use crate::linearization::tests::problem;
    use crate::statistics::{Solution, moved_by};
    use crate::{Block, Factor, Noise, Problem, ProblemBuilder, RankAnalysis, Values, testing::Line};

    #[test]
    fn covariances_and_leverages_with_elimination_are_those_without() {
        let ((plain, values), (eliminated, _)) = (problem(40, false), problem(40, true));
        let (reference, analysis) =
            (RankAnalysis::new(&plain, &values).unwrap(), RankAnalysis::new(&eliminated, &values).unwrap());
        assert_eq!(analysis.rank(), reference.rank());
        let (dense, reduced) = (reference.covariance().scaled(2.0), analysis.covariance().scaled(2.0));
        for i in 0..plain.columns().len() {
            for j in 0..plain.columns().len() {
                let difference = (dense.at(i, j) - reduced.at(i, j)).abs();
                assert!(difference < 1e-9 * dense.std(i) * dense.std(j), "{i} {j}");
            }
        }
        let (of_all, residuals) = reference.leverages(&plain, &values).unwrap();
        let (of_shared, same) = analysis.leverages(&eliminated, &values).unwrap();
        assert_eq!(residuals, same);
        for (a, b) in of_all.iter().zip(of_shared) {
            assert!((a - b).abs() < 1e-9);
        }
    }

    /// Unknowns of samples that follow each other, tied together: one component of all of them, and others between.
    fn tied(is_eliminated: bool) -> (Problem, Values) {
        let mut builder = ProblemBuilder::new();
        let shared = builder.add_block(Block::scalar("a", ""), &[0.0]);
        let block =
            |name: String| if is_eliminated { Block::scalar(name, "").eliminated() } else { Block::scalar(name, "") };
        let noise = |std: f64| Noise::independent(&[std]).unwrap();
        let mut chain = Vec::new();
        for k in 0..=LARGE {
            for name in ["tied", "alone"] {
                let id = builder.add_block(block(format!("{name}{k}")), &[0.0]);
                builder.add_factor(Factor::new(Line::new(&[id], &[1.0], 0.0), noise(0.5)));
                let coefficient = 1.0 + (0.1 * k as f64).sin();
                builder.add_factor(Factor::new(Line::new(&[shared, id], &[coefficient, 1.0], 0.0), noise(0.1)));
                chain.extend((name == "tied").then_some(id));
            }
        }
        for pair in chain.windows(2) {
            builder.add_factor(Factor::new(Line::new(pair, &[1.0, -1.0], 0.0), noise(0.2)));
        }
        builder.build().unwrap()
    }

    #[test]
    fn unknowns_that_are_tied_together_have_the_covariances_of_any_others() {
        let [plain, eliminated] = [false, true].map(|is_eliminated| {
            let (problem, values) = tied(is_eliminated);
            RankAnalysis::new(&problem, &values).unwrap().covariance()
        });
        for i in 0..2 * LARGE + 3 {
            for j in 0..2 * LARGE + 3 {
                let difference = (plain.at(i, j) - eliminated.at(i, j)).abs();
                assert!(difference < 1e-9 * plain.std(i) * plain.std(j), "{i} {j}: {difference}");
            }
        }
    }

    /// Errors of readings move what is shared by as much, whether the unknowns of samples are eliminated or not.
    #[test]
    fn errors_move_shared_columns_as_without_elimination() {
        let [plain, eliminated] = [false, true].map(|is_eliminated| {
            let (problem, values) = tied(is_eliminated);
            let analysis = RankAnalysis::new(&problem, &values).unwrap();
            let error = |k: usize| (0..problem.rows()).map(|row| ((row + 3 * k) as f64).sin()).collect::<Vec<f64>>();
            moved_by(&Solution { problem: &problem, values: &values, analysis: &analysis }, &[error(0), error(1)])
                .unwrap()
        });
        for (plain, eliminated) in plain.iter().zip(eliminated) {
            assert!(plain[0] != 0.0 && (plain[0] / eliminated[0] - 1.0).abs() < 1e-9, "{} {}", plain[0], eliminated[0]);
        }
    }

    #[test]
    fn a_eliminated_block_that_nothing_determines_is_named() {
        let mut builder = ProblemBuilder::new();
        let shared = builder.add_block(Block::scalar("a", ""), &[0.0]);
        let eliminated = builder.add_block(Block::vector("error1", "rad", &["x", "y"]).eliminated(), &[0.0, 0.0]);
        let noise = || Noise::independent(&[1.0]).unwrap();
        builder.add_factor(Factor::new(Line::new(&[shared], &[1.0], 0.0), noise()));
        builder.add_factor(Factor::new(Line::new(&[shared, eliminated], &[1.0, 1.0, 2.0], 0.0), noise()));
        let (problem, values) = builder.build().unwrap();
        let error = RankAnalysis::new(&problem, &values).unwrap_err().to_string();
        assert!(error.starts_with("the eliminated block `error1` is not determined by its own factors"), "{error}");
    }
}
