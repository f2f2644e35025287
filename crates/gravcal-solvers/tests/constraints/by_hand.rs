//! Small problems whose optimum and multipliers are calculated in the comment.

use gravcal_estimation::{Affine, Constraint, Estimate, ProblemBuilder};

use crate::build::{active, block, build, near, readings, solve};

/// The method ends at cosines of 1e-10.
const EXACT: f64 = 1e-9;

/// The readings of one block, and the constraints on it.
fn read(
    values: &[f64],
    start: &[f64],
    constraints: impl FnOnce(gravcal_estimation::BlockId) -> Vec<Constraint>,
) -> Estimate {
    let mut builder = ProblemBuilder::new();
    let id = builder.add_block(block("x", values.len()), start);
    readings(&mut builder, id, values);
    constraints(id).into_iter().for_each(|c| builder.add_constraint(c));
    let (problem, initial) = builder.build().unwrap();
    let estimate = solve(&problem, &initial).unwrap();
    assert!(estimate.termination.converged(), "{}", estimate.termination);
    estimate
}

/// Sum and difference of two masses are weighed as 1 and 3: `½ (m1 + m2 − 1)² + ½ (m1 − m2 − 3)²`, whose optimum
/// is m1 = 2, m2 = −1.
///
/// With m2 ≥ 0: at m2 = 0 the slope by m1 is (m1 − 1) + (m1 − 3) = 0, so m1 = 2, and the cost ½ + ½ = 1. The slope by m2 is
/// (m1 − 1) − (m1 − 3) = 2: with m2 = −ε the cost falls by 2 ε. The multiplier is 2.
#[test]
fn a_negative_mass_ends_at_zero() {
    let weighed = |x: &[f64], r: &mut [f64], j: &mut [f64]| {
        r.copy_from_slice(&[x[0] + x[1] - 1.0, x[0] - x[1] - 3.0]);
        j.copy_from_slice(&[1.0, 1.0, 1.0, -1.0]);
    };
    let positive = |id| {
        let positive = |i, name: &str| Constraint::bound(name, id, i, 0.0, f64::INFINITY);
        vec![positive(0, "m1 is positive"), positive(1, "m2 is positive")]
    };
    let (problem, initial, id) = build(&[1.0, 1.0], 2, weighed, |_| Vec::new());
    let free = solve(&problem, &initial).unwrap();
    assert!(near(free.values.get(id), &[2.0, -1.0], EXACT) && free.active.is_empty());
    let (problem, initial, id) = build(&[1.0, 1.0], 2, weighed, positive);
    let estimate = solve(&problem, &initial).unwrap();
    assert!(estimate.termination.converged(), "{}", estimate.termination);
    assert!(near(estimate.values.get(id), &[2.0, 0.0], EXACT), "{:?}", estimate.values);
    assert_eq!(estimate.values.get(id)[1], 0.0);
    assert!((estimate.cost - 1.0).abs() < EXACT);
    let [(name, multiplier)] = active(&estimate)[..] else { panic!("{:?}", estimate.active) };
    assert_eq!(name, "m2 is positive");
    assert!((multiplier - 2.0).abs() < EXACT, "{multiplier}");
}

/// (3, 4, 0) is read, at most 1 is allowed: the nearest is (0.6, 0.8, 0) at distance 4, and the cost ½ (5 − R)² falls
/// by 5 − R = 4 for each unit of R. Where 6 is allowed, nothing is in the way.
#[test]
fn a_ball_holds_a_vector() {
    let within =
        |radius| read(&[3.0, 4.0, 0.0], &[0.1, 0.2, 0.3], |id| vec![Constraint::ball("ball", id, &[0.0; 3], radius)]);
    let held = within(1.0);
    assert!(near(&held.values.as_slice()[..3], &[0.6, 0.8, 0.0], EXACT), "{:?}", held.values);
    let [("ball", multiplier)] = active(&held)[..] else { panic!("{:?}", held.active) };
    assert!((multiplier - 4.0).abs() < EXACT, "{multiplier}");
    let free = within(6.0);
    assert!(near(free.values.as_slice(), &[3.0, 4.0, 0.0], EXACT) && free.active.is_empty());
}

fn centre_of_mass(id: gravcal_estimation::BlockId, centre: [f64; 3], radius: f64) -> Constraint {
    let off_centre = |i: usize| Affine::component(id, i + 1).plus(id, 0, -centre[i]);
    Constraint::cone("centre of mass", (0..3).map(off_centre).collect(), Affine::default().plus(id, 0, radius))
}

