//! What a solution is worth: which parameters are determined, how well, and what the residuals say.

mod concerns;
mod cure;
mod determined;
mod far_off;
mod fit;
mod friction;
mod gains_of_instruments;
mod gravity;
mod moments;
mod outliers;
mod positions;
mod remarks;
mod residual_tests;
mod rotors;
mod tools;
mod torque_parts;

pub(crate) use concerns::concerns;
pub(crate) use cure::Situation;
pub(crate) use determined::{Asked, Judgement, asked, limits_of_use};
pub use far_off::doubts_of_results;
pub(crate) use far_off::{far_off, off_together};
pub(crate) use fit::{explained, fit, held_out};
pub(crate) use friction::driving_friction_notes;
pub(crate) use gravity::gravity_result;
pub(crate) use moments::{DeterminedMoment, determined_moments};
pub(crate) use outliers::{outlier_note, outliers};
pub(crate) use positions::{deflections, position_errors};
pub(crate) use remarks::{held, loss, weak_combinations, weak_note};
pub(crate) use residual_tests::{ResidualTests, TestsWanted, in_words, residual_tests, too_large};
pub(crate) use rotors::negative_rotor_notes;
pub(crate) use tools::tool_notes;
pub(crate) use torque_parts::keep_determined;
