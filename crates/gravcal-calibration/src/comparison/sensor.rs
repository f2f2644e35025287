//! The parameters of one sensor in several calibrations.

use gravcal_recording::{EarlierEstimate, EarlierParameter};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::{ComparedParameter, ComparisonError};
use crate::parameter::Quantity;

const GRAVITY: [&str; 3] = ["gravity.x", "gravity.y", "gravity.z"];
/// Share of gravity's variance along itself below which its magnitude is taken as exact.
const EXACT_MAGNITUDE: f64 = 1e-9;

/// One sensor, before it is tested.
pub(super) struct Sensor {
    pub name: String,
    pub parameters: Vec<ComparedParameter>,
    pub left_out: Vec<String>,
    /// Of what is compared; `None` where that is nothing.
    pub estimates: Option<Estimates>,
}

/// Values and covariance by calibration, in units of the first one's standard deviations.
pub(super) struct Estimates {
    pub values: Vec<DVector<f64>>,
    pub covariances: Vec<DMatrix<f64>>,
}

/// Gravity, and every sensor of the first calibration.
pub(super) fn sensors(calibrations: &[&EarlierEstimate]) -> Result<Vec<Sensor>, ComparisonError> {
    let mut sensors = vec![gravity(calibrations)];
    let Some(first) = calibrations.first() else { return Ok(sensors) };
    let mut names: Vec<String> = Vec::new();
    for parameter in &first.parameters {
        let name = sensor_of(first, &parameter.name);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    for name in names {
        let own: Vec<&EarlierParameter> =
            first.parameters.iter().filter(|parameter| sensor_of(first, &parameter.name) == name).collect();
        sensors.push(sensor(calibrations, name, &own)?);
    }
    Ok(sensors)
}

/// `joint1 torque`, `joint1 position`, `joint1 compliance`; of what is no joint its own name.
fn sensor_of(estimate: &EarlierEstimate, parameter: &str) -> String {
    let (owner, quantity) = parameter.rsplit_once('.').unwrap_or((parameter, ""));
    let gain = Quantity::PositionGain.name(owner);
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

fn sensor(
    calibrations: &[&EarlierEstimate],
    name: String,
    own: &[&EarlierParameter],
) -> Result<Sensor, ComparisonError> {
    let (mut compared, mut left_out) = (Vec::new(), Vec::new());
    for parameter in own {
        check_unit(calibrations, parameter)?;
        match calibrations.iter().enumerate().find_map(|(index, other)| why_not(other, index, &parameter.name)) {
            None => compared.push(parameter.name.as_str()),
            Some(why) => left_out.push(format!("{} {why}", parameter.name)),
        }
    }
    let unit = |name: &str| own.iter().find(|parameter| parameter.name == name).map_or("", |p| p.unit.as_str());
    let parameters = compared.iter().map(|name| told(calibrations, name, unit(name))).collect();
    let estimates = (!compared.is_empty()).then(|| Estimates::new(calibrations, &compared).scaled());
    Ok(Sensor { name, parameters, left_out, estimates })
}

fn check_unit(calibrations: &[&EarlierEstimate], parameter: &EarlierParameter) -> Result<(), ComparisonError> {
    let same = calibrations.iter().filter_map(|other| other.parameters.iter().find(|p| p.name == parameter.name));
    match same.map(|other| &other.unit).find(|unit| **unit != parameter.unit) {
        None => Ok(()),
        Some(other) => Err(ComparisonError::Units {
            name: parameter.name.clone(),
            first: parameter.unit.clone(),
            other: other.clone(),
        }),
    }
}

/// Why a parameter of a calibration cannot be compared.
fn why_not(calibration: &EarlierEstimate, index: usize, name: &str) -> Option<String> {
    let which = index + 1;
    let Some(parameter) = calibration.parameters.iter().find(|parameter| parameter.name == name) else {
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
        calibration.gravity.is_none() || GRAVITY.iter().any(|axis| place(calibration, axis).is_none())
    });
    let name = "gravity".to_owned();
    if let Some(index) = lacking {
        let left_out = vec![format!("gravity is not determined in calibration {}", index + 1)];
        return Sensor { name, parameters: Vec::new(), left_out, estimates: None };
    }
    let parameters = GRAVITY.iter().map(|axis| told(calibrations, axis, "m/s²")).collect();
    let estimates = Estimates::new(calibrations, &GRAVITY).of_gravity();
    Sensor { name, parameters, left_out: Vec::new(), estimates: Some(estimates.scaled()) }
}

/// Where the covariance has a quantity.
fn place(calibration: &EarlierEstimate, name: &str) -> Option<usize> {
    calibration.quantities.iter().position(|known| matches!(known.terms.as_slice(), [(only, _)] if only == name))
}

fn told(calibrations: &[&EarlierEstimate], name: &str, unit: &str) -> ComparedParameter {
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
    fn new(calibrations: &[&EarlierEstimate], names: &[&str]) -> Estimates {
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

    /// In units of the first one's standard deviations, so that units do not matter to the digits.
    fn scaled(self) -> Estimates {
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
