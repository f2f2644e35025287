//! The links' inertias that a rigid body can have, nearest to what is assumed of them and to what the readings say.
//!
//! Readings determine combinations of masses, moments and tensors only, and errors make even these those of no body: masses below zero,
//! tensors that no distribution of mass has. A simulation or a controller needs bodies. So this finds them, after the joint estimate and from
//! it: from the information about the links' parameters that is left when all sensors, gravity and loads are unknown, as uncertain as the
//! estimate is told to be. What is told of sensors stays that of the estimate without it.

mod programme;

use gravcal_dynamics::BodyInertia;
use gravcal_estimation::{BlockId, Factor, Problem, RankAnalysis, Values};
use gravcal_identification::median;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{InertiaPrior, JointPriors, PriorKind, Session};
use nalgebra::{DMatrix, DVector};

use super::held_out::of_validation;
use crate::joint::error::{BuildError, EstimateError};
use crate::joint::solved::Solved;
use crate::joint::variables::State;
use crate::result::{ConsistentModel, LinkInertiaResult};
use programme::{Assumed, BODY, Programme};

/// How well a robot's file is taken to know its links where the session does not say.
const RELATIVE_STD: f64 = 0.3;
/// Least root mean square distance of an assumed body's mass from a plane through its centre, m: of a flat one the file says something that
/// no link is.
const LEAST_SPREAD: f64 = 0.01;
/// Share of a column in what the readings leave open from which on its standard deviation says nothing.
const OPEN: f64 = 1e-6;

/// The model, and remarks on it; nothing where the session asks for none.
pub(in crate::joint) fn consistent_model(
    session: &Session,
    solved: &Solved,
) -> Result<(Option<ConsistentModel>, Vec<String>), EstimateError> {
    if !session.constraints.physical_inertias || !solved.estimate.termination.converged() {
        return Ok((None, Vec::new()));
    }
    let (assumed, mut remarks) = assumed(session);
    let count = session.robot.chain.link_count();
    if assumed.len() < count || solved.built.variables.inertia.len() < count {
        remarks.push(
            "There are no consistent inertias: they need links ([inertia] description = \"link\") of each of which the robot states mass, \
             centre of mass and inertia tensor."
                .into(),
        );
        return Ok((None, remarks));
    }
    let problem = without_link_priors(solved)?;
    let values = &solved.estimate.values;
    let columns = Columns::new(solved, &problem);
    let residuals = problem.residuals(values)?;
    let weighted: Vec<f64> = residuals.iter().zip(problem.weights(values)?).map(|(r, weight)| r * weight).collect();
    let gradient = problem.transposed_product(values, &weighted)?;
    let left = RankAnalysis::new(&problem, values)?.eliminate_others(&columns.kept, &gradient)?;
    let inflation = solved.inflation();
    let programme = Programme {
        information: columns.spread_matrix(&left.information) / inflation,
        slope: columns.spread(&left.slope) / inflation,
        around: columns.values(values),
        assumed,
    };
    let Some(found) = programme.solve() else {
        remarks.push(
            "No consistent inertias were found: the search did not end. The other results are not touched by that. Give \
             [inertia] links = \"model\" with a smaller relative_std, if the robot's file is known better."
                .into(),
        );
        return Ok((None, remarks));
    };
    let off = &found - &programme.around;
    let step: Vec<f64> = columns.places.iter().map(|place| off[*place]).collect();
    let moved = columns.placed(problem.retract(values, &left.whole_step(&step)), &found);
    let state = solved.built.variables.state(&moved, &State::nominal(session));
    let held_out = match session.validation.is_empty() {
        true => None,
        false => of_validation(session, solved.readings(), state)?,
    };
    let growth = off.dot(&(&programme.information * &off)) + 2.0 * programme.slope.dot(&off);
    let model = ConsistentModel {
        links: links(session, &found),
        relative_std: relative_stds(session),
        tensors_from_readings: session.has_windows(),
        variance_inflation: inflation,
        chi_squared_growth: growth.max(0.0),
        held_out,
    };
    remarks.extend(remarks_on(session, &model));
    Ok((Some(model), remarks))
}

/// What the robot's file says of the links, and what had to be changed of that.
fn assumed(session: &Session) -> (Vec<Assumed>, Vec<String>) {
    let stated = session.robot.chain.inertial_parameters().unwrap_or_default();
    let (bodies, _) = stated.as_chunks::<BODY>();
    let (mut all, mut flat) = (Vec::new(), Vec::new());
    let links = session.robot.chain.links().iter().zip(bodies).zip(relative_stds(session));
    for ((link, body), relative_std) in links {
        let body = BodyInertia::from_parameters(*body);
        if body.mass <= 0.0 {
            continue;
        }
        let least = LEAST_SPREAD * LEAST_SPREAD;
        if body.least_spread() < least {
            flat.push(link.name.as_str());
        }
        all.push(Assumed { body: body.spread_at_least(least), weight: 1.0 / (relative_std * relative_std) });
    }
    let remark = (!flat.is_empty()).then(|| {
        format!(
            "The inertia tensors that the robot's file states of {} are those of no body, or of one that is thinner than {} mm: for \
             consistent inertias they were taken as thicker than that. Correct them in the file (the largest principal moment \
             must be less than the sum of the others).",
            flat.join(", "),
            1e3 * LEAST_SPREAD
        )
    });
    (all, remark.into_iter().collect())
}

/// How well each link's inertia is assumed to be known, relative to it.
fn relative_stds(session: &Session) -> Vec<f64> {
    let links = 0..session.robot.chain.link_count();
    match &session.inertia {
        InertiaPrior::Model { relative_std } => {
            links.map(|link| relative_std.get(link).copied().flatten().unwrap_or(RELATIVE_STD)).collect()
        }
        InertiaPrior::Unknown | InertiaPrior::Sweep => links.map(|_| RELATIVE_STD).collect(),
    }
}

