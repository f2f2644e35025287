//! Sensors that moved beside the others, though by themselves they are where they were.
//!
//! Where little tells the scale of all torques, every gain is uncertain by as much, and all together: a gain that moved by less than that is seen only
//! beside the others. So the parameters of all sensors that did not move by themselves are held against one value for all calibrations, with
//! their whole covariance. If that is improbable, the sensor without which the others are explained best has moved (as outliers are found one by one;
//! Baarda, *A testing procedure for use in geodetic networks*, 1968), until the others agree.

use gravcal_recording::EarlierEstimate;

use super::compared::{BesideOthers, GRAVITY, SensorComparison};
use super::homogeneity::homogeneous;
use super::sensor::Estimates;

/// Probability below which sensors together are not where they were: a tenth of that of single ones, as it rests on all covariances.
const IMPROBABLE: f64 = 1e-3;

/// Names those that moved beside the others.
pub(super) fn name_moved(calibrations: &[&EarlierEstimate], sensors: &mut [SensorComparison], freedom: Option<f64>) {
    let still =
        |sensor: &SensorComparison| sensor.name != GRAVITY && sensor.test.as_ref().is_some_and(|test| !test.moved);
    let mut rest: Vec<usize> = (0..sensors.len()).filter(|index| still(&sensors[*index])).collect();
    while rest.len() > 1 {
        let probability = |without: Option<usize>| {
            let kept = rest.iter().filter(|index| Some(**index) != without);
            let names: Vec<&str> =
                kept.flat_map(|index| &sensors[*index].parameters).map(|parameter| parameter.name.as_str()).collect();
            let estimates = Estimates::new(calibrations, &names).scaled();
            homogeneous(&estimates, freedom).map(|(_, _, p_value)| p_value)
        };
        let Some(p_value) = probability(None).filter(|p_value| *p_value < IMPROBABLE) else { return };
        let mut without: Vec<(usize, f64)> =
            rest.iter().filter_map(|index| Some((*index, probability(Some(*index))?))).collect();
        without.sort_by(|a, b| b.1.total_cmp(&a.1));
        let Some((moved, left)) = without.first().copied() else { return };
        // Without any of these the others agree.
        let or: Vec<usize> =
            without[1..].iter().take_while(|(_, p_value)| *p_value >= IMPROBABLE).map(|(index, _)| *index).collect();
        let names = or.iter().map(|index| sensors[*index].name.clone()).collect();
        sensors[moved].beside_others = Some(BesideOthers { p_value, or: names });
        if let Some(test) = &mut sensors[moved].test {
            test.moved = true;
        }
        if left >= IMPROBABLE {
            return;
        }
        rest.retain(|index| *index != moved);
    }
}
