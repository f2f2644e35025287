//! What hangs beyond each joint, and how it moves: from the tips inward.
//!
//! Of a body, or of many, whose points `r` move at `v(r)`,
//!
//! ```text
//!     m = ∫ dm,   c = ∫ r dm,   E = ∫ r rᵀ dm,   P = ∫ v dm,   K = ∫ v rᵀ dm
//! ```
//!
//! about the base's origin all add up. With the motion u = (η, u_0) (`u(r) = u_0 + η × r`)
//!
//! ```text
//!     I u   = ( m u_0 + η × c,   c × u_0 + tr(E) η − E η )        what resists to accelerate by u:      ∫ (1, r×) u dm
//!     B η   = ( η × P,           tr(K) η − K η )                  what the velocity adds where u turns: ∫ (1, r×) η × v dm
//!     Bᵀ S  = P × s_v + tr(K) s_ω − Kᵀ s_ω                        S · B η = η · Bᵀ S
//! ```
//!
//! and what moves a link, whose spatial acceleration is a and angular velocity ω, is the wrench `F = I a + B ω`.

use nalgebra::{Matrix3, Vector3};

use super::link_motion::LinkMotion;
use super::spatial::{Twist, Wrench, zero};
use crate::arithmetic::{Arithmetic, Number, Stored, columns, cross, matrix, times, transposed_times};
use crate::body_inertia::BODY;
use crate::chain::{Chain, Run};
use crate::frame::{Frame, constant, load, store};
use crate::gravity::Bodies;

/// One or many bodies in motion.
#[derive(Clone, Debug)]
pub(super) struct MovingBody<N> {
    /// m, kg.
    mass: N,
    /// c, kg·m.
    first: Vector3<N>,
    /// E, kg·m².
    second: Matrix3<N>,
    /// P, kg·m/s.
    momentum: Vector3<N>,
    /// K, kg·m²/s.
    momentum_at: Matrix3<N>,
}

impl<L: Stored> MovingBody<L> {
    pub fn nothing() -> Self {
        let matrix = matrix(zero(), zero(), zero());
        MovingBody { mass: L::ZERO, first: zero(), second: matrix, momentum: zero(), momentum_at: matrix }
    }

    #[inline(always)]
    pub fn load<A: Arithmetic<Stored = L>>(&self, on: A) -> MovingBody<A::Number> {
        MovingBody {
            mass: on.load(self.mass),
            first: load(on, &self.first),
            second: load_matrix(on, &self.second),
            momentum: load(on, &self.momentum),
            momentum_at: load_matrix(on, &self.momentum_at),
        }
    }

    #[inline(always)]
    fn store<A: Arithmetic<Stored = L>>(on: A, body: &MovingBody<A::Number>) -> Self {
        MovingBody {
            mass: on.store(body.mass),
            first: store(on, &body.first),
            second: store_matrix(on, &body.second),
            momentum: store(on, &body.momentum),
            momentum_at: store_matrix(on, &body.momentum_at),
        }
    }
}

impl<N: Number> MovingBody<N> {
    /// A link in motion.
    #[inline(always)]
    fn of_link<A: Arithmetic<Number = N>>(on: A, own: &[f64; BODY], frame: &Frame<N>, velocity: &Twist<N>) -> Self {
        let [own_mass, x, y, z, xx, xy, yy, xz, yz, zz] = *own;
        let half = 0.5 * (xx + yy + zz);
        let about_origin = Matrix3::new(half - xx, -xy, -xz, -xy, half - yy, -yz, -xz, -yz, half - zz);
        let mass = on.constant(own_mass);
        let moment = times(&frame.rotation, &constant(on, &Vector3::new(x, y, z)));
        let turned = turned(on, frame, &about_origin);
        // With r = p + s: E = ∫ s sᵀ + p (R h)ᵀ + (R h) pᵀ + m p pᵀ.
        let first = frame.translation * mass + moment;
        let second = add(&add(&turned, &outer(&frame.translation, &first)), &outer(&moment, &frame.translation));
        let momentum = velocity.linear * mass + cross(&velocity.angular, &first);
        let momentum_at = add(&outer(&velocity.linear, &first), &cross_matrix(&velocity.angular, &second));
        MovingBody { mass, first, second, momentum, momentum_at }
    }

    #[inline(always)]
    fn plus(&self, other: &Self) -> Self {
        MovingBody {
            mass: self.mass + other.mass,
            first: self.first + other.first,
            second: add(&self.second, &other.second),
            momentum: self.momentum + other.momentum,
            momentum_at: add(&self.momentum_at, &other.momentum_at),
        }
    }

    /// `I u`.
    #[inline(always)]
    pub fn resisting(&self, motion: &Twist<N>) -> Wrench<N> {
        let Twist { angular, linear } = motion;
        Wrench {
            force: *linear * self.mass + cross(angular, &self.first),
            moment: cross(&self.first, linear) + *angular * trace(&self.second) - times(&self.second, angular),
        }
    }

