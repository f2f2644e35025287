//! Residuals that tie sensors to robots: one file each, prediction minus measurement in the unit of the reading.
//!
//! To add one: a file here with a type that implements [`Residual`](gravcal_estimation::Residual), and a test
//! that calls [`check_derivatives`](gravcal_estimation::check_derivatives) at random points.

mod displaced;
mod gravity_norm;
mod gravity_sweep;
mod instrument;
mod linear_prior;
mod load_difference;
mod load_distance;
mod modelled;
mod pose_torque;
mod prior;
mod shifted;
mod sinusoid;
mod stacked;
mod sweep_torque;

pub use displaced::Displaced;
pub use gravity_norm::GravityNorm;
pub use gravity_sweep::{GravitySweep, GravitySweepBlocks};
pub use instrument::{
    AuxiliarySensorModel, AuxiliarySensorReading, GainEntry, PositionTerms, Sensed, SensedQuantity, SpecificForce,
    Wrench,
};
pub use linear_prior::{KnownCombination, LinearPrior};
pub use load_difference::{LoadDifference, LoadDifferenceBlocks, MeasuredDifference};
pub use load_distance::LoadDistance;
pub use modelled::{ModelledResidual, ModelledScene};
pub use pose_torque::{
    CarriedLoad, LoadMass, MotionTorque, MotionTorqueModel, PoseTorque, PoseTorqueBlocks, PoseTorqueModel,
};
pub use prior::Prior;
pub use shifted::{Shift, Shifted};
pub use sinusoid::{Sinusoid, SinusoidBlocks};
pub use stacked::{Stacked, names_a_block_twice};
pub use sweep_torque::{SweepTorque, SweepTorqueModel, lumped_directions};

#[cfg(test)]
pub(crate) mod testing {
    use gravcal_estimation::{BlockId, Residual, check_derivatives};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Ids of blocks that exist only for a derivative check.
    pub fn ids(lengths: &[usize]) -> Vec<BlockId> {
        let mut builder = gravcal_estimation::ProblemBuilder::new();
        lengths
            .iter()
            .enumerate()
            .map(|(i, n)| {
                let names: Vec<String> = (0..*n).map(|c| c.to_string()).collect();
                let names: Vec<&str> = names.iter().map(String::as_str).collect();
                let block = gravcal_estimation::Block::vector(format!("b{i}"), "", &names);
                builder.add_block(block, &vec![0.0; *n])
            })
            .collect()
    }

    /// Holds the Jacobian against differences at 20 random points within ±2 of `around`.
    pub fn check_at_random_points(residual: &dyn Residual, lengths: &[usize], around: &[f64]) {
        let mut random = Pcg64::seed_from_u64(7);
        for _ in 0..20 {
            let x: Vec<f64> = around.iter().map(|c| c + random.random_range(-2.0..2.0)).collect();
            check_derivatives(residual, lengths, &x, 1e-8).unwrap();
        }
    }
}
