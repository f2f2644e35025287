//! The parameters of one sensor in several calibrations.

use gravcal_recording::{EarlierEstimate, EarlierParameter};
use gravcal_robot_model::parameter::{SensorParameter, UNREAD};
use gravcal_robot_model::session::NO_TORQUE_SENSOR;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::compared::{ComparedParameter, ComparisonError, GRAVITY, LeftOut};

const GRAVITY_COMPONENTS: [&str; 3] = ["gravity.x", "gravity.y", "gravity.z"];
/// Share of gravity's variance along itself below which its magnitude is taken as exact.
const EXACT_MAGNITUDE: f64 = 1e-9;

/// One sensor, before it is tested.
pub(super) struct Sensor {
    pub name: String,
    pub parameters: Vec<ComparedParameter>,
    pub left_out: Vec<LeftOut>,
    /// Whether all calibrations have it.
    pub in_all: bool,
    /// Parameters that only some of its models have.
    pub models_differ_in: Vec<String>,
    /// Of what is compared; `None` where that is nothing.
    pub estimates: Option<Estimates>,
}

/// Values and covariance by calibration, in units of the first one's standard deviations.
pub(super) struct Estimates {
    pub values: Vec<DVector<f64>>,
    pub covariances: Vec<DMatrix<f64>>,
}

/// Gravity, and every sensor that any of the calibrations has.
pub(super) fn sensors(calibrations: &[&EarlierEstimate]) -> Result<Vec<Sensor>, ComparisonError> {
    let mut names: Vec<String> = Vec::new();
    for calibration in calibrations {
        for parameter in &calibration.parameters {
            let name = sensor_of(calibration, &parameter.name);
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    let mut sensors = vec![gravity(calibrations)];
    for name in names {
        sensors.push(sensor(calibrations, name)?);
    }
    Ok(sensors)
}

/// `joint1 torque`, `joint1 position`, `joint1 compliance`; of what is no joint its own name.
fn sensor_of(estimate: &EarlierEstimate, parameter: &str) -> String {
    let (owner, quantity) = parameter.rsplit_once('.').unwrap_or((parameter, ""));
    let gain = SensorParameter::PositionGain.name(owner);
    if estimate.parameters.iter().all(|other| other.name != gain) {
        return owner.to_owned();
    }
    let what = match quantity {
        "compliance" => "compliance",
        position if position.starts_with("position_") => "position",
        _ => "torque",
    };
    format!("{owner} {what}")
}

fn sensor(calibrations: &[&EarlierEstimate], name: String) -> Result<Sensor, ComparisonError> {
    let own = parameters_of(calibrations, &name);
    for parameter in &own {
        check_unit(calibrations, &parameter.name)?;
    }
    if let Some(index) = calibrations.iter().position(|calibration| !has(calibration, &name)) {
        let can_move = own.iter().any(|parameter| can_move(calibrations, &parameter.name));
        let left_out =
            vec![LeftOut { name: name.clone(), why: format!("is not in calibration {}", index + 1), can_move }];
        return Ok(Sensor {
            name,
            parameters: Vec::new(),
            left_out,
            in_all: false,
            models_differ_in: Vec::new(),
            estimates: None,
        });
    }
    let (mut compared, mut left_out) = (Vec::new(), Vec::new());
    for parameter in &own {
        let name = &parameter.name;
        match calibrations.iter().enumerate().find_map(|(index, other)| why_not(other, index, name)) {
            None => compared.push((name.as_str(), parameter.unit.as_str())),
            Some(why) => {
                left_out.push(LeftOut { name: name.clone(), why, can_move: can_move(calibrations, name) });
            }
        }
    }
    let estimates = |names: &[&str]| Estimates::new(calibrations, names);
    let (parameters, estimates) = comparable(calibrations, &compared, estimates, &mut left_out);
    let models_differ_in = own.iter().filter(|parameter| in_some_models_only(calibrations, parameter));
    let models_differ_in = models_differ_in.map(|parameter| parameter.name.clone()).collect();
    Ok(Sensor { name, parameters, left_out, in_all: true, models_differ_in, estimates })
}

/// What is told and tested of these parameters (name and unit), if their covariances can be inverted; else the reason is left out.
fn comparable(
    calibrations: &[&EarlierEstimate],
    compared: &[(&str, &str)],
    estimates: impl Fn(&[&str]) -> Estimates,
    left_out: &mut Vec<LeftOut>,
) -> (Vec<ComparedParameter>, Option<Estimates>) {
    let names: Vec<&str> = compared.iter().map(|(name, _)| *name).collect();
    if names.is_empty() {
        return (Vec::new(), None);
    }
    let estimates = estimates(&names);
    if let Some(index) = estimates.not_positive_definite() {
        let why =
            format!("is not compared: its sensor's covariance in calibration {} is not positive definite", index + 1);
        left_out.extend(names.iter().map(|name| LeftOut {
            name: (*name).to_owned(),
            why: why.clone(),
            can_move: true,
        }));
        return (Vec::new(), None);
    }
    let reported = compared.iter().map(|(name, unit)| reported(calibrations, name, unit)).collect();
    (reported, Some(estimates.scaled()))
}

/// The parameters of a sensor, each as the first calibration says that has it.
fn parameters_of<'a>(calibrations: &[&'a EarlierEstimate], sensor: &str) -> Vec<&'a EarlierParameter> {
    let mut own: Vec<&EarlierParameter> = Vec::new();
    for calibration in calibrations {
        for parameter in &calibration.parameters {
            let known = own.iter().any(|other| other.name == parameter.name);
            if !known && sensor_of(calibration, &parameter.name) == sensor {
                own.push(parameter);
            }
        }
    }
    own
}

