//! Figures: their places on the page, and their data.

use std::collections::BTreeMap;

use gravcal_calibration::result::{EstimatorResult, ReadingResidual, TorqueParts};
use gravcal_recording::{PositionUnit, file_name};
use gravcal_robot_model::Session;
use gravcal_robot_model::session::ReadingId;
use gravcal_robot_model::sweeps::{Sweep, find_sweeps};
use maud::{Markup, html};
use serde::Serialize;

use super::CalibrationPage;
use super::arrays::base64;
use super::correlation::{Correlation, correlation};
use super::spectra::{Spectra, spectra};
use crate::json::JsonError;

/// What the script draws.
#[derive(Serialize)]
struct Data<'a> {
    joints: Vec<Joint>,
    tables: Vec<String>,
    poses: Poses,
    sweeps: Vec<SweepData>,
    channels: Vec<Channel>,
    estimators: Vec<Estimator<'a>>,
    correlation: Option<Correlation>,
}

#[derive(Serialize)]
struct Joint {
    name: String,
    unit: String,
    /// Readings by pose, in degrees where they are angles.
    positions: String,
}

#[derive(Serialize)]
struct Poses {
    count: usize,
    table: String,
    line: String,
    /// s since the first pose; absent where it is not known.
    time: Option<String>,
}

#[derive(Serialize)]
struct SweepData {
    swept: usize,
    first: usize,
    count: usize,
    told: String,
}

/// A reading by pose.
#[derive(Serialize)]
struct Channel {
    index: usize,
    name: String,
    unit: String,
    readings: String,
}

#[derive(Serialize)]
struct Estimator<'a> {
    name: &'a str,
    channels: Vec<Residuals>,
}

/// By pose, prediction less reading.
#[derive(Serialize)]
struct Residuals {
    index: usize,
    after: String,
    /// Of the estimator that decides only.
    before: Option<String>,
    /// One for all readings, or one for each.
    std: Option<f64>,
    stds: Option<String>,
    /// Only where a loss counts some less.
    weights: Option<String>,
    /// Of the estimator that decides, where an arm in motion was read.
    parts: Option<Parts>,
    spectra: Option<Spectra>,
}

/// By pose, of what the prediction is made.
#[derive(Serialize)]
struct Parts {
    gravity: String,
    inertia: String,
    bias: String,
}

