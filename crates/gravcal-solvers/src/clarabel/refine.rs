//! The last digits of a conic programme's solution.
//!
//! An interior point comes close to where rows hold with equality, and tells which do. On those Newton's method
//! solves the conditions of optimality
//!
//! ```text
//!     K w + q − Nᵀ z = 0,     c(w) = 0,     N = ∂c/∂w
//! ```
//!
//! where `c` holds, of a range or an equation, its `s`; of a cone touched on its side, `s₁ − ‖s₂…‖`; of a cone touched at its
//! tip, all of its `s` (Nocedal and Wright, *Numerical optimization*, 2006, section 16.2, null-space method). N may have
//! dependent rows: what these leave open of `z` stays as the interior point has it, which lies amid all answers.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::programme::{Quadratic, Solution};
use super::rows::{Cone, Rows, norm};

/// Newton steps: from eight digits to all in one or two.
const STEPS: usize = 3;
/// Singular values of N (rows of length one) below this are zero.
const DEPENDENT: f64 = 1e-9;
/// Duals may be on the wrong side of zero, and rows beyond their cones, by this.
const ROUNDING: f64 = 1e-11;

/// How rows hold at a solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Touch {
    /// Inside: z is zero.
    Not,
    /// On the side of a second-order cone.
    Side,
    /// Equation, range at its limit, or tip of a cone: s is zero.
    Fully,
}

/// The solution near `found`; `None` where it is not one.
pub(super) fn refine(quadratic: &Quadratic, rows: &[Rows], found: &Solution) -> Option<Solution> {
    let mut touches: Vec<Touch> = rows.iter().zip(&found.duals).map(|(r, z)| touch(r, &r.at(&found.step), z)).collect();
    // Each round lets go of rows that pull, or takes up rows that were broken.
    for _ in 0..=rows.len() {
        let refined = newton(quadratic, rows, &touches, found)?;
        let corrected: Vec<Touch> = (0..rows.len()).map(|i| corrected(&rows[i], touches[i], &refined, i)).collect();
        if corrected == touches {
            let kept = |r: &Rows| r.excess(&r.at(&refined.step)) <= ROUNDING * (1.0 + norm(&r.slack));
            return rows.iter().all(kept).then_some(refined);
        }
        touches = corrected;
    }
    None
}

/// By which of `s` and `z` is larger, in each eigenvalue of a second-order cone.
fn touch(rows: &Rows, s: &[f64], z: &[f64]) -> Touch {
    let low_and_high = |v: &[f64]| (v[0] - norm(&v[1..]), v[0] + norm(&v[1..]));
    match rows.cone {
        Cone::Equation => Touch::Fully,
        Cone::Nonnegative if z[0] > s[0] => Touch::Fully,
        Cone::Nonnegative => Touch::Not,
        Cone::SecondOrder => {
            let ((s_low, s_high), (z_low, z_high)) = (low_and_high(s), low_and_high(z));
            match (s_low > z_high, s_high < z_low) {
                (true, _) => Touch::Not,
                (_, true) => Touch::Fully,
                _ => Touch::Side,
            }
        }
    }
}

/// How rows should be taken instead.
fn corrected(rows: &Rows, touch: Touch, at: &Solution, index: usize) -> Touch {
    let (s, z) = (rows.at(&at.step), &at.duals[index]);
    let broken = || rows.excess(&s) > ROUNDING * (1.0 + norm(&rows.slack));
    match (touch, rows.cone) {
        (Touch::Not, Cone::SecondOrder) if broken() => Touch::Side,
        (Touch::Not, _) if broken() => Touch::Fully,
        (Touch::Fully, Cone::Nonnegative) | (Touch::Side, _) if z[0] < -ROUNDING => Touch::Not,
        (Touch::Fully, Cone::SecondOrder) if rows.excess(z) > ROUNDING => Touch::Side,
        _ => touch,
    }
}

/// The conditions that hold with equality: residual, normal and dual of each, and who they belong to.
struct Conditions {
    residual: Vec<f64>,
    normals: Vec<Vec<f64>>,
    duals: Vec<f64>,
}

fn newton(quadratic: &Quadratic, rows: &[Rows], touches: &[Touch], found: &Solution) -> Option<Solution> {
    let mut at = found.clone();
    for (z, touch) in at.duals.iter_mut().zip(touches) {
        if *touch == Touch::Not {
            z.fill(0.0);
        }
    }
    for _ in 0..STEPS {
        let conditions = conditions(rows, touches, &at)?;
        let curvature = curvature(quadratic, rows, touches, &at);
        let (step, duals) = newton_step(quadratic, &curvature, &conditions, &at.step)?;
        at.step.iter_mut().zip(&step).for_each(|(w, d)| *w += d);
        store_duals(rows, touches, &duals, &mut at);
    }
    at.step.iter().all(|w| w.is_finite()).then_some(at)
}

