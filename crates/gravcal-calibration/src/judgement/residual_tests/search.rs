//! One search of what the model lacks: all that may be is tested, the likeliest is named and taken into the model, and all the rest is tested
//! again, until nothing more is told.

use std::ops::Range;

use gravcal_estimation::in_parallel;
use gravcal_estimation::statistics::{ResidualMaker, Solution, StatisticsError, moved_by};
use gravcal_robot_model::session::{Session, UnexplainedError};

use super::candidate::{Candidate, SIGNIFICANCE, Tested, correct, next, weights};
use super::columns::{ALL_JOINTS, Columns};
use super::drift::{DRIFT, drift_of_all, drift_of_joint, not_alone, with_errors};
use super::first_order;
use super::in_fit::of_estimate;
use super::neighbours::Neighbours;
use super::rows::{MANY, Rows};
use super::score::{Left, MATTERS, Score, dot, lacking, left_of, score};
use super::terms::{Elastic, Friction, Stated, Term};
use super::uneven_scatter;
use crate::joint::{OfReadings, Solved};
use crate::result::{ResidualTest, ResidualTestKind};

/// Correlation of neighbours from which intervals from noise cannot hold: they are too narrow by up to a fifth.
const ALIKE: f64 = 0.2;
/// A term that moves a number by more than so many of its standard deviations spoils its interval: one of 95 % holds in 92 % then.
const MOVES: f64 = 0.5;
/// Where neighbours are alike, blocks of them tell a term with little power: one that is named there, and would move a number by so many, does so too.
const MOVES_FAR: f64 = 3.0;
/// Probability, corrected for the number of tests, below which it does so even if little is seen of it: chance moves numbers as far.
const SURE: f64 = 0.1 * SIGNIFICANCE;
/// More terms are not named: then the model as a whole is wrong. Terms that the fit has as unknowns are no error of it, that neighbours are alike
/// names no term, and both may be so in every channel.
const MOST_NAMED: usize = 8;
/// A column that is so small a share of the longest of its term is rounding: numbers are rounded to 1e-16 of theirs.
const ROUNDING: f64 = 1e-10;
/// Candidates of whose columns the fit's part is taken off at once.
const TOGETHER: usize = 4;

/// Whether a term is large where the torque is, where friction leaves most at rest.
fn goes_with_torque(kind: &ResidualTestKind) -> bool {
    matches!(
        kind,
        ResidualTestKind::TorqueNonlinearity
            | ResidualTestKind::TorqueGain { .. }
            | ResidualTestKind::TorqueGainTrend
            | ResidualTestKind::Crosstalk { .. }
            | ResidualTestKind::Creep
            | ResidualTestKind::LoadFriction
    )
}

/// What is searched.
pub struct Search<'a> {
    pub session: &'a Session,
    pub solved: &'a Solved,
    /// Of the problem that is judged.
    pub solution: Solution<'a>,
    pub columns: Columns<'a>,
    /// Of each row, where readings are counted by a loss.
    pub weights: Option<&'a [f64]>,
    /// Whether standard deviations hold where neighbours are alike.
    pub robust: bool,
}

/// What is named of the robot and its loads, where most wrong. Who measured one length badly measured others so; and as masses have one scale with the torque
/// gains, one load is as well too light as another too heavy.
#[derive(Clone, Copy, Debug, Default)]
struct Worst {
    /// m
    length: f64,
    /// rad
    tilt: f64,
    /// Share of a mass.
    mass: f64,
}

impl Worst {
    /// `size`: of the term, in its unit.
    fn heed(&mut self, candidate: &Candidate, size: f64, session: &Session) {
        match candidate {
            Candidate::OfArm(Term::Stated(Stated::JointPlacement(_))) => self.length = self.length.max(size),
            Candidate::OfArm(Term::Stated(Stated::JointTilt(_))) => self.tilt = self.tilt.max(size),
            Candidate::OfArm(Term::Stated(Stated::LoadMass(load))) => {
                self.mass = self.mass.max(size / session.loads[*load].mass);
            }
            _ => {}
        }
    }
}

