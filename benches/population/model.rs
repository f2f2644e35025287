//! All unknowns of a session, and the torque readings that they predict.
//!
//! ```text
//!     θ_i = s_i q_i + o_i              y_i = k_i τ_i(θ; g, bodies, load) + b_i
//!     g = g₀ + ‖g₀‖ (t₁ u₁ + t₂ u₂)    tangent to the sphere of the known magnitude
//!     b = a + d₀ + ‖d₀‖ (…)            likewise, two placements a known distance apart
//! ```
//!
//! The Jacobian is by complex step, one unknown at a time: `∂y/∂x = Im y(x + i h) / h`.

use faer::Mat;
use nalgebra::Vector3;

use super::statics::{Number, complex, gravity_at, torques};
use super::truth::{PLACEMENTS, Sensors, Truth, Wrist};

/// Step along the imaginary axis: its square is nothing beside one.
const STEP: f64 = 1e-30;

/// Names of the unknowns, and their true values.
pub struct State {
    /// `gravity.1`, `joint1.torque_gain`, `joint1.mass`, `a.x`, …
    pub names: Vec<String>,
    /// In SI and the torque readings' unit.
    pub values: Vec<f64>,
}

/// The unknowns of a session at their true values.
pub fn state(truth: &Truth) -> State {
    let joints = &truth.arm.joints;
    let Sensors { torque_gain, torque_bias, position_gain, position_offset } = &truth.sensors;
    let mut all: Vec<(String, f64)> = [1, 2].map(|axis| (format!("gravity.{axis}"), 0.0)).into();
    let by_joint = [
        ("torque_gain", torque_gain),
        ("torque_bias", torque_bias),
        ("position_gain", position_gain),
        ("position_offset", position_offset),
    ];
    for (quantity, values) in by_joint {
        all.extend(joints.iter().zip(values).map(|(joint, value)| (format!("{}.{quantity}", joint.name), *value)));
    }
    for joint in joints {
        let parts = ["mass", "moment_x", "moment_y", "moment_z"].iter().zip(joint.body);
        all.extend(parts.map(|(part, value)| (format!("{}.{part}", joint.name), value)));
    }
    if let Some(first) = truth.placements.first() {
        all.extend("xyz".chars().zip(first.iter()).map(|(axis, value)| (format!("{}.{axis}", PLACEMENTS[0]), *value)));
    }
    if truth.placements.len() == 2 {
        all.extend([1, 2].map(|axis| (format!("{}.direction{axis}", PLACEMENTS[1]), 0.0)));
    }
    if let Some(Wrist { gain, bias, tool, .. }) = &truth.wrist {
        let mut add = |quantity: String, value: &f64| all.push((format!("{}.{quantity}", Wrist::NAME), *value));
        Wrist::AXES.iter().zip(gain).for_each(|(axis, gain)| add(format!("gain_{axis}"), gain));
        Wrist::AXES.iter().zip(bias).for_each(|(axis, bias)| add(format!("bias_{axis}"), bias));
        Wrist::TOOL.iter().zip(tool).for_each(|(part, value)| add((*part).to_owned(), value));
    }
    let (names, values) = all.into_iter().unzip();
    State { names, values }
}

/// Every reading, table by table, pose by pose and channel by channel, at some values of the unknowns.
pub fn predicted(truth: &Truth, values: &[Number]) -> Vec<Number> {
    let model = Model::new(truth, values);
    let of_table = |table: &super::truth::Table| {
        let bodies = model.loaded(table.placement);
        table
            .angles
            .iter()
            .flat_map(|angles| model.readings(&truth.position_readings(angles), &bodies, table.placement))
            .collect::<Vec<_>>()
    };
    truth.tables.iter().flat_map(of_table).collect()
}

/// Derivatives of all readings in units of their noise: a row a reading, a column an unknown.
pub fn jacobian(truth: &Truth, state: &State) -> Mat<f64> {
    let mut values: Vec<Number> = state.values.iter().copied().map(Number::from).collect();
    let mut jacobian = Mat::zeros(truth.readings(), values.len());
    for column in 0..values.len() {
        values[column].im = STEP;
        for (row, reading) in predicted(truth, &values).iter().enumerate() {
            jacobian[(row, column)] = reading.im / STEP / truth.noise[row % truth.channels()];
        }
        values[column].im = 0.0;
    }
    jacobian
}

