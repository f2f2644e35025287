//! What is looked for, and which of it is named next: p-values corrected for their number.

use super::terms::{Recorder, Stated, Surroundings, Term};
use crate::result::ResidualTest;

/// Probability, corrected for the number of tests, below which something is named.
pub(crate) const SIGNIFICANCE: f64 = 0.01;

/// A parameter of a sensor is named before the robot's lengths and axes where it explains so large a share of what they do.
const AS_MUCH: f64 = 0.8;

/// Share of what a sensor keeps of the pose before in the probability of naming anything: it shows by far where it is, and friction that is left at rest, as
/// chance has it, is its like.
const SELDOM: f64 = 0.1;

/// A test with what it is of.
pub struct Tested {
    pub test: ResidualTest,
    pub candidate: Candidate,
    pub gain: f64,
    /// The p-value if noise were the only error: it tells which of several is named first.
    pub p_of_noise: f64,
    /// Whether it stands where noise is of first order, or grows with the term: see [`super::first_order`] and [`super::uneven_scatter`].
    pub is_confirmed: bool,
    /// Of each column of the term.
    pub coefficients: Vec<f64>,
}

/// What is looked for, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Candidate {
    Term(usize, Term),
    Neighbours(usize),
    /// With one coefficient for all joints.
    Together(Term),
    /// Of no single channel.
    OfArm(Term),
    /// That the zeros of all joints drift, each by itself.
    DriftOfAll,
}

/// The place of what is named next: of all that tells, what is least likely noise, for its weight. That all zeros drift comes last: one that drifts
/// much is to be named by itself.
pub fn next(found: &[Tested]) -> usize {
    let weight = weights(found);
    let tells =
        |tested: &Tested| tested.test.corrected_p_value < SIGNIFICANCE && tested.candidate != Candidate::DriftOfAll;
    let weighted = |tested: &Tested| tested.p_of_noise / weight(tested);
    let telling = found.iter().enumerate().filter(|(_, tested)| tells(tested));
    let first = telling.min_by(|(_, a), (_, b)| weighted(a).total_cmp(&weighted(b)).then(b.gain.total_cmp(&a.gain)));
    let Some((place, first)) = first else { return 0 };
    let instead = match &first.candidate {
        // A zero that is stated wrongly turns a link, which is a joint that sits elsewhere and is tilted: one wrong number is likelier than several.
        Candidate::OfArm(term) if term.is_of_description() => {
            telling_most(found, |candidate| matches!(candidate, Candidate::Term(_, Term::Stated(Stated::Sensor(_)))))
                .filter(|(_, other)| other.gain > AS_MUCH * first.gain)
        }
        // One number is less likely chance than three; but wrong lengths are likelier than a wrong clock, where they explain more.
        Candidate::OfArm(Term::Recorder(Recorder::ClockRate) | Term::Surroundings(Surroundings::BaseGivesWay)) => {
            telling_most(found, |candidate| matches!(candidate, Candidate::OfArm(term) if term.is_of_description()))
                .filter(|(_, other)| other.gain > first.gain)
        }
        _ => None,
    };
    instead.map_or(place, |(place, _)| place)
}

/// Of some candidates that tell, the one that explains most.
fn telling_most(found: &[Tested], is_one: impl Fn(&Candidate) -> bool) -> Option<(usize, &Tested)> {
    let tells = |tested: &Tested| tested.test.corrected_p_value < SIGNIFICANCE && is_one(&tested.candidate);
    let telling = found.iter().enumerate().filter(|(_, tested)| tells(tested));
    telling.max_by(|(_, a), (_, b)| a.gain.total_cmp(&b.gain))
}

/// The share of each in the probability of naming anything: those of all joints count as much as all others together, and what hardly any sensor has a tenth.
/// Of what the robot's description says of a joint, each is asked by itself.
pub fn weights(found: &[Tested]) -> impl Fn(&Tested) -> f64 + use<> {
    let of_all_joints = |tested: &Tested| match &tested.candidate {
        Candidate::Together(_) | Candidate::DriftOfAll => true,
        Candidate::OfArm(term) => !term.is_of_description(),
        Candidate::Term(..) | Candidate::Neighbours(_) => false,
    };
    let own = |tested: &Tested| match &tested.candidate {
        Candidate::Term(_, Term::EarlierLoad(_)) => SELDOM,
        _ => 1.0,
    };
    let together = found.iter().filter(|tested| of_all_joints(tested)).count();
    let others: f64 = found.iter().filter(|tested| !of_all_joints(tested)).map(own).sum();
    let share = if others > 0.0 { others / together.max(1) as f64 } else { 1.0 };
    move |tested| if of_all_joints(tested) { share } else { own(tested) }
}

/// Holm's method with weights: a p-value counts as often as its weight is contained in those of all that are no smaller, and no less than a
/// smaller one. (Holm 1979, section 4.) With equal weights the k-th smallest of m counts m − k + 1 times.
pub fn correct(found: &mut [Tested], least: f64) {
    let weights: Vec<f64> = found.iter().map(weights(found)).collect();
    let (mut rest, mut least) = (weights.iter().sum::<f64>(), least);
    for (tested, weight) in found.iter_mut().zip(weights) {
        least = least.max((rest / weight * tested.test.p_value).min(1.0));
        tested.test.corrected_p_value = least;
        rest -= weight;
    }
}
