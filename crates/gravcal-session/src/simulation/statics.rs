//! Where the joints of a simulated pose truly are, and the torques that hold them.

use gravcal_dynamics::GravityTorque;
use gravcal_recording::Conditions;

use super::experiment::Simulation;

/// Rounds in which a compliant joint and its torque come to agree; each shrinks the error by (compliance · stiffness
/// of gravity), a few per cent.
const COMPLIANCE_ROUNDS: usize = 20;

/// The true arm, for one pose after another.
pub(super) struct Statics<'s> {
    simulation: &'s Simulation,
    /// Masses and moments of the links with nothing attached, then with each load.
    inertia: Vec<Vec<f64>>,
    torque: GravityTorque,
}

impl<'s> Statics<'s> {
    pub fn new(simulation: &'s Simulation) -> Statics<'s> {
        let bare: Vec<f64> = simulation.truth.inertia.iter().flatten().copied().collect();
        let carrying = |load: usize| {
            let (mass, link) = (simulation.template.loads[load].mass, simulation.template.loads[load].link);
            let mut inertia = bare.clone();
            inertia[4 * link] += mass;
            (0..3).for_each(|axis| inertia[4 * link + 1 + axis] += mass * simulation.truth.loads[load][axis]);
            inertia
        };
        let loads: Vec<Vec<f64>> = (0..simulation.template.loads.len()).map(carrying).collect();
        let chain = &simulation.template.robot.chain;
        let torque = GravityTorque::new(chain.joint_count(), chain.link_count());
        Statics { simulation, inertia: std::iter::once(bare).chain(loads).collect(), torque }
    }

    pub fn simulation(&self) -> &'s Simulation {
        self.simulation
    }

    /// True coordinates and torques: joints that stand deflected, and each bent by what it carries.
    pub fn of(&mut self, stand: &Stand, conditions: &Conditions, load: Option<usize>) -> (Vec<f64>, &[f64]) {
        let Simulation { truth, template, disturbance, .. } = self.simulation;
        let inertia = &self.inertia[load.map_or(0, |load| load + 1)];
        let compliance = &disturbance.deflection.compliance;
        let sensed = self.simulation.coordinates(&stand.position, conditions);
        let rounds = if compliance.iter().any(|c| *c != 0.0) { COMPLIANCE_ROUNDS } else { 1 };
        self.torque.torque.fill(0.0);
        let mut coordinates = sensed.clone();
        for _ in 0..rounds {
            for (joint, coordinate) in coordinates.iter_mut().enumerate() {
                let held = if stand.swept == Some(joint) { 0.0 } else { stand.deflection[joint] };
                *coordinate = sensed[joint] + held + compliance[joint] * self.torque.torque[joint];
            }
            template.robot.chain.update_gravity_torque(&coordinates, truth.gravity, inertia, &mut self.torque);
        }
        (coordinates, &self.torque.torque)
    }
}

/// Where the joints stand: position readings without noise, and the deflection drawn for each joint.
#[derive(Clone)]
pub(super) struct Stand {
    pub position: Vec<f64>,
    pub deflection: Vec<f64>,
    pub swept: Option<usize>,
}
