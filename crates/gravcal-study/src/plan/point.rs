//! One point of a study's grid: how its trials are made.

use gravcal_calibration::joint::State;
use gravcal_robot_model::Session;
use gravcal_robot_model::parameter::ParameterId;
use serde::{Deserialize, Serialize};

use super::source::{Drawn, Source};
use crate::quantities::{Measured, measured_quantities};

/// What is varied, and the values it takes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// In words.
    pub name: String,
    /// Unit of the values.
    pub unit: Option<String>,
    /// The values in words.
    pub labels: Vec<String>,
    /// The values, where all of them are numbers.
    pub numbers: Option<Vec<f64>>,
}

/// `noise = 0.3 count, range = 90 deg`; nothing where nothing is varied.
pub(crate) fn reported(axes: &[Axis], places: &[usize]) -> String {
    let each = axes.iter().zip(places).map(|(axis, place)| {
        let unit = axis.unit.as_ref().map_or_else(String::new, |unit| format!(" {unit}"));
        format!("{} = {}{unit}", axis.name, axis.labels[*place])
    });
    each.collect::<Vec<_>>().join(", ")
}

/// Place on each axis of a point of the grid, of axes of these sizes; the last axis runs fastest.
pub(crate) fn places(mut index: usize, sizes: &[usize]) -> Vec<usize> {
    let mut places: Vec<usize> = sizes
        .iter()
        .rev()
        .map(|size| {
            let place = index % size;
            index /= size;
            place
        })
        .collect();
    places.reverse();
    places
}

/// One point.
#[derive(Debug)]
pub struct Point {
    /// Place on each axis.
    pub places: Vec<usize>,
    pub(super) source: Source,
    pub(super) seed: u64,
}

/// One trial: what is to be calibrated, and the truth.
pub(crate) struct Instance {
    pub session: Session,
    /// In the session's own terms.
    pub truth: State,
    /// What is measured of it, with the place among the study's quantities.
    pub measured: Vec<(usize, Measured)>,
}

impl Point {
    /// The trial of this number, which with the seed alone decides everything random.
    pub(crate) fn instance(&self, trial: u64, names: &[(String, String)]) -> Result<Instance, String> {
        let Drawn { simulation, mut session, stated } = self.source.draw(self.seed, trial)?;
        let drawn = simulation.session(trial);
        session.poses = drawn.poses;
        session.saturated = drawn.saturated;
        for (pose, stated) in session.poses.iter_mut().zip(stated) {
            for (reading, stated) in pose.torque.iter_mut().zip(stated) {
                if let (Some(reading), Some(stated)) = (reading, stated) {
                    reading.std = stated.std;
                }
            }
        }
        let truth = in_terms_of(&session, &simulation.template, &simulation.truth);
        let place = |measured: &Measured| {
            let name = measured.name(&session);
            names.iter().position(|(known, _)| *known == name)
        };
        let all = measured_quantities(&session);
        let measured = all.into_iter().filter_map(|m| Some((place(&m)?, m))).collect();
        Ok(Instance { session, truth, measured })
    }

    /// Whether the Cramér-Rao bound differs from trial to trial.
    pub(crate) fn bound_varies(&self) -> bool {
        self.source.varies()
    }
}

/// The truth in the terms of a session that may declare more, or less, than the simulation has: what the simulation does not
/// have is at its nominal value, which is that of a sensor without it.
fn in_terms_of(session: &Session, template: &Session, truth: &State) -> State {
    let mut own = State { further: State::nominal(session).further, ..truth.clone() };
    for (index, parameter) in session.further.iter().enumerate() {
        let name = parameter.name();
        let same = template.further.iter().position(|other| other.name() == name);
        if let Some(same) = same {
            *own.value_mut(ParameterId::Further(index)) = truth.value(ParameterId::Further(same));
        }
    }
    own
}
