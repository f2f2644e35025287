//! Undetermined combinations in words: what they are, why, and which pose or load would determine them.

use std::borrow::Cow;

use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::parameters::MOVE_MORE;
use gravcal_robot_model::session::{InertiaPrior, Load, Session};

use super::determined::Combination;
use crate::result::Undetermined;

/// Angle between gravity and the first axis below which tilting the base is the cure, rad.
const UPRIGHT: f64 = 0.05;

/// Standard deviations beyond so many times what would be of use say nothing but that: the linearization does not reach so far.
const HOPELESS: f64 = 1000.0;

/// What the words depend on.
pub(crate) struct Situation<'a> {
    /// The session.
    pub session: &'a Session,
    /// Gravity in base coordinates, m/s².
    pub gravity: [f64; 3],
    /// Joints with at least one torque reading in use.
    pub read: Vec<bool>,
    /// Parameters on which no reading in use depends.
    pub unread: Vec<ParameterId>,
    /// Parameters that a constraint holds at its bound.
    pub on_bound: Vec<ParameterId>,
    /// Joints that carry no gravity.
    pub gravity_free: Vec<bool>,
}

impl Situation<'_> {
    /// Tells a combination in words.
    pub fn report(&self, combination: &Combination) -> Undetermined {
        let names: Vec<String> =
            combination.parameters.iter().map(|(id, _)| self.session.parameter_name(*id)).collect();
        let mut parameters = names.clone();
        if combination.gravity {
            parameters.insert(0, "gravity".into());
        }
        let (words, why, cure) = self.explain(combination, &parameters);
        let why = match combination.std_over_limit {
            Some(ratio) if ratio < HOPELESS => {
                format!("{why} (its standard deviation is {ratio:.1} times what would be of use)")
            }
            Some(_) => format!("{why} (its standard deviation is more than {HOPELESS} times what would be of use)"),
            None => why,
        };
        Undetermined { combination: words, parameters, why, cure }
    }

    fn explain(&self, combination: &Combination, parameters: &[String]) -> (String, String, String) {
        let list = parameters.join(", ");
        let sensors = combination.parameters.iter().filter_map(|(id, _)| match id {
            ParameterId::Sensor(joint, quantity) => Some((*joint, *quantity)),
            ParameterId::Further(_) => None,
        });
        let only_sensors =
            !combination.parameters.is_empty() && sensors.clone().count() == combination.parameters.len();
        if self.is_common_scale(combination) {
            // Where the trunk carries no gravity, each branch has a scale of its own.
            let all = (0..self.session.joints.len()).filter(|joint| self.weighs(*joint)).count();
            let words = if self.weighing_with(combination).len() == all {
                "common scale of all torque gains".into()
            } else {
                format!("common scale of the torque gains from {} on", self.joint(self.weighing_with(combination)[0]))
            };
            let why = "all masses and moments are unknown, so readings in any unit of torque explain the data";
            return (words, why.into(), self.scale_cure(combination));
        }
        if combination.parameters.iter().any(|(id, _)| self.on_bound.contains(id)) {
            let why = "the estimate leans on its constraint: the readings put it beyond, and its interval is one-sided";
            return (
                list,
                why.into(),
                "widen the constraint or drop it; or look for what makes the readings pass it".into(),
            );
        }
        if combination.parameters.iter().any(|(id, _)| self.unread.contains(id)) {
            let cure = "record the torque of a joint or an instrument that depends on it";
            return (list, "no reading in use depends on it".into(), cure.into());
        }
        if let Some(unread) = sensors.clone().find_map(|(joint, quantity)| {
            let of_torque = matches!(quantity, SensorParameter::TorqueGain | SensorParameter::TorqueBias);
            (of_torque && !self.read[joint]).then_some(joint)
        }) {
            let joint = self.joint(unread);
            return (list, format!("no torque reading of {joint} is used"), format!("record the torque of {joint}"));
        }
        let upright = sensors.clone().next().map(|(joint, _)| joint).filter(|joint| self.is_upright(*joint));
        if let Some(first) = upright.filter(|joint| only_sensors && sensors.clone().all(|(other, _)| other == *joint)) {
            let first = self.joint(first);
            return (
                list,
                format!("gravity is parallel to the axis of {first}, which therefore carries none of it"),
                format!("tilt the base by a few degrees (10° serve well), so that {first} carries gravity"),
            );
        }
        if combination.gravity {
            return (
                list,
                "the poses see gravity from too few directions".into(),
                "add poses in which the first joints take at least three well separated positions".into(),
            );
        }
        if sensors.clone().any(|(_, quantity)| quantity == SensorParameter::TorqueGain) {
            let why = if combination.parameters.len() == 1 {
                "the unknown masses and moments trade off with it"
            } else {
                "only their combination acts on the readings"
            };
            return (list, why.into(), self.scale_cure(combination));
        }
        if !only_sensors {
            let why = "what it depends on varies too little over the poses, or only together with other things";
            return (list, why.into(), self.cures(combination));
        }
        let why = match parameters {
            [_] => "the readings tell it too little, or unknown masses and moments change them alike",
            _ => "the readings tell only their combination, or too little of them",
        };
        let known = self.session.loads.iter().any(|load| !load.is_unknown());
        let with_load = if known { "" } else { ", or poses with a load of known mass" };
        (list, why.into(), format!("{MOVE_MORE}{with_load}"))
    }

    /// The cures of the further parameters.
    fn cures(&self, combination: &Combination) -> String {
        let further = combination.parameters.iter().filter(|(id, _)| matches!(id, ParameterId::Further(_)));
        let mut cures: Vec<Cow<'static, str>> = further.map(|(id, _)| self.session.parameter(*id).cure).collect();
        cures.dedup();
        cures.join("; ")
    }

    fn is_common_scale(&self, combination: &Combination) -> bool {
        let gain = |(id, coefficient): &(ParameterId, f64)| match id {
            ParameterId::Sensor(joint, SensorParameter::TorqueGain) => Some((*joint, *coefficient)),
            _ => None,
        };
        let Some(gains) = combination.parameters.iter().map(gain).collect::<Option<Vec<(usize, f64)>>>() else {
            return false;
        };
        let equal = gains.iter().all(|(_, c)| (c / gains[0].1 - 1.0).abs() < 0.01);
        let with_sensor = self.weighing_with(combination).len();
        !combination.gravity
            && with_sensor > 1
            && gains.iter().filter(|(j, _)| !self.gravity_free[*j]).count() == with_sensor
            && equal
    }

    /// Whether a joint's readings tell of gravity.
    fn weighs(&self, joint: usize) -> bool {
        self.read[joint] && !self.gravity_free[joint]
    }

    /// The joints that weigh, and weigh something that a joint with a torque gain in the combination weighs too.
    fn weighing_with(&self, combination: &Combination) -> Vec<usize> {
        let gain = |(id, _): &(ParameterId, f64)| match id {
            ParameterId::Sensor(joint, SensorParameter::TorqueGain) if !self.gravity_free[*joint] => Some(*joint),
            _ => None,
        };
        let gains: Vec<usize> = combination.parameters.iter().filter_map(gain).collect();
        let meets = |joint: &usize| gains.iter().any(|gain| self.session.robot.chain.meet(*joint, *gain));
        (0..self.session.joints.len()).filter(|joint| self.weighs(*joint) && meets(joint)).collect()
    }

    fn scale_cure(&self, combination: &Combination) -> String {
        let weighing = self.weighing_with(combination);
        let chain = &self.session.robot.chain;
        let moved = |link: usize| weighing.iter().any(|joint| chain.moves(*joint, link));
        let weighed = |load: usize| !self.session.loads[load].is_unknown() && moved(self.session.loads[load].link);
        let loaded = self.session.poses.iter().any(|p| p.load.is_some_and(weighed));
        let bare = self.session.poses.iter().any(|p| !p.load.is_some_and(weighed));
        let placed = self.session.load_distances.iter().any(|known| weighed(known.between[0]));
        match (loaded, bare, placed, &self.session.inertia) {
            (false, ..) => {
                let names =
                    chain.last_links().filter(|link| moved(*link)).map(|link| chain.links()[link].name.as_str());
                let last = match chain.is_serial() {
                    true => "the last link".to_owned(),
                    false => format!("link {}", names.collect::<Vec<_>>().join(" or ")),
                };
                // Who wants to know what a load weighs knows as a rule what the torques are.
                let stated = match self.session.loads.iter().any(Load::is_unknown) {
                    true => "state a torque gain that is known ([joints] torque_gain = { fixed = …, unit = … }), or ",
                    false => "",
                };
                format!(
                    "{stated}attach a load of known mass to {last} and record loaded poses besides the bare ones; two placements \
                     a known distance apart are best"
                )
            }
            (true, false, ..) => "record bare poses besides the loaded ones".into(),
            (true, true, false, _) => {
                "record the load at a second placement a known distance (load_distance) from the first".into()
            }
            (_, _, _, InertiaPrior::Sweep) => {
                "sweep the joints with the load at both placements and read every torque; or state a gain as known: \
                 [[joint]] torque_gain = { fixed = …, unit = … }"
                    .into()
            }
            (_, _, _, InertiaPrior::Unknown) => {
                "state the load's position in the link (position_m), or the links' masses ([inertia] links = \"model\")"
                    .into()
            }
            _ => "state a gain as known: [[joint]] torque_gain = { fixed = …, unit = … }".into(),
        }
    }

    /// Whether a joint hangs on the base, and its axis is parallel to gravity.
    fn is_upright(&self, joint: usize) -> bool {
        let chain = &self.session.robot.chain;
        let mut links = chain.links_of(joint);
        let (Some(link), None) = (links.next(), links.next()) else { return false };
        let axis = chain.axis_rotations()[link].map(|row| row[2]);
        let norm = self.gravity.iter().map(|c| c * c).sum::<f64>().sqrt();
        let along: f64 = axis.iter().zip(self.gravity).map(|(a, g)| a * g).sum();
        chain.parent(link).is_none() && (1.0 - (along / norm).powi(2)).max(0.0).sqrt() < UPRIGHT
    }

    fn joint(&self, index: usize) -> &str {
        &self.session.robot.chain.joints()[index].name
    }
}

