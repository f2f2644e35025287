//! What sensors beyond the affine ones add to the residual and its derivatives.
//!
//! ```text
//!     ∂y_i/∂τ_j = k_i [i = j] + Σ ∂f/∂τ_j,   ∂y_i/∂θ_j += Σ ∂f/∂θ_j,   ∂y_i/∂x = ∂f/∂x  (own),   (∂y_i/∂o_j) ∂f/∂x  (of position j)
//! ```

use std::ops::Range;

use gravcal_recording::Conditions;

use crate::sensors::{Moment, Partials, SensorTerms, Term};

/// The terms of all sensors, and where their parameters are stored.
#[derive(Debug)]
pub(super) struct Terms {
    pub(super) functions: SensorTerms,
    pub(super) joints: usize,
    /// First stored column: that of the first parameter.
    pub(super) column: usize,
    /// By joint, the terms of its torque sensor.
    of_joint: Vec<Vec<usize>>,
    /// Whether any position sensor has terms.
    move_joints: bool,
    /// By joint, whose torques and coordinates its reading depends on by terms. The coordinate of a joint that gives way is its torque's.
    torques: Vec<Vec<usize>>,
    coordinates: Vec<Vec<usize>>,
}

/// Derivatives of what terms say: of coordinates by parameters of position sensors, and of one reading.
#[derive(Debug, Default)]
pub(super) struct Slopes {
    /// By the parameters of all terms; of torque sensors only those of the reading.
    pub by_parameter: Vec<f64>,
    /// By each joint's torque; only of those that the reading depends on.
    pub by_torque: Vec<f64>,
    /// By each joint's coordinate; only of those that the reading depends on.
    pub by_coordinate: Vec<f64>,
    /// Those of a single term, all zero in between.
    torque: Vec<f64>,
    coordinate: Vec<f64>,
}

impl Slopes {
    /// Those of a term at this moment go to its parameters, and are added to the rest.
    fn add(&mut self, term: &Term, at: &Moment<'_>, values: &[f64]) -> f64 {
        let by_parameter = &mut self.by_parameter[term.places.clone()];
        by_parameter.fill(0.0);
        let partials = Partials { by_parameter, by_torque: &mut self.torque, by_coordinate: &mut self.coordinate };
        let value = term.value(at, values, Some(partials));
        for joint in term.reads.torques() {
            self.by_torque[*joint] += std::mem::take(&mut self.torque[*joint]);
        }
        for joint in term.reads.coordinates() {
            self.by_coordinate[*joint] += std::mem::take(&mut self.coordinate[*joint]);
        }
        value
    }

    /// The same where joints give way: `dθ = dθ⁰ + τ dc + c dτ`, and what `dθ⁰` and `dc` do is that of a coordinate.
    pub fn with_compliance(&mut self, coordinates: &[usize], compliance: &[f64]) {
        for joint in coordinates {
            self.by_torque[*joint] += self.by_coordinate[*joint] * compliance[*joint];
        }
    }
}

impl Terms {
    pub fn new(functions: SensorTerms, joints: usize, column: usize, give_way: bool) -> Terms {
        let read = |of: &dyn Fn(&Term) -> Vec<usize>| -> Vec<Vec<usize>> {
            let of_joint = |joint| {
                let mut all: Vec<usize> = functions.of_torque(joint).flat_map(of).collect();
                all.sort_unstable();
                all.dedup();
                all
            };
            (0..joints).map(of_joint).collect()
        };
        let giving_way = |term: &Term| if give_way { term.reads.coordinates().to_vec() } else { Vec::new() };
        let torques = read(&|term| [term.reads.torques(), &giving_way(term)].concat());
        let coordinates = read(&|term| term.reads.coordinates().to_vec());
        let of_joint = (0..joints).map(|joint| functions.places_of_torque(joint)).collect();
        let move_joints = functions.of_positions().next().is_some();
        Terms { functions, joints, column, of_joint, move_joints, torques, coordinates }
    }

    /// Room for the derivatives of these terms.
    pub fn fit(&self, slopes: &mut Slopes) {
        slopes.by_parameter.resize(self.functions.len(), 0.0);
        for by_joint in [&mut slopes.by_torque, &mut slopes.by_coordinate, &mut slopes.torque, &mut slopes.coordinate] {
            by_joint.resize(self.joints, 0.0);
        }
    }

    /// What position sensors add to the coordinates; where derivatives are wanted, `slopes` has them of their parameters.
    pub fn add_to_coordinates(
        &self,
        (position, conditions): (&[f64], &Conditions),
        x: &[f64],
        coordinates: &mut [f64],
        mut slopes: Option<&mut Slopes>,
    ) {
        let values = self.values(x);
        let at = Moment::new(&[], &[], position, conditions);
        for term in self.functions.of_positions() {
            coordinates[term.joint] += match &mut slopes {
                None => term.value(&at, values, None),
                Some(slopes) => slopes.add(term, &at, values),
            };
        }
    }

    /// What the torque sensor of a joint adds to its reading; where derivatives are wanted, `slopes` has them.
    pub fn reading(&self, joint: usize, at: &Moment<'_>, x: &[f64], slopes: Option<&mut Slopes>) -> f64 {
        let values = self.values(x);
        let own = self.of_torque(joint);
        let Some(slopes) = slopes else { return own.map(|term| term.value(at, values, None)).sum() };
        self.torques[joint].iter().for_each(|source| slopes.by_torque[*source] = 0.0);
        self.coordinates[joint].iter().for_each(|source| slopes.by_coordinate[*source] = 0.0);
        own.map(|term| slopes.add(term, at, values)).sum()
    }

    /// The terms of a joint's torque sensor.
    pub fn of_torque(&self, joint: usize) -> impl Iterator<Item = &Term> {
        self.of_joint[joint].iter().map(|place| &self.functions.all()[*place])
    }

    /// Whether a joint's torque sensor has any.
    pub fn has(&self, joint: usize) -> bool {
        !self.of_joint[joint].is_empty()
    }

    /// Whether any position sensor has some.
    pub fn move_joints(&self) -> bool {
        self.move_joints
    }

    /// Whether any reading depends on a true coordinate by terms.
    pub fn read_coordinates(&self) -> bool {
        self.coordinates.iter().any(|read| !read.is_empty())
    }

    fn values<'x>(&self, x: &'x [f64]) -> &'x [f64] {
        &x[self.column..self.column + self.functions.len()]
    }

    /// Whether no reading depends on another joint's torque by terms.
    pub fn read_own_torques(&self) -> bool {
        self.torques.iter().enumerate().all(|(joint, read)| read.iter().all(|source| *source == joint))
    }

    /// Joints whose torques a joint's reading depends on by terms.
    pub fn torques(&self, joint: usize) -> &[usize] {
        &self.torques[joint]
    }

    /// Joints whose coordinates it depends on by terms.
    pub fn coordinates(&self, joint: usize) -> &[usize] {
        &self.coordinates[joint]
    }

    /// Stored columns of parameters of terms that a joint's reading touches.
    pub fn columns(&self, joint: usize) -> impl Iterator<Item = usize> {
        let column = |places: Range<usize>| places.map(|place| self.column + place);
        let positions = self.functions.of_positions();
        self.functions.of_torque(joint).chain(positions).flat_map(move |term| column(term.places.clone()))
    }
}
