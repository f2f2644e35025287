//! Problems of Hock and Schittkowski, *Test examples for nonlinear programming codes*, 1981, that are least squares under
//! constraints that the method takes: number, start, minimum and minimiser from there, but for starts that lie outside.
//! The published minimum is of Σ r².

use gravcal_estimation::{Affine, BlockId, Constraint};

use crate::build::{build, near, solve};

type Model = fn(&[f64], &mut [f64], &mut [f64]);

struct Published {
    number: usize,
    start: &'static [f64],
    rows: usize,
    model: Model,
    constraints: fn(BlockId) -> Vec<Constraint>,
    minimum: f64,
    /// Empty where only the minimum is published.
    minimiser: &'static [f64],
}

fn sum(id: BlockId, coefficients: &[f64]) -> Affine {
    coefficients.iter().enumerate().fold(Affine::default(), |f, (i, c)| f.plus(id, i, *c))
}

fn equation(name: &str, id: BlockId, coefficients: &[f64], value: f64) -> Constraint {
    Constraint::range(name, sum(id, coefficients), value, value)
}

/// r = M x − b.
fn affine(matrix: &[f64], constant: &[f64], x: &[f64], r: &mut [f64], j: &mut [f64]) {
    j.copy_from_slice(matrix);
    for (i, row) in matrix.chunks(x.len()).enumerate() {
        r[i] = row.iter().zip(x).map(|(m, x)| m * x).sum::<f64>() - constant[i];
    }
}

fn rosenbrock(x: &[f64], r: &mut [f64], j: &mut [f64]) {
    r.copy_from_slice(&[10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]);
    j.copy_from_slice(&[-20.0 * x[0], 10.0, -1.0, 0.0]);
}

fn three_sums(id: BlockId) -> Vec<Constraint> {
    vec![
        equation("first", id, &[1.0, 3.0, 0.0, 0.0, 0.0], 0.0),
        equation("second", id, &[0.0, 0.0, 1.0, 1.0, -2.0], 0.0),
        equation("third", id, &[0.0, 1.0, 0.0, 0.0, -1.0], 0.0),
    ]
}

