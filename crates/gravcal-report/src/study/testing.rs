//! Studies for the tests of this folder.

use gravcal_study::batch::Manifest;
use gravcal_study::measures::{Measure, QuantityMeasures, Series};
use gravcal_study::plan::Axis;

/// Of each point.
pub const TRIALS: u64 = 400;

/// An axis of counts.
pub fn axis(name: &str, labels: &[&str]) -> Axis {
    let labels = labels.iter().map(|label| (*label).to_owned()).collect();
    Axis { name: name.to_owned(), unit: Some("count".to_owned()), labels, numbers: None }
}

/// Two quantities over the grid of some axes.
pub fn manifest(estimators: &[&str], axes: Vec<Axis>) -> Manifest {
    let grid = |points: Vec<Vec<usize>>, axis: &Axis| {
        let all = points.iter().flat_map(|point| (0..axis.labels.len()).map(move |at| [&point[..], &[at]].concat()));
        all.collect()
    };
    Manifest {
        gravcal: "0".to_owned(),
        fingerprint: "0".to_owned(),
        trials: TRIALS,
        estimators: estimators.iter().map(|name| (*name).to_owned()).collect(),
        solvers: vec!["levenberg-marquardt".to_owned()],
        points: axes.iter().fold(vec![Vec::new()], grid),
        axes,
        quantities: ["joint1.torque_gain", "joint1.torque_bias"].map(|name| (name.into(), "1".into())).to_vec(),
    }
}

/// rms, which is its ratio to the bound, and the share of intervals that hold.
pub fn quantity(rms: f64, coverage: f64, estimates: u64) -> QuantityMeasures {
    let measure = |value: f64| Measure { value: if estimates > 0 { value } else { f64::NAN }, error: 0.01 };
    QuantityMeasures {
        estimates,
        bias: measure(0.0),
        rms: measure(rms),
        ratio: measure(rms),
        nees: measure(1.0),
        coverage: measure(coverage),
        bound: 1.0,
    }
}

/// The first estimator of each point errs three times as much as the others; all intervals hold.
pub fn series(manifest: &Manifest) -> Vec<Series> {
    let places = (0..manifest.points.len()).flat_map(|at| (0..manifest.estimators.len()).map(move |of| (at, of)));
    let series = places.map(|(point, estimator)| Series {
        point,
        estimator,
        solver: 0,
        trials: TRIALS,
        outcomes: [TRIALS, 0, 0],
        iterations: Measure { value: 5.0, error: 0.1 },
        reasons: Vec::new(),
        quantities: vec![quantity(if estimator == 0 { 3.0 } else { 1.0 }, 0.95, TRIALS); 2],
    });
    series.collect()
}