/// Mass 1 and moment h = (0, 0, 2) are read, the centre of mass is at most 0.5 from the origin: ‖h‖ ≤ m/2. The nearest
/// point of the line h = m/2 to (1, 2) is (1.6, 0.8). With the residuals (0.6, −1.2) and the slope (−½, 1) of
/// ‖h‖ − m/2, the multiplier is 1.2.
///
/// The same about the centre (0.1, 0, 0.2), the readings moved along: h = m c + (0, 0, 2) with m = 1.
#[test]
fn a_centre_of_mass_stays_within_its_ball() {
    let near_origin = read(&[1.0, 0.0, 0.0, 2.0], &[1.0, 0.0, 0.0, 0.0], |id| vec![centre_of_mass(id, [0.0; 3], 0.5)]);
    assert!(near(near_origin.values.as_slice(), &[1.6, 0.0, 0.0, 0.8], EXACT), "{:?}", near_origin.values);
    let [(_, multiplier)] = active(&near_origin)[..] else { panic!("{:?}", near_origin.active) };
    assert!((multiplier - 1.2).abs() < EXACT, "{multiplier}");
    // ½ m − h_z: what the cone holds.
    let mut slope = [0.0; 4];
    near_origin.active[0].holds[0].terms.iter().for_each(|(_, i, c)| slope[*i] += c);
    assert!(near(&slope, &[0.5, 0.0, 0.0, -1.0], EXACT), "{slope:?}");
    let inside = read(&[1.0, 0.1, 0.0, 0.2], &[1.0, 0.0, 0.0, 0.0], |id| vec![centre_of_mass(id, [0.0; 3], 0.5)]);
    assert!(near(inside.values.as_slice(), &[1.0, 0.1, 0.0, 0.2], EXACT) && inside.active.is_empty());
    let centre = [0.1, 0.0, 0.2];
    let off = read(&[1.0, 0.1, 0.0, 2.2], &[1.0, 0.1, 0.0, 0.2], |id| vec![centre_of_mass(id, centre, 0.5)]);
    let [m, x, _, z] = off.values.as_slice()[..] else { panic!() };
    assert!((x - 0.1 * m).hypot(z - 0.2 * m) - 0.5 * m < EXACT && off.active.len() == 1);
}

/// A negative mass is read, m = −1 and h = (0, 0, 0.1). Of all masses and moments with ‖h‖ ≤ m/2 the nearest is none
/// at all: the tip of the cone. If the cone gives way by ε, m = −2ε with h = 0 obeys it, and the cost ½ (1 + m)² falls by
/// 2 ε: the multiplier is 2.
///
/// With m ≥ 0 demanded besides, nothing changes, and the two share what holds the mass: ½ z₁ + z₂ = 1.
#[test]
fn a_cone_is_touched_at_its_tip() {
    let reading = [-1.0, 0.0, 0.0, 0.1];
    let start = [1.0, 0.1, 0.1, 0.1];
    let alone = read(&reading, &start, |id| vec![centre_of_mass(id, [0.0; 3], 0.5)]);
    assert!(near(alone.values.as_slice(), &[0.0; 4], EXACT), "{:?}", alone.values);
    let [(_, multiplier)] = active(&alone)[..] else { panic!("{:?}", alone.active) };
    assert!((multiplier - 2.0).abs() < EXACT, "{multiplier}");
    assert_eq!(alone.active[0].holds.len(), 4);
    let both = read(&reading, &start, |id| {
        vec![centre_of_mass(id, [0.0; 3], 0.5), Constraint::bound("positive", id, 0, 0.0, f64::INFINITY)]
    });
    assert!(near(both.values.as_slice(), &[0.0; 4], EXACT), "{:?}", both.values);
    let multiplier = |name: &str| active(&both).iter().find(|(n, _)| *n == name).map_or(0.0, |(_, z)| *z);
    let (cone, bound) = (multiplier("centre of mass"), multiplier("positive"));
    assert!(cone >= 0.0 && bound >= 0.0 && (0.5 * cone + bound - 1.0).abs() < 1e-9, "{cone}, {bound}");
}

/// x and y are both read as 1 and must sum to 1: both are ½. For a sum c the cost is (c/2 − 1)², which falls by ½ for each
/// unit by which c grows. If they must sum to 4, both are 2, and the cost rises by 1.
#[test]
fn the_multiplier_of_an_equation_has_the_sign_of_what_its_value_does() {
    for (sum, expected) in [(1.0, 0.5), (4.0, -1.0)] {
        let estimate = read(&[1.0, 1.0], &[0.25 * sum, 0.75 * sum], |id| {
            vec![Constraint::range("sum", Affine::default().plus(id, 0, 1.0).plus(id, 1, 1.0), sum, sum)]
        });
        assert!(near(estimate.values.as_slice(), &[0.5 * sum; 2], EXACT), "{:?}", estimate.values);
        let [("sum", multiplier)] = active(&estimate)[..] else { panic!("{:?}", estimate.active) };
        assert!((multiplier - expected).abs() < EXACT, "{multiplier}");
    }
}

