//! Lengths and angles of the robot's file that no arm has.

use std::f64::consts::PI;

use gravcal_dynamics::Transform;

use crate::session::Session;

/// No link's frame is farther from the one before, m.
const FARTHEST: f64 = 20.0;
/// How near an angle in degrees is to a multiple of π/2 that was meant in radians, as a share of it.
const NEAR: f64 = 1e-3;

/// One sentence or two for each mistake.
pub(super) fn doubts(session: &Session) -> Vec<String> {
    let chain = &session.robot.chain;
    let axes = chain.axes(&vec![0.0; chain.joint_count()]);
    let (mut farthest, mut turned) = (0.0_f64, Vec::new());
    for (link, length) in lengths(session).into_iter().enumerate() {
        farthest = farthest.max(length);
        let angle = chain.parent(link).and_then(|before| Some(angle(*axes.get(link)?, *axes.get(before)?)));
        if angle.is_some_and(|angle| meant_in_radians(angle.to_degrees())) {
            turned.push(chain.movers()[link].name.as_str());
        }
    }
    let far = (farthest > FARTHEST).then(|| {
        format!(
            "The robot's file places links {farthest:.0} m apart: are its lengths (a_m, d_m, or a URDF's origins) in millimetres? \
             State them in m."
        )
    });
    let turned = (!turned.is_empty()).then(|| {
        format!(
            "The axis of {} is π/2 or π degrees off the one before it: are the robot's angles (alpha_deg) in radians? State them in \
             degrees.",
            turned.join(", ")
        )
    });
    far.into_iter().chain(turned).collect()
}

/// How far each link's frame is from that of the link before, or from the base's, m.
pub(super) fn lengths(session: &Session) -> Vec<f64> {
    let chain = &session.robot.chain;
    let still = vec![0.0; chain.joint_count()];
    let origins: Vec<[f64; 3]> = chain.forward(&still).iter().map(Transform::translation).collect();
    let before = |link: usize| chain.parent(link).map_or([0.0; 3], |before| origins[before]);
    origins.iter().enumerate().map(|(link, origin)| distance(*origin, before(link))).collect()
}

/// Whether an angle in degrees is the number that π/2 or π is in radians.
fn meant_in_radians(degrees: f64) -> bool {
    [0.5 * PI, PI].iter().any(|meant| (degrees / meant - 1.0).abs() < NEAR)
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// Between unit vectors, rad.
fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let cosine: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    cross.iter().map(|part| part * part).sum::<f64>().sqrt().atan2(cosine)
}
