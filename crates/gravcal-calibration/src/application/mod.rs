//! A calibration applied to a recording: what its readings truly say.
//!
//! ```text
//!     coordinate   θ = s q + o + Σ a ψ(q)
//!     velocity     θ̇ = (s + Σ a ψ′(q)) q̇
//!     torque       τ, from y = k τ + b + Σ a φ(τ, conditions) by Newton's method
//!     residual     τ − τ_g(θ), the torque that does not carry gravity
//! ```
//!
//! Rows may say only some of the readings at a time, as where joints are spread over topics: what a row does not say is taken as it was
//! said last. A reading at an end of its sensor's range has no torque, and becomes an empty cell.
//!
//! Angles that begin anew after a turn are taken as the session took its own: within the turn that its standstills visit, on from row to row where its arm moved,
//! and as they are recorded where its poses are rows of tables.
//!
//! Velocities are those of columns, or slopes of positions: over the time that the session says, or a quarter of a window of a session in motion.
//!
//! Where Coulomb friction has its sign from a velocity, a joint no faster than the session's `speed_above` has none: what it reads at
//! rest is the sign of noise.

mod columns;
mod error;
mod friction_sign;
mod gravity;
#[cfg(test)]
mod tests;
mod values;

use gravcal_recording::{
    ConditionColumn, Conditions, DahlFriction, EarlierEstimate, MotionSource, Rows, Slope, SlopesAhead, is_saturated,
    unwrapped, within_turn,
};
use gravcal_robot_model::number::shortest;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::sensors::{Moment, Need};
use gravcal_robot_model::session::Session;

pub use self::error::ApplicationError;
pub use self::gravity::GravityModel;
pub use self::values::check_units;

use self::columns::Columns;
use self::friction_sign::FrictionSign;
use self::values::{check_models, values};
use crate::joint::State;

/// Step of numerical differentiation of a position sensor's terms, rad or m: their periods are far longer.
const STEP: f64 = 1e-5;

/// Windows are so many times longer than the time over which velocities are slopes: these should follow what the model follows in a window.
const SLOPES_IN_WINDOW: f64 = 4.0;

/// What efforts become.
#[derive(Clone, Debug, PartialEq)]
pub enum Effort {
    /// Torques.
    Torque,
    /// Torques without that which carries gravity.
    Residual {
        /// Name of the load that is attached.
        load: Option<String>,
    },
}

/// A calibration that changes the rows of a recording. Angles are then in the unit of their column (rad, where that is the sensor's
/// own), torques in N·m (N where a joint slides).
#[derive(Debug)]
pub struct Application<'a> {
    session: &'a Session,
    values: State,
    gravity: Option<GravityModel<'a>>,
    columns: Columns,
    /// Last readings of all joints, in inside units; NaN before the first.
    positions: Vec<f64>,
    /// The same, where angles go on from row to row over full turns.
    unwrapped: Vec<f64>,
    torques: Vec<f64>,
    conditions: Conditions,
    /// Whether the arm of the session moved: then its angles go on from row to row.
    goes_on: bool,
    /// Where velocities are slopes.
    slopes: Option<SlopesAhead<'a>>,
    clock: ConditionColumn,
    friction_sign: FrictionSign,
    /// Of each joint whose friction builds up before it slides.
    built_up: Vec<Option<DahlFriction>>,
    /// By joint, readings at an end of the range.
    saturated: Vec<u64>,
    /// Torque readings whose torque is not known.
    without_torque: u64,
}

