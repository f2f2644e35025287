//! Which way orientations go and which sign a wrist sensor has, as far as its forces tell.
//!
//! ```text
//!     f = ∓ m v + b,   v = Rᵀ g  or  R g
//! ```
//!
//! Forces go with the direction of gravity in the sensor's frame as a straight line does, for the right one of both; the sign is that of
//! the line's slope. Where gravity points in the base's frame is assumed.

use gravcal_recording::Orientation;
use nalgebra::Vector3;

/// Share of the forces' scatter that gravity makes at least, if it is gravity that they show, as a correlation.
const LEAST: f64 = 0.8;

/// What the forces say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sense {
    /// Whether orientations turn vectors of the base into the body's frame.
    pub body_from_base: bool,
    /// Whether the sensor reads what the tool exerts on it.
    pub reversed: bool,
}

/// Listens to orientations and forces.
#[derive(Debug, Default)]
pub(super) struct Forces {
    base_from_body: Scatter,
    body_from_base: Scatter,
}

impl Forces {
    /// Takes a pose: how it is turned, and the force; what is no number is passed over.
    pub fn take(&mut self, turned: &Orientation, force: [f64; 3]) {
        if !force.iter().all(|part| part.is_finite()) {
            return;
        }
        // Gravity points down the third axis: the third row of what turns it back, the third column of what turns it.
        let force = Vector3::from(force);
        self.base_from_body.take(-Vector3::from(turned[2]), force);
        self.body_from_base.take(-Vector3::from(turned.map(|row| row[2])), force);
    }

    pub fn sense(&self) -> Option<Sense> {
        let correlations = [&self.base_from_body, &self.body_from_base].map(Scatter::correlation);
        let body_from_base = correlations[1].abs() > correlations[0].abs();
        let correlation = correlations[usize::from(body_from_base)];
        (correlation.abs() > LEAST).then_some(Sense { body_from_base, reversed: correlation > 0.0 })
    }
}

/// Sums over poses of two vectors each.
#[derive(Debug, Default)]
struct Scatter {
    poses: f64,
    means: [Vector3<f64>; 2],
    /// Sums of squares of each, and of their products, about the means.
    squares: [f64; 2],
    products: f64,
}

impl Scatter {
    fn take(&mut self, gravity: Vector3<f64>, force: Vector3<f64>) {
        self.poses += 1.0;
        let [of_gravity, of_force] = [gravity - self.means[0], force - self.means[1]];
        self.means[0] += of_gravity / self.poses;
        self.means[1] += of_force / self.poses;
        self.squares[0] += of_gravity.dot(&(gravity - self.means[0]));
        self.squares[1] += of_force.dot(&(force - self.means[1]));
        self.products += of_gravity.dot(&(force - self.means[1]));
    }

    /// From -1 to 1; 0 where one of both does not change.
    fn correlation(&self) -> f64 {
        let size = (self.squares[0] * self.squares[1]).sqrt();
        if size > 0.0 { self.products / size } else { 0.0 }
    }
}