fn has(calibration: &EarlierEstimate, sensor: &str) -> bool {
    calibration.parameters.iter().any(|parameter| sensor_of(calibration, &parameter.name) == sensor)
}

fn parameter<'a>(calibration: &'a EarlierEstimate, name: &str) -> Option<&'a EarlierParameter> {
    calibration.parameters.iter().find(|parameter| parameter.name == name)
}

/// Whether any of the calibrations has what could move: not so a torque sensor that is not there, nor an axis that is not read.
fn can_move(calibrations: &[&EarlierEstimate], name: &str) -> bool {
    let absent = [Some(NO_TORQUE_SENSOR), Some(UNREAD)];
    calibrations.iter().filter_map(|other| parameter(other, name)).any(|found| !absent.contains(&found.held.as_deref()))
}

/// A parameter that is fixed at zero says nothing, as if it were not there.
fn in_some_models_only(calibrations: &[&EarlierEstimate], own: &EarlierParameter) -> bool {
    let says_something =
        |parameter: &EarlierParameter| parameter.held.is_none() || parameter.value.unwrap_or(parameter.nominal) != 0.0;
    says_something(own) && calibrations.iter().any(|other| parameter(other, &own.name).is_none())
}

fn check_unit(calibrations: &[&EarlierEstimate], name: &str) -> Result<(), ComparisonError> {
    let unit = |calibration: &&EarlierEstimate| parameter(calibration, name).map(|found| found.unit.clone());
    let units: Vec<(usize, String)> =
        calibrations.iter().enumerate().filter_map(|(index, other)| Some((index, unit(other)?))).collect();
    for pair in units.windows(2) {
        if let [(first, one), (second, other)] = pair
            && one != other
        {
            return Err(ComparisonError::Units {
                name: name.to_owned(),
                units: [one.clone(), other.clone()],
                calibrations: [*first, *second],
            });
        }
    }
    Ok(())
}

/// Why a parameter of a calibration cannot be compared.
fn why_not(calibration: &EarlierEstimate, index: usize, name: &str) -> Option<String> {
    let which = index + 1;
    let Some(parameter) = parameter(calibration, name) else {
        return Some(format!("is not in calibration {which}"));
    };
    match parameter {
        EarlierParameter { held: Some(why), .. } => Some(format!("is held in calibration {which} ({why})")),
        EarlierParameter { value: None, .. } => Some(format!("is not determined in calibration {which}")),
        _ if place(calibration, name).is_none() => Some(format!("has no covariance in calibration {which}")),
        _ => None,
    }
}

