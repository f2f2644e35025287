//! What is looked for in a solution's residuals, and where.

use gravcal_estimation::statistics::ResidualMaker;

use super::candidate::Candidate;
use super::columns::Term;
use super::rows::Rows;
use super::search::Search;
use crate::joint::CURVES;

/// Residuals below this share of the readings' range are those of arithmetic.
const ROUNDING: f64 = 1e-7;

impl Search<'_> {
    /// Every term of every channel whose residuals scatter, what all joints may do together, and what is of none.
    pub fn candidates(&self, maker: &ResidualMaker, rows: &Rows) -> Vec<Candidate> {
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
        let mut of_all =
            vec![Term::Compliance, Term::TorqueLag, Term::TorqueFilter, Term::TorqueGainTrend, Term::FrictionTrend];
        if self.columns.tables_of_all().len() == 2 {
            of_all.push(Term::TorqueGains);
        }
        for term in of_all {
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
        if !scattered.is_empty() {
            candidates.extend(self.columns.terms_of_arm().into_iter().map(Candidate::OfArm));
        }
        candidates
    }

    /// Whether a channel's residuals are more than the rounding of numbers.
    fn scatters(&self, maker: &ResidualMaker, rows: &Rows, channel: usize) -> bool {
        let own = rows.of_channel(channel);
        let rows = &self.solved.built.rows;
        let square =
            |row: &usize| (maker.residuals()[*row] * self.solved.readings().std(self.session, rows[*row])).powi(2);
        let rms = (own.iter().map(square).sum::<f64>() / own.len().max(1) as f64).sqrt();
        let largest = own.iter().filter_map(|row| self.session.reading(rows[*row]));
        let least = if self.session.has_windows() { CURVES } else { ROUNDING };
        rms > least * largest.map(|reading| reading.value.abs()).fold(0.0, f64::max)
    }
}
