//! Where what hangs beyond a force-torque sensor has its centre of mass: `c = h / m`, in the sensor's frame.

use gravcal_robot_model::number::{measured, shortest};
use gravcal_robot_model::parameter::ParameterId;
use gravcal_robot_model::session::{AuxiliarySensor, AuxiliarySensorKind, Session};

use crate::joint::Solved;
use crate::result::ParameterResult;

/// A mass within so many of its standard deviations of zero says nothing of a centre.
const BEYOND_ZERO: f64 = 3.0;

/// One sentence for each sensor whose tool's mass and first moment both have values; `parameters` are those of the session, in its order.
pub(crate) fn tool_notes(session: &Session, solved: &Solved, parameters: &[ParameterResult]) -> Vec<String> {
    let wrists = session.instruments.iter().filter(|instrument| instrument.kind == AuxiliarySensorKind::ForceTorque);
    wrists.filter_map(|wrist| tool_note(session, solved, parameters, wrist)).collect()
}

fn tool_note(
    session: &Session,
    solved: &Solved,
    parameters: &[ParameterResult],
    wrist: &AuxiliarySensor,
) -> Option<String> {
    let ids: Vec<ParameterId> = wrist.own_parameters().map(ParameterId::Further).collect();
    let of = |id: &ParameterId| parameters.iter().zip(session.parameters()).find(|(_, other)| other == id)?.0.value;
    let values: Vec<f64> = ids.iter().filter_map(of).collect();
    let [mass, moment @ ..] = values.as_slice() else { return None };
    if moment.len() != 3 || mass.abs() <= BEYOND_ZERO * solved.parameter_std(ids[0]) {
        return None;
    }
    let along = |axis: usize| {
        let center = moment[axis] / mass;
        let changes = [(ids[1 + axis], 1.0 / mass), (ids[0], -center / mass)];
        let columns: Vec<(usize, f64)> =
            changes.iter().flat_map(|(id, by)| column(solved, *id).map(|at| (at, *by))).collect();
        let name = ["x", "y", "z"][axis];
        match solved.covariance().std_of(&columns) {
            std if std > 0.0 => {
                let (center, std) = measured(center, std);
                format!("{name} = {center} ± {std}")
            }
            _ => format!("{name} = {}", shortest(center)),
        }
    };
    Some(format!(
        "What hangs beyond {} has its centre of mass at {}, {}, {} (m, in the sensor's frame: tool_moment / tool_mass).",
        wrist.name,
        along(0),
        along(1),
        along(2)
    ))
}

/// The column of a parameter; `None` where it is fixed.
fn column(solved: &Solved, id: ParameterId) -> Option<usize> {
    solved.built.problem.columns_of(solved.built.variables.block(id)).next()
}