/// Only the sum of x and y is read, as 3 and as 3.2. The bounds x ≤ 1 and y ≤ 1.5 leave at most 2.5: the cost
/// ½ (s − 3)² + ½ (s − 3.2)² falls there by 0.5 + 0.7 = 1.2 for each unit of either.
///
/// Where the bounds leave more, the data say nothing of the difference, and it stays where it started.
#[test]
fn bounds_hold_what_the_data_do_not_determine() {
    let sum = |x: &[f64], r: &mut [f64], j: &mut [f64]| {
        r.copy_from_slice(&[x[0] + x[1] - 3.0, x[0] + x[1] - 3.2]);
        j.fill(1.0);
    };
    let bounded = |limits: [f64; 2], start: &[f64]| {
        let (problem, initial, _) = build(start, 2, sum, |id| {
            let below = |i: usize| Constraint::bound(["x", "y"][i], id, i, f64::NEG_INFINITY, limits[i]);
            vec![below(0), below(1)]
        });
        solve(&problem, &initial).unwrap()
    };
    let corner = bounded([1.0, 1.5], &[-3.0, 1.0]);
    assert!(corner.termination.converged(), "{}", corner.termination);
    assert!(near(corner.values.as_slice(), &[1.0, 1.5], EXACT), "{:?}", corner.values);
    let [("x", of_x), ("y", of_y)] = active(&corner)[..] else { panic!("{:?}", corner.active) };
    assert!((of_x - 1.2).abs() < EXACT && (of_y - 1.2).abs() < EXACT);
    let one = bounded([1.0, 9.0], &[0.0, 0.0]);
    assert!(near(one.values.as_slice(), &[1.0, 2.1], 1e-9) && one.active.is_empty(), "{one:?}");
    let none = bounded([8.0, 9.0], &[0.0, 1.0]);
    assert!(near(none.values.as_slice(), &[1.05, 2.05], 1e-9) && none.active.is_empty(), "{:?}", none.values);
}

/// x = −1 is read and x ≥ 0 demanded three times, once in other words: what holds x back, 1, is shared.
#[test]
fn what_is_said_twice_does_no_harm() {
    let estimate = read(&[-1.0], &[3.0], |id| {
        let bound = |name: &str| Constraint::bound(name, id, 0, 0.0, f64::INFINITY);
        vec![
            bound("a"),
            bound("b"),
            Constraint::range("c", Affine::default().plus(id, 0, -5.0), f64::NEG_INFINITY, 0.0),
        ]
    });
    assert_eq!(estimate.values.as_slice(), [0.0]);
    let total: f64 = active(&estimate).iter().map(|(name, z)| if *name == "c" { 5.0 * z } else { *z }).sum();
    assert!((total - 1.0).abs() < EXACT && active(&estimate).iter().all(|(_, z)| *z >= 0.0), "{estimate:?}");
}

/// What is read lies exactly on the limit: nothing leans on it.
///
/// The same beside a limit that holds: x − y is read as 0 and y as −1, both may not be negative. Without limits both are −1;
/// at (0, 0) the slope by y is 1, that by x is 0.
#[test]
fn a_constraint_that_only_touches_is_not_active() {
    let difference = |x: &[f64], r: &mut [f64], j: &mut [f64]| {
        r.copy_from_slice(&[x[0] - x[1], x[1] + 1.0]);
        j.copy_from_slice(&[1.0, -1.0, 0.0, 1.0]);
    };
    let (problem, initial, _) = build(&[3.0, 4.0], 2, difference, |id| {
        let positive = |i: usize| Constraint::bound(["x", "y"][i], id, i, 0.0, f64::INFINITY);
        vec![positive(0), positive(1)]
    });
    let estimate = solve(&problem, &initial).unwrap();
    assert!(near(estimate.values.as_slice(), &[0.0, 0.0], EXACT), "{estimate:?}");
    let [("y", multiplier)] = active(&estimate)[..] else { panic!("{:?}", estimate.active) };
    assert!((multiplier - 1.0).abs() < EXACT, "{multiplier}");
    let estimate = read(&[0.0, 2.0], &[3.0, 4.0], |id| {
        vec![Constraint::bound("x", id, 0, 0.0, f64::INFINITY), Constraint::bound("y", id, 1, 2.0, 5.0)]
    });
    assert!(near(estimate.values.as_slice(), &[0.0, 2.0], EXACT) && estimate.active.is_empty(), "{estimate:?}");
}
