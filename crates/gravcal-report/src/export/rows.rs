//! Gravity and every parameter as rows of a table.

use gravcal_recording::{EarlierEstimate, EarlierParameter};

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
            Some(gravity) => Status::Determined { value: gravity[axis], std: std(estimate, &name), ci95: None },
            None => Status::Undetermined,
        };
        Row { name, unit: "m/s²", status, nominal: None, convention: "in base coordinates, pointing down" }
    });
    gravity.chain(estimate.parameters.iter().map(parameter)).collect()
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
