//! What a session does not know as plain numbers: what a start, a truth or a solution is made of.

use crate::parameter::{ParameterId, SensorParameter};
use crate::session::{AuxiliarySensor, AuxiliarySensorKind, Load, Session};

/// A value for every unknown of a session, in inside units.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Gravity in base coordinates, m/s².
    pub gravity: [f64; 3],
    /// `[k, b, s, o]` of each joint.
    pub sensors: Vec<[f64; 4]>,
    /// The further parameters, in the order of [`Session::further`].
    pub further: Vec<f64>,
    /// `(m, h_x, h_y, h_z)` of each link, kg and kg·m.
    pub inertia: Vec<[f64; 4]>,
    /// `[I_xx, I_xy, I_yy, I_xz, I_yz, I_zz]` of each link about its origin, then that of each load in the frame of the link that carries it,
    /// kg·m²; empty where the arm never moves.
    pub tensors: Vec<[f64; 6]>,
    /// Of each unknown load ([`Load::is_unknown`]), in their order: ten numbers of the link with it, as a
    /// [`BodyInertia`](gravcal_dynamics::BodyInertia) has them.
    pub with_payloads: Vec<[f64; 10]>,
    /// The moments of the sweep description (kg·m, masses in kg), in the order of the joint problem's blocks; empty where
    /// they are those that `inertia` comes to.
    pub sweep_moments: Vec<Vec<f64>>,
    /// Centre of mass of each load in its link's frame, m; less that of the load from which it is counted, where moments
    /// are described by sweep.
    pub loads: Vec<[f64; 3]>,
    /// The deflections of each sweep, in the order of the variables' own; empty where all are zero.
    pub deflections: Vec<Vec<f64>>,
    /// Static friction of joints that stand while others sweep: by joint, to the side from which it came, then of each sweep, in the order of the
    /// variables' own; unit of the torque reading, empty where there is none.
    pub static_friction: Vec<Vec<f64>>,
    /// What friction leaves at rest, by joint, unit of the torque reading; empty where it is zero.
    pub at_rest: Vec<f64>,
    /// By how much more it leaves where a joint carries twice as much as in the mean, by joint, unit of the torque reading; empty where it does not grow.
    pub growing_friction: Vec<f64>,
    /// By how much joints bend that are not declared to, by joint, rad/(N·m); empty where none does.
    pub bending: Vec<f64>,
    /// How far joints sit from where the robot's description has them, m, in the order of the variables' own; empty where lengths are exact.
    pub lengths: Vec<f64>,
    /// How far the joints' axes are tilted against the robot's description, rad, in the order of the variables' own; empty where axes are exact.
    pub axes: Vec<f64>,
}

impl State {
    /// What the robot and the session say beforehand.
    pub fn nominal(session: &Session) -> State {
        State {
            gravity: session.gravity.assumed(),
            sensors: session
                .joints
                .iter()
                .map(|joint| SensorParameter::ALL.map(|quantity| joint.of(quantity).nominal))
                .collect(),
            further: session.further.iter().map(|parameter| parameter.prior.nominal).collect(),
            inertia: session.robot.chain.links().iter().map(nominal_inertia).collect(),
            tensors: nominal_tensors(session),
            with_payloads: nominal_with_payloads(session),
            sweep_moments: Vec::new(),
            loads: nominal_placements(session),
            deflections: Vec::new(),
            static_friction: Vec::new(),
            at_rest: Vec::new(),
            growing_friction: Vec::new(),
            bending: Vec::new(),
            lengths: Vec::new(),
            axes: Vec::new(),
        }
    }

    /// The value of one parameter.
    pub fn value(&self, id: ParameterId) -> f64 {
        match id {
            ParameterId::Sensor(joint, quantity) => self.sensors[joint][quantity as usize],
            ParameterId::Further(index) => self.further[index],
        }
    }

    /// The place of the same.
    pub fn value_mut(&mut self, id: ParameterId) -> &mut f64 {
        match id {
            ParameterId::Sensor(joint, quantity) => &mut self.sensors[joint][quantity as usize],
            ParameterId::Further(index) => &mut self.further[index],
        }
    }

    /// Gives parameters that are the same as another one its value.
    pub fn share(&mut self, session: &Session) {
        for (index, parameter) in session.further.iter().enumerate() {
            if let Some(same) = parameter.same_as {
                self.further[index] = self.further[same];
            }
        }
    }