    /// `B η`.
    #[inline(always)]
    pub fn turning(&self, turn: &Vector3<N>) -> Wrench<N> {
        Wrench {
            force: cross(turn, &self.momentum),
            moment: *turn * trace(&self.momentum_at) - times(&self.momentum_at, turn),
        }
    }

    /// `Bᵀ S`.
    #[inline(always)]
    pub fn turned_along(&self, motion: &Twist<N>) -> Vector3<N> {
        let Twist { angular, linear } = motion;
        let along = transposed_times(&self.momentum_at, angular);
        cross(&self.momentum, linear) + *angular * trace(&self.momentum_at) - along
    }
}

/// What hangs beyond a joint, and the wrench that moves it.
#[derive(Clone, Debug)]
pub(super) struct Beyond<L> {
    pub body: MovingBody<L>,
    pub wrench: Wrench<L>,
}

impl<L: Stored> Beyond<L> {
    pub fn nothing() -> Self {
        Beyond { body: MovingBody::nothing(), wrench: Wrench::ZERO }
    }
}

/// What hangs beyond each joint, from the tips to the base. `parameters`: ten numbers a link.
#[inline(always)]
pub(super) fn gather<A: Arithmetic>(
    on: A,
    chain: &Chain,
    bodies: &Bodies<A::Stored>,
    motions: &[LinkMotion<A::Stored>],
    parameters: &[f64],
    beyond: &mut [Beyond<A::Stored>],
) {
    let runs = &chain.topology.runs;
    let parameters = parameters.as_chunks::<BODY>().0;
    for (index, Run { links, .. }) in runs.iter().enumerate().rev() {
        let mut sum = Beyond::nothing();
        for branch in runs[index + 1..].iter().filter(|run| run.parent == Some(links.end - 1)) {
            sum = add_stored(on, &sum, &beyond[branch.links.start]);
        }
        let (mut body, mut wrench) = (sum.body.load(on), sum.wrench.load(on));
        for k in links.clone().rev() {
            let velocity = motions[k].velocity.load(on);
            let frame = bodies.as_slice()[k].link_pose(on);
            let own = MovingBody::of_link(on, &parameters[k], &frame, &velocity);
            let resisting = own.resisting(&motions[k].acceleration.load(on));
            wrench = wrench.plus(&resisting).plus(&own.turning(&velocity.angular));
            body = body.plus(&own);
            beyond[k] = Beyond { body: MovingBody::store(on, &body), wrench: Wrench::store(on, &wrench) };
        }
    }
}

#[inline(always)]
fn add_stored<A: Arithmetic>(on: A, a: &Beyond<A::Stored>, b: &Beyond<A::Stored>) -> Beyond<A::Stored> {
    Beyond {
        body: MovingBody::store(on, &a.body.load(on).plus(&b.body.load(on))),
        wrench: Wrench::store(on, &a.wrench.load(on).plus(&b.wrench.load(on))),
    }
}

/// `R M Rᵀ` of a constant symmetric matrix.
#[inline(always)]
fn turned<A: Arithmetic>(on: A, frame: &Frame<A::Number>, constant_matrix: &Matrix3<f64>) -> Matrix3<A::Number> {
    let (r, [x, y, z]) = (&frame.rotation, columns(constant_matrix));
    let product = matrix(times(r, &constant(on, &x)), times(r, &constant(on, &y)), times(r, &constant(on, &z)));
    // (R M) Rᵀ: column j is R M times row j of R.
    matrix(
        times(&product, &Vector3::new(r.m11, r.m12, r.m13)),
        times(&product, &Vector3::new(r.m21, r.m22, r.m23)),
        times(&product, &Vector3::new(r.m31, r.m32, r.m33)),
    )
}

/// `a bᵀ`.
#[inline(always)]
fn outer<N: Number>(a: &Vector3<N>, b: &Vector3<N>) -> Matrix3<N> {
    matrix(*a * b.x, *a * b.y, *a * b.z)
}

/// `a × M`, column by column.
#[inline(always)]
fn cross_matrix<N: Number>(a: &Vector3<N>, m: &Matrix3<N>) -> Matrix3<N> {
    let [x, y, z] = columns(m);
    matrix(cross(a, &x), cross(a, &y), cross(a, &z))
}

#[inline(always)]
fn add<N: Number>(a: &Matrix3<N>, b: &Matrix3<N>) -> Matrix3<N> {
    let ([ax, ay, az], [bx, by, bz]) = (columns(a), columns(b));
    matrix(ax + bx, ay + by, az + bz)
}

#[inline(always)]
fn trace<N: Number>(m: &Matrix3<N>) -> N {
    m.m11 + m.m22 + m.m33
}

#[inline(always)]
fn load_matrix<A: Arithmetic>(on: A, m: &Matrix3<A::Stored>) -> Matrix3<A::Number> {
    let [x, y, z] = columns(m);
    matrix(load(on, &x), load(on, &y), load(on, &z))
}

#[inline(always)]
fn store_matrix<A: Arithmetic>(on: A, m: &Matrix3<A::Number>) -> Matrix3<A::Stored> {
    let [x, y, z] = columns(m);
    matrix(store(on, &x), store(on, &y), store(on, &z))
}
