//! The inertia of all links, as numbers in a row.

use super::Chain;
use super::error::ChainError;
use crate::body_inertia::BodyInertia;

impl Chain {
    /// The same chain with these inertia tensors of its links, `[I_xx, I_xy, I_yy, I_xz, I_yz, I_zz]` each, about the origin of the
    /// link's frame and along its axes, kg·m². A chain from a URDF has those that it states; any other has none.
    ///
    /// # Panics
    ///
    /// When there is not one for each link.
    #[must_use]
    pub fn with_tensors(self, tensors: Vec<[f64; 6]>) -> Chain {
        assert_eq!(tensors.len(), self.link_count(), "one tensor for each link");
        Chain { tensors, ..self }
    }

    /// Mass, first moment and inertia tensor of every link as they are assumed, ten numbers each in the order of
    /// [`BodyInertia::parameters`], zero where nothing is known.
    ///
    /// # Errors
    ///
    /// [`ChainError::NotFinite`]: a URDF may state a tensor that is none, and gravity does not ask for it.
    pub fn inertial_parameters(&self) -> Result<Vec<f64>, ChainError> {
        let mut parameters = Vec::new();
        for (link, &tensor) in self.links().iter().zip(&self.tensors) {
            if tensor.iter().any(|entry| !entry.is_finite()) {
                return Err(ChainError::NotFinite { what: format!("inertia tensor of link `{}`", link.name) });
            }
            let own = link.inertia.unwrap_or_default();
            let body = BodyInertia { mass: own.mass, first_moment: own.first_moment, tensor };
            parameters.extend(body.parameters());
        }
        Ok(parameters)
    }
}