#[cfg(test)]
mod tests {
    use gravcal_robot_model::parameter::SensorParameter::{PositionGain, PositionOffset, TorqueBias, TorqueGain};

    use super::*;
    use crate::testing::{sarcos_shoulder, sarcos_with_instruments};

    /// All torques are read, on a base that leans.
    fn situation(session: &Session) -> Situation<'_> {
        Situation {
            session,
            gravity: [1.0, 0.0, -9.7],
            read: vec![true; 3],
            unread: Vec::new(),
            on_bound: Vec::new(),
            gravity_free: vec![false; 3],
        }
    }

    fn of(parameters: &[(usize, SensorParameter, f64)]) -> Combination {
        let parameters = parameters.iter().map(|(joint, of, c)| (ParameterId::Sensor(*joint, *of), *c)).collect();
        Combination { parameters, gravity: false, std_over_limit: None }
    }

    fn common_scale() -> Combination {
        of(&[(0, TorqueGain, 0.5), (1, TorqueGain, 0.5), (2, TorqueGain, 0.5)])
    }

    #[test]
    fn a_common_scale_is_one_of_all_joints_that_carry_gravity_in_equal_parts() {
        let session = sarcos_shoulder().session(0);
        let words = |situation: &Situation<'_>, combination: &Combination| situation.report(combination).combination;
        let all = situation(&session);
        assert_eq!(words(&all, &common_scale()), "common scale of all torque gains");
        let unequal = of(&[(0, TorqueGain, 0.5), (1, TorqueGain, 0.4), (2, TorqueGain, 0.5)]);
        let two = of(&[(1, TorqueGain, 0.5), (2, TorqueGain, 0.5)]);
        let with_gravity = Combination { gravity: true, ..common_scale() };
        let with_another = of(&[(0, TorqueGain, 0.5), (1, TorqueGain, 0.5), (2, PositionGain, 0.5)]);
        for other in [unequal, two.clone(), with_gravity, with_another] {
            assert!(!words(&all, &other).contains("common"), "{other:?}");
        }
        let first_is_free = Situation { gravity_free: vec![true, false, false], ..situation(&session) };
        assert_eq!(words(&first_is_free, &two), "common scale of all torque gains");
    }

    /// Each cure is what is missing first.
    #[test]
    fn the_cure_of_a_common_scale_is_the_next_thing_that_is_missing() {
        let full = sarcos_shoulder().session(0);
        let cure = |session: &Session| situation(session).report(&common_scale()).cure;
        let with_poses = |kept: fn(Option<usize>) -> bool| {
            let poses = full.poses.iter().filter(|pose| kept(pose.load)).cloned().collect();
            Session { poses, ..full.clone() }
        };
        assert!(cure(&with_poses(|load| load.is_none())).starts_with("attach a load of known mass to the last link"));
        assert_eq!(cure(&with_poses(|load| load.is_some())), "record bare poses besides the loaded ones");
        let apart = Session { load_distances: Vec::new(), ..full.clone() };
        assert!(cure(&apart).starts_with("record the load at a second placement"));
        assert!(cure(&full).starts_with("state the load's position in the link"));
        let swept = Session { inertia: InertiaPrior::Sweep, ..full.clone() };
        assert!(cure(&swept).starts_with("sweep the joints with the load"));
        let known = InertiaPrior::Model { relative_std: vec![Some(0.1); 3] };
        assert!(cure(&Session { inertia: known, ..full }).starts_with("state a gain as known"));
    }

    #[test]
    fn only_an_upright_first_axis_is_cured_by_a_tilt() {
        let session = sarcos_shoulder().session(0);
        let tilts = |tilt: f64, combination: &Combination| {
            let gravity = [9.8 * tilt.sin(), 0.0, -9.8 * tilt.cos()];
            Situation { gravity, ..situation(&session) }.report(combination).cure.contains("tilt the base")
        };
        let first = of(&[(0, TorqueGain, 1.0), (0, PositionGain, 0.3)]);
        assert!(tilts(0.0, &first) && tilts(0.9 * UPRIGHT, &first) && !tilts(1.1 * UPRIGHT, &first));
        assert!(!tilts(0.0, &of(&[(1, TorqueGain, 1.0)])), "the second axis lies");
        assert!(!tilts(0.0, &of(&[(0, TorqueGain, 1.0), (1, PositionGain, 1.0)])));
    }

    #[test]
    fn a_cause_that_explains_more_is_told_before_others() {
        let session = sarcos_shoulder().session(0);
        let gain = ParameterId::Sensor(1, TorqueGain);
        let alone = of(&[(1, TorqueGain, 1.0)]);
        let why = |situation: Situation<'_>, combination: &Combination| situation.report(combination).why;
        let (on_bound, unread, silent) = (vec![gain], vec![gain], vec![true, false, true]);
        let worst = || Situation { on_bound: on_bound.clone(), unread: unread.clone(), ..situation(&session) };
        assert!(why(worst(), &alone).contains("leans on its constraint"));
        let no_bound = Situation { on_bound: Vec::new(), read: silent.clone(), ..worst() };
        assert_eq!(why(no_bound, &alone), "no reading in use depends on it");
        let unheard = || Situation { read: silent.clone(), ..situation(&session) };
        assert_eq!(why(unheard(), &alone), "no torque reading of joint2 is used");
        assert_eq!(why(unheard(), &of(&[(1, TorqueBias, 1.0)])), "no torque reading of joint2 is used");
        assert!(!why(unheard(), &of(&[(1, PositionOffset, 1.0)])).contains("no torque reading"));
        let gravity = Combination { gravity: true, ..of(&[]) };
        assert!(why(situation(&session), &gravity).contains("too few directions"));
        assert!(why(situation(&session), &alone).contains("masses and moments trade off"));
        let both = of(&[(1, TorqueGain, 1.0), (1, PositionGain, 1.0)]);
        assert_eq!(why(situation(&session), &both), "only their combination acts on the readings");
        assert_eq!(situation(&session).report(&of(&[(1, PositionGain, 1.0)])).cure, MOVE_MORE);
    }

    #[test]
    fn what_is_hopeless_is_not_put_in_numbers() {
        let session = sarcos_shoulder().session(0);
        let why = |ratio: f64| {
            let combination = Combination { std_over_limit: Some(ratio), ..of(&[(1, PositionGain, 1.0)]) };
            situation(&session).report(&combination).why
        };
        assert!(why(2.5).ends_with("(its standard deviation is 2.5 times what would be of use)"));
        assert!(why(1e9).ends_with("(its standard deviation is more than 1000 times what would be of use)"));
    }

    #[test]
    fn further_parameters_are_cured_by_what_each_needs_once() {
        let mut session = sarcos_with_instruments().session(0);
        for (parameter, cure) in session.further.iter_mut().zip(["warm up", "warm up", "cool down"]) {
            parameter.cure = cure.into();
        }
        let parameters = (0..3).map(|place| (ParameterId::Further(place), 1.0)).collect();
        let combination = Combination { parameters, gravity: false, std_over_limit: None };
        assert_eq!(situation(&session).report(&combination).cure, "warm up; cool down");
    }
}