/// The unknowns in their places.
struct Model<'t> {
    truth: &'t Truth,
    gravity: Vector3<Number>,
    /// By quantity and joint.
    sensors: [&'t [Number]; 4],
    bodies: Vec<[Number; 4]>,
    placements: Vec<Vector3<Number>>,
    /// Gains, biases and tool.
    wrist: &'t [Number],
}

impl<'t> Model<'t> {
    fn new(truth: &'t Truth, values: &'t [Number]) -> Model<'t> {
        let n = truth.arm.joint_count();
        let (gravity, rest) = values.split_at(2);
        let (sensors, rest) = rest.split_at(4 * n);
        let (bodies, rest) = rest.split_at(4 * n);
        let (placements, wrist) = rest.split_at([0, 3, 5][truth.placements.len()]);
        Model {
            truth,
            gravity: on_sphere(&truth.gravity, gravity),
            sensors: std::array::from_fn(|quantity| &sensors[quantity * n..(quantity + 1) * n]),
            bodies: bodies.chunks(4).map(|body| std::array::from_fn(|part| body[part])).collect(),
            placements: placed(&truth.placements, placements),
            wrist,
        }
    }

    /// The bodies with the load on the last one.
    fn loaded(&self, placement: Option<usize>) -> Vec<[Number; 4]> {
        let mut bodies = self.bodies.clone();
        if let (Some(placement), Some(last)) = (placement, bodies.last_mut()) {
            let tip = &self.truth.arm.tip_frame;
            let rotation = tip.rotation.to_rotation_matrix().into_inner().map(Number::from);
            let centre = complex(&tip.translation.vector) + rotation * self.placements[placement];
            let moment = centre * Number::from(self.truth.mass);
            last[0] += self.truth.mass;
            (0..3).for_each(|axis| last[1 + axis] += moment[axis]);
        }
        bodies
    }

    /// The readings of one pose.
    fn readings(&self, positions: &[f64], bodies: &[[Number; 4]], placement: Option<usize>) -> Vec<Number> {
        let [torque_gain, torque_bias, position_gain, position_offset] = self.sensors;
        let joints = || 0..positions.len();
        let angles: Vec<Number> = joints().map(|i| position_gain[i] * positions[i] + position_offset[i]).collect();
        let torques = torques(&self.truth.arm.joints, &angles, &self.gravity, bodies);
        let mut readings: Vec<Number> = joints().map(|i| torque_gain[i] * torques[i] + torque_bias[i]).collect();
        if !self.wrist.is_empty() {
            readings.extend(self.wrench_readings(&angles, placement));
        }
        readings
    }

    /// `y = gain · (f, n) + bias` with `f = −m v` and `n = v × h`, where v is gravity in the tip's frame, m and h the mass and the first
    /// moment of the tool and the load.
    fn wrench_readings(&self, angles: &[Number], placement: Option<usize>) -> [Number; 6] {
        let (arm, (gains, rest)) = (&self.truth.arm, self.wrist.split_at(6));
        let (biases, tool) = rest.split_at(6);
        let v = gravity_at(&arm.joints, angles, &self.gravity, &arm.tip_frame);
        let (mut mass, mut moment) = (tool[0], Vector3::from_column_slice(&tool[1..]));
        if let Some(placement) = placement {
            mass += self.truth.mass;
            moment += self.placements[placement] * Number::from(self.truth.mass);
        }
        let (force, torque) = (-v * mass, v.cross(&moment));
        std::array::from_fn(|axis| {
            let sensed = if axis < 3 { force[axis] } else { torque[axis - 3] };
            gains[axis] * sensed + biases[axis]
        })
    }
}

/// The first placement, and the second at its known distance.
fn placed(truth: &[Vector3<f64>], values: &[Number]) -> Vec<Vector3<Number>> {
    let Some((first, direction)) = values.split_at_checked(3) else { return Vec::new() };
    let first = Vector3::from_column_slice(first);
    match truth {
        [a, b] => vec![first, first + on_sphere(&(b - a), direction)],
        _ => vec![first],
    }
}

/// A vector moved along the sphere on which it lies, by two tangent coordinates.
fn on_sphere(vector: &Vector3<f64>, tangent: &[Number]) -> Vector3<Number> {
    let aside = if vector.x.abs() < 0.8 * vector.norm() { Vector3::x() } else { Vector3::y() };
    let first = vector.cross(&aside).normalize();
    let second = vector.cross(&first).normalize();
    let length = vector.norm();
    complex(vector) + complex(&(first * length)) * tangent[0] + complex(&(second * length)) * tangent[1]
}