pub(super) fn section(page: &CalibrationPage<'_>) -> Markup {
    let Some(main) = page.drawn().first().copied() else { return html! {} };
    html! {
        section.figures {
            h2 { "Fit" }
            p.small {
                "Readings against the angle of the joint that sweeps, with what the calibrated model predicts (line) and what it predicts "
                "with sensors at their nominal values (dashed). Point at a reading to see its pose."
            }
            div.controls {
                label { "reading " select #fit-channel {} }
                label { "poses " select #fit-sweep {} }
            }
            canvas #fit data-height="340" {}
            p #fit-legend .small {}
            p #fit-hover .hover {}
            @if residuals(main).any(|residual| residual.torque.is_some()) {
                h2 { "Torque over time" }
                p.small {
                    "Of what the model makes the readings of an arm in motion: gravity, inertia (accelerations and velocities of links, loads and "
                    "rotors), and friction with whatever else the sensor does, each without the bias."
                }
                div.controls {
                    label { "reading " select #parts-channel {} }
                    label { "recording " select #parts-table {} }
                }
                canvas #parts data-height="340" {}
                p #parts-legend .small {}
                p #parts-hover .hover {}
            }
            h2 { "Residuals" }
            p.small {
                "Prediction less reading in standard deviations. Rings: beyond 3.5, or counted less than half by a loss, unless a fifth of all are. A shape over the angle "
                "is a sensor's or the model's, over time a drift."
            }
            div.controls {
                label { "estimator " select #estimator {} }
                label { "against " select #against {} }
            }
            div #residuals .panels {}
            p #residual-hover .hover {}
            @if page.session.has_windows() {
                h2 { "Spectrum of residuals" }
                p.small {
                    "Of an arm in motion, as amplitude spectral densities over frequency: what the model leaves of the readings (blue) beside the readings "
                    "themselves (grey). Where blue nears grey the model explains nothing, where it is above the recorder filtered the torques; a peak is a "
                    "resonance, a gear or a controller. Beyond the dashed line windows let little of either pass."
                }
                div #spectra .panels {}
                p #spectrum-hover .hover {}
            }
            h2 { "Is it noise?" }
            p.small {
                "Left of each pair: residuals in order against normal quantiles; noise of the stated size lies on the line. Right: how alike "
                "residuals of neighbouring poses are; beyond the band neighbours share errors, which is model error."
            }
            div #normality .panels {}
            @if !main.covariance.order.is_empty() {
                h2 { "Correlations" }
                p.small { "Of what " (page.main().map_or("", |main| main.name.as_str())) " determines: two that go together (dark; blue where both rise, orange where one falls) the data tell apart badly." }
                canvas #correlation data-height="420" {}
                p #correlation-hover .hover {}
            }
            noscript { p { "The figures need JavaScript; everything else is on this page without it." } }
        }
    }
}

pub(super) fn data(page: &CalibrationPage<'_>) -> Result<String, JsonError> {
    let (session, drawn) = (page.session, page.drawn());
    let channels: Vec<usize> = (0..session.channel_count())
        .filter(|channel| drawn.iter().any(|result| residuals(result).any(|residual| residual.id.channel == *channel)))
        .collect();
    let data = Data {
        joints: joints(session),
        tables: session.tables.iter().map(|table| file_name(&table.path)).collect(),
        poses: poses(session),
        sweeps: sweeps(session),
        channels: channels.iter().map(|channel| readings(session, *channel)).collect(),
        estimators: drawn
            .iter()
            .enumerate()
            .map(|(place, result)| Estimator {
                name: &result.name,
                channels: channels.iter().map(|channel| of_channel(session, result, *channel, place == 0)).collect(),
            })
            .collect(),
        correlation: drawn.first().map(|result| correlation(result)),
    };
    crate::json::compact(&data)
}

fn residuals(result: &EstimatorResult) -> impl Iterator<Item = &ReadingResidual> {
    result.fit.iter().flat_map(|fit| &fit.residuals)
}

fn joints(session: &Session) -> Vec<Joint> {
    let joint = |(index, described): (usize, &gravcal_dynamics::Joint)| {
        let (unit, factor) = match session.joints[index].position_unit.si() {
            PositionUnit::Radian => ("deg".to_owned(), 1_f64.to_degrees()),
            other => (other.to_string(), 1.0),
        };
        let readings = session.poses.iter().map(|pose| factor * pose.position[index]);
        Joint { name: described.name.clone(), unit, positions: base64(readings) }
    };
    session.robot.chain.joints().iter().enumerate().map(joint).collect()
}

fn poses(session: &Session) -> Poses {
    let times: Option<Vec<f64>> = session.poses.iter().map(|pose| pose.conditions.time).collect();
    Poses {
        count: session.poses.len(),
        table: base64(session.poses.iter().map(|pose| pose.table as f64)),
        line: base64(session.poses.iter().map(|pose| pose.line as f64)),
        time: times.map(base64),
    }
}

fn sweeps(session: &Session) -> Vec<SweepData> {
    let told = |sweep: &Sweep| {
        let load = sweep.load.map_or_else(String::new, |load| format!(" with {}", session.loads[load].name));
        format!(
            "{} sweeps, {}{load}",
            session.robot.chain.joints()[sweep.swept].name,
            file_name(&session.tables[sweep.table].path)
        )
    };
    let sweeps = find_sweeps(session);
    let data = |sweep: &Sweep| {
        Some(SweepData {
            swept: sweep.swept,
            first: *sweep.poses.first()?,
            count: sweep.poses.len(),
            told: told(sweep),
        })
    };
    sweeps.iter().filter_map(data).collect()
}

fn readings(session: &Session, channel: usize) -> Channel {
    let reading = |pose: usize| session.reading(ReadingId { pose, channel }).map_or(f64::NAN, |reading| reading.value);
    Channel {
        index: channel,
        name: session.channel_name(channel),
        unit: session.channel_unit(channel),
        readings: base64((0..session.poses.len()).map(reading)),
    }
}

fn of_channel(session: &Session, result: &EstimatorResult, channel: usize, decides: bool) -> Residuals {
    let own: BTreeMap<usize, &ReadingResidual> = residuals(result)
        .filter(|residual| residual.id.channel == channel)
        .map(|residual| (residual.id.pose, residual))
        .collect();
    let by_pose = |of: &dyn Fn(&ReadingResidual) -> f64| {
        base64((0..session.poses.len()).map(|pose| own.get(&pose).map_or(f64::NAN, |residual| of(residual))))
    };
    let first = own.values().next().map(|residual| residual.std);
    let std = first.filter(|first| own.values().all(|residual| residual.std == *first));
    let weighted = own.values().any(|residual| residual.weight < 1.0);
    Residuals {
        index: channel,
        after: by_pose(&|residual| residual.residual),
        before: decides.then(|| by_pose(&|residual| residual.nominal_residual)),
        std,
        stds: std.is_none().then(|| by_pose(&|residual| residual.std)),
        weights: weighted.then(|| by_pose(&|residual| residual.weight)),
        parts: (decides && own.values().any(|residual| residual.torque.is_some())).then(|| {
            let part =
                |of: &dyn Fn(&TorqueParts) -> f64| by_pose(&|residual| residual.torque.as_ref().map_or(f64::NAN, of));
            Parts {
                gravity: part(&|torque| torque.gravity),
                inertia: part(&|torque| torque.inertia),
                bias: part(&|torque| torque.bias),
            }
        }),
        spectra: if decides { spectra(session, &own) } else { None },
    }
}
