//! The arm's shape, as far as its kinematics tell it: straight pieces from joint to joint.

use gravcal_dynamics::{Chain, JointKind, Transform};
use nalgebra::{UnitQuaternion, Vector3};
use re_sdk_types::archetypes::Capsules3D;
use re_sdk_types::components::{Color, FillMode};
use re_sdk_types::datatypes::Quaternion;

/// From one point to another, m.
pub type Piece = [[f64; 3]; 2];

/// Thickness of links, and of the housings of joints, as a share of the arm's size.
const LINK_RADIUS: f64 = 0.018;
const HOUSING_RADIUS: f64 = 0.03;
/// Half the length of a housing, as a share of the arm's size.
const HOUSING_HALF: f64 = 0.06;
/// Size of an arm whose file gives no lengths, and that carries no load, m.
const SOME_SIZE: f64 = 0.5;

/// Pieces in the frame of each link.
pub struct Shape {
    /// From the base to the joints that hang on it.
    pub base: Vec<Piece>,
    /// Of each link.
    pub links: Vec<Vec<Piece>>,
    /// Sum of the links' lengths, m.
    pub reach: f64,
    /// The same with what is attached: what is drawn has a size in proportion to it.
    pub size: f64,
}

impl Shape {
    /// Of a chain; `further`: distances of what is attached from the frames of links, m.
    pub fn of(chain: &Chain, further: impl Iterator<Item = f64>) -> Shape {
        let on = |link: Option<usize>| {
            let children = (0..chain.link_count()).filter(move |child| chain.parent(*child) == link);
            children.map(|child| chain.movers()[child].before.translation())
        };
        let pieces = |link: usize| {
            let start = chain.movers()[link].after.inverse().translation();
            let ends = on(Some(link)).map(|end| [[0.0; 3], end]);
            [[start, [0.0; 3]]].into_iter().chain(ends).filter(|piece| length(piece) > 0.0).collect::<Vec<_>>()
        };
        let base: Vec<Piece> = on(None).map(|end| [[0.0; 3], end]).filter(|piece| length(piece) > 0.0).collect();
        let links: Vec<Vec<Piece>> = (0..chain.link_count()).map(pieces).collect();
        let longest = |pieces: &Vec<Piece>| pieces.iter().map(length).sum::<f64>();
        let reach = longest(&base) + links.iter().map(longest).sum::<f64>();
        let size = reach + further.fold(0.0, f64::max);
        Shape { base, links, reach, size: if size > 0.0 { size } else { SOME_SIZE } }
    }

    /// Pieces as solid capsules.
    pub fn capsules(&self, pieces: &[Piece], colour: Color) -> Capsules3D {
        capsules(pieces, LINK_RADIUS * self.size, colour)
    }

    /// Housing of the joint that moves a link, in the link's frame: along its axis.
    pub fn housing(&self, chain: &Chain, link: usize, colour: Color) -> Capsules3D {
        let mover = &chain.movers()[link];
        let to_link: Transform = mover.after.inverse();
        let along = mover.axis.map(|component| HOUSING_HALF * self.size * component);
        let ends = [along.map(|component| -component), along].map(|end| to_link.transform_point(end));
        let housing = capsules(&[ends], HOUSING_RADIUS * self.size, colour);
        let kind = match mover.kind {
            JointKind::Revolute => "",
            JointKind::Prismatic => " (slides)",
        };
        housing.with_labels([format!("{}{kind}", mover.name)])
    }
}

fn length([from, to]: &Piece) -> f64 {
    (Vector3::from(*to) - Vector3::from(*from)).norm()
}

/// Solid capsules along pieces.
pub fn capsules(pieces: &[Piece], radius: f64, colour: Color) -> Capsules3D {
    let lengths = pieces.iter().map(|piece| length(piece) as f32);
    Capsules3D::from_lengths_and_radii(lengths, pieces.iter().map(|_| radius as f32))
        .with_translations(pieces.iter().map(|[from, _]| small(*from)))
        .with_quaternions(
            pieces.iter().map(|[from, to]| quaternion(upright(Vector3::from(*to) - Vector3::from(*from)))),
        )
        .with_colors([colour])
        .with_fill_mode(FillMode::Solid)
}

/// The rotation that turns z into a direction.
fn upright(direction: Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(&Vector3::z(), &direction)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI))
}

/// As Rerun takes it.
pub fn quaternion(rotation: UnitQuaternion<f64>) -> Quaternion {
    let [x, y, z, w] = rotation.coords.data.0[0];
    Quaternion::from_xyzw([x as f32, y as f32, z as f32, w as f32])
}

/// In single precision, as Rerun takes it.
pub fn small(vector: [f64; 3]) -> [f32; 3] {
    vector.map(|component| component as f32)
}
