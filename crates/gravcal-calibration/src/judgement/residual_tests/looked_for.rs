//! What is looked for in a solution's residuals, and where.

use gravcal_estimation::statistics::ResidualMaker;

use super::candidate::Candidate;
use super::rows::Rows;
use super::search::Search;
use super::terms::{Elastic, Term};
use crate::joint::CURVES;

/// Residuals below this share of the readings' range are those of arithmetic.
const ROUNDING: f64 = 1e-7;

impl Search<'_> {
    /// Every term of every channel whose residuals scatter, what all joints may do together, and what is of none.
    pub fn candidates(&self, maker: &ResidualMaker, rows: &Rows) -> Vec<Candidate> {
        let scattered: Vec<usize> =
            (0..rows.channels()).filter(|channel| self.scatters(maker, rows, *channel)).collect();
        let own = |channel: &usize| {
            let terms = Term::of_channel(&self.columns, *channel).into_iter();
            terms
                .map(|term| Candidate::Term(*channel, term))
                .chain([Candidate::Neighbours(*channel)])
                .collect::<Vec<_>>()
        };
        let of_position = |joint: usize| {
            let terms = Term::of_coordinate(&self.columns, joint).into_iter();
            terms.map(move |term| Candidate::Term(joint, term)).collect::<Vec<_>>()
        };
        let positions = if scattered.is_empty() { 0 } else { self.session.joints.len() };
        let mut candidates: Vec<Candidate> =
            scattered.iter().flat_map(own).chain((0..positions).flat_map(of_position)).collect();
        candidates.extend(self.together(&candidates));
        if !scattered.is_empty() {
            candidates.extend(Term::of_arm(&self.columns).into_iter().map(Candidate::OfArm));
        }
        candidates
    }

    /// What two joints or more may have, and have alike.
    fn together(&self, candidates: &[Candidate]) -> Vec<Candidate> {
        let alike = |candidate: &Candidate| match *candidate {
            // Where it is in the fit already, nothing needs to be looked for in what the fit leaves.
            Candidate::Term(joint, Term::Elastic(Elastic::Compliance)) if self.solved.has_bending(joint) => None,
            Candidate::Term(channel, _) if !self.columns.is_joint(channel) => None,
            Candidate::Term(_, term) => Some(term).filter(|term| term.lacked().is_alike_in_all_joints(&self.columns)),
            _ => None,
        };
        let (mut seen, mut together) = (Vec::new(), Vec::new());
        for term in candidates.iter().filter_map(alike) {
            if seen.contains(&term) && !together.contains(&Candidate::Together(term)) {
                together.push(Candidate::Together(term));
            }
            seen.push(term);
        }
        together
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
