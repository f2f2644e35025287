//! Gravity's torque in any pose, from what a calibration determines of masses and moments.
//!
//! A calibration determines combinations `C x = v` of the links' masses and first moments and of the loads' placements. Torques are
//! linear in these: `τ_i = r_i(θ) · x + τ_load`. So `τ_i` is known where `r_i` lies in the space of the rows of `C`, which is
//! tried in the session's own poses; then any solution of `C x = v` gives it, and the one nearest to the assumed `x₀` is taken,
//!
//! ```text
//!     x = x₀ + Bᵀ (b − B x₀)          B: orthonormal rows with the span of C, b: their values
//! ```

use gravcal_dynamics::GravityTorque;
use gravcal_recording::EarlierEstimate;
use gravcal_robot_model::session::{InertiaPrior, Load, Session};

use super::error::ApplicationError;
use super::values::values;
use crate::joint::State;

/// Numbers of one link: mass and first moment.
const INERTIA: usize = 4;
/// A row that lies in the span but for this share of its length does so.
const SPANNED: f64 = 1e-6;
/// A row that is left with less than this share of its length is in the span already.
const INDEPENDENT: f64 = 1e-9;
/// Poses that are tried.
const POSES: usize = 200;

/// Gravity's torque in any pose of a session's robot, from what a calibration determines of masses and moments.
#[derive(Debug)]
pub struct GravityModel<'a> {
    session: &'a Session,
    gravity: [f64; 3],
    /// Of the links, what is attached included.
    inertia: Vec<f64>,
    torque: Vec<f64>,
}

impl<'a> GravityModel<'a> {
    /// Of `calibration`, which is of `session`. `load`: name of the load that is attached. `nominal`: whether assumed masses and
    /// moments (and sensors) stand for what is not determined.
    ///
    /// # Errors
    /// Something is not determined or of another session, there is no such load, or the session describes moments by sweep.
    pub fn new(
        session: &'a Session,
        calibration: &EarlierEstimate,
        load: Option<&str>,
        nominal: bool,
    ) -> Result<GravityModel<'a>, ApplicationError> {
        if session.inertia == InertiaPrior::Sweep {
            return Err(ApplicationError::BySweep);
        }
        let assumed = nominal.then(|| session.gravity.assumed());
        let gravity = calibration.gravity.or(assumed).ok_or(ApplicationError::NoGravity)?;
        let load = load.map(|name| find(session, name)).transpose()?;
        let weighed = load.map(|load| as_found(session, calibration, load));
        let load = weighed.as_ref();
        if let Some(load) = load.filter(|load| load.is_unknown()) {
            return Err(ApplicationError::UnknownLoad { name: load.name.clone() });
        }
        let names = Names::new(session, calibration, load);
        let span = Span::new(calibration, &names);
        let model = Linear { session, gravity, load, names: &names };
        if !nominal {
            model.check(&span, &values(session, calibration, nominal)?)?;
        }
        let solution = span.nearest(&names.assumed(session, nominal));
        let inertia = model.inertia(&solution);
        Ok(GravityModel { session, gravity, inertia, torque: vec![0.0; session.joints.len()] })
    }

    /// Torque of every joint, N·m or N, at these coordinates; NaN where one of them is.
    pub fn torques(&mut self, coordinates: &[f64]) -> &[f64] {
        match coordinates.iter().any(|coordinate| coordinate.is_nan()) {
            true => self.torque.fill(f64::NAN),
            false => {
                self.session.robot.chain.gravity_torque(coordinates, self.gravity, &self.inertia, &mut self.torque);
            }
        }
        &self.torque
    }
}

fn find<'s>(session: &'s Session, name: &str) -> Result<&'s Load, ApplicationError> {
    session.loads.iter().find(|load| load.name == name).ok_or_else(|| {
        let known: Vec<&str> = session.loads.iter().map(|load| load.name.as_str()).collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        ApplicationError::NoLoad { name: name.to_owned(), known }
    })
}

/// A load with the mass that was found, where it was weighed with an error.
fn as_found(session: &Session, calibration: &EarlierEstimate, load: &Load) -> Load {
    let place = session.loads.iter().position(|other| other.name == load.name);
    let name = place.and_then(|place| session.load_mass(place)).map(|id| session.parameter_name(id));
    let found = calibration.parameters.iter().find(|found| Some(&found.name) == name.as_ref());
    Load { mass: found.and_then(|found| found.value).unwrap_or(load.mass), ..load.clone() }
}

/// The components of `x` by their names in a calibration.
struct Names {
    all: Vec<String>,
    /// Places whose sum is the placement of the load that is attached, of each axis; none where it is given.
    placement: [Vec<usize>; 3],
}

impl Names {
    fn new(session: &Session, calibration: &EarlierEstimate, load: Option<&Load>) -> Names {
        let links = session.robot.chain.links().iter();
        let inertia = links.flat_map(|link| {
            ["mass", "first_moment.x", "first_moment.y", "first_moment.z"].map(|what| format!("{}.{what}", link.name))
        });
        let mut all: Vec<String> = inertia.collect();
        let known =
            |name: &str| calibration.quantities.iter().flat_map(|known| &known.terms).any(|(term, _)| term == name);
        let mut placement: [Vec<usize>; 3] = Default::default();
        let mut next = load.filter(|load| load.position.is_none() || load.position_std.is_some());
        let mut passed = Vec::new();
        while let Some(load) = next {
            passed.push(&load.name);
            // A placement is told by itself, or as a displacement from another.
            let from = |other: &&Load| {
                !passed.contains(&&other.name)
                    && known(&format!("load.{}.displacement_from.{}.x", load.name, other.name))
            };
            next = session.loads.iter().find(from);
            let what = next.map_or("position".to_owned(), |other| format!("displacement_from.{}", other.name));
            for (axis, places) in ["x", "y", "z"].into_iter().zip(&mut placement) {
                places.push(all.len());
                all.push(format!("load.{}.{what}.{axis}", load.name));
            }
        }
        Names { all, placement }
    }

