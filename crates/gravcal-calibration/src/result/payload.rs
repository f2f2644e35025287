//! Loads of unknown mass.

use serde::Serialize;

/// What was found of a load of unknown mass. What is undetermined is `null`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PayloadResult {
    /// Name of the load.
    pub load: String,
    /// Name of the link that carries it, in whose frame all is told.
    pub link: String,
    /// Mass, kg.
    pub mass_kg: Option<PayloadNumber>,
    /// Centre of mass, m.
    pub center_of_mass_m: Option<[PayloadNumber; 3]>,
    /// `[I_xx, I_xy, I_yy, I_xz, I_yz, I_zz]` about the centre of mass, along the axes of the link's frame, kg·m².
    pub tensor_kg_m2: Option<[PayloadNumber; 6]>,
    /// What is not determined of it, why, and what to do; `null` where all is determined.
    pub undetermined: Option<String>,
}

/// A number of a payload.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PayloadNumber {
    /// In the unit of the field.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
}
