//! Inertias that rigid bodies can have.

use serde::Serialize;

use super::fit::HeldOut;

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

/// The links' inertias for simulations and controllers: those of rigid bodies, nearest to what the robot's file assumes and to what the
/// readings say. Sensors and gravity are those of the estimate without it.
#[derive(Clone, Debug, Serialize)]
pub struct ConsistentModel {
    /// Every link that a joint moves, without loads.
    pub links: Vec<LinkInertiaResult>,
    /// How well each link of the robot's file was taken to be known, relative to it.
    pub relative_std: Vec<f64>,
    /// Whether the arm moved; if not, tensors are those of the robot's file.
    pub tensors_from_readings: bool,
    /// By how much the readings were taken to say less than their noise alone makes them: told variances over those of the noise.
    pub variance_inflation: f64,
    /// By how much worse the readings are explained than without it: growth of χ², in told standard deviations.
    pub chi_squared_growth: f64,
    /// How well it predicts the tables of `[[validation]]`, with the sensors and the gravity that go best with it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held_out: Option<HeldOut>,
}
