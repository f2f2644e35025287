//! All torque readings of one pose of a sweep, by the moments of what hangs beyond each joint.
//!
//! ```text
//!     y_i = k_i τ_i + b_i,     τ_i = z_i · (g × M_i),     M_i = h_i + R_{i,i+1}(θ) M_{i+1}  (+ m_L R_i(θ) r_L)
//! ```
//!
//! No length enters. While joint j sweeps and the others stand, what hangs beyond a joint is rigid but for what hangs
//! beyond j, so that lengths and links only add to the moment `h_i` of that posture:
//!
//! - `i = j`: `M_j` stands still in the link, and `y_j = k_j (p (z × g)_x + q (z × g)_y) + b_j`, a sinusoid of θ_j
//!   (paper, eqs. (4), (7));
//! - `i < j`: a constant part `h_i` and a rotating one `R_ij(θ_j) M_j` (paper, eqs. (19)–(21));
//! - `i > j`: `M_i` stands still in the link, and gravity's direction changes with θ_j.
//!
//! `h_i = p u_i + q v_i` is across the axis: what lies along it the joint does not feel, and the joints before it feel as
//! part of their own `h`. A prismatic joint has a mass in its place, `f_i = −(g · z_i) m_i⁺`. A load is told by its
//! placement less another one's, from which `h` is counted: the difference of two placements is `m_L (r² − r¹)`, turned
//! into place (paper, eq. (18)).
//!
//! This is the pose torque of the chain without lengths, with moments across the axes.

use std::ops::Range;
use std::sync::Arc;

use gravcal_dynamics::{Joint, JointKind};
use gravcal_estimation::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};
use nalgebra::{Matrix3, Vector3};

use super::pose_torque::{PoseTorque, PoseTorqueModel, joined};

/// What stands for one link in a sweep: each unknown as `[m, h_x, h_y, h_z]` in the link's frame.
///
/// A revolute joint's link has a first moment along two unit vectors across the axis (kg·m), a prismatic one's a mass (kg).
pub fn lumped_directions(joint: &Joint) -> Vec<[f64; 4]> {
    if joint.kind == JointKind::Prismatic {
        return vec![[1.0, 0.0, 0.0, 0.0]];
    }
    let after = Matrix3::from_fn(|row, column| joint.after.rotation()[row][column]);
    let axis = after.tr_mul(&Vector3::from(joint.axis));
    let first = Vector3::ith(axis.iamin(), 1.0);
    let first = (first - axis * axis.dot(&first)).normalize();
    [first, axis.cross(&first)].map(|v| [0.0, v.x, v.y, v.z]).into()
}

/// What all poses with the same moments and the same load share.
#[derive(Debug)]
pub struct SweepTorqueModel {
    pose: Arc<PoseTorqueModel>,
    /// Start of each of the inner residual's blocks among its stored columns, and their number.
    starts: Vec<usize>,
    /// Each stored column here as what it adds to stored columns of the inner residual.
    columns: Vec<Vec<(usize, f64)>>,
    /// Stored columns that each joint's torque can touch.
    patterns: Vec<Vec<Range<usize>>>,
}

impl SweepTorqueModel {
    /// `pose`: the model of the chain without lengths, its inertia blocks two numbers for a link that turns
    /// (along two unit vectors across its axis, kg·m), one for a link that slides (kg).
    pub fn new(pose: Arc<PoseTorqueModel>) -> Self {
        let inertia = pose.inertia_blocks();
        let mut starts = vec![0];
        let mut columns: Vec<Vec<(usize, f64)>> = Vec::new();
        for block in 0..pose.blocks.len() {
            let start = starts[block];
            let length = pose.stored_length(block);
            match inertia.clone().position(|other| other == block) {
                None => columns.extend((start..start + length).map(|column| vec![(column, 1.0)])),
                Some(link) => columns.extend(lumped_directions(&pose.chain.movers()[link]).iter().map(|direction| {
                    let terms = direction.iter().enumerate().filter(|(_, share)| **share != 0.0);
                    terms.map(|(component, share)| (start + component, *share)).collect()
                })),
            }
            starts.push(start + length);
        }
        let patterns = pose.patterns.iter().map(|inner| pattern(&columns, inner)).collect();
        SweepTorqueModel { pose, starts, columns, patterns }
    }

    /// The model of the chain without lengths.
    pub fn pose(&self) -> &Arc<PoseTorqueModel> {
        &self.pose
    }
}