impl Search<'_> {
    /// All of them, and what the model is missing that spoils intervals: one entry a row of the problem, in standard deviations.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated.
    pub fn all(
        &self,
        mut maker: ResidualMaker,
        mut rows: Rows,
        mut neighbours: Vec<Option<Neighbours>>,
        candidates: &[Candidate],
    ) -> Result<(Vec<ResidualTest>, Vec<Vec<f64>>), StatisticsError> {
        let mut named: Vec<ResidualTest> = Vec::new();
        let (mut missing, mut lacking) = (Vec::new(), 0);
        let mut not_alone_in = Vec::new();
        let (mut worst, mut named_terms) = (Worst::default(), Vec::new());
        let mut found = self.tested(&maker, &rows, &neighbours, candidates);
        loop {
            let weight = weights(&found);
            let weighted = |tested: &Tested| tested.test.p_value / weight(tested);
            found.sort_by(|a, b| weighted(a).total_cmp(&weighted(b)).then(b.gain.total_cmp(&a.gain)));
            correct(&mut found, named.last().map_or(0.0, |last| last.corrected_p_value));
            let next = next(&found);
            let tells = found.get(next).is_some_and(|first| first.test.corrected_p_value < SIGNIFICANCE);
            if tells && self.is_less_certain(&maker, &rows, &neighbours, &mut found[next]) {
                continue;
            }
            if !tells || lacking == MOST_NAMED {
                missing.extend(self.of_others(&not_alone_in, &found));
                missing.extend(self.of_like_terms(worst, &named_terms));
                named.extend(found.into_iter().map(|tested| tested.test));
                return Ok((named, missing));
            }
            let first = found.remove(next);
            found.retain(|other| !self.covers(&first.candidate, &other.candidate));
            let own = self.missing(&first.candidate, &first.coefficients);
            let judged = self.judged(&first.candidate, first.test, self.moves(&own)?);
            if judged.spoils_intervals {
                missing.extend(own);
                not_alone_in.extend(not_alone(&first.candidate, self.session.joints.len()));
                worst.heed(&first.candidate, judged.size.abs(), self.session);
                named_terms.push(first.candidate);
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

    /// Whether a candidate is less certain where noise is of first order, or, of what goes with the torque, grows with it, as residuals show; it has that
    /// p-value then. It is asked once.
    fn is_less_certain(
        &self,
        maker: &ResidualMaker,
        rows: &Rows,
        neighbours: &[Option<Neighbours>],
        tested: &mut Tested,
    ) -> bool {
        if std::mem::replace(&mut tested.is_confirmed, true) {
            return false;
        }
        let terms = lacking(maker, self.columns_of(&tested.candidate));
        let uneven = goes_with_torque(&tested.test.kind).then(|| uneven_scatter::test(maker, rows, &terms)).flatten();
        let others = [first_order::test(maker, rows, neighbours, &terms), uneven];
        let least = others.into_iter().flatten().max_by(|a, b| a.2.total_cmp(&b.2));
        let Some((statistic, degrees_of_freedom, p_value)) = least.filter(|least| least.2 > tested.test.p_value) else {
            return false;
        };
        tested.test = ResidualTest { statistic, degrees_of_freedom, p_value, ..tested.test.clone() };
        tested.p_of_noise = tested.p_of_noise.max(p_value);
        true
    }

    /// What a model without this term does not say of the readings; nothing of neighbours that are alike, which are no term.
    fn missing(&self, candidate: &Candidate, coefficients: &[f64]) -> Vec<Vec<f64>> {
        let missing = match candidate {
            Candidate::Neighbours(_) => Vec::new(),
            Candidate::Term(channel, term) => vec![term.missing(&self.columns, *channel, coefficients)],
            Candidate::OfArm(
                term @ Term::Stated(Stated::LoadPlacement(_) | Stated::JointPlacement(_) | Stated::JointTilt(_)),
            ) => self.aside(*term, dot(coefficients, coefficients).sqrt()),
            Candidate::OfArm(term) => vec![term.missing(&self.columns, 0, coefficients)],
            Candidate::Together(term) => {
                let coefficient = coefficients.first().copied().unwrap_or(0.0);
                vec![term.missing_in_joints(&self.columns, &vec![coefficient; self.session.joints.len()])]
            }
            Candidate::DriftOfAll => vec![DRIFT.missing_in_joints(&self.columns, coefficients)],
        };
        self.weighted(missing)
    }

    /// What is stated of a term and wrong by so much, in its unit: a place along one axis after the other. About its joint's axis an offset takes up what is
    /// wrong, and nothing is seen of it: it may be as wrong there.
    pub fn aside(&self, term: Term, by: f64) -> Vec<Vec<f64>> {
        let axes = term.columns(&self.columns, 0).into_iter();
        axes.map(|axis| axis.into_iter().map(|entry| by * entry).collect()).collect()
    }

    /// What a model may not say of other channels than those of which a term is named that is seldom alone.
    fn of_others(&self, not_alone: &[(Term, Vec<usize>)], found: &[Tested]) -> Vec<Vec<f64>> {
        let of_other = |tested: &Tested| {
            let Candidate::Term(channel, term) = &tested.candidate else { return None };
            let mut named = not_alone.iter().filter(|(named, _)| named == term).peekable();
            let is_other = named.peek().is_some() && named.all(|(_, channels)| !channels.contains(channel));
            is_other.then(|| term.missing(&self.columns, *channel, &with_errors(tested)))
        };
        self.weighted(found.iter().filter_map(of_other).collect())
    }

    /// What is stated of the robot and its loads and is not named, as wrong as the like that is named and most wrong.
    fn of_like_terms(&self, worst: Worst, named: &[Candidate]) -> Vec<Vec<f64>> {
        let by = |term: Term| match term {
            Term::Stated(Stated::JointPlacement(_)) => worst.length,
            Term::Stated(Stated::JointTilt(_)) => worst.tilt,
            Term::Stated(Stated::LoadMass(load)) => worst.mass * self.session.loads[load].mass,
            _ => 0.0,
        };
        // Also of what cannot be tested beside what is named: the model has it then.
        let others = Term::of_arm(&self.columns).into_iter();
        let others = others.filter(|term| by(*term) > 0.0 && !named.contains(&Candidate::OfArm(*term)));
        self.weighted(others.flat_map(|term| self.aside(term, by(term))).collect())
    }

    /// Columns of a candidate that are looked for in what the fit leaves; none of what is tested otherwise.
    pub fn columns_of(&self, candidate: &Candidate) -> Vec<Vec<f64>> {
        let columns = match candidate {
            Candidate::Neighbours(_) => Vec::new(),
            Candidate::Term(channel, term) if self.is_in_fit(*channel, *term) => Vec::new(),
            Candidate::Term(channel, term) => term.columns(&self.columns, *channel),
            Candidate::OfArm(term) => term.columns(&self.columns, 0),
            Candidate::Together(term) => vec![sum(&term.columns_of_each_joint(&self.columns))],
            Candidate::DriftOfAll => DRIFT.columns_of_each_joint(&self.columns),
        };
        self.weighted(without_rounding(columns))
    }

    /// Columns as the problem counts their rows.
    pub fn weighted(&self, mut columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        if let Some(weights) = self.weights {
            let of_row = |(entry, weight): (&mut f64, &f64)| *entry *= weight.sqrt();
            columns.iter_mut().for_each(|column| column.iter_mut().zip(weights).for_each(of_row));
        }
        columns
    }

    /// What the model lacks that has not what a candidate says, as unit vectors perpendicular to each other.
    fn lacking(&self, maker: &ResidualMaker, candidate: &Candidate) -> Vec<Vec<f64>> {
        match candidate {
            // Joints do not bend alike: the model takes up what each does.
            Candidate::Together(term) => lacking(maker, self.weighted(term.columns_of_each_joint(&self.columns))),
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
    fn is_in_fit(&self, channel: usize, term: Term) -> bool {
        match term {
            Term::Friction(Friction::Direction) => self.solved.has_friction_at_rest(channel),
            Term::Elastic(Elastic::Compliance) => self.solved.has_bending(channel),
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

    pub fn test(
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
                let (candidate, coefficients) = (*candidate, Vec::new());
                Some(Tested { test, candidate, gain: 0.0, p_of_noise: p_value, is_confirmed: true, coefficients })
            }
            Candidate::Together(term) | Candidate::OfArm(term) => {
                let tested = self.report((0, *term), *candidate, score(maker, rows, neighbours, left)?)?;
                let test = ResidualTest { channel: ALL_JOINTS.into(), ..tested.test };
                Some(Tested { test, ..tested })
            }
            Candidate::DriftOfAll => None, // made of the others: see `drift.rs`
            Candidate::Term(channel, term) => {
                let in_fit = |found: Option<OfReadings>| {
                    of_estimate(found?, rows, *channel, &self.weighted(term.columns(&self.columns, *channel))[0])
                };
                let scored = match (term, self.is_in_fit(*channel, *term)) {
                    (Term::Friction(_), true) => in_fit(self.solved.friction_at_rest(*channel))?,
                    (_, true) => in_fit(self.solved.bending(*channel))?,
                    (_, false) => score(maker, rows, neighbours, left)?,
                };
                self.report((*channel, *term), *candidate, scored)
            }
        }
    }

    /// The result of one test, with its size in a unit; nothing of coefficients that nothing real has.
    fn report(&self, (channel, term): (usize, Term), candidate: Candidate, scored: Score) -> Option<Tested> {
        let Score { statistic, degrees_of_freedom, blocks, p_value, p_of_noise, coefficients, in_noise, gain } = scored;
        if !term.lacked().may_be(&self.columns, channel, &coefficients) {
            return None;
        }
        let found = term.lacked().found(&self.columns, channel, &coefficients);
        let test = ResidualTest {
            channel: self.session.channel_name(channel),
            kind: found.kind,
            statistic,
            degrees_of_freedom,
            blocks,
            p_value,
            corrected_p_value: p_value,
            size: found.size,
            unit: found.unit,
            in_noise,
            named: false,
            spoils_intervals: false,
        };
        Some(Tested { test, candidate, gain, p_of_noise, is_confirmed: false, coefficients })
    }

    /// Whether friction that is left at rest is an unknown, or among the errors that standard deviations of the channel allow for: in recordings that is
    /// so where such errors are estimated.
    fn errs_at_rest(&self, channel: usize) -> bool {
        let estimated = self.session.unexplained_errors()[channel] == UnexplainedError::Estimated;
        (estimated && !self.session.searched.is_empty()) || self.solved.has_friction_at_rest(channel)
    }

    /// By how many of its standard deviations what is missing moves the number that it moves most.
    fn moves(&self, missing: &[Vec<f64>]) -> Result<f64, StatisticsError> {
        let (variables, covariance) = (&self.solved.built.variables, self.solved.covariance());
        let parameters = self.session.parameters().into_iter().map(|id| variables.block(id));
        let columns: Vec<usize> = parameters
            .chain([variables.gravity])
            .flat_map(|block| self.solution.problem.columns_of(block))
            .filter(|column| covariance.std(*column) > 0.0)
            .collect();
        let largest = |moved: &Vec<f64>| {
            columns.iter().map(|column| moved[*column].abs() / covariance.std(*column)).fold(0.0, f64::max)
        };
        Ok(moved_by(&self.solution, missing)?.iter().map(largest).fold(0.0, f64::max))
    }

    /// `moves`: by how many of its standard deviations it moves any number.
    fn judged(&self, candidate: &Candidate, test: ResidualTest, moves: f64) -> ResidualTest {
        let far = test.blocks.is_some() && moves > MOVES_FAR;
        let matters = test.in_noise >= MATTERS || (moves > MOVES && test.corrected_p_value < SURE) || far;
        let spoils = match candidate {
            Candidate::Neighbours(_) => test.size >= ALIKE && !self.robust,
            Candidate::Term(channel, Term::Friction(Friction::Direction)) => matters && !self.errs_at_rest(*channel),
            Candidate::Term(joint, Term::Elastic(Elastic::Compliance)) => matters && !self.solved.has_bending(*joint),
            Candidate::Term(..) | Candidate::Together(_) | Candidate::OfArm(_) | Candidate::DriftOfAll => matters,
        };
        ResidualTest { named: true, spoils_intervals: spoils, ..test }
    }
}

/// The same with zeros for columns that are but the rounding of numbers beside the longest: of a joint that is displaced along the axis before it,
/// nothing is seen, and any size would do.
pub fn without_rounding(mut columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let largest = columns.iter().map(|column| dot(column, column)).fold(0.0, f64::max);
    let short = columns.iter_mut().filter(|column| dot(column, column) < ROUNDING * ROUNDING * largest);
    short.for_each(|column| column.fill(0.0));
    columns
}

fn sum(columns: &[Vec<f64>]) -> Vec<f64> {
    let mut sum = vec![0.0; columns.first().map_or(0, Vec::len)];
    columns.iter().for_each(|column| sum.iter_mut().zip(column).for_each(|(sum, own)| *sum += own));
    sum
}
