//! Recording more poses with what is attached already, or with nothing.

use gravcal_dynamics::JointKind;
use gravcal_robot_model::session::InertiaPrior;

use super::addition::Addition;
use crate::check::hypothetical::Hypothetical;

/// How many poses an addition has: few enough to be recorded within an hour by hand.
pub const POSES: usize = 20;
/// A joint without stated limits is supposed to reach this far from the middle of where it was, rad or m.
const REACH_ANGLE: f64 = std::f64::consts::FRAC_PI_2;
const REACH_LENGTH: f64 = 0.2;

/// Poses spread over the joints' limits, with nothing attached or what is attached already.
pub fn more(now: &Hypothetical) -> Vec<Addition> {
    let load = attached(now);
    let words = format!("record {}{}, {}", poses(now, "more "), with(now, load), spread_in_words(now));
    vec![Addition::new(words, move |hypothetical| hypothetical.record(load, spread(hypothetical)))]
}

/// Bare poses where none is.
pub fn bare_besides_loaded(now: &Hypothetical) -> Vec<Addition> {
    if attached(now).is_none() {
        return Vec::new();
    }
    let words = format!("record {} besides the loaded ones, {}", poses(now, "bare "), spread_in_words(now));
    vec![Addition::new(words, |hypothetical| hypothetical.record(None, spread(hypothetical)))]
}

/// Some of the poses again, with one joint where it has not been.
pub fn third_position(now: &Hypothetical) -> Vec<Addition> {
    let load = attached(now);
    let move_joint = |joint: usize| {
        let there = far_from_present(now, joint, load);
        let name = &now.session.robot.chain.joints()[joint].name;
        let angle = shown(now, joint, there);
        let words = format!("record {POSES} of the poses{} again with {name} at {angle}", with(now, load));
        Addition::new(words, move |hypothetical| {
            let moved = |mut coordinates: Vec<f64>| {
                coordinates[joint] = there;
                coordinates
            };
            hypothetical.record(load, some_present(hypothetical, load).into_iter().map(moved).collect());
        })
    };
    (0..now.session.joints.len()).map(move_joint).collect()
}

/// One joint over all of its range, from one of the poses.
pub fn wider_sweep(now: &Hypothetical) -> Vec<Addition> {
    let load = attached(now);
    let sweep = |joint: usize| {
        let [low, high] = range(now, joint);
        let name = &now.session.robot.chain.joints()[joint].name;
        let (from, to) = (shown(now, joint, low), shown(now, joint, high));
        let words = format!("record a sweep of {name} from {from} to {to}{}, {POSES} poses", with(now, load));
        Addition::new(words, move |hypothetical| {
            let Some(held) = some_present(hypothetical, load).into_iter().next() else { return };
            let at = |k: usize| {
                let mut coordinates = held.clone();
                coordinates[joint] = low + (high - low) * k as f64 / (POSES as f64 - 1.0);
                coordinates
            };
            hypothetical.record(load, (0..POSES).map(at).collect());
        })
    };
    (0..now.session.joints.len()).map(sweep).collect()
}

fn spread_in_words(now: &Hypothetical) -> &'static str {
    if now.session.joints.is_empty() { "turned every way" } else { "spread over the joints' whole range" }
}

/// What [`spread`] records, in words.
pub fn poses(now: &Hypothetical, which: &str) -> String {
    match now.session.inertia {
        InertiaPrior::Sweep => format!("{which}sweeps of each joint at two positions of the one before it"),
        _ => format!("{POSES} {which}poses"),
    }
}

/// Coordinates of poses over the joints' whole range: sweeps where poses of no sweep are not used.
pub fn spread(now: &Hypothetical) -> Vec<Vec<f64>> {
    match now.session.inertia {
        InertiaPrior::Sweep => sweeps(now),
        _ => evenly_spread(now),
    }
}

/// Multiples, modulo one, of the powers of the root of `xⁿ⁺¹ = x + 1` (Roberts, *The unreasonable effectiveness of
/// quasirandom sequences*, 2018).
fn evenly_spread(now: &Hypothetical) -> Vec<Vec<f64>> {
    let joints = now.session.joints.len();
    let root = (0..64).fold(1.5_f64, |x, _| (1.0 + x).powf(1.0 / (joints as f64 + 1.0)));
    let share = |pose: usize, joint: usize| (0.5 + (pose as f64 + 1.0) * root.powi(-(joint as i32) - 1)).fract();
    (0..POSES).map(|pose| (0..joints).map(|joint| within(now, joint, share(pose, joint))).collect()).collect()
}