/// The problem without what the session knows of each link beforehand: the programme has a better form of that.
fn without_link_priors(solved: &Solved) -> Result<Problem, EstimateError> {
    let variables = &solved.built.variables;
    let of_links: Vec<BlockId> = variables.inertia.iter().chain(&variables.tensors).copied().collect();
    let is_prior = |blocks: &[BlockId]| matches!(blocks, [only] if of_links.contains(only));
    let problem = solved.built.problem.without_reference();
    let readings = solved.built.rows.len() + solved.built.modelled.len();
    let keeps = |(index, factor): &(usize, &Factor)| {
        problem.rows_of(*index).start < readings || !is_prior(factor.residual.blocks())
    };
    let factors: Vec<Factor> =
        problem.factors().iter().enumerate().filter(keeps).map(|(_, factor)| factor.clone()).collect();
    if factors.len() == problem.factors().len() {
        return Ok(problem);
    }
    Ok(problem.with_only(factors, "no reading depends on it").map_err(BuildError::from)?)
}

/// Which of the problem's columns are which of the links' parameters.
struct Columns {
    kept: Vec<usize>,
    /// Of each kept column among the parameters, ten a link.
    places: Vec<usize>,
    /// Block and first component of each run of parameters: place, block, length.
    blocks: Vec<(usize, BlockId, usize)>,
    links: usize,
}

impl Columns {
    fn new(solved: &Solved, problem: &Problem) -> Columns {
        let variables = &solved.built.variables;
        let links = variables.inertia.len();
        let moments = variables.inertia.iter().enumerate().map(|(link, id)| (BODY * link, *id, 4));
        let tensors = variables.tensors.iter().take(links).enumerate().map(|(link, id)| (BODY * link + 4, *id, 6));
        let blocks: Vec<(usize, BlockId, usize)> = moments.chain(tensors).collect();
        let of_block = |(place, id, _): &(usize, BlockId, usize)| {
            let place = *place;
            problem.columns_of(*id).enumerate().map(move |(component, column)| (column, place + component))
        };
        let (kept, places) = blocks.iter().flat_map(of_block).unzip();
        Columns { kept, places, blocks, links }
    }

    /// Zero where a parameter has no column.
    fn spread_matrix(&self, kept: &[f64]) -> DMatrix<f64> {
        let mut all = DMatrix::zeros(BODY * self.links, BODY * self.links);
        for (row, of_row) in self.places.iter().zip(kept.chunks(self.places.len().max(1))) {
            self.places.iter().zip(of_row).for_each(|(column, entry)| all[(*row, *column)] = *entry);
        }
        all
    }

    fn spread(&self, kept: &[f64]) -> DVector<f64> {
        let mut all = DVector::zeros(BODY * self.links);
        self.places.iter().zip(kept).for_each(|(place, entry)| all[*place] = *entry);
        all
    }

    /// Zero where there is no block.
    fn values(&self, values: &Values) -> DVector<f64> {
        let mut all = DVector::zeros(BODY * self.links);
        for (place, id, length) in &self.blocks {
            (0..*length).for_each(|component| all[place + component] = values.get(*id)[component]);
        }
        all
    }

    /// Values with these parameters of the links, fixed ones included.
    fn placed(&self, mut values: Values, parameters: &DVector<f64>) -> Values {
        for (place, id, length) in &self.blocks {
            values.set(*id, &parameters.as_slice()[*place..place + length]);
        }
        values
    }
}

impl Solved {
    /// By how much the told variances exceed those of the noise: the median over what is known at all.
    fn inflation(&self) -> f64 {
        let (noise, reported) = (self.analysis.covariance(), self.covariance());
        let shared = 0..self.built.problem.columns().len();
        let known =
            shared.filter(|column| self.analysis.null_share(*column) < OPEN && noise.at(*column, *column) > 0.0);
        let mut ratios: Vec<f64> = known
            .map(|column| reported.at(column, column) / noise.at(column, column))
            .filter(|r| r.is_finite())
            .collect();
        median(&mut ratios).filter(|ratio| *ratio > 0.0).unwrap_or(1.0)
    }
}

fn links(session: &Session, parameters: &DVector<f64>) -> Vec<LinkInertiaResult> {
    let (bodies, _) = parameters.as_slice().as_chunks::<BODY>();
    let reported = session.robot.chain.links().iter().zip(bodies).map(|(link, body)| {
        let body = BodyInertia::from_parameters(*body);
        LinkInertiaResult {
            link: link.name.clone(),
            mass_kg: body.mass,
            center_of_mass_m: body.center_of_mass(),
            tensor_kg_m2: body.tensor_about_center(),
        }
    });
    reported.collect()
}

fn remarks_on(session: &Session, model: &ConsistentModel) -> Vec<String> {
    let mut remarks = Vec::new();
    if !model.tensors_from_readings {
        remarks.push(
            "Only arms at rest were read, which says nothing of inertia tensors: in consistent inertias they are those of the robot's \
             file, as far as masses and centres of mass allow. Record the arm in motion ([readings] motion = {}) to identify them."
                .into(),
        );
    }
    let gain = |joint: &JointPriors| joint.of(SensorParameter::TorqueGain).kind == PriorKind::Flat;
    let weighed = session.loads.iter().any(|load| !load.is_unknown());
    if !weighed && session.joints.iter().any(gain) {
        remarks.push(
            "Torque gains are unknown, and no load of known mass was attached: the scale of consistent masses is that of the robot's file."
                .into(),
        );
    }
    remarks
}
