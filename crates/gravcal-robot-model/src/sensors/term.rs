//! What a term of a sensor's model is: a function with parameters of its own, from any crate.
//!
//! ```text
//!     reading of torque    y_i = k_i τ_i + b_i + Σ f(x; τ, θ, q, conditions)
//!     joint coordinate     θ_i = s_i q_i + o_i + Σ f(x; q, conditions)
//! ```
//!
//! A [`SensorTerm`] is `f` with its partial derivatives by hand; a [`SensorFormula`](super::SensorFormula) needs none.

use std::fmt::{self, Debug};

use gravcal_estimation::Number;
use gravcal_recording::Conditions;

/// `f`: what a sensor does beyond gain and bias (or gain and offset), with parameters `x` in which it may be nonlinear.
pub trait SensorTerm: Debug + Send + Sync {
    /// What it depends on besides its parameters.
    fn reads(&self) -> Reads;

    /// `f` in the unit of the reading (of a position sensor: rad or m). `partials`, where wanted, come as zeros and are filled with all
    /// derivatives.
    ///
    /// Where `f` is not defined it is not finite; a solver shortens its step then.
    fn value(&self, at: &Moment<'_>, x: &[f64], partials: Option<Partials<'_>>) -> f64;

    /// Whether it holds its derivatives against differences itself: then no session does.
    fn checks_derivatives(&self) -> bool {
        false
    }
}

/// The derivatives of a term.
#[derive(Debug)]
pub struct Partials<'a> {
    /// By each of its parameters, in their order.
    pub by_parameter: &'a mut [f64],
    /// By the torque of each joint; only of those that [`Reads`] names.
    pub by_torque: &'a mut [f64],
    /// By the true coordinate of each joint; only of those that [`Reads`] names.
    pub by_coordinate: &'a mut [f64],
}

/// What a term depends on besides its parameters and the joints' position readings: a problem is built after it, and a session that
/// does not say what a term needs is refused.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reads {
    torques: Vec<usize>,
    coordinates: Vec<usize>,
    needs: Vec<Need>,
    affine_in_torques: bool,
    linear_in_parameters: bool,
}

/// A condition of the poses that a term reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// When the pose was read.
    Time,
    /// How warm the sensor was.
    Temperature,
    /// How fast the joint moved.
    Velocity,
    /// From which side the joint came; its velocity tells, too.
    Direction,
    /// How far friction has built up since the joint last turned round: of an arm in motion.
    Presliding,
}

impl Reads {
    /// Nothing but position readings.
    pub fn positions() -> Reads {
        Reads::default()
    }

    /// The torque of a joint, too, by its index.
    #[must_use]
    pub fn torque(mut self, joint: usize) -> Reads {
        insert(&mut self.torques, joint);
        self
    }

    /// The true coordinate of a joint, too.
    #[must_use]
    pub fn coordinate(mut self, joint: usize) -> Reads {
        insert(&mut self.coordinates, joint);
        self
    }

    /// A condition of the poses, too.
    #[must_use]
    pub fn condition(mut self, need: Need) -> Reads {
        if !self.needs.contains(&need) {
            self.needs.push(need);
        }
        self
    }

    /// The same of a term that is affine in the torques: then masses and moments are eliminated as linear unknowns. A term that reads
    /// no torque is.
    #[must_use]
    pub fn affine_in_torques(self) -> Reads {
        Reads { affine_in_torques: true, ..self }
    }

    /// The same of a term `Σ x_p φ_p` whose `φ_p` depend on no parameter.
    #[must_use]
    pub fn linear_in_parameters(self) -> Reads {
        Reads { linear_in_parameters: true, ..self }
    }

    pub(crate) fn torques(&self) -> &[usize] {
        &self.torques
    }

    pub(crate) fn coordinates(&self) -> &[usize] {
        &self.coordinates
    }

    /// Conditions that it needs.
    pub fn needs(&self) -> &[Need] {
        &self.needs
    }

    pub(crate) fn is_affine_in_torques(&self) -> bool {
        self.torques.is_empty() || self.affine_in_torques
    }

    /// Whether readings are affine in the term's parameters together with masses and moments.
    pub(crate) fn is_linear(&self) -> bool {
        self.linear_in_parameters && self.torques.is_empty()
    }
}

fn insert(list: &mut Vec<usize>, joint: usize) {
    if !list.contains(&joint) {
        list.push(joint);
    }
}

/// What a term may read in one pose. Joints are counted as in the robot; torques, coordinates and positions of a joint that there is not
/// are NaN, as are further columns.
#[derive(Clone, Copy)]
pub struct Moment<'a, N = f64> {
    torque: &'a [f64],
    coordinate: &'a [f64],
    position: &'a [f64],
    conditions: &'a Conditions,
    /// Those that carry derivatives.
    lifted: &'a [(Variable, N)],
}

/// What a term depends on and that depends on unknowns itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Variable {
    Torque(usize),
    Coordinate(usize),
}

