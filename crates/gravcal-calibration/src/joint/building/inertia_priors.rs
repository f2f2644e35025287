//! What the robot's description says of the links' inertia, and how well.

use gravcal_estimation::BlockId;
use gravcal_robot_model::session::{InertiaPrior, Session};

use crate::joint::variables::{State, VariableIndex};

/// Centre of mass from which an assumed mass's moment is taken to be uncertain, m: see [`moment_std`].
const TYPICAL_LEVER: f64 = 0.1;

/// What is known beforehand of one block.
pub(in crate::joint) struct LinkPrior {
    pub link: usize,
    pub block: BlockId,
    pub expected: Vec<f64>,
    pub std: Vec<f64>,
}

/// Masses and first moments of all links first, then, where the arm moves, their tensors, each as well as its mass; none of a link that is exact, or of
/// which nothing is said.
pub(in crate::joint) fn inertia_priors(session: &Session, variables: &VariableIndex) -> Vec<LinkPrior> {
    let InertiaPrior::Model { relative_std } = &session.inertia else { return Vec::new() };
    let links = || session.robot.chain.links().iter().zip(relative_std).enumerate();
    let bodies = variables.inertia.iter().zip(links()).filter_map(|(block, (link, (described, relative_std)))| {
        let (inertia, relative_std) = (described.inertia.as_ref()?, (*relative_std)?);
        let [x, y, z] = inertia.first_moment;
        let moment = relative_std * moment_std(inertia.mass, [x, y, z]);
        let std = vec![relative_std * inertia.mass, moment, moment, moment];
        Some(LinkPrior { link, block: *block, expected: vec![inertia.mass, x, y, z], std })
    });
    let nominal = State::nominal(session).tensors;
    let tensors = variables.tensors.iter().zip(nominal).zip(links());
    let tensors = tensors.filter_map(|((block, tensor), (link, (described, relative_std)))| {
        let (inertia, relative_std) = (described.inertia.as_ref()?, (*relative_std)?);
        let least = inertia.mass * TYPICAL_LEVER * TYPICAL_LEVER;
        let size = f64::max(0.5 * (tensor[0] + tensor[2] + tensor[5]).abs(), least);
        Some(LinkPrior { link, block: *block, expected: tensor.to_vec(), std: vec![relative_std * size; 6] })
    });
    bodies.chain(tensors).collect()
}

/// Size of a first moment for a relative uncertainty, kg·m: that of the moment itself, but at least that of the
/// mass at [`TYPICAL_LEVER`], so that a moment drawn as zero is not taken as exact.
fn moment_std(mass: f64, moment: [f64; 3]) -> f64 {
    let length = moment.iter().map(|c| c * c).sum::<f64>().sqrt();
    length.max(mass * TYPICAL_LEVER)
}
