//! Attaching a load of known mass to a last link.

use gravcal_robot_model::session::{Load, LoadDistance};

use super::addition::Addition;
use super::poses::{poses, spread};
use crate::check::hypothetical::Hypothetical;

/// Mass of a load that is not there yet, kg: what an arm of any size carries.
const MASS: f64 = 1.0;
/// Distance between two placements of it, m, along a direction that is no axis, of unit length.
const DISTANCE: f64 = 0.2;
const DIRECTION: [f64; 3] = [0.6, 0.48, 0.64];
/// Where it hangs in the link's frame, m: supposed, and unknown unless said to be known.
const POSITION: [f64; 3] = [0.05, 0.04, 0.1];
/// How well a position is known that is stated, m.
const POSITION_KNOWN: f64 = 1e-3;

/// A first load, anywhere.
pub fn attached(now: &Hypothetical) -> Vec<Addition> {
    let words = |on: &str| format!("record {} with a load of known mass ({MASS} kg) on {on} besides", poses(now, ""));
    on_unloaded(now, words, |hypothetical, link| {
        let load = hung(hypothetical, (MASS, link), POSITION);
        hypothetical.record(Some(load), spread(hypothetical));
    })
}

/// The same load at another place.
pub fn second_placement(now: &Hypothetical) -> Vec<Addition> {
    let place = |first: usize| {
        let words = format!(
            "record {} with the mass of load `{}` at a second placement a known distance ({DISTANCE} m) from the \
             first (load_distance)",
            poses(now, ""),
            now.session.loads[first].name
        );
        Addition::new(words, move |hypothetical| put_beside(hypothetical, first))
    };
    let hangs = |load: &usize| {
        !now.session.loads[*load].is_unknown() && now.session.poses.iter().any(|pose| pose.load == Some(*load))
    };
    (0..now.session.loads.len()).filter(hangs).map(place).collect()
}

/// A first load, at a known place.
pub fn at_known_position(now: &Hypothetical) -> Vec<Addition> {
    let words = |on: &str| {
        format!(
            "record {} with a load of known mass ({MASS} kg) besides, at a position in {on} known within {} mm (position_m)",
            poses(now, ""),
            1e3 * POSITION_KNOWN
        )
    };
    on_unloaded(now, words, |hypothetical, link| {
        let load = hung(hypothetical, (MASS, link), POSITION);
        hypothetical.session.loads[load].position = Some(POSITION);
        hypothetical.session.loads[load].position_std = Some(POSITION_KNOWN);
        hypothetical.record(Some(load), spread(hypothetical));
    })
}

/// A first load at two places.
pub fn two_placements(now: &Hypothetical) -> Vec<Addition> {
    let words = |on: &str| {
        format!(
            "record {} each with a load of known mass ({MASS} kg) at two placements a known distance ({DISTANCE} m) apart \
             on {on} (load_distance)",
            poses(now, "")
        )
    };
    on_unloaded(now, words, |hypothetical, link| {
        let load = hung(hypothetical, (MASS, link), POSITION);
        hypothetical.record(Some(load), spread(hypothetical));
        put_beside(hypothetical, load);
    })
}

/// An addition for each branch that carries no load yet: `words` for its last link, and what to make of it.
fn on_unloaded(
    now: &Hypothetical,
    words: impl Fn(&str) -> String,
    make: impl Fn(&mut Hypothetical, usize) + Copy + 'static,
) -> Vec<Addition> {
    let (session, chain) = (&now.session, &now.session.robot.chain);
    let name = |link: usize| match chain.is_serial() {
        true => "the last link".to_owned(),
        false => format!("link {}", chain.links()[link].name),
    };
    let on_the_way = |last: usize, link: usize| {
        std::iter::successors(Some(last), |link| chain.parent(*link)).any(|before| before == link)
    };
    let known = |load: &usize| !session.loads[*load].is_unknown();
    let loads = || session.poses.iter().filter_map(|pose| pose.load).filter(known);
    let loaded = |last: usize| loads().any(|load| on_the_way(last, session.loads[load].link));
    let addition = |link: usize| Addition::new(words(&name(link)), move |hypothetical| make(hypothetical, link));
    chain.last_links().filter(|link| !loaded(*link)).map(addition).collect()
}

/// Hangs a load on a link of the robot; gives its index.
fn hung(hypothetical: &mut Hypothetical, (mass, link): (f64, usize), position: [f64; 3]) -> usize {
    let loads = &mut hypothetical.session.loads;
    loads.push(Load { name: format!("supposed {}", loads.len()), mass, link, position: None, position_std: None });
    hypothetical.values.loads.push(position);
    hypothetical.session.loads.len() - 1
}

/// The mass of a load at a known distance from it, with poses.
fn put_beside(hypothetical: &mut Hypothetical, first: usize) {
    let from = hypothetical.values.loads[first];
    let position = [0, 1, 2].map(|axis| from[axis] + DISTANCE * DIRECTION[axis]);
    let like = &hypothetical.session.loads[first];
    let second = hung(hypothetical, (like.mass, like.link), position);
    hypothetical.session.load_distances.push(LoadDistance { between: [first, second], distance: DISTANCE, std: None });
    hypothetical.record(Some(second), spread(hypothetical));
}
