//! Where the values of a block live, and how a step moves along it: an open set, to which any crate may add.

mod check;
mod definition;
mod euclidean;
mod rotation;
mod sphere;

pub use check::{ManifoldMismatch, check_manifold};
pub use definition::Manifold;
pub(crate) use euclidean::Euclidean;
pub use rotation::Rotation;
pub use sphere::Sphere;