impl<'a> Application<'a> {
    /// Applies `calibration`, which is of `session`. Where it has no value, nominal ones are taken if `nominal`. `ahead`: the rows of the recording to
    /// which it is applied, unread, where velocities may be slopes (see the module); without them only columns tell velocities.
    ///
    /// # Errors
    /// See [`ApplicationError`].
    pub fn new(
        session: &'a Session,
        calibration: &EarlierEstimate,
        effort: &Effort,
        nominal: bool,
        ahead: Option<Box<dyn Rows>>,
    ) -> Result<Application<'a>, ApplicationError> {
        if session.joints.is_empty() {
            return Err(ApplicationError::NoJoints);
        }
        check_stiffness(session)?;
        let slope = velocity_slope(session);
        let slopes = slope.zip(ahead).map(|(slope, rows)| SlopesAhead::new(rows, &session.readings, slope));
        check_conditions(session, slopes.is_some())?;
        check_models(session, calibration)?;
        let values = values(session, calibration, nominal)?;
        let gravity = match effort {
            Effort::Torque => None,
            Effort::Residual { load } => Some(GravityModel::new(session, calibration, load.as_deref(), nominal)?),
        };
        let joints = session.joints.len();
        let friction_sign = FrictionSign::new(session, slopes.is_some());
        let followed = session.terms.with_presliding();
        let scale = |joint: usize| session.nominal(ParameterId::Sensor(joint, SensorParameter::PositionGain));
        let built_up = |joint: usize| followed.contains(&joint).then(|| DahlFriction::new(scale(joint)));
        Ok(Application {
            session,
            values,
            gravity,
            columns: Columns::default(),
            positions: vec![f64::NAN; joints],
            unwrapped: vec![f64::NAN; joints],
            torques: vec![f64::NAN; joints],
            conditions: Conditions {
                time: None,
                temperature: vec![f64::NAN; session.readings.conditions.temperature.len()],
                velocity: vec![f64::NAN; joints],
                acceleration: Vec::new(),
                direction: vec![f64::NAN; session.readings.conditions.direction.len()],
                presliding: Vec::new(),
                further: vec![f64::NAN; session.readings.conditions.further.len()],
            },
            goes_on: session.has_windows(),
            slopes,
            clock: session.readings.conditions.clock(),
            friction_sign,
            built_up: (0..joints).map(built_up).collect(),
            saturated: vec![0; joints],
            without_torque: 0,
        })
    }

    /// Looks for the session's columns among those of a recording, as far as they are known.
    ///
    /// # Errors
    /// One is missing.
    pub fn find(&mut self, columns: &[String]) -> Result<(), ApplicationError> {
        self.columns = Columns::find(&self.session.readings, columns);
        let needs_time = self.slopes.is_some() && self.columns.time.is_none();
        let missing = self.columns.missing(&self.session.readings);
        match missing.or(needs_time.then_some(self.clock.column.as_str())) {
            None => Ok(()),
            Some(column) => {
                let known: Vec<String> = columns.iter().map(|column| format!("`{column}`")).collect();
                Err(ApplicationError::NoColumn { column: column.to_owned(), known: known.join(", ") })
            }
        }
    }

    /// Changes the cells of a row, whose columns have these names.
    pub fn apply(&mut self, columns: &[String], cells: &mut [f64]) {
        if self.columns.count != columns.len() {
            self.columns = Columns::find(&self.session.readings, columns);
        }
        self.hear(cells);
        let coordinates = self.session.terms.coordinates(&self.positions, &self.conditions, &self.values);
        self.report_motion(cells, &coordinates);
        if self.columns.torques.iter().flatten().any(|column| !cells[*column].is_nan()) {
            self.report_torques(cells, &coordinates);
        }
    }

    /// What a reader of the new recording should know.
    pub fn remarks(&self) -> Vec<String> {
        let names = self.session.robot.chain.joints().iter().map(|joint| &joint.name);
        let saturated = names.zip(&self.saturated).filter(|(_, count)| **count > 0).map(|(name, count)| {
            format!("joint {name}: {count} torque readings are at an end of the sensor's range, and became empty")
        });
        let without = (self.without_torque > 0).then(|| {
            format!(
                "{} torque readings became empty: no torque explains them, or not everything that theirs depends on was \
                 said before",
                self.without_torque
            )
        });
        let slope = self.slopes.as_ref().and_then(|_| velocity_slope(self.session));
        let slope =
            slope.map(|slope| format!("velocities are slopes of the positions over {} s", shortest(slope.window)));
        saturated.chain(without).chain(slope).chain(self.friction_sign.remarks(self.session)).collect()
    }

    /// Takes what a row says of the readings and conditions.
    fn hear(&mut self, cells: &[f64]) {
        let mapping = &self.session.readings;
        let hear = |last: &mut f64, column: Option<usize>, inside: &dyn Fn(f64) -> f64| {
            let cell = column.map_or(f64::NAN, |column| cells[column]);
            if !cell.is_nan() {
                *last = inside(cell);
            }
        };
        for (joint, (position, on)) in self.positions.iter_mut().zip(&mut self.unwrapped).enumerate() {
            let (unit, before) = (mapping.positions[joint].unit, Some(*on).filter(|on| !on.is_nan()));
            hear(position, self.columns.positions[joint], &|cell| cell * unit.to_si());
            *on = unwrapped(*position, before, unit);
            match self.session.turns.get(joint) {
                Some(Some(begin)) => *position = within_turn(*position, *begin),
                _ if self.goes_on => *position = *on,
                _ => {}
            }
        }
        for (joint, last) in self.torques.iter_mut().enumerate() {
            let unit = mapping.torques[joint].as_ref().map_or(1.0, |(_, unit)| unit.to_si());
            hear(last, self.columns.torques[joint], &|cell| cell * unit);
        }
        let conditions = &mut self.conditions;
        for ((last, column), mapped) in
            conditions.temperature.iter_mut().zip(&self.columns.temperature).zip(&mapping.conditions.temperature)
        {
            hear(last, *column, &|cell| mapped.unit.to_inside(cell));
        }
        if let MotionSource::Columns(mapped) = &mapping.conditions.velocity {
            for ((last, column), mapped) in conditions.velocity.iter_mut().zip(&self.columns.velocities).zip(mapped) {
                hear(last, *column, &|cell| mapped.unit.to_inside(cell));
            }
        }
        let time = self.columns.time.map_or(f64::NAN, |column| self.clock.unit.to_inside(cells[column]));
        if let Some(slopes) = self.slopes.as_mut().filter(|_| !time.is_nan()) {
            conditions.velocity = slopes.at(time);
        }
        let (directions, further) = (conditions.direction.iter_mut(), conditions.further.iter_mut());
        let columns = self.columns.direction.iter().chain(&self.columns.further);
        for (last, column) in directions.chain(further).zip(columns) {
            hear(last, *column, &|cell| cell);
        }
        self.friction_sign.report(conditions);
        for (friction, position) in self.built_up.iter_mut().zip(&self.unwrapped) {
            friction.iter_mut().filter(|_| !position.is_nan()).for_each(|friction| friction.go(*position));
        }
        if self.built_up.iter().any(Option::is_some) {
            conditions.presliding = self.built_up.iter().map(|friction| friction.as_ref()?.state()).collect();
        }
    }

    /// Coordinates and velocities in the units of their columns.
    fn report_motion(&self, cells: &mut [f64], coordinates: &[f64]) {
        let say = |cells: &mut [f64], column: Option<usize>, number: &dyn Fn(f64) -> f64| {
            if let Some(column) = column.filter(|column| !cells[*column].is_nan()) {
                cells[column] = number(cells[column]);
            }
        };
        for (joint, coordinate) in coordinates.iter().enumerate() {
            let unit = self.session.readings.positions[joint].unit;
            say(cells, self.columns.positions[joint], &|_| coordinate / unit.to_si());
            // A velocity beside counts or volts is in a unit of its own, and says itself what it is.
            if !unit.is_sensors_own() {
                say(cells, self.columns.velocities[joint], &|cell| cell * self.position_gain(joint));
            }
        }
    }

    /// `dθ/dq` at the last reading.
    fn position_gain(&self, joint: usize) -> f64 {
        let gain = self.values.sensors[joint][SensorParameter::PositionGain as usize];
        let own = || self.session.terms.of_positions().filter(|term| term.joint == joint);
        let at = |step: f64| {
            let mut moved = self.positions.clone();
            moved[joint] += step;
            let at = Moment::new(&[], &[], &moved, &self.conditions);
            own().map(|term| term.value(&at, &self.values.further, None)).sum::<f64>()
        };
        if own().next().is_none() {
            return gain;
        }
        gain + (at(STEP) - at(-STEP)) / (2.0 * STEP)
    }

    /// Torques, or residuals.
    fn report_torques(&mut self, cells: &mut [f64], coordinates: &[f64]) {
        let torques = self.true_torques(coordinates);
        let gravity = self.gravity.as_mut().map(|model| model.torques(coordinates));
        for (joint, column) in self.columns.torques.iter().enumerate() {
            let Some(column) = column.filter(|column| !cells[*column].is_nan()) else { continue };
            let [lowest, highest] =
                self.session.readings.torques[joint].as_ref().map_or([None; 2], |(mapped, unit)| {
                    [mapped.lowest, mapped.highest].map(|end| end.map(|e| e * unit.to_si()))
                });
            if is_saturated(self.torques[joint], lowest, highest) {
                self.saturated[joint] += 1;
                cells[column] = f64::NAN;
                continue;
            }
            cells[column] = torques[joint] - gravity.map_or(0.0, |gravity| gravity[joint]);
            self.without_torque += u64::from(!cells[column].is_finite());
            match cells[column].is_finite() {
                true => self.friction_sign.count(joint, &self.conditions),
                false => cells[column] = f64::NAN,
            }
        }
    }

    /// Torques behind the last readings; NaN where they are not known.
    fn true_torques(&self, coordinates: &[f64]) -> Vec<f64> {
        let terms = &self.session.terms;
        if (0..self.torques.len()).all(|joint| terms.of_torque(joint).next().is_none()) {
            let affine = self.torques.iter().zip(&self.values.sensors);
            return affine.map(|(reading, [gain, bias, ..])| (reading - bias) / gain).collect();
        }
        let at = Moment::new(&[], coordinates, &self.positions, &self.conditions);
        let found = terms.torques(&self.torques, &at, &self.values);
        found.unwrap_or_else(|| vec![f64::NAN; self.torques.len()])
    }
}

