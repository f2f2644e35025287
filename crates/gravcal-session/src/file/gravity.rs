//! `[gravity]`: how strong, and roughly where to.

use gravcal_robot_model::session::GravityPrior;
use serde::Deserialize;

use super::normal_gravity::normal_gravity;
use crate::document::{Document, Field, FileError};

/// `[gravity]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct GravityTable {
    /// How strong gravity is. Give this, or latitude and altitude.
    ///
    /// Example: `magnitude_m_per_s2 = 9.80665`
    magnitude_m_per_s2: Option<f64>,
    /// Latitude, from which the strength follows (with `altitude_m`).
    ///
    /// Example: `latitude_deg = 48.1`
    latitude_deg: Option<f64>,
    /// Height above sea level.
    ///
    /// Example: `altitude_m = 520`
    altitude_m: Option<f64>,
    /// Standard deviation of the strength.
    ///
    /// Default: exact.
    /// Example: `magnitude_std_m_per_s2 = 0.001`
    magnitude_std_m_per_s2: Option<f64>,
    /// Rough direction of gravity in base coordinates. It settles the sign.
    ///
    /// Unit: none.
    /// Default: not known.
    /// Example: `hemisphere = [0, 0, -1]`
    hemisphere: Option<[f64; 3]>,
}

/// What `[gravity]` comes to.
pub(super) fn resolve(document: &Document, table: &GravityTable) -> Result<GravityPrior, FileError> {
    let magnitude_std = table.magnitude_std_m_per_s2.map(|std| {
        document.positive(&gravity("magnitude_std_m_per_s2"), std, "a standard deviation", "m/s² (or leave it out)")
    });
    Ok(GravityPrior {
        magnitude: magnitude(document, table)?,
        magnitude_std: magnitude_std.transpose()?,
        hemisphere: table.hemisphere.map(|written| direction(document, written)).transpose()?,
    })
}

fn gravity(key: &str) -> Field {
    Field::new("gravity").key(key)
}

fn magnitude(document: &Document, table: &GravityTable) -> Result<f64, FileError> {
    match (table.magnitude_m_per_s2, table.latitude_deg, table.altitude_m) {
        (Some(magnitude), None, None) => {
            document.positive(&gravity("magnitude_m_per_s2"), magnitude, "a magnitude of gravity", "m/s²")
        }
        (None, Some(latitude), Some(altitude)) => {
            check_range(document, "latitude_deg", latitude, [-90.0, 90.0])?;
            // From below the shore of the Dead Sea to above the highest summit.
            check_range(document, "altitude_m", altitude, [-1000.0, 9000.0])?;
            Ok(normal_gravity(latitude.to_radians(), altitude))
        }
        _ => Err(document.error(
            &Field::new("gravity"),
            "expected either magnitude_m_per_s2, or latitude_deg and altitude_m, and not both",
        )),
    }
}

fn check_range(document: &Document, key: &str, value: f64, [lower, upper]: [f64; 2]) -> Result<(), FileError> {
    if (lower..=upper).contains(&value) {
        return Ok(());
    }
    Err(document.error(&gravity(key), format!("expected a number from {lower} to {upper}, found {value}")))
}

/// Made a unit vector; scaled first, so that no square overflows or vanishes.
fn direction(document: &Document, written: [f64; 3]) -> Result<[f64; 3], FileError> {
    let largest = written.iter().fold(0.0, |largest: f64, component| largest.max(component.abs()));
    if largest == 0.0 {
        return Err(document.error(
            &gravity("hemisphere"),
            "a zero vector has no direction: expected the rough direction of gravity in base coordinates, [0, 0, -1] \
             for an upright base",
        ));
    }
    let scaled = written.map(|component| component / largest);
    let length = scaled.iter().map(|component| component * component).sum::<f64>().sqrt();
    Ok(scaled.map(|component| component / length))
}
