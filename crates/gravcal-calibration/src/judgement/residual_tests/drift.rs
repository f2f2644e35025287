//! What seldom happens to one sensor alone: together, and beside one that is named.
//!
//! An arm that warms up lets all zeros drift, each too little to be named. So the joints' own tests of a trend, p-values `p_j`, are combined,
//!
//! ```text
//!     −2 Σ ln p_j  ~  χ²(2k)       of k joints
//! ```
//!
//! (Fisher, *Statistical Methods for Research Workers*, 4th edition, 1932, section 21.1): each knows how well its joint's noise is known, which
//! an F test of all trends does not. And where a zero drifts, by a trend that is named, others may: the intervals of each other channel allow for a trend
//! as large as `√(a² + σ_a²)`, with the trend `a` that its own residuals show, and its standard deviation. So they do where a gain drifts, or a gain or
//! the zero of a position sensor is another in another table: what warms one sensor warms others, who homes one joint anew homes others, and
//! sensors of one make have hysteresis, or creep, alike.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::candidate::{Candidate, Tested};
use super::columns::ALL_JOINTS;
use super::rows::MANY;
use super::terms::{Friction, PositionZero, SensorGain, SensorZero, Term};
use crate::result::ResidualTest;

/// A zero that drifts steadily.
pub const DRIFT: Term = Term::Zero(SensorZero::Trend);

/// The joint, of so many, of whose zero a candidate says that it drifts steadily.
pub fn drift_of_joint(candidate: &Candidate, joints: usize) -> Option<usize> {
    match candidate {
        Candidate::Term(channel, DRIFT) => Some(*channel).filter(|joint| *joint < joints),
        _ => None,
    }
}

/// What other channels may have where a candidate is so, and the channels in which it is known.
pub fn not_alone(candidate: &Candidate, joints: usize) -> Option<(Term, Vec<usize>)> {
    match *candidate {
        Candidate::Term(channel, term) => others_may_have(term).map(|other| (other, vec![channel])),
        Candidate::Together(term) => others_may_have(term).map(|other| (other, (0..joints).collect())),
        Candidate::DriftOfAll => Some((DRIFT, (0..joints).collect())),
        Candidate::OfArm(_) | Candidate::Neighbours(_) => None,
    }
}

/// What other channels may have where one has this.
fn others_may_have(term: Term) -> Option<Term> {
    match term {
        Term::Zero(SensorZero::Trend | SensorZero::TrendInTables) => Some(DRIFT),
        Term::Zero(SensorZero::Curve | SensorZero::Settling)
        | Term::Gain(SensorGain::InTables | SensorGain::Trend)
        | Term::Friction(Friction::Trend)
        | Term::EarlierLoad(_)
        | Term::PositionZero(PositionZero::InTables) => Some(term),
        _ => None,
    }
}

/// Whether the zeros of all joints drift, of their own tests; nothing of fewer than two.
pub fn drift_of_all(found: &[Tested], joints: usize) -> Option<Tested> {
    let own = || found.iter().filter_map(move |tested| Some((drift_of_joint(&tested.candidate, joints)?, tested)));
    if own().count() < 2 {
        return None;
    }
    let (sum, freedom, p_value) = combined(own().map(|(_, tested)| tested.test.p_value))?;
    let (_, largest) = own().max_by(|(_, a), (_, b)| a.test.size.abs().total_cmp(&b.test.size.abs()))?;
    let mut coefficients = vec![0.0; joints];
    own().for_each(|(joint, tested)| coefficients[joint] = with_errors(tested)[0]);
    let test = ResidualTest {
        channel: ALL_JOINTS.into(),
        statistic: sum / freedom,
        degrees_of_freedom: [freedom, MANY],
        blocks: None,
        p_value,
        corrected_p_value: p_value,
        in_noise: own().map(|(_, tested)| tested.test.in_noise).fold(0.0, f64::max),
        ..largest.test.clone()
    };
    let gain = own().map(|(_, tested)| tested.gain).sum();
    Some(Tested {
        test,
        candidate: Candidate::DriftOfAll,
        gain,
        p_of_noise: p_value,
        is_confirmed: false,
        coefficients,
    })
}

/// Fisher's statistic, its degrees of freedom and its p-value.
pub fn combined(p_values: impl Iterator<Item = f64> + Clone) -> Option<(f64, f64, f64)> {
    let freedom = 2.0 * p_values.clone().count() as f64;
    let sum = p_values.map(|p| -2.0 * p.max(f64::MIN_POSITIVE).ln()).sum::<f64>();
    Some((sum, freedom, ChiSquared::new(freedom).ok()?.sf(sum)))
}

/// `√(a² + σ_a²)` with the sign of `a`, of each coefficient; the statistic of a single one is `(a/σ_a)²`, of several the mean of such squares.
pub fn with_errors(tested: &Tested) -> Vec<f64> {
    let statistic = tested.test.statistic;
    let grows = if statistic > 0.0 { (1.0 + 1.0 / statistic).sqrt() } else { 0.0 };
    tested.coefficients.iter().map(|coefficient| coefficient * grows).collect()
}
