//! Links with what they carry in a pose.

use gravcal_robot_model::session::Session;

use crate::joint::variables::State;

/// Numbers of a link: mass, first moment and tensor.
const BODY: usize = 10;

/// Mass, kg, and first moment, kg·m, of each link with what it carries in a pose.
pub(crate) fn inertia_in_pose(session: &Session, state: &State, pose: usize) -> Vec<[f64; 4]> {
    let mut inertia = state.inertia.clone();
    if let Some(load) = session.poses[pose].load {
        let described = &session.loads[load];
        let link = &mut inertia[described.link];
        if described.is_unknown() {
            let before = session.loads[..load].iter().filter(|other| other.is_unknown()).count();
            link.copy_from_slice(&state.with_payloads[before][..4]);
        } else {
            let mass = session.load_mass(load).map_or(described.mass, |id| state.value(id));
            let [x, y, z] = state.loads[load].map(|place| mass * place);
            link.iter_mut().zip([mass, x, y, z]).for_each(|(number, of_load)| *number += of_load);
        }
    }
    inertia
}

/// Ten numbers of each link (see [`gravcal_dynamics::BodyInertia`]) with what it carries in a pose.
pub(in crate::joint) fn bodies_in_pose(session: &Session, state: &State, pose: usize) -> Vec<f64> {
    let mut tensors = state.tensors.clone();
    if let Some(load) = session.poses[pose].load {
        let described = &session.loads[load];
        if described.is_unknown() {
            let before = session.loads[..load].iter().filter(|other| other.is_unknown()).count();
            tensors[described.link].copy_from_slice(&state.with_payloads[before][4..]);
        } else {
            let carried = tensors[session.robot.chain.link_count() + load];
            tensors[described.link].iter_mut().zip(carried).for_each(|(own, of_load)| *own += of_load);
        }
    }
    let mut bodies = Vec::with_capacity(BODY * session.robot.chain.link_count());
    for (moments, tensor) in inertia_in_pose(session, state, pose).iter().zip(&tensors) {
        bodies.extend(moments.iter().chain(tensor));
    }
    bodies
}
