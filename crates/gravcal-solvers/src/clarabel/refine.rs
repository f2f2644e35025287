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
//! tip, all of its `s` (Nocedal and Wright, *Numerical optimization*, 2006, eq. 18.9). N may have dependent rows: what
//! these leave open of `z` stays as the interior point has it, which lies amid all answers.

use faer::{Mat, Scale, Side};

use super::programme::{Quadratic, Solution};
use super::rows::{Cone, Rows, norm};

/// Newton steps at most: from eight digits to all in one or two.
const STEPS: usize = 4;
/// Steps this short change only rounding errors.
const SETTLED: f64 = 1e-14;
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
    let mut touches: Vec<Touch> =
        rows.iter().zip(&found.duals).map(|(r, z)| touch(r, &r.at(&found.point), z)).collect();
    // Each round lets go of rows that pull, or takes up rows that were broken.
    for _ in 0..=rows.len() {
        let refined = newton(quadratic, rows, &touches, found)?;
        let corrected: Vec<Touch> = (0..rows.len()).map(|i| corrected(&rows[i], touches[i], &refined, i)).collect();
        if corrected == touches {
            let kept = |r: &Rows| r.excess(&r.at(&refined.point)) <= ROUNDING * (1.0 + norm(&r.slack));
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
    let (s, z) = (rows.at(&at.point), &at.duals[index]);
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
        let (step, duals) = newton_step(&conditions, curvature, quadratic.gradient(&at.point))?;
        at.point.iter_mut().zip(&step).for_each(|(w, d)| *w += d);
        store_duals(rows, touches, &duals, &mut at);
        if norm(&step) <= SETTLED * norm(&at.point) {
            break;
        }
    }
    at.point.iter().all(|w| w.is_finite()).then_some(at)
}

fn conditions(rows: &[Rows], touches: &[Touch], at: &Solution) -> Option<Conditions> {
    let columns = at.point.len();
    let mut all = Conditions { residual: Vec::new(), normals: Vec::new(), duals: Vec::new() };
    for ((rows, touch), z) in rows.iter().zip(touches).zip(&at.duals) {
        let s = rows.at(&at.point);
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

/// The Lagrangian's second derivative: K and `z₁ G₂ᵀ (I − û ûᵀ) G₂ / ‖u‖` of each cone touched on its side.
fn curvature(quadratic: &Quadratic, rows: &[Rows], touches: &[Touch], at: &Solution) -> Mat<f64> {
    let mut curvature = quadratic.curvature.clone();
    for ((rows, _), z) in rows.iter().zip(touches).zip(&at.duals).filter(|((_, t), _)| **t == Touch::Side) {
        let s = rows.at(&at.point);
        let (length, count) = (norm(&s[1..]), s.len() - 1);
        let mut side = Mat::<f64>::zeros(count, at.point.len());
        for (i, row) in rows.coefficients[1..].iter().enumerate() {
            row.iter().for_each(|(j, c)| side[(i, *j)] += c);
        }
        let unit = Mat::from_fn(count, 1, |i, _| s[i + 1] / length);
        let across = &side - &unit * (unit.transpose() * &side);
        curvature += Scale(z[0].max(0.0) / length) * (across.transpose() * &across);
    }
    curvature
}

/// Newton's step Δ of w and the new duals, from `B Δ − Nᵀ Δz = Nᵀ z − gradient` and `N Δ = −c` with `B = L Lᵀ`.
///
/// With `v = Lᵀ Δ` and `M = L⁻¹ Nᵀ`, columns brought to length one, `v` is the point with `Mᵀ v = −c` nearest to
/// `L⁻¹ (Nᵀ z − gradient)`, and `M Δz` is the difference: both come from the singular values of M.
fn newton_step(c: &Conditions, curvature: Mat<f64>, gradient: Vec<f64>) -> Option<(Vec<f64>, Vec<f64>)> {
    let (count, columns) = (c.residual.len(), gradient.len());
    let root = curvature.llt(Side::Lower).ok()?;
    let held = |j: usize| c.normals.iter().zip(&c.duals).map(|(n, z)| n[j] * z).sum::<f64>();
    let mut v = Mat::from_fn(columns, 1, |j, _| held(j) - gradient[j]);
    let mut normals = Mat::from_fn(columns, count, |j, i| c.normals[i][j]);
    root.L().solve_lower_triangular_in_place(v.as_mut());
    root.L().solve_lower_triangular_in_place(normals.as_mut());
    let mut duals = c.duals.clone();
    if count > 0 {
        let lengths: Vec<f64> = (0..count).map(|i| normals.col(i).norm_l2().max(f64::MIN_POSITIVE)).collect();
        let svd = Mat::from_fn(columns, count, |j, i| normals[(j, i)] / lengths[i]).thin_svd().ok()?;
        for k in (0..count.min(columns)).filter(|k| svd.S()[*k] > DEPENDENT) {
            let (left, right, value) = (svd.U().col(k), svd.V().col(k), svd.S()[k]);
            let wanted = -(0..count).map(|i| right[i] * c.residual[i] / lengths[i]).sum::<f64>() / value;
            let pull = wanted - (0..columns).map(|j| left[j] * v[(j, 0)]).sum::<f64>();
            (0..columns).for_each(|j| v[(j, 0)] += pull * left[j]);
            (0..count).for_each(|i| duals[i] += pull / value * right[i] / lengths[i]);
        }
    }
    root.L().transpose().solve_upper_triangular_in_place(v.as_mut());
    Some(((0..columns).map(|j| v[(j, 0)]).collect(), duals))
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
                if let Some(direction) = outward(&rows.at(&at.point)) {
                    at.duals[index] = direction.iter().map(|v| dual * v).collect();
                }
            }
        }
    }
}
