//! What a solution leaves undetermined, in words.

use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{LAST_FRAME_CHOICE, Session};

use crate::joint::identifiability::untold_noise::UntoldNoise;
use crate::joint::reporting::answer::Answer;
use crate::joint::solved::Solved;
use crate::result::Undetermined;

/// All of it: the noise if that is unknown, combinations without information, gravity's sign, choices of frames.
pub(super) fn undetermined(session: &Session, answer: &Answer) -> Vec<Undetermined> {
    let Answer { solved, judgement, parameters, .. } = answer;
    let situation = solved.situation(session);
    let open = parameters.iter().filter(|parameter| parameter.asked && !parameter.determined);
    let untold = solved.freedom_of_noise(session).map(|_| UntoldNoise::of_solved(solved));
    let noise = untold.map(|untold| untold.of(open.map(|parameter| parameter.name.clone()).collect()));
    let combinations = judgement.combinations.iter().map(|c| situation.report(&c.into()));
    let sign = unknown_sign(session, solved, &solved.readings().spreads);
    noise.into_iter().chain(combinations).chain(sign).chain(last_frame_choices(session)).collect()
}

/// The choices of the last links' frames, told as something undetermined.
pub(crate) fn last_frame_choices(session: &Session) -> Vec<Undetermined> {
    let chain = &session.robot.chain;
    let chosen =
        |joint: &usize| session.fixed_reason(*joint, SensorParameter::PositionOffset) == Some(LAST_FRAME_CHOICE);
    let report = |joint: usize| {
        let name = SensorParameter::PositionOffset.name(&chain.joints()[joint].name);
        let of_branch = chain.links_of(joint).map(|link| format!("link {}", chain.links()[link].name));
        let link = if chain.is_serial() { "the last link".into() } else { of_branch.collect::<Vec<_>>().join(" or ") };
        Undetermined {
            combination: name.clone(),
            parameters: vec![name],
            why: "a choice of the last link's frame: turning it turns the unknown moments and placements along".into(),
            cure: format!("state a load's position in {link} (position_m)"),
        }
    };
    (0..session.joints.len()).filter(chosen).map(report).collect()
}

/// That the readings do not tell gravity from its opposite, where that is so; with the parameters that would turn with it.
pub(crate) fn unknown_sign(session: &Session, solved: &Solved, spreads: &[f64]) -> Option<Undetermined> {
    let turning = solved.turning_with_gravity(session, spreads).into_iter().map(|id| session.parameter_name(id));
    let [why, cure] = match session.gravity.hemisphere {
        None => [
            "gravity the other way up, with all masses and moments negative, explains the readings as well",
            "state gravity's rough direction ([gravity] hemisphere), or attach a load of known mass at the end of known lengths",
        ],
        Some(_) => [
            "the readings are explained best with gravity outside of its declared hemisphere, and hardly worse on the border of it",
            "add poses that move the joints over a wider range, or attach a load of known mass",
        ],
    };
    (!solved.sign_known).then(|| Undetermined {
        combination: "sign of gravity".into(),
        parameters: std::iter::once("gravity".into()).chain(turning).collect(),
        why: why.into(),
        cure: cure.into(),
    })
}