impl<'a> Moment<'a> {
    /// Torques (N·m or N), true coordinates (rad or m) and position readings of all joints.
    pub fn new(torque: &'a [f64], coordinate: &'a [f64], position: &'a [f64], conditions: &'a Conditions) -> Self {
        Moment { torque, coordinate, position, conditions, lifted: &[] }
    }

    /// The same at other torques.
    pub(crate) fn with_torque<'b>(&self, torque: &'b [f64]) -> Moment<'b>
    where
        'a: 'b,
    {
        Moment { torque, ..*self }
    }

    pub(super) fn with_coordinate<'b>(&self, coordinate: &'b [f64]) -> Moment<'b>
    where
        'a: 'b,
    {
        Moment { coordinate, ..*self }
    }

    /// Torques and true coordinates of all joints.
    pub(super) fn unknowns(&self) -> (&'a [f64], &'a [f64]) {
        (self.torque, self.coordinate)
    }

    /// How many joints there are.
    pub(super) fn joints(&self) -> usize {
        self.torque.len()
    }

    pub(super) fn with_derivatives<'b, N>(&self, lifted: &'b [(Variable, N)]) -> Moment<'b, N>
    where
        'a: 'b,
    {
        let Moment { torque, coordinate, position, conditions, lifted: _ } = *self;
        Moment { torque, coordinate, position, conditions, lifted }
    }

    pub(super) fn of(&self, variable: Variable) -> f64 {
        match variable {
            Variable::Torque(joint) => self.torque(joint),
            Variable::Coordinate(joint) => self.coordinate(joint),
        }
    }
}

impl<N: Number> Moment<'_, N> {
    /// The torque of a joint, N·m (N where it slides); of those that [`Reads`] names.
    pub fn torque(&self, joint: usize) -> N {
        self.lifted(Variable::Torque(joint)).unwrap_or_else(|| N::from(entry(self.torque, joint)))
    }

    /// The true coordinate of a joint, rad (m where it slides), as its calibrated sensor says; of those that [`Reads`] names.
    pub fn coordinate(&self, joint: usize) -> N {
        self.lifted(Variable::Coordinate(joint)).unwrap_or_else(|| N::from(entry(self.coordinate, joint)))
    }

    /// The position reading of a joint: rad, m or the sensor's own unit. No parameter moves it.
    pub fn position(&self, joint: usize) -> f64 {
        entry(self.position, joint)
    }

    /// s since the session's first pose; 0 where it is not known.
    pub fn time(&self) -> f64 {
        self.conditions.time.unwrap_or(0.0)
    }

    /// °C of a joint's sensors, where it is known.
    pub fn temperature(&self, joint: usize) -> Option<f64> {
        self.conditions.temperature.get(joint).copied()
    }

    /// rad/s or m/s of a joint; 0 where it is not known.
    pub fn velocity(&self, joint: usize) -> f64 {
        self.conditions.velocity.get(joint).copied().unwrap_or(0.0)
    }

    /// The number of a further column, by its place: see [`Site::further_column`](super::Site::further_column).
    pub fn further(&self, place: usize) -> f64 {
        entry(&self.conditions.further, place)
    }

    /// From which side a joint came, or which way it moves: 1, 0 or −1; 0 where neither is known.
    pub fn direction(&self, joint: usize) -> f64 {
        let by_velocity = || self.conditions.velocity.get(joint).map(|v| if *v == 0.0 { 0.0 } else { v.signum() });
        self.conditions.direction.get(joint).copied().or_else(by_velocity).unwrap_or(0.0)
    }

    /// How far a joint's friction has built up over a travel (rad or m), from −1 to 1, and its slope by the travel; all of it, by the
    /// direction, where that was not followed.
    pub fn presliding(&self, joint: usize, travel: f64) -> (f64, f64) {
        let followed = self.conditions.presliding.get(joint).copied().flatten();
        followed.map_or_else(|| (self.direction(joint), 0.0), |followed| followed.at(travel))
    }

    fn lifted(&self, variable: Variable) -> Option<N> {
        self.lifted.iter().find(|(own, _)| *own == variable).map(|(_, number)| *number)
    }
}

impl<N> Debug for Moment<'_, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Moment { torque, coordinate, position, conditions, lifted: _ } = self;
        let mut fields = f.debug_struct("Moment");
        fields.field("torque", torque).field("coordinate", coordinate).field("position", position);
        fields.field("conditions", conditions).finish()
    }
}

fn entry(list: &[f64], joint: usize) -> f64 {
    list.get(joint).copied().unwrap_or(f64::NAN)
}

/// `x φ` of a term with one parameter and a known function of conditions or position readings.
pub(super) fn scaled(x: &[f64], function: f64, partials: Option<Partials<'_>>) -> f64 {
    if let Some(Partials { by_parameter, .. }) = partials {
        by_parameter[0] = function;
    }
    x[0] * function
}
