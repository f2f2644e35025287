//! Gravity and every parameter as rows of a table.

use gravcal_recording::{EarlierEstimate, EarlierParameter};

use crate::sensor_row::{split_name, tilt};

/// One row; numbers in the unit that stands beside them.
pub(super) struct Row<'a> {
    pub name: String,
    pub unit: &'a str,
    pub status: Status<'a>,
    /// Absent for gravity.
    pub nominal: Option<f64>,
    pub convention: &'a str,
}

/// What is known.
pub(super) enum Status<'a> {
    Determined { value: f64, std: Option<f64>, ci95: Option<[f64; 2]> },
    Held { value: f64, why: &'a str },
    Undetermined,
}

pub(super) fn rows(estimate: &EarlierEstimate) -> Vec<Row<'_>> {
    let gravity = ["x", "y", "z"].into_iter().enumerate().map(|(axis, name)| {
        let name = format!("gravity.{name}");
        let status = match estimate.gravity {
            Some(gravity) => Status::Determined {
                value: gravity[axis],
                std: std(estimate, &name),
                ci95: estimate.gravity_ci95.map(|intervals| intervals[axis]),
            },
            None => Status::Undetermined,
        };
        Row { name, unit: "m/s²", status, nominal: None, convention: "in base coordinates, pointing down" }
    });
    let parameters = estimate.parameters.iter().map(parameter);
    gravity.chain(angles(estimate)).chain(parameters).collect()
}

/// How well gravity's direction is known, and how far the base is from standing upright; rad.
fn angles(estimate: &EarlierEstimate) -> impl Iterator<Item = Row<'_>> {
    let row = |name: &str, value: f64, convention| Row {
        name: name.to_owned(),
        unit: "rad",
        status: Status::Determined { value, std: None, ci95: None },
        nominal: None,
        convention,
    };
    let cone = estimate.gravity.and(estimate.cone95_deg).map(|cone| {
        let meaning = "half-angle of the cone about gravity that holds its true direction with 95 % probability";
        row("gravity.cone95", cone.to_radians(), meaning)
    });
    let tilt = estimate
        .gravity
        .map(|gravity| row("gravity.tilt", tilt(gravity), "angle between gravity and the base's -z axis"));
    cone.into_iter().chain(tilt)
}

/// Each convention once, after the quantities that it is of: `torque_gain, torque_bias: reading = …`.
pub(super) fn conventions(rows: &[Row<'_>]) -> Vec<String> {
    let mut found: Vec<(&str, Vec<&str>)> = Vec::new();
    for row in rows {
        let (owner, quantity) = split_name(&row.name);
        let quantity = if owner == "gravity" && row.nominal.is_none() { row.name.as_str() } else { quantity };
        match found.iter_mut().find(|(convention, _)| *convention == row.convention) {
            Some((_, quantities)) if quantities.contains(&quantity) => {}
            Some((_, quantities)) => quantities.push(quantity),
            None => found.push((row.convention, vec![quantity])),
        }
    }
    found.into_iter().map(|(convention, quantities)| format!("{}: {convention}", quantities.join(", "))).collect()
}

fn parameter(parameter: &EarlierParameter) -> Row<'_> {
    let EarlierParameter { name, unit, value, held, std, ci95, convention, nominal } = parameter;
    let status = match (held, value) {
        (Some(why), value) => Status::Held { value: value.unwrap_or(*nominal), why },
        (None, Some(value)) => Status::Determined { value: *value, std: *std, ci95: *ci95 },
        (None, None) => Status::Undetermined,
    };
    Row { name: name.clone(), unit, status, nominal: Some(*nominal), convention }
}

/// By the covariance.
fn std(estimate: &EarlierEstimate, name: &str) -> Option<f64> {
    let alone = |terms: &[(String, f64)]| matches!(terms, [(only, _)] if only == name);
    let place = estimate.quantities.iter().position(|quantity| alone(&quantity.terms))?;
    Some(estimate.covariance[place * (estimate.quantities.len() + 1)].sqrt())
}