    /// Gravity the other way up, masses, moments and placements negative: the same torques, but for what a load's mass
    /// does on known lengths. What is given as exact stays.
    pub fn upside_down(&self, session: &Session) -> State {
        let mut further = self.further.clone();
        let wrist = |instrument: &&AuxiliarySensor| instrument.kind == AuxiliarySensorKind::ForceTorque;
        for instrument in session.instruments.iter().filter(wrist) {
            let free = instrument.own_parameters().filter(|own| session.further[*own].fixed.is_none());
            free.for_each(|own| further[own] *= -1.0);
        }
        let negative = |v: &[f64; 3]| v.map(|component| -component);
        let placement = |(position, load): (&[f64; 3], &Load)| match (load.position, load.position_std) {
            (Some(_), None) => *position,
            _ => negative(position),
        };
        State {
            gravity: negative(&self.gravity),
            sensors: self.sensors.clone(),
            further,
            inertia: self.inertia.iter().map(|v| v.map(|component| -component)).collect(),
            tensors: self.tensors.iter().map(|v| v.map(|component| -component)).collect(),
            with_payloads: self.with_payloads.iter().map(|v| v.map(|component| -component)).collect(),
            sweep_moments: self.sweep_moments.iter().map(|v| v.iter().map(|component| -component).collect()).collect(),
            loads: self.loads.iter().zip(&session.loads).map(placement).collect(),
            deflections: self.deflections.clone(),
            static_friction: self.static_friction.clone(),
            at_rest: self.at_rest.clone(),
            growing_friction: self.growing_friction.clone(),
            bending: self.bending.clone(),
            lengths: self.lengths.clone(),
            axes: self.axes.clone(),
        }
    }
}

/// A link without an assumed mass starts as 1 kg a few centimetres from its frame's origin, in no special direction:
/// what can be determined does not depend on the numbers, only on their not being special.
const SOME_INERTIA: [f64; 4] = [1.0, 0.06, 0.05, 0.08];
/// A link without an assumed tensor starts with one of that mass, kg·m²; so does every load, whose tensor nobody states.
const SOME_TENSOR: [f64; 6] = [0.02, 0.001, 0.03, -0.002, 0.001, 0.025];
/// A load without a known position starts here, m, in no special direction either.
const SOME_PLACEMENT: [f64; 3] = [0.05, 0.04, 0.1];
/// The direction in which placements of a known distance start apart: of unit length.
const SOME_DIRECTION: [f64; 3] = [0.6, 0.48, 0.64];

fn nominal_inertia(link: &gravcal_dynamics::Link) -> [f64; 4] {
    link.inertia.as_ref().map_or(SOME_INERTIA, |i| [i.mass, i.first_moment[0], i.first_moment[1], i.first_moment[2]])
}

/// Those of the robot, where the arm moves.
fn nominal_tensors(session: &Session) -> Vec<[f64; 6]> {
    if !session.has_windows() {
        return Vec::new();
    }
    let assumed = session.robot.chain.inertial_parameters().unwrap_or_default();
    let (bodies, _) = assumed.as_chunks::<10>();
    let tensor = |link: usize| {
        let stated = bodies.get(link).map(|[_, _, _, _, tensor @ ..]| *tensor);
        stated.filter(|tensor| tensor.iter().any(|entry| *entry != 0.0)).unwrap_or(SOME_TENSOR)
    };
    let links = (0..session.robot.chain.link_count()).map(tensor);
    links.chain(session.loads.iter().map(|_| SOME_TENSOR)).collect()
}

/// A link with an unknown load starts as heavier than without, by some body in no special place.
fn nominal_with_payloads(session: &Session) -> Vec<[f64; 10]> {
    let links = session.robot.chain.links();
    let with = |load: &Load| {
        let [m, x, y, z] = nominal_inertia(&links[load.link]);
        let [dm, dx, dy, dz] = SOME_INERTIA.map(|number| 0.7 * number);
        let tensor = SOME_TENSOR.map(|entry| 2.2 * entry);
        let mut body = [m + dm, x + dx, y - dy, z + dz, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        body[4..].copy_from_slice(&tensor);
        body
    };
    session.loads.iter().filter(|load| load.is_unknown()).map(with).collect()
}

/// Unknown placements of a known distance start that far apart.
fn nominal_placements(session: &Session) -> Vec<[f64; 3]> {
    let mut placements: Vec<[f64; 3]> = session.loads.iter().map(|l| l.position.unwrap_or(SOME_PLACEMENT)).collect();
    for known in &session.load_distances {
        let [a, b] = known.between;
        if placements[a] == placements[b] {
            for (load, sign) in [(a, -0.5), (b, 0.5)] {
                if session.loads[load].position.is_none() {
                    (0..3).for_each(|i| placements[load][i] += sign * known.distance * SOME_DIRECTION[i]);
                }
            }
        }
    }
    placements
}
