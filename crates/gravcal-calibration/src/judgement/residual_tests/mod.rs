//! Tests on residuals: whether what a fit leaves has a shape that noise has not, which tells that its intervals cannot hold.
//!
//! For each channel, terms are looked for that the model lacks ([`columns`]), by score tests from the same fit ([`score`]), and whether
//! neighbouring poses are alike ([`neighbours`]). As there are many tests, p-values are corrected by Holm's method: where the model is
//! right, anything at all is named with probability [`SIGNIFICANCE`] at most. What is named is then taken into the model, and all the rest
//! is tested again, so that one error of the model is told once, by its likeliest name. An order of a harmonic, a file, a size: these are
//! of that fit.
//!
//! **An arm in motion.** That a torque is recorded late, or filtered, shows in the slope and the bend of the predicted readings over time
//! ([`delayed`]).
//!
//! **What all joints do.** What bends most passes for a position gain, so that a joint's own test has little power, and needs it most. And a
//! recorder does the same to all torques. One compliance of all joints, one lag and one filter of all torques are therefore looked for, too, and
//! whether the zeros of all joints drift, each by itself, as an arm that warms up lets them; these have half of the probability of naming anything,
//! as all other tests together have.
//!
//! **What it comes to.** A term that is there spoils intervals where what is seen of it is a quarter of one reading's noise; neighbours
//! that are alike where their correlation is 0.2, unless standard deviations come from blocks. By as much as such a term would move a number
//! if the model had it, the number's standard deviation grows, `σ² + Δ²` for `σ²`: an effect that is known, and left uncorrected, is counted as
//! an uncertainty. A zero that drifts is seldom alone: where one is named, others are taken to drift, too ([`drift`]). The verdict stays *partly
//! determined*: the term belongs into the model. Less is told, and changes no verdict. The side from which joints came spoils nothing where errors beyond the noise are estimated: what friction leaves at rest is then an unknown of the
//! fit (`joint/model_error/at_rest.rs`), told from position gains and biases or widening their intervals
//! (`cargo run --release -p gravcal-benches --bin real_arms -- --line still --line one-way` counts how often these hold the truth).
//!
//! **Not tested**: what was counted by a loss, what has not converged, readings that enter group by group, residuals that are but the
//! rounding of numbers, a term that the model has already, a channel with too few readings to tell its noise.

mod bound;
mod candidate;
mod columns;
mod delayed;
mod drift;
mod in_fit;
mod neighbours;
mod rows;
mod score;
#[cfg(test)]
mod tests;
mod words;

use std::ops::Range;

use gravcal_estimation::statistics::{ResidualMaker, Solution, StatisticsError, moved_by};
use gravcal_estimation::{Loss, in_parallel};
use gravcal_recording::file_name;
use gravcal_robot_model::session::{ReadingId, Session, UnexplainedError};

use crate::joint::{OfReadings, Order, Solved};
use crate::result::{ResidualTest, ResidualTestKind, UncertaintyResult};
use bound::{Bound, Sums};
pub(crate) use candidate::SIGNIFICANCE;
use candidate::{Candidate, Tested, correct, next, weights};
use columns::{ALL_JOINTS, Columns, Term};
use drift::{combined, drift_of_all, drift_of_joint, drifting, with_error};
use in_fit::of_estimate;
use neighbours::Neighbours;
use rows::{MANY, Rows};
use score::{Left, MATTERS, Score, lacking, left_of, score};
pub(crate) use words::in_words;

/// Correlation of neighbours from which intervals from noise cannot hold: they are too narrow by up to a fifth.
const ALIKE: f64 = 0.2;
/// More terms are not named: then the model as a whole is wrong. Terms that the fit has as unknowns are no error of it, that neighbours are alike
/// names no term, and both may be so in every channel.
const MOST_NAMED: usize = 8;
/// Residuals below this share of the readings' range are those of arithmetic.
const ROUNDING: f64 = 1e-7;
/// Candidates of whose columns the fit's part is taken off at once.
const TOGETHER: usize = 4;
/// Entries of the Jacobian beyond which it is not made a second time.
const MOST_ENTRIES: usize = 100_000_000;