/// Whether coordinates follow from the readings of their own joints alone.
fn check_stiffness(session: &Session) -> Result<(), ApplicationError> {
    let Some(first) = session.deflection.compliance else { return Ok(()) };
    let of_joints = (first..first + session.joints.len()).map(ParameterId::Further);
    let give_way = of_joints.filter(|id| session.parameter(*id).fixed.is_none());
    let names: Vec<String> = give_way.map(|id| session.parameter_name(id)).collect();
    if names.is_empty() { Ok(()) } else { Err(ApplicationError::Compliance { names }) }
}

/// Over what time velocities are slopes of a recording's positions, where sensors' models need them and no columns tell them: as the session says, or in
/// proportion to its windows in motion.
fn velocity_slope(session: &Session) -> Option<Slope> {
    let conditions = &session.readings.conditions;
    let needed = session.terms.models().any(|model| model.needs(Need::Velocity) || model.needs(Need::Direction));
    let windows = || session.searched.iter().find_map(|searched| searched.windows.as_ref());
    let slope = match &conditions.velocity {
        MotionSource::Columns(_) => None,
        MotionSource::Slope(slope) => Some(*slope),
        MotionSource::Unknown => windows().map(|windows| Slope { window: windows.length / SLOPES_IN_WINDOW }),
    };
    slope.filter(|_| needed)
}

/// Whether a recording says all that the sensors' models need.
fn check_conditions(session: &Session, by_slope: bool) -> Result<(), ApplicationError> {
    let columns = matches!(session.readings.conditions.velocity, MotionSource::Columns(_));
    let said = columns || by_slope;
    let directed = !session.readings.conditions.direction.is_empty();
    for model in session.terms.models() {
        let joint = session.robot.chain.joints()[model.joint].name.clone();
        if model.needs(Need::Time) {
            return Err(ApplicationError::Drift { joint, model: model.name.to_owned() });
        }
        if !said && (model.needs(Need::Velocity) || model.needs(Need::Direction) && !directed) {
            return Err(ApplicationError::NoVelocities { joint, model: model.name.to_owned() });
        }
    }
    Ok(())
}