    fn place(&self, name: &str) -> Option<usize> {
        self.all.iter().position(|known| known == name)
    }

    /// `x₀`: what the robot's file says of its links, where that is asked for, else zero.
    fn assumed(&self, session: &Session, nominal: bool) -> Vec<f64> {
        let mut assumed = vec![0.0; self.all.len()];
        for (link, numbers) in session.robot.chain.links().iter().zip(assumed.chunks_mut(INERTIA)) {
            if let Some(inertia) = link.inertia.filter(|_| nominal) {
                let [x, y, z] = inertia.first_moment;
                numbers.copy_from_slice(&[inertia.mass, x, y, z]);
            }
        }
        assumed
    }
}

/// `B x = b`.
struct Span {
    rows: Vec<(Vec<f64>, f64)>,
}

impl Span {
    /// Of the combinations of components that have a name here.
    fn new(calibration: &EarlierEstimate, names: &Names) -> Span {
        let mut span = Span { rows: Vec::new() };
        for quantity in &calibration.quantities {
            let mut row = vec![0.0; names.all.len()];
            let all_known = quantity
                .terms
                .iter()
                .all(|(name, coefficient)| names.place(name).inspect(|place| row[*place] += coefficient).is_some());
            if all_known {
                span.add(row, quantity.value);
            }
        }
        span
    }

    /// Adds a combination by Gram and Schmidt's method, twice for the sake of its digits.
    fn add(&mut self, mut row: Vec<f64>, mut value: f64) {
        let length = norm(&row);
        for _ in 0..2 {
            for (other, known) in &self.rows {
                let share = dot(&row, other);
                row.iter_mut().zip(other).for_each(|(entry, other)| *entry -= share * other);
                value -= share * known;
            }
        }
        let left = norm(&row);
        if left > INDEPENDENT * length {
            row.iter_mut().for_each(|entry| *entry /= left);
            self.rows.push((row, value / left));
        }
    }

    /// Whether a combination is determined.
    fn holds(&self, row: &[f64]) -> bool {
        let mut left = row.to_vec();
        for (other, _) in &self.rows {
            let share = dot(&left, other);
            left.iter_mut().zip(other).for_each(|(entry, other)| *entry -= share * other);
        }
        norm(&left) <= SPANNED * norm(row)
    }

    fn nearest(&self, assumed: &[f64]) -> Vec<f64> {
        let mut solution = assumed.to_vec();
        for (row, value) in &self.rows {
            let missing = value - dot(row, assumed);
            solution.iter_mut().zip(row).for_each(|(entry, row)| *entry += missing * row);
        }
        solution
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// The torques as linear functions of `x`.
struct Linear<'a> {
    session: &'a Session,
    gravity: [f64; 3],
    load: Option<&'a Load>,
    names: &'a Names,
}

impl Linear<'_> {
    /// Whether every torque that is read is determined in the session's poses.
    fn check(&self, span: &Span, values: &State) -> Result<(), ApplicationError> {
        let session = self.session;
        let (joints, links) = (session.joints.len(), session.robot.chain.link_count());
        let mut open = vec![false; joints];
        let mut work = GravityTorque::new(joints, links);
        let inertia = vec![0.0; INERTIA * links];
        let step = session.poses.len().div_ceil(POSES).max(1);
        for pose in session.poses.iter().step_by(step) {
            let coordinates = session.terms.coordinates(&pose.position, &pose.conditions, values);
            session.robot.chain.linearize_gravity_torque(&coordinates, self.gravity, &inertia, &mut work);
            for (joint, open) in
                open.iter_mut().enumerate().filter(|(joint, _)| session.readings.torques[*joint].is_some())
            {
                let by_inertia = &work.by_inertia[INERTIA * links * joint..INERTIA * links * (joint + 1)];
                *open |= !span.holds(&self.row(by_inertia));
            }
        }
        let names = session.robot.chain.joints().iter().zip(&open).filter(|(_, open)| **open);
        let names: Vec<String> = names.map(|(joint, _)| joint.name.clone()).collect();
        if names.is_empty() { Ok(()) } else { Err(ApplicationError::NoMoments { joints: names }) }
    }

    /// `r_i`, from the derivatives by the links' masses and moments.
    fn row(&self, by_inertia: &[f64]) -> Vec<f64> {
        let mut row = by_inertia.to_vec();
        row.resize(self.names.all.len(), 0.0);
        if let Some(load) = self.load {
            for (axis, places) in self.names.placement.iter().enumerate() {
                places.iter().for_each(|place| row[*place] = load.mass * by_inertia[INERTIA * load.link + 1 + axis]);
            }
        }
        row
    }

    /// Masses and moments of the links with the load.
    fn inertia(&self, solution: &[f64]) -> Vec<f64> {
        let mut inertia = solution[..INERTIA * self.session.robot.chain.link_count()].to_vec();
        if let Some(load) = self.load {
            let given = load.position.filter(|_| load.position_std.is_none());
            let numbers = &mut inertia[INERTIA * load.link..INERTIA * (load.link + 1)];
            numbers[0] += load.mass;
            for (axis, places) in self.names.placement.iter().enumerate() {
                let found = places.iter().map(|place| solution[*place]).sum();
                numbers[1 + axis] += load.mass * given.map_or(found, |position| position[axis]);
            }
        }
        inertia
    }
}