/// Whether a solution's residuals are not tested because its Jacobian has too many entries.
pub(crate) fn too_large(solved: &Solved) -> bool {
    let problem = solved.judged_problem();
    problem.rows().saturating_mul(problem.columns().len()) >= MOST_ENTRIES
}

/// The tests of a solution's residuals.
#[derive(Debug, Default)]
pub(crate) struct ResidualTests {
    /// What is named first, in the order in which it was found.
    pub tests: Vec<ResidualTest>,
    /// By how much each column of the problem that is judged would be another with each of the terms that are named and spoil intervals.
    pub moved: Vec<Vec<f64>>,
}

/// Which tests on residuals are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TestsWanted {
    /// Every one.
    All,
    /// All or none: none where nothing is named.
    WhereNamed,
}

/// Tests the residuals of a solution.
///
/// # Errors
/// Where a residual cannot be evaluated.
pub(crate) fn residual_tests(
    session: &Session,
    solved: &Solved,
    uncertainty: &UncertaintyResult,
    wanted: TestsWanted,
) -> Result<ResidualTests, StatisticsError> {
    let problem = solved.judged_problem();
    let tested = solved.estimate.termination.converged()
        && solved.built.loss == Loss::None
        && solved.readings.order == Order::Together
        && problem.rows() > solved.analysis.rank()
        && !too_large(solved);
    if !tested {
        return Ok(ResidualTests::default());
    }
    let solution = Solution { problem, values: &solved.estimate.values, analysis: &solved.analysis };
    let maker = ResidualMaker::new(&solution)?;
    let columns = Columns::new(session, solved, problem.rows())?;
    let rows = Rows::new(session, solved, &maker);
    let session_of_tests =
        Tests { session, solved, columns, robust: !matches!(uncertainty, UncertaintyResult::Noise { .. }) };
    let neighbours = in_parallel(0..rows.channels(), |channel| Neighbours::of(&maker, &rows, channel));
    let candidates = session_of_tests.candidates(&maker, &rows);
    if wanted == TestsWanted::WhereNamed && session_of_tests.names_nothing(&maker, &rows, &neighbours, &candidates) {
        return Ok(ResidualTests::default());
    }
    let (tests, missing) = session_of_tests.all(maker, rows, neighbours, &candidates);
    Ok(ResidualTests { tests, moved: moved_by(&solution, &missing)? })
}

struct Tests<'a> {
    session: &'a Session,
    solved: &'a Solved,
    columns: Columns<'a>,
    /// Whether standard deviations hold where neighbours are alike.
    robust: bool,
}

