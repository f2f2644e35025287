//! Where the loads hang: blocks for their centres of mass.
//!
//! A placement is a position of its own, or, at an exactly known distance d from another, that one's position plus a
//! vector on the sphere of radius d: the distance then holds exactly, as gravity's norm does. Distances that are
//! uncertain, or would close a circle, are residuals.
//!
//! Where moments are described by sweep, only the difference of two placements counts. Of the loads that are alike (one
//! mass, one link) the others are then counted from one, whose position is fixed at zero, unless one of them is known.

use gravcal_estimation::{Block, BlockId, ProblemBuilder, Sphere};
use gravcal_robot_model::session::{Load, Session};

use crate::joint::building::sweep_moments::by_sweep;
use crate::joint::variables::{Placement, State};

/// Whether readings are affine in masses, moments and placements: no sensor's model is curved, and no joint gives way under what it carries.
pub(in crate::joint) fn is_straight(session: &Session) -> bool {
    session.terms.are_straight() && session.compliances().is_empty()
}

/// Adds the blocks of all carried loads; distances enter only if `exact_distances`.
pub(in crate::joint) fn add_placements(
    session: &Session,
    carried: &[bool],
    start: &State,
    exact_distances: bool,
    builder: &mut ProblemBuilder,
) -> Vec<Option<Placement>> {
    let mut placements: Vec<Option<Placement>> = vec![None; session.loads.len()];
    let parents = if exact_distances { parents(session, carried) } else { vec![None; session.loads.len()] };
    let start = relative_placements(session, &start.loads);
    let curved = match (exact_distances, is_straight(session)) {
        (false, _) => vec![false; session.loads.len()],
        (true, true) => in_residuals(session, carried),
        (true, false) => vec![true; session.loads.len()],
    };
    // Parents first: a chain of placements is no longer than the loads.
    for _ in 0..session.loads.len() {
        for load in (0..session.loads.len()).filter(|load| carried[*load]) {
            if placements[load].is_some() {
                continue;
            }
            placements[load] = match parents[load] {
                None => {
                    let block = position_block(session, load, curved[load]);
                    let block = if is_reference(session, load) { block.fixed(REFERENCE) } else { block };
                    Some(vec![builder.add_block(block, &start[load])])
                }
                Some((parent, distance)) => placements[parent].clone().map(|mut blocks| {
                    blocks.push(add_displacement(session, load, (parent, distance), &start, builder));
                    blocks
                }),
            };
        }
    }
    placements
}

/// Indices of the known distances that the placements do not hold by themselves.
pub(in crate::joint) fn distances_left(session: &Session, carried: &[bool]) -> Vec<usize> {
    let parents = parents(session, carried);
    let fixed = |index: usize| {
        let [a, b] = session.load_distances[index].between;
        let exact = session.load_distances[index].std.is_none();
        let is_parent = |child: usize, parent: usize| parents[child].is_some_and(|(p, _)| p == parent);
        exact && (is_parent(b, a) || is_parent(a, b))
    };
    (0..session.load_distances.len()).filter(|index| !fixed(*index)).collect()
}

/// For each load whether a distance that is a residual reads its position.
fn in_residuals(session: &Session, carried: &[bool]) -> Vec<bool> {
    let parents = parents(session, carried);
    let mut read = vec![false; session.loads.len()];
    for index in distances_left(session, carried) {
        for end in session.load_distances[index].between {
            let mut next = Some(end);
            while let Some(load) = next {
                read[load] = true;
                next = parents[load].map(|(parent, _)| parent);
            }
        }
    }
    read
}

/// For each load the placement that it is tied to, and the distance in m.
fn parents(session: &Session, carried: &[bool]) -> Vec<Option<(usize, f64)>> {
    let mut parents: Vec<Option<(usize, f64)>> = vec![None; session.loads.len()];
    for known in session.load_distances.iter().filter(|known| known.std.is_none()) {
        let [a, b] = known.between;
        let ties = |child: usize, parent: usize, parents: &[Option<(usize, f64)>]| {
            let mut root = parent;
            while let Some((next, _)) = parents[root] {
                root = next;
            }
            let free = session.loads[child].position.is_none() && !is_reference(session, child);
            parents[child].is_none() && free && root != child
        };
        if !(carried[a] && carried[b]) {
            continue;
        }
        if ties(b, a, &parents) {
            parents[b] = Some((a, known.distance));
        } else if ties(a, b, &parents) {
            parents[a] = Some((b, known.distance));
        }
    }
    parents
}

/// Why the position is fixed from which others are counted.
const REFERENCE: &str = "only differences of placements count where moments are described by sweep";

/// The first load of the same mass on the same link: the two differ by their placement only.
pub(in crate::joint) fn first_alike(session: &Session, load: usize) -> usize {
    let of = |load: &Load| (load.mass, load.link);
    session.loads.iter().position(|other| of(other) == of(&session.loads[load])).unwrap_or(load)
}

/// Whether the placements of the loads alike are counted from this one.
fn is_reference(session: &Session, load: usize) -> bool {
    reference(session, load) == Some(load)
}

/// The load from whose placement this one's is counted, if from any.
fn reference(session: &Session, load: usize) -> Option<usize> {
    let first = first_alike(session, load);
    let alike = || (0..session.loads.len()).filter(move |other| first_alike(session, *other) == first);
    let known = alike().any(|other| session.loads[other].position.is_some());
    (by_sweep(session) && !known).then_some(first)
}

/// The placements as they are counted.
pub(in crate::joint) fn relative_placements(session: &Session, placements: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let counted = |load: usize| match reference(session, load) {
        Some(reference) => std::array::from_fn(|axis| placements[load][axis] - placements[reference][axis]),
        None => placements[load],
    };
    (0..placements.len()).map(counted).collect()
}

fn position_block(session: &Session, load: usize, curved: bool) -> Block {
    let load = &session.loads[load];
    let block = Block::vector(format!("load.{}.position", load.name), "m", &["x", "y", "z"]);
    let block = if curved { block } else { block.linear() };
    match (load.position, load.position_std) {
        (Some(_), None) => block.fixed("its position in the link is given as exact"),
        _ => block,
    }
}

fn add_displacement(
    session: &Session,
    load: usize,
    (parent, distance): (usize, f64),
    start: &[[f64; 3]],
    builder: &mut ProblemBuilder,
) -> BlockId {
    let difference = nalgebra::Vector3::from(start[load]) - nalgebra::Vector3::from(start[parent]);
    let direction = difference.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(nalgebra::Vector3::x);
    let name = format!("load.{}.displacement_from.{}", session.loads[load].name, session.loads[parent].name);
    let block = Block::vector(name, "m", &["x", "y", "z"]).on(Sphere { radius: distance });
    builder.add_block(block, (distance * direction).as_slice())
}