/// Each joint over its range, the one before it at a quarter and at two thirds of its own, the others at a third.
fn sweeps(now: &Hypothetical) -> Vec<Vec<f64>> {
    let joints = now.session.joints.len();
    let rest: Vec<f64> = (0..joints).map(|joint| within(now, joint, 1.0 / 3.0)).collect();
    let mut all = Vec::new();
    for swept in 0..joints {
        for before in [0.25, 2.0 / 3.0] {
            for pose in 0..POSES {
                let mut coordinates = rest.clone();
                if let Some(joint) = swept.checked_sub(1) {
                    coordinates[joint] = within(now, joint, before);
                }
                coordinates[swept] = within(now, swept, pose as f64 / (POSES as f64 - 1.0));
                all.push(coordinates);
            }
        }
    }
    all
}

/// The coordinate at a share of a joint's range.
fn within(now: &Hypothetical, joint: usize, share: f64) -> f64 {
    let [low, high] = range(now, joint);
    low + share * (high - low)
}

/// What is attached in the poses that there are: nothing, if there are bare ones.
pub fn attached(now: &Hypothetical) -> Option<usize> {
    let bare = now.session.poses.iter().any(|pose| pose.load.is_none());
    if bare { None } else { now.session.poses.first().and_then(|pose| pose.load) }
}

/// Coordinates of some poses of a load, or bare ones, evenly chosen.
pub fn some_present(now: &Hypothetical, load: Option<usize>) -> Vec<Vec<f64>> {
    let present: Vec<_> = now.session.poses.iter().filter(|pose| pose.load == load).collect();
    let count = POSES.min(present.len());
    (0..count).map(|k| now.coordinates(present[k * present.len() / count])).collect()
}

/// Where a joint may go: within its limits, or around where it was.
fn range(now: &Hypothetical, joint: usize) -> [f64; 2] {
    let described = &now.session.robot.chain.joints()[joint];
    let [lowest, highest] = extremes(now.session.poses.iter().map(|pose| now.coordinates(pose)[joint]));
    let reach = if described.kind == JointKind::Revolute { REACH_ANGLE } else { REACH_LENGTH };
    let middle = 0.5 * (lowest + highest);
    described.limits.unwrap_or([lowest.min(middle - reach), highest.max(middle + reach)])
}

/// The place in a joint's range that is farthest from where it stands in the poses. A whole half turn does not count as
/// far: there gravity is as it was, but for its sign.
fn far_from_present(now: &Hypothetical, joint: usize, load: Option<usize>) -> f64 {
    let [low, high] = range(now, joint);
    let taken: Vec<f64> = present(now, joint, load).collect();
    let revolute = now.session.robot.chain.joints()[joint].kind == JointKind::Revolute;
    let distance = |place: f64| {
        let away = |other: &f64| if revolute { (place - other).sin().abs() } else { (place - other).abs() };
        taken.iter().map(away).fold(f64::INFINITY, f64::min)
    };
    let places = (0..=PLACES).map(|k| low + (high - low) * k as f64 / PLACES as f64);
    places.max_by(|a, b| distance(*a).total_cmp(&distance(*b))).unwrap_or(low)
}

/// Places of a range that are compared.
const PLACES: usize = 24;

fn present(now: &Hypothetical, joint: usize, load: Option<usize>) -> impl Iterator<Item = f64> {
    let of_load = now.session.poses.iter().filter(move |pose| pose.load == load);
    of_load.map(move |pose| now.coordinates(pose)[joint])
}

fn extremes(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

/// A coordinate of a joint with its unit.
fn shown(now: &Hypothetical, joint: usize, coordinate: f64) -> String {
    match now.session.robot.chain.joints()[joint].kind {
        JointKind::Revolute => format!("{:.0}°", coordinate.to_degrees()),
        JointKind::Prismatic => format!("{coordinate:.3} m"),
    }
}

/// ` with plate-a attached`, or nothing where nothing is.
fn with(now: &Hypothetical, load: Option<usize>) -> String {
    load.map_or_else(String::new, |load| format!(" with load `{}` attached", now.session.loads[load].name))
}