impl Tests<'_> {
    /// All of them, and what the model is missing that spoils intervals: one entry a row of the problem, in standard deviations.
    fn all(
        &self,
        mut maker: ResidualMaker,
        mut rows: Rows,
        mut neighbours: Vec<Option<Neighbours>>,
        candidates: &[Candidate],
    ) -> (Vec<ResidualTest>, Vec<Vec<f64>>) {
        let mut named: Vec<ResidualTest> = Vec::new();
        let (mut missing, mut lacking) = (Vec::new(), 0);
        let mut drift = Vec::new();
        let mut found = self.tested(&maker, &rows, &neighbours, candidates);
        loop {
            let weight = weights(&found);
            let weighted = |tested: &Tested| tested.test.p_value / weight(tested);
            found.sort_by(|a, b| weighted(a).total_cmp(&weighted(b)).then(b.gain.total_cmp(&a.gain)));
            correct(&mut found, named.last().map_or(0.0, |last| last.corrected_p_value));
            let next = next(&found);
            let tells = found.get(next).is_some_and(|first| first.test.corrected_p_value < SIGNIFICANCE);
            if !tells || lacking == MOST_NAMED {
                missing.extend(self.drifts_of_others(&drift, &found));
                named.extend(found.into_iter().map(|tested| tested.test));
                return (named, missing);
            }
            let first = found.remove(next);
            found.retain(|other| !self.covers(&first.candidate, &other.candidate));
            let judged = self.judged(&first.candidate, first.test);
            if judged.spoils_intervals {
                missing.extend(self.missing(&first.candidate, &first.coefficients));
                drift.extend(drifting(&first.candidate, self.session.joints.len()));
            }
            named.push(judged);
            // With a term in the model, what it leaves is another.
            let terms = self.lacking(&maker, &first.candidate);
            if !terms.is_empty() {
                lacking += 1;
                for term in &terms {
                    for (channel, known) in neighbours.iter_mut().enumerate() {
                        *known = known.take().and_then(|known| known.with(&maker, &rows, channel, term));
                    }
                    maker = maker.with(std::slice::from_ref(term));
                }
                rows.count_freedom(&maker);
                let candidates = found.into_iter().map(|tested| tested.candidate);
                let candidates: Vec<Candidate> = candidates.filter(|other| *other != Candidate::DriftOfAll).collect();
                found = self.tested(&maker, &rows, &neighbours, &candidates);
            }
        }
    }

    /// Whether nothing can be named, as sums over channels tell ([`bound`]). Tests that need no columns are made. A p-value counts as often as
    /// there are such tests, and twice where it is of all joints, if not more often: see [`weights`]. Of trends any may be left out.
    fn names_nothing(
        &self,
        maker: &ResidualMaker,
        rows: &Rows,
        neighbours: &[Option<Neighbours>],
        candidates: &[Candidate],
    ) -> bool {
        if !maker.is_shared_alone() {
            return false;
        }
        let sums = Sums::of(maker, rows);
        let (mut own, mut together, mut trends, mut made) = (f64::INFINITY, f64::INFINITY, Vec::new(), 0);
        for candidate in candidates {
            let columns = self.columns_of(candidate);
            let least = match columns.is_empty() {
                true => self.test(maker, rows, neighbours, candidate, &[]).map(|tested| tested.test.p_value),
                false => match sums.bound(maker, rows, &columns) {
                    Bound::InModel => None,
                    Bound::Least(p) => Some(p),
                    Bound::Open => return false,
                },
            };
            let Some(least) = least else { continue };
            made += usize::from(columns.is_empty());
            trends.extend(drift_of_joint(candidate, self.session.joints.len()).map(|_| least));
            match candidate {
                Candidate::Together(_) => together = together.min(least),
                _ => own = own.min(least),
            }
        }
        trends.sort_by(f64::total_cmp);
        let of_trends = (2..=trends.len()).map(|count| combined(trends[..count].iter().copied()));
        let together = of_trends.map(|tested| tested.map_or(0.0, |(_, _, p)| p)).fold(together, f64::min);
        made as f64 * own >= SIGNIFICANCE && 2.0 * together >= SIGNIFICANCE
    }

    /// What a model without this term does not say of the readings; nothing of neighbours that are alike, which are no term.
    fn missing(&self, candidate: &Candidate, coefficients: &[f64]) -> Option<Vec<f64>> {
        match candidate {
            Candidate::Neighbours(_) => None,
            Candidate::Term(channel, term) => Some(self.columns.missing(*channel, term, coefficients)),
            Candidate::Together(term) => {
                let coefficient = coefficients.first().copied().unwrap_or(0.0);
                Some(self.columns.missing_in_joints(term, &vec![coefficient; self.session.joints.len()]))
            }
            Candidate::DriftOfAll => Some(self.columns.missing_in_joints(&Term::Trend, coefficients)),
        }
    }

    /// What a model without drifts may not say of the channels whose own drift is not named; nothing where no zero drifts.
    fn drifts_of_others(&self, drifting: &[usize], found: &[Tested]) -> Vec<Vec<f64>> {
        let of_other = |tested: &Tested| match &tested.candidate {
            Candidate::Term(channel, Term::Trend) if !drifting.is_empty() && !drifting.contains(channel) => {
                Some(self.columns.missing(*channel, &Term::Trend, &[with_error(tested)]))
            }
            _ => None,
        };
        found.iter().filter_map(of_other).collect()
    }

    /// Columns of a candidate that are looked for in what the fit leaves; none of what is tested otherwise.
    fn columns_of(&self, candidate: &Candidate) -> Vec<Vec<f64>> {
        match candidate {
            Candidate::Neighbours(_) => Vec::new(),
            Candidate::Term(channel, term) if self.is_in_fit(*channel, term) => Vec::new(),
            Candidate::Term(channel, term) => self.columns.of(*channel, term),
            Candidate::Together(term) => vec![sum(&self.columns.of_each_joint(term))],
            Candidate::DriftOfAll => self.columns.of_each_joint(&Term::Trend),
        }
    }

    /// What the model lacks that has not what a candidate says, as unit vectors perpendicular to each other.
    fn lacking(&self, maker: &ResidualMaker, candidate: &Candidate) -> Vec<Vec<f64>> {
        match candidate {
            // Joints do not bend alike: the model takes up what each does.
            Candidate::Together(term) => lacking(maker, self.columns.of_each_joint(term)),
            _ => lacking(maker, self.columns_of(candidate)),
        }
    }

    /// Whether another need not be looked for where a candidate is in the model.
    fn covers(&self, candidate: &Candidate, other: &Candidate) -> bool {
        let has = |term: &Term| matches!(other, Candidate::Term(_, other) if other == term);
        match candidate {
            Candidate::Together(term) => candidate == other || has(term),
            Candidate::DriftOfAll => candidate == other || drift_of_joint(other, self.session.joints.len()).is_some(),
            _ => candidate == other,
        }
    }

    /// Whether a term is an unknown of the fit.
    fn is_in_fit(&self, channel: usize, term: &Term) -> bool {
        match term {
            Term::Direction => self.solved.has_friction_at_rest(channel),
            Term::Compliance => self.solved.has_bending(channel),
            _ => false,
        }
    }

    /// Those that can be tested.
    fn tested(
        &self,
        maker: &ResidualMaker,
        rows: &Rows,
        neighbours: &[Option<Neighbours>],
        candidates: &[Candidate],
    ) -> Vec<Tested> {
        let test = |candidates: &[Candidate]| {
            let mut columns = Vec::new();
            let place = |candidate: &Candidate| {
                let first = columns.len();
                columns.extend(self.columns_of(candidate));
                first..columns.len()
            };
            let places: Vec<Range<usize>> = candidates.iter().map(place).collect();
            let left = left_of(maker, columns);
            let test = |(candidate, own): (&Candidate, Range<usize>)| {
                self.test(maker, rows, neighbours, candidate, &left[own])
            };
            candidates.iter().zip(places).filter_map(test).collect::<Vec<Tested>>()
        };
        let mut tested: Vec<Tested> = in_parallel(candidates.chunks(TOGETHER), test).into_iter().flatten().collect();
        tested.extend(drift_of_all(&tested, self.session.joints.len()));
        tested
    }

    fn candidates(&self, maker: &ResidualMaker, rows: &Rows) -> Vec<Candidate> {
        let scattered: Vec<usize> =
            (0..rows.channels()).filter(|channel| self.scatters(maker, rows, *channel)).collect();
        let own = |channel: &usize| {
            let terms = self.columns.terms(*channel).into_iter();
            terms
                .map(|term| Candidate::Term(*channel, term))
                .chain([Candidate::Neighbours(*channel)])
                .collect::<Vec<_>>()
        };
        let of_position = |joint: usize| {
            let terms = self.columns.terms_of_position(joint).into_iter();
            terms.map(move |term| Candidate::Term(joint, term)).collect::<Vec<_>>()
        };
        let positions = if scattered.is_empty() { 0 } else { self.session.joints.len() };
        let mut candidates: Vec<Candidate> =
            scattered.iter().flat_map(own).chain((0..positions).flat_map(of_position)).collect();
        for term in [Term::Compliance, Term::TorqueLag, Term::TorqueFilter] {
            let own = |candidate: &&Candidate| match candidate {
                // Where it is in the fit already, nothing needs to be looked for in what the fit leaves.
                Candidate::Term(joint, Term::Compliance) if self.solved.has_bending(*joint) => false,
                Candidate::Term(_, own) => *own == term,
                _ => false,
            };
            if candidates.iter().filter(own).count() > 1 {
                candidates.push(Candidate::Together(term));
            }
        }
        candidates
    }

    /// Whether a channel's residuals are more than the rounding of numbers.
    fn scatters(&self, maker: &ResidualMaker, rows: &Rows, channel: usize) -> bool {
        let own = rows.of_channel(channel);
        let square = |row: &usize| {
            let ReadingId { pose, .. } = self.solved.built.rows[*row];
            (maker.residuals()[*row] * self.solved.readings.std(self.session, pose, channel)).powi(2)
        };
        let rms = (own.iter().map(square).sum::<f64>() / own.len().max(1) as f64).sqrt();
        let largest = own.iter().filter_map(|row| self.session.reading(self.solved.built.rows[*row].pose, channel));
        rms > ROUNDING * largest.map(|reading| reading.value.abs()).fold(0.0, f64::max)
    }

    fn test(
        &self,
        maker: &ResidualMaker,
        rows: &Rows,
        neighbours: &[Option<Neighbours>],
        candidate: &Candidate,
        left: &[Left],
    ) -> Option<Tested> {
        match candidate {
            Candidate::Neighbours(channel) => {
                let known = neighbours[*channel].as_ref()?;
                let (correlation, t, freedom, p_value) = known.test(rows, *channel, maker.residuals())?;
                let test = ResidualTest {
                    channel: self.session.channel_name(*channel),
                    kind: ResidualTestKind::Neighbours,
                    statistic: t,
                    degrees_of_freedom: [1.0, freedom.min(MANY)],
                    blocks: None,
                    p_value,
                    corrected_p_value: p_value,
                    size: correlation,
                    unit: String::new(),
                    in_noise: 0.0,
                    named: false,
                    spoils_intervals: false,
                };
                Some(Tested { test, candidate: candidate.clone(), gain: 0.0, coefficients: Vec::new() })
            }
            Candidate::Together(term) => {
                let tested = self.report(0, term, score(maker, rows, neighbours, left)?);
                let test = ResidualTest { channel: ALL_JOINTS.into(), ..tested.test };
                Some(Tested { test, candidate: candidate.clone(), ..tested })
            }
            Candidate::DriftOfAll => None, // made of the others: see `drift.rs`
            Candidate::Term(channel, term) => {
                let in_fit = |found: Option<OfReadings>| {
                    of_estimate(found?, rows, *channel, &self.columns.of(*channel, term)[0])
                };
                let scored = match (term, self.is_in_fit(*channel, term)) {
                    (Term::Direction, true) => in_fit(self.solved.friction_at_rest(*channel))?,
                    (Term::Compliance, true) => in_fit(self.solved.bending(*channel))?,
                    _ => score(maker, rows, neighbours, left)?,
                };
                Some(self.report(*channel, term, scored))
            }
        }
    }

    fn report(&self, channel: usize, term: &Term, scored: Score) -> Tested {
        let Score { statistic, degrees_of_freedom, blocks, p_value, coefficients, in_noise, gain } = scored;
        let unit = self.session.channel_unit(channel);
        let amplitude = coefficients.iter().map(|c| c * c).sum::<f64>().sqrt();
        let first = coefficients.first().copied().unwrap_or(0.0);
        let each = if self.columns.in_time() { "s" } else { "pose" };
        let (kind, size, unit) = match term {
            Term::Trend => (ResidualTestKind::Trend, first, format!("{unit}/{each}")),
            Term::TrendInTables => (ResidualTestKind::TrendInTables, first, format!("{unit}/{each}")),
            Term::TorqueHarmonic(order) => (ResidualTestKind::TorqueHarmonic { order: *order }, amplitude, unit),
            Term::PositionHarmonic(order) => {
                (ResidualTestKind::PositionHarmonic { order: *order }, amplitude, "rad".to_owned())
            }
            Term::Compliance => (ResidualTestKind::Compliance, first, "rad/(N·m)".to_owned()),
            Term::Velocity => (ResidualTestKind::Velocity, first, self.by_motion(channel, &unit, "s")),
            Term::Acceleration => (ResidualTestKind::Acceleration, first, self.by_motion(channel, &unit, "s²")),
            Term::Direction => (ResidualTestKind::Direction, first, unit),
            Term::TorqueLag => (ResidualTestKind::TorqueLag, first, "s".to_owned()),
            Term::TorqueFilter => (ResidualTestKind::TorqueFilter, first, "s²".to_owned()),
            Term::Tables => {
                let (table, size) = self.farthest(channel, &coefficients);
                let file = file_name(&self.session.tables[table].path);
                (ResidualTestKind::Tables { file }, size, unit)
            }
        };
        let test = ResidualTest {
            channel: self.session.channel_name(channel),
            kind,
            statistic,
            degrees_of_freedom,
            blocks,
            p_value,
            corrected_p_value: p_value,
            size,
            unit,
            in_noise,
            named: false,
            spoils_intervals: false,
        };
        Tested { test, candidate: Candidate::Term(channel, term.clone()), gain, coefficients }
    }

    fn by_motion(&self, joint: usize, unit: &str, time: &str) -> String {
        let slides = self.session.robot.chain.joints()[joint].kind == gravcal_dynamics::JointKind::Prismatic;
        format!("{unit}/({}/{time})", if slides { "m" } else { "rad" })
    }

    /// The table that is farthest from the mean one, and by how much; `coefficients` are those of all but the first.
    fn farthest(&self, channel: usize, coefficients: &[f64]) -> (usize, f64) {
        let tables = self.columns.tables(channel);
        let mean = coefficients.iter().sum::<f64>() / tables.len() as f64;
        let apart =
            tables.iter().zip(std::iter::once(&0.0).chain(coefficients)).map(|(table, own)| (*table, own - mean));
        apart.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or((0, 0.0))
    }

    /// Whether friction that is left at rest is among the errors that standard deviations of the channel allow for.
    fn errs_at_rest(&self, channel: usize) -> bool {
        self.session.unexplained_errors()[channel] == UnexplainedError::Estimated
    }

    fn judged(&self, candidate: &Candidate, test: ResidualTest) -> ResidualTest {
        let spoils = match candidate {
            Candidate::Neighbours(_) => test.size >= ALIKE && !self.robust,
            Candidate::Term(channel, Term::Direction) => test.in_noise >= MATTERS && !self.errs_at_rest(*channel),
            Candidate::Term(joint, Term::Compliance) => test.in_noise >= MATTERS && !self.solved.has_bending(*joint),
            Candidate::Term(..) | Candidate::Together(_) | Candidate::DriftOfAll => test.in_noise >= MATTERS,
        };
        ResidualTest { named: true, spoils_intervals: spoils, ..test }
    }
}

fn sum(columns: &[Vec<f64>]) -> Vec<f64> {
    let mut sum = vec![0.0; columns.first().map_or(0, Vec::len)];
    columns.iter().for_each(|column| sum.iter_mut().zip(column).for_each(|(sum, own)| *sum += own));
    sum
}