fn gravity(calibrations: &[&EarlierEstimate]) -> Sensor {
    let lacking = calibrations.iter().position(|calibration| {
        calibration.gravity.is_none() || GRAVITY_COMPONENTS.iter().any(|axis| place(calibration, axis).is_none())
    });
    let (mut left_out, mut compared) = (Vec::new(), GRAVITY_COMPONENTS.map(|axis| (axis, "m/s²")).to_vec());
    if let Some(index) = lacking {
        let why = format!("is not determined in calibration {}", index + 1);
        left_out.push(LeftOut { name: GRAVITY.to_owned(), why, can_move: true });
        compared.clear();
    }
    let estimates = |names: &[&str]| Estimates::new(calibrations, names).of_gravity();
    let (parameters, estimates) = comparable(calibrations, &compared, estimates, &mut left_out);
    Sensor { name: GRAVITY.to_owned(), parameters, left_out, in_all: true, models_differ_in: Vec::new(), estimates }
}

/// Where the covariance has a quantity.
fn place(calibration: &EarlierEstimate, name: &str) -> Option<usize> {
    calibration.quantities.iter().position(|known| matches!(known.terms.as_slice(), [(only, _)] if only == name))
}

fn reported(calibrations: &[&EarlierEstimate], name: &str, unit: &str) -> ComparedParameter {
    let Estimates { values, covariances } = Estimates::new(calibrations, &[name]);
    ComparedParameter {
        name: name.to_owned(),
        unit: unit.to_owned(),
        values: values.iter().map(|value| value[0]).collect(),
        stds: covariances.iter().map(|covariance| covariance[(0, 0)].sqrt()).collect(),
    }
}

impl Estimates {
    /// Of quantities that every covariance has.
    pub fn new(calibrations: &[&EarlierEstimate], names: &[&str]) -> Estimates {
        let of = |calibration: &&EarlierEstimate| {
            let places: Vec<usize> = names.iter().filter_map(|name| place(calibration, name)).collect();
            let all = calibration.quantities.len();
            let value = DVector::from_iterator(places.len(), places.iter().map(|i| calibration.quantities[*i].value));
            let entry = |i: usize, j: usize| calibration.covariance[places[i] * all + places[j]];
            (value, DMatrix::from_fn(places.len(), places.len(), entry))
        };
        let (values, covariances) = calibrations.iter().map(of).unzip();
        Estimates { values, covariances }
    }

    /// The directions of gravity in the plane across their mean, where its magnitude is exact in any of the calibrations.
    fn of_gravity(self) -> Estimates {
        let sum = self.values.iter().fold(Vector3::zeros(), |sum, g| sum + Vector3::new(g[0], g[1], g[2]).normalize());
        let mean = sum.normalize();
        let exact = self.covariances.iter().zip(&self.values).any(|(covariance, g)| {
            let (covariance, along) =
                (Matrix3::from_fn(|i, j| covariance[(i, j)]), Vector3::new(g[0], g[1], g[2]).normalize());
            along.dot(&(covariance * along)) <= EXACT_MAGNITUDE * covariance.trace()
        });
        if !exact {
            return self;
        }
        let least = mean.iamin();
        let first = mean.cross(&Vector3::ith(least, 1.0)).normalize();
        let across = DMatrix::from_rows(
            &[first.transpose(), mean.cross(&first).transpose()]
                .map(|row| nalgebra::RowDVector::from_iterator(3, row.iter().copied())),
        );
        Estimates {
            values: self.values.iter().map(|g| &across * g / g.norm()).collect(),
            covariances: self
                .covariances
                .iter()
                .zip(&self.values)
                .map(|(covariance, g)| &across * covariance * across.transpose() / g.norm_squared())
                .collect(),
        }
    }

    /// The first calibration whose covariance cannot be inverted.
    fn not_positive_definite(&self) -> Option<usize> {
        self.covariances.iter().position(|covariance| {
            let scale = DMatrix::from_diagonal(&covariance.diagonal().map(|variance| 1.0 / variance.sqrt()));
            (&scale * covariance * &scale).cholesky().is_none()
        })
    }

    /// In units of the first one's standard deviations, so that units do not matter to the digits.
    pub fn scaled(self) -> Estimates {
        let Some(first) = self.covariances.first() else { return self };
        let scale =
            DVector::from_iterator(first.nrows(), first.diagonal().iter().map(|variance| 1.0 / variance.sqrt()));
        Estimates {
            values: self.values.iter().map(|value| value.component_mul(&scale)).collect(),
            covariances: self
                .covariances
                .iter()
                .map(|covariance| DMatrix::from_diagonal(&scale) * covariance * DMatrix::from_diagonal(&scale))
                .collect(),
        }
    }
}