fn conditions(rows: &[Rows], touches: &[Touch], at: &Solution) -> Option<Conditions> {
    let columns = at.step.len();
    let mut all = Conditions { residual: Vec::new(), normals: Vec::new(), duals: Vec::new() };
    for ((rows, touch), z) in rows.iter().zip(touches).zip(&at.duals) {
        let s = rows.at(&at.step);
        match touch {
            Touch::Not => {}
            Touch::Fully => {
                for (i, row) in rows.coefficients.iter().enumerate() {
                    let mut normal = vec![0.0; columns];
                    row.iter().for_each(|(j, c)| normal[*j] += c);
                    all.normals.push(normal);
                    all.residual.push(s[i]);
                    all.duals.push(z[i]);
                }
            }
            Touch::Side => {
                let mut normal = vec![0.0; columns];
                rows.add_transposed(1.0, &outward(&s)?, &mut normal);
                all.normals.push(normal);
                all.residual.push(s[0] - norm(&s[1..]));
                all.duals.push(z[0]);
            }
        }
    }
    Some(all)
}

/// Gradient of `s₁ − ‖s₂…‖` by s; `None` at the tip, where there is none.
fn outward(s: &[f64]) -> Option<Vec<f64>> {
    let length = norm(&s[1..]);
    (length > 0.0).then(|| std::iter::once(1.0).chain(s[1..].iter().map(|u| -u / length)).collect())
}

/// K with what the sides of cones bend: `z₁ G₂ᵀ (I − û ûᵀ) G₂ / ‖u‖`.
fn curvature(quadratic: &Quadratic, rows: &[Rows], touches: &[Touch], at: &Solution) -> Mat<f64> {
    let mut curvature = quadratic.curvature.clone();
    for ((rows, _), z) in rows.iter().zip(touches).zip(&at.duals).filter(|((_, t), _)| **t == Touch::Side) {
        let s = rows.at(&at.step);
        let length = norm(&s[1..]);
        let (bend, side) = (z[0].max(0.0) / length, &rows.coefficients[1..]);
        for (i, row) in side.iter().enumerate() {
            for (k, other) in side.iter().enumerate() {
                let across = f64::from(i == k) - s[i + 1] * s[k + 1] / (length * length);
                for (a, ca) in row {
                    other.iter().for_each(|(b, cb)| curvature[(*a, *b)] += bend * across * ca * cb);
                }
            }
        }
    }
    curvature
}

/// Newton's step of w, and the new duals.
fn newton_step(quadratic: &Quadratic, curvature: &Mat<f64>, c: &Conditions, w: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
    let (count, columns) = (c.residual.len(), w.len());
    let normals = Mat::from_fn(count, columns, |i, j| c.normals[i][j]);
    let duals = Mat::from_fn(count, 1, |i, _| c.duals[i]);
    let w = Mat::from_fn(columns, 1, |j, _| w[j]);
    let slope = Mat::from_fn(columns, 1, |j, _| quadratic.slope[j]);
    let gradient = &quadratic.curvature * &w + slope - normals.transpose() * &duals;
    let Spaces { fixed, inverse, free } = Spaces::of(&normals)?;
    let onto = -(&fixed * (inverse.transpose() * Mat::from_fn(count, 1, |i, _| c.residual[i])));
    let along = if free.ncols() > 0 {
        let reduced = free.transpose() * curvature * &free;
        let down = free.transpose() * -(&gradient + curvature * &onto);
        &free * reduced.llt(Side::Lower).ok()?.solve(down)
    } else {
        Mat::zeros(columns, 1)
    };
    let step = onto + along;
    let duals = duals + inverse * (fixed.transpose() * (gradient + curvature * &step));
    Some(((0..columns).map(|j| step[(j, 0)]).collect(), (0..count).map(|i| duals[(i, 0)]).collect()))
}

/// The directions that N sees and those it leaves free, from its singular values `N = U S Vᵀ`.
struct Spaces {
    /// Columns of V with a singular value.
    fixed: Mat<f64>,
    /// U S⁻¹ for these.
    inverse: Mat<f64>,
    /// The other columns of V.
    free: Mat<f64>,
}

impl Spaces {
    fn of(normals: &Mat<f64>) -> Option<Spaces> {
        let (count, columns) = (normals.nrows(), normals.ncols());
        if count == 0 {
            let (fixed, inverse) = (Mat::zeros(columns, 0), Mat::zeros(0, 0));
            return Some(Spaces { fixed, inverse, free: Mat::identity(columns, columns) });
        }
        let svd = normals.svd().ok()?;
        let rank = (0..count.min(columns)).filter(|k| svd.S()[*k] > DEPENDENT).count();
        Some(Spaces {
            fixed: svd.V().get(.., 0..rank).to_owned(),
            inverse: Mat::from_fn(count, rank, |i, k| svd.U()[(i, k)] / svd.S()[k]),
            free: svd.V().get(.., rank..columns).to_owned(),
        })
    }
}

/// Puts the duals of the conditions back to their rows; those of a cone's side point along its normal.
fn store_duals(rows: &[Rows], touches: &[Touch], duals: &[f64], at: &mut Solution) {
    let mut duals = duals.iter().copied();
    for (index, (rows, touch)) in rows.iter().zip(touches).enumerate() {
        let size = at.duals[index].len();
        match touch {
            Touch::Not => {}
            Touch::Fully => at.duals[index] = duals.by_ref().take(size).collect(),
            Touch::Side => {
                let dual = duals.next().unwrap_or(0.0);
                if let Some(direction) = outward(&rows.at(&at.step)) {
                    at.duals[index] = direction.iter().map(|v| dual * v).collect();
                }
            }
        }
    }
}
