//! Inertias that rigid bodies can have.

use serde::Serialize;

/// A rigid body on a link, in the frame of the link.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LinkInertiaResult {
    /// Name of the link.
    pub link: String,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass, m.
    pub center_of_mass_m: [f64; 3],
    /// `[I_xx, I_xy, I_yy, I_xz, I_yz, I_zz]` about the centre of mass, along the axes of the link's frame, kg·m².
    pub tensor_kg_m2: [f64; 6],
}
