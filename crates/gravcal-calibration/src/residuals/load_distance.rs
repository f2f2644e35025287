//! Two placements of a load a known distance apart.
//!
//! ```text
//!     ‖r¹ − r²‖ = d        (d = 2 l in the paper, section 2.3)
//! ```

use gravcal_estimation::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};

/// Distance in m between two placements in the frame of one link.
#[derive(Clone, Debug)]
pub struct LoadDistance {
    placements: [BlockId; 2],
    distance: f64,
}

impl LoadDistance {
    /// `distance`: d, m.
    pub fn new(placements: [BlockId; 2], distance: f64) -> Self {
        LoadDistance { placements, distance }
    }
}

impl Residual for LoadDistance {
    fn blocks(&self) -> &[BlockId] {
        &self.placements
    }

    fn len(&self) -> usize {
        1
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let difference: [f64; 3] = std::array::from_fn(|i| x.block(0)[i] - x.block(1)[i]);
        let length = difference.iter().map(|c| c * c).sum::<f64>().sqrt();
        if length == 0.0 {
            return Err(EvaluateError("two placements of known distance coincide".into()));
        }
        residual[0] = length - self.distance;
        if let Some(mut rows) = jacobian {
            for (i, component) in difference.iter().enumerate() {
                rows.row(0)[i] = component / length;
                rows.row(0)[3 + i] = -component / length;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residuals::testing::{check_at_random_points, ids};

    #[test]
    fn derivatives() {
        let ids = ids(&[3, 3]);
        let residual = LoadDistance::new([ids[0], ids[1]], 0.402);
        check_at_random_points(&residual, &[3, 3], &[5.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    }
}
