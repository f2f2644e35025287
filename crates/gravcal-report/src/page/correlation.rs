//! Correlations of what is determined: gravity and sensors, without the combinations of moments.

use gravcal_calibration::result::EstimatorResult;
use serde::Serialize;

use super::arrays::base64;

#[derive(Serialize)]
pub(super) struct Correlation {
    names: Vec<String>,
    matrix: String,
}

pub(super) fn correlation(result: &EstimatorResult) -> Correlation {
    let covariance = &result.covariance;
    let kept: Vec<usize> =
        (0..covariance.order.len()).filter(|place| !covariance.order[*place].starts_with("moments[")).collect();
    let entry = |i: usize, j: usize| {
        let scale = (covariance.matrix[i][i] * covariance.matrix[j][j]).sqrt();
        if scale > 0.0 { covariance.matrix[i][j] / scale } else { 0.0 }
    };
    Correlation {
        names: kept.iter().map(|place| covariance.order[*place].clone()).collect(),
        matrix: base64(kept.iter().flat_map(|i| kept.iter().map(move |j| entry(*i, *j)))),
    }
}
