//! One pose as a residual sees it.

use std::fmt::{self, Debug};

use gravcal_dynamics::{Chain, LinkFrame};
use gravcal_estimation::Number;
use gravcal_recording::Conditions;

use super::term::Sees;

/// One pose: where the arm is, how gravity acts, and what its row of the table says. Of joints that [`Sees`] does not name, coordinates
/// are NaN, and so are frames of links that they move.
#[derive(Clone, Copy)]
pub struct Scene<'a, N = f64> {
    chain: &'a Chain,
    coordinate: &'a [f64],
    position: &'a [f64],
    conditions: &'a Conditions,
    gravity: [f64; 3],
    /// Those that carry derivatives.
    lifted: Lifted<'a, N>,
}

/// What carries derivatives: gravity, and coordinates by their joint.
#[derive(Clone, Copy)]
pub(super) struct Lifted<'a, N> {
    pub gravity: Option<[N; 3]>,
    pub coordinates: &'a [(usize, N)],
}

/// Where a link is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place<N> {
    /// The rotation of its frame in the base's, row-major.
    pub rotation: [[N; 3]; 3],
    /// The origin of its frame in the base's, m.
    pub origin: [N; 3],
}

impl<'a> Scene<'a> {
    /// True coordinates (rad or m) and position readings of all joints, and gravity in the base's frame, m/s².
    pub fn new(
        chain: &'a Chain,
        (coordinate, position): (&'a [f64], &'a [f64]),
        gravity: [f64; 3],
        conditions: &'a Conditions,
    ) -> Scene<'a> {
        Scene { chain, coordinate, position, conditions, gravity, lifted: Lifted { gravity: None, coordinates: &[] } }
    }

    /// The same at other coordinates and another gravity.
    pub(super) fn moved<'b>(&self, coordinate: &'b [f64], gravity: [f64; 3]) -> Scene<'b>
    where
        'a: 'b,
    {
        Scene { coordinate, gravity, ..*self }
    }

    pub(super) fn lifted<'b, N>(&self, lifted: Lifted<'b, N>) -> Scene<'b, N>
    where
        'a: 'b,
    {
        let Scene { chain, coordinate, position, conditions, gravity, lifted: _ } = *self;
        Scene { chain, coordinate, position, conditions, gravity, lifted }
    }

    /// Where a link is, with its derivatives: for who has them by hand.
    pub fn link_frame(&self, link: usize) -> LinkFrame {
        self.chain.link_frame(link, self.coordinate)
    }

    /// Numbers of the coordinates that are seen, and of gravity.
    pub(super) fn plain(&self) -> (&'a [f64], [f64; 3]) {
        (self.coordinate, self.gravity)
    }
}

impl<N: Number> Scene<'_, N> {
    /// Gravity in the base's frame, m/s².
    pub fn gravity(&self) -> [N; 3] {
        self.lifted.gravity.unwrap_or_else(|| self.gravity.map(N::from))
    }

    /// The true coordinate of a joint, rad (m where it slides).
    pub fn coordinate(&self, joint: usize) -> N {
        let lifted = self.lifted.coordinates.iter().find(|(own, _)| *own == joint).map(|(_, number)| *number);
        lifted.unwrap_or_else(|| N::from(self.coordinate.get(joint).copied().unwrap_or(f64::NAN)))
    }

    /// Where a link is.
    pub fn frame(&self, link: usize) -> Place<N> {
        let LinkFrame { rotation, origin, by_coordinate } = self.chain.link_frame(link, self.coordinate);
        let mut place = Place { rotation: rotation.map(|row| row.map(N::from)), origin: origin.map(N::from) };
        for (joint, number) in self.lifted.coordinates {
            // Zero with its derivative: what is left of a first order in it.
            let change = *number - number.re();
            let (by_rotation, by_origin) = &by_coordinate[*joint];
            for (row, by) in place.rotation.iter_mut().zip(by_rotation) {
                row.iter_mut().zip(by).for_each(|(entry, by)| *entry += change * *by);
            }
            place.origin.iter_mut().zip(by_origin).for_each(|(entry, by)| *entry += change * *by);
        }
        place
    }

    /// Gravity in the frame of a link, m/s²: what an inclinometer there senses.
    pub fn gravity_on(&self, link: usize) -> [N; 3] {
        self.frame(link).seen(self.gravity())
    }

    /// The number of one of the model's columns, by its [place](super::Setting::column); NaN where the cell is empty.
    pub fn column(&self, place: usize) -> f64 {
        self.conditions.further.get(place).copied().unwrap_or(f64::NAN)
    }

    /// The position reading of a joint: rad, m or the sensor's own unit. No parameter moves it.
    pub fn position(&self, joint: usize) -> f64 {
        self.position.get(joint).copied().unwrap_or(f64::NAN)
    }

    /// When the pose was read, s since the session's first, how warm it was, and so on.
    pub fn conditions(&self) -> &Conditions {
        self.conditions
    }
}

impl<N: Number> Place<N> {
    /// A point of the link, m in its frame, in the base's frame.
    pub fn point(&self, point: [N; 3]) -> [N; 3] {
        let turned = self.direction(point);
        [0, 1, 2].map(|axis| self.origin[axis] + turned[axis])
    }

    /// A direction of the link's frame in the base's.
    pub fn direction(&self, direction: [N; 3]) -> [N; 3] {
        self.rotation.map(|row| row[0] * direction[0] + row[1] * direction[1] + row[2] * direction[2])
    }

    /// A direction of the base's frame as the link sees it.
    pub fn seen(&self, direction: [N; 3]) -> [N; 3] {
        let [a, b, c] = self.rotation;
        [0, 1, 2].map(|axis| a[axis] * direction[0] + b[axis] * direction[1] + c[axis] * direction[2])
    }
}

impl<N> Debug for Scene<'_, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Scene { coordinate, position, conditions, gravity, .. } = self;
        let mut fields = f.debug_struct("Scene");
        fields.field("coordinate", coordinate).field("position", position).field("gravity", gravity);
        fields.field("conditions", conditions).finish_non_exhaustive()
    }
}

/// Coordinates of which only those that are seen have a number.
pub(super) fn only_seen(sees: &Sees, coordinates: &mut [f64]) {
    for (joint, coordinate) in coordinates.iter_mut().enumerate() {
        if sees.joints.binary_search(&joint).is_err() {
            *coordinate = f64::NAN;
        }
    }
}