const PROBLEMS: &[Published] = &[
    Published {
        number: 1,
        start: &[-2.0, 1.0],
        rows: 2,
        model: rosenbrock,
        constraints: |id| vec![Constraint::bound("x2", id, 1, -1.5, f64::INFINITY)],
        minimum: 0.0,
        minimiser: &[1.0, 1.0],
    },
    // From (−2, 1), which lies outside, moved to the bound. 2a cos(⅓ arccos 1/b), a = √(598/1200), b = 400 a³.
    Published {
        number: 2,
        start: &[2.0, 1.5],
        rows: 2,
        model: rosenbrock,
        constraints: |id| vec![Constraint::bound("x2", id, 1, 1.5, f64::INFINITY)],
        minimum: 0.0504261879,
        minimiser: &[1.22437075, 1.5],
    },
    // From (−1, −1), which lies outside. The constant −100 is left out.
    Published {
        number: 21,
        start: &[5.0, -1.0],
        rows: 2,
        model: |x, r, j| affine(&[0.1, 0.0, 0.0, 1.0], &[0.0, 0.0], x, r, j),
        constraints: |id| {
            vec![
                Constraint::range("linear", sum(id, &[10.0, -1.0]), 10.0, f64::INFINITY),
                Constraint::bound("x1", id, 0, 2.0, 50.0),
                Constraint::bound("x2", id, 1, -50.0, 50.0),
            ]
        },
        minimum: 0.04,
        minimiser: &[2.0, 0.0],
    },
    // From (−4, 1, 1), which lies outside.
    Published {
        number: 28,
        start: &[-4.0, 1.0, 1.0],
        rows: 2,
        model: |x, r, j| affine(&[1.0, 1.0, 0.0, 0.0, 1.0, 1.0], &[0.0, 0.0], x, r, j),
        constraints: |id| vec![equation("sum", id, &[1.0, 2.0, 3.0], 1.0)],
        minimum: 0.0,
        minimiser: &[0.5, -0.5, 0.5],
    },
    // From (1, 1, 1, 1), which lies outside. x3² + x4² = 2 is the length of a block there: see `number_42`.
    Published {
        number: 48,
        start: &[3.0, 5.0, -3.0, 2.0, -2.0],
        rows: 3,
        model: |x, r, j| {
            let m = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, -1.0];
            affine(&m, &[1.0, 0.0, 0.0], x, r, j);
        },
        constraints: |id| {
            vec![equation("all", id, &[1.0; 5], 5.0), equation("last", id, &[0.0, 0.0, 1.0, -2.0, -2.0], -3.0)]
        },
        minimum: 0.0,
        minimiser: &[1.0; 5],
    },
    Published {
        number: 51,
        start: &[2.5, 0.5, 2.0, -1.0, 0.5],
        rows: 4,
        model: |x, r, j| {
            #[rustfmt::skip]
            let m = [
                1.0, -1.0, 0.0, 0.0, 0.0,
                0.0, 1.0, 1.0, 0.0, 0.0,
                0.0, 0.0, 0.0, 1.0, 0.0,
                0.0, 0.0, 0.0, 0.0, 1.0,
            ];
            affine(&m, &[0.0, 2.0, 1.0, 1.0], x, r, j);
        },
        constraints: |id| {
            vec![
                equation("first", id, &[1.0, 3.0, 0.0, 0.0, 0.0], 4.0),
                equation("second", id, &[0.0, 0.0, 1.0, 1.0, -2.0], 0.0),
                equation("third", id, &[0.0, 1.0, 0.0, 0.0, -1.0], 0.0),
            ]
        },
        minimum: 0.0,
        minimiser: &[1.0; 5],
    },
    // From (2, 2, 2, 2, 2), which lies outside. Minimum 1859/349.
    Published {
        number: 52,
        start: &[0.0; 5],
        rows: 4,
        model: |x, r, j| {
            #[rustfmt::skip]
            let m = [
                4.0, -1.0, 0.0, 0.0, 0.0,
                0.0, 1.0, 1.0, 0.0, 0.0,
                0.0, 0.0, 0.0, 1.0, 0.0,
                0.0, 0.0, 0.0, 0.0, 1.0,
            ];
            affine(&m, &[0.0, 2.0, 1.0, 1.0], x, r, j);
        },
        constraints: three_sums,
        minimum: 1859.0 / 349.0,
        minimiser: &[-33.0 / 349.0, 11.0 / 349.0, 180.0 / 349.0, -158.0 / 349.0, 11.0 / 349.0],
    },
    // From (2, 2, 2, 2, 2), which lies outside. Minimum 176/43.
    Published {
        number: 53,
        start: &[0.0; 5],
        rows: 4,
        model: |x, r, j| {
            #[rustfmt::skip]
            let m = [
                1.0, -1.0, 0.0, 0.0, 0.0,
                0.0, 1.0, 1.0, 0.0, 0.0,
                0.0, 0.0, 0.0, 1.0, 0.0,
                0.0, 0.0, 0.0, 0.0, 1.0,
            ];
            affine(&m, &[0.0, 2.0, 1.0, 1.0], x, r, j);
        },
        constraints: |id| {
            let bound = |i| Constraint::bound(format!("bound {i}"), id, i, -10.0, 10.0);
            three_sums(id).into_iter().chain((0..5).map(bound)).collect()
        },
        minimum: 176.0 / 43.0,
        minimiser: &[-33.0 / 43.0, 11.0 / 43.0, 27.0 / 43.0, -5.0 / 43.0, 11.0 / 43.0],
    },
    // From (−5, 5, 0), which lies outside.
    Published {
        number: 65,
        start: &[-4.0, 4.0, 0.0],
        rows: 3,
        model: |x, r, j| {
            let third = 1.0 / 3.0;
            let m = [1.0, -1.0, 0.0, third, third, 0.0, 0.0, 0.0, 1.0];
            affine(&m, &[0.0, 10.0 / 3.0, 5.0], x, r, j);
        },
        constraints: |id| {
            vec![
                Constraint::ball("ball", id, &[0.0; 3], 48f64.sqrt()),
                Constraint::bound("x1", id, 0, -4.5, 4.5),
                Constraint::bound("x2", id, 1, -4.5, 4.5),
                Constraint::bound("x3", id, 2, -5.0, 5.0),
            ]
        },
        minimum: 0.9535288567,
        minimiser: &[3.650461821, 3.650461682, 4.620417051],
    },
];

#[test]
fn published_minima_are_reached() {
    for Published { number, start, rows, model, constraints, minimum, minimiser } in PROBLEMS {
        let (problem, initial, id) = build(start, *rows, *model, constraints);
        let estimate = solve(&problem, &initial).unwrap();
        let (found, cost) = (estimate.values.get(id), 2.0 * estimate.cost);
        assert!(estimate.termination.converged(), "number {number}: {}", estimate.termination);
        assert!((cost - minimum).abs() <= 2e-9 * minimum.max(1e-9), "number {number}: {cost}, not {minimum}");
        assert!(near(found, minimiser, 1e-6), "number {number}: {found:?}, not {minimiser:?}");
        assert!(problem.constraints().iter().all(|c| c.violation(&estimate.values) <= 1e-14), "number {number}");
    }
}