/// The columns that reach into the inner pattern.
fn pattern(columns: &[Vec<(usize, f64)>], inner: &[Range<usize>]) -> Vec<Range<usize>> {
    let touched = |terms: &[(usize, f64)]| terms.iter().any(|(c, _)| inner.iter().any(|range| range.contains(c)));
    let own = columns.iter().enumerate().filter(|(_, terms)| touched(terms));
    joined(own.map(|(column, _)| column..column + 1))
}

/// The torque readings of one pose of a sweep.
#[derive(Clone, Debug)]
pub struct SweepTorque {
    model: Arc<SweepTorqueModel>,
    inner: PoseTorque,
}

impl SweepTorque {
    /// `inner`: the pose's readings as those of `model.pose()`.
    pub fn new(model: Arc<SweepTorqueModel>, inner: PoseTorque) -> Self {
        SweepTorque { model, inner }
    }

    fn width(&self) -> usize {
        self.model.starts[self.model.starts.len() - 1]
    }
}

impl Residual for SweepTorque {
    fn blocks(&self) -> &[BlockId] {
        self.inner.blocks()
    }

    fn len(&self) -> usize {
        self.inner.len()
    }

    fn row_pattern(&self, row: usize) -> Option<&[Range<usize>]> {
        Some(&self.model.patterns[self.inner.joint_of_row(row)])
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let width = self.width();
        let mut inner_x = vec![0.0; width];
        for (value, terms) in x.as_slice().iter().zip(&self.model.columns) {
            terms.iter().for_each(|(column, share)| inner_x[*column] += share * value);
        }
        let inner_x = LocalValues::new(&inner_x, &self.model.starts);
        let Some(mut rows) = jacobian else {
            return self.inner.evaluate(inner_x, residual, None);
        };
        let mut inner = vec![0.0; self.len() * width];
        self.inner.evaluate(inner_x, residual, Some(RowsMut::new(&mut inner, width)))?;
        for (index, inner) in inner.chunks_exact(width).enumerate() {
            for (entry, terms) in rows.row(index).iter_mut().zip(&self.model.columns) {
                *entry = terms.iter().map(|(column, share)| share * inner[*column]).sum();
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::pose_torque::tests::{READ_POSITIONS, model_of, some_chain};
    use super::*;
    use crate::residuals::testing::{check_at_random_points, ids};
    use crate::sensors::SensorTerms;

    /// Turning, sliding and turning joint with a load on the second link; lengths of the blocks.
    fn loaded() -> (SweepTorque, Vec<usize>) {
        let mut lengths = vec![3];
        lengths.extend([1; 12]);
        lengths.extend([2, 1, 2, 3, 3, 1]);
        let model = Arc::new(model_of(some_chain().without_lengths(), &SensorTerms::default(), &ids(&lengths)));
        let model = Arc::new(SweepTorqueModel::new(model));
        let readings = vec![(0, 2.0), (1, 1.0), (2, -1.0)];
        let inner = PoseTorque::new(Arc::clone(model.pose()), READ_POSITIONS.to_vec(), readings);
        (SweepTorque::new(model, inner), lengths)
    }

    #[test]
    fn derivatives() {
        let (residual, lengths) = loaded();
        check_at_random_points(&residual, &lengths, &vec![0.5; lengths.iter().sum()]);
    }

    #[test]
    fn rows_touch_only_the_columns_of_their_pattern() {
        let (residual, lengths) = loaded();
        let width: usize = lengths.iter().sum();
        assert_eq!(width, 27);
        assert_eq!(residual.row_pattern(0).unwrap(), [0..4, 6..7, 9..27]);
        assert_eq!(residual.row_pattern(1).unwrap(), [0..3, 4..5, 7..8, 9..15, 17..27]);
        assert_eq!(residual.row_pattern(2).unwrap(), [0..3, 5..6, 8..15, 18..27]);
        let offsets: Vec<usize> = (0..=lengths.len()).map(|blocks| lengths[..blocks].iter().sum()).collect();
        let x: Vec<f64> = (0..width).map(|k| 1.0 + (k as f64).sin()).collect();
        let (mut values, mut jacobian) = ([0.0; 3], vec![0.0; 3 * width]);
        let rows = RowsMut::new(&mut jacobian, width);
        residual.evaluate(LocalValues::new(&x, &offsets), &mut values, Some(rows)).unwrap();
        for (row, entries) in jacobian.chunks(width).enumerate() {
            let pattern = residual.row_pattern(row).unwrap();
            let outside = |column: &usize| !pattern.iter().any(|range| range.contains(column));
            assert!((0..width).filter(outside).all(|column| entries[column] == 0.0));
        }
    }
}
