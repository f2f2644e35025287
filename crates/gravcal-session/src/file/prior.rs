//! `[prior]`: what an earlier calibration knows.

use gravcal_recording::{
    Digest, EarlierEstimate, EarlierInput, EarlierParameter, InputRole, Memory, Part, read_earlier, read_earlier_inputs,
};
use gravcal_robot_model::EstimatorName;
use gravcal_robot_model::number::{rounded, shown_unit};
use gravcal_robot_model::parameter::{Limit, Parameter, ParameterId, SensorParameter};
use gravcal_robot_model::session::{
    EarlierCalibration, InertiaPrior, InputFile, KnownCombination, LAST_FRAME_CHOICE, Load, PriorKind, Session,
};
use serde::Deserialize;

use super::context::Context;
use super::poses::WrittenTables;
use crate::document::{Field, FileError};

/// Gravity's magnitude may differ from the earlier session's by this share: more is another place on Earth.
const SAME_PLACE: f64 = 1e-3;
/// What is held twice is held at the same value if it differs by less, relative to 1.
const SAME_VALUE: f64 = 1e-9;

/// `[prior]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct PriorTable {
    /// The earlier `calibration.json`. Parameters of the same names are taken with their whole covariance. Do not state a std for them
    /// again. Only a mounting, a compliance and a load's mass keep theirs, as they are exact without it; gravcal does not count it twice.
    ///
    /// Example: `calibration = "last-week/calibration.json"`
    calibration: String,
    /// Whose answer is taken.
    ///
    /// Default: `"joint"`.
    /// Example: `estimator = "joint"`
    estimator: Option<String>,
    /// What else is as it was then: `"base"` (gravity), `"links"` (masses and moments), `"loads"` (placements).
    ///
    /// Default: `[]`.
    /// Example: `unchanged = ["base", "links", "loads"]`
    #[serde(default)]
    unchanged: Vec<Unchanged>,
}

/// What is as it was then, besides the sensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Unchanged {
    /// The base has not moved: gravity.
    Base,
    /// The links: their masses and moments.
    Links,
    /// The loads, which hang where they hung: their placements.
    Loads,
}

/// The session with what the earlier calibration knows: as a prior, and as the start of what has no other. What is unknown only by a
/// standard deviation keeps that in the file, and is known from there in its place.
/// `written`: the session's tables.
pub(super) fn resolve(
    context: &Context<'_>,
    table: &PriorTable,
    (written, memory): (WrittenTables<'_>, &Memory),
    session: Session,
) -> Result<Session, FileError> {
    let section = Section { context, table, session: &session };
    let field = |key: &str| Field::new("prior").key(key);
    let path = context.document.resolve_path(&field("calibration"), &table.calibration)?;
    let estimator = section.estimator()?;
    let earlier = read_earlier(&path, estimator.as_str()).map_err(|e| section.error("calibration", e))?;
    earlier.parameters.iter().try_for_each(|parameter| section.check_parameter(parameter))?;
    section.check_gravity(&earlier)?;
    section.check_inertia()?;
    section.check_common_errors()?;
    let inputs = read_earlier_inputs(&path).map_err(|e| section.error("calibration", e))?;
    let shared = section.shared_parts((written, memory), &inputs)?;
    let known = section.known(&earlier, format!("{} ({estimator})", table.calibration))?.sharing(shared);
    let mut session = session;
    for id in session.parameters() {
        let value = known.value(&session.parameter_name(id));
        let by_std = session.is_unknown_by_its_std(id) && session.fixed(id).is_none();
        let own = session.prior_mut(id);
        if by_std && value.is_some() {
            own.kind = PriorKind::Flat;
        }
        if let (PriorKind::Flat, Some(value)) = (own.kind, value) {
            own.nominal = value;
        }
    }
    session.inputs.push(InputFile::new(InputRole::Calibration, path));
    Ok(Session { earlier: Some(known), ..session })
}

/// Factor of a covariance that was estimated from so many blocks, by which its inverse is right on the average: of Wishart's distribution (Hartlap, Simon and
/// Schneider, 2007, eq. 17). `None` where there is none.
fn of_few_blocks(blocks: usize, numbers: usize) -> Option<f64> {
    let left = blocks.checked_sub(numbers + 2).filter(|left| *left > 0)?;
    Some((blocks - 1) as f64 / left as f64)
}

/// A number with its unit for people, angles in degrees.
fn shown(value: f64, unit: &str) -> String {
    let (unit, factor) = shown_unit(unit);
    format!("{} {unit}", rounded(factor * value, 9))
}

struct Section<'a> {
    context: &'a Context<'a>,
    table: &'a PriorTable,
    session: &'a Session,
}

impl Section<'_> {
    fn error(&self, key: &str, message: impl std::fmt::Display) -> FileError {
        self.context.document.error(&Field::new("prior").key(key), message)
    }

    fn is_unchanged(&self, what: Unchanged) -> bool {
        self.table.unchanged.contains(&what)
    }

    fn estimator(&self) -> Result<EstimatorName, FileError> {
        match self.table.estimator.as_deref().unwrap_or(EstimatorName::Joint.as_str()).parse() {
            Ok(EstimatorName::Sequential) => {
                let message = "the sequential estimator freezes each step's result and knows no covariance between steps: \
                               name one of the joint estimators";
                Err(self.error("estimator", message))
            }
            Ok(name) => Ok(name),
            Err(error) => Err(self.error("estimator", error)),
        }
    }

    /// The recordings, by file name, that the earlier calibration was made from as well, of which this session takes a part: which one
    /// was taken there its file does not say. A whole one is refused: what was read there is in it.
    fn shared_parts(
        &self,
        (written, memory): (WrittenTables<'_>, &Memory),
        inputs: &[EarlierInput],
    ) -> Result<Vec<String>, FileError> {
        let mut shared = Vec::new();
        let tables = self.session.tables.iter().zip(written.iter()).enumerate();
        // What is in memory is no file that was read then.
        for (index, (table, here)) in tables.filter(|(_, (table, _))| !memory.holds(&table.path)) {
            let field = written.field(index).key("file");
            let digest = Digest::of(&table.path).map_err(|error| self.context.document.error(&field, error))?;
            if inputs.iter().all(|input| input.sha256 != digest.sha256) {
                continue;
            }
            if here.part_of_recording() == Part::default() {
                let message = format!(
                    "the calibration of [prior], {}, was made from this table, too, and its readings would count twice: leave \
                     the table out, or calibrate all tables together, without [prior]",
                    self.table.calibration
                );
                return Err(self.context.document.error(&field, message));
            }
            if !shared.contains(&here.file) {
                shared.push(here.file.clone());
            }
        }
        Ok(shared)
    }

    /// Units, signs and what is held must agree, and nothing may be known twice.
    fn check_parameter(&self, earlier: &EarlierParameter) -> Result<(), FileError> {
        let Some(id) = self.find(&earlier.name) else { return Ok(()) };
        let own = self.session.parameter(id);
        let (name, unit, nominal) = (&earlier.name, &own.unit, own.prior.nominal);
        let refused = |message: String| Err(self.error("calibration", message));
        let was_read = earlier.value.is_some() || earlier.held.is_none();
        if was_read && earlier.unit != *unit {
            let there = &earlier.unit;
            return refused(format!("{name} is in {there} there, but in {unit} here: record the readings in one unit"));
        }
        let same = (earlier.nominal - nominal).abs() <= SAME_VALUE * nominal.abs().max(1.0);
        let frame = [Unchanged::Links, Unchanged::Loads].iter().any(|what| self.is_unchanged(*what));
        match (earlier.held.as_deref(), earlier.value) {
            (Some(_), Some(value)) if own.fixed.is_none() || !same => refused(format!(
                "{name} was held at {} there, and what was found depends on it: hold it at that value here, \
                 too (fixed)",
                shown(value, unit)
            )),
            (Some(LAST_FRAME_CHOICE), None) if frame && (own.fixed != Some(LAST_FRAME_CHOICE) || !same) => {
                refused(format!(
                    "{name} chose the last link's frame there, at {}, and it is another here: leave \"links\" and \
                     \"loads\" out of prior.unchanged, or choose the same frame",
                    shown(earlier.nominal, unit)
                ))
            }
            (None, Some(_)) if self.session.is_unknown_by_its_std(id) && own.fixed.is_none() => Ok(()),
            (None, None) if self.session.is_unknown_by_its_std(id) && own.fixed.is_none() => refused(format!(
                "{name} is not determined there, and what was found depends on the std that was stated for it, which would count \
                 twice: calibrate all tables together, without [prior]"
            )),
            (None, Some(value)) => self.check_estimated(&own, value),
            _ => Ok(()),
        }
    }

    fn check_estimated(&self, own: &Parameter, value: f64) -> Result<(), FileError> {
        let (name, prior) = (own.name(), own.prior);
        if matches!(own.limit, Limit::ShareOfNominal(_)) && value * prior.nominal < 0.0 {
            let message = format!("{name} came out as {value:.4} there, but is declared with the other sign here");
            return Err(self.error("calibration", message));
        }
        if let PriorKind::Gaussian { .. } = prior.kind {
            let message = format!(
                "{name} is known from there and by a std of its own here; what was stated there as well would count twice: \
                 leave that std away"
            );
            return Err(self.error("calibration", message));
        }
        Ok(())
    }

    fn check_gravity(&self, earlier: &EarlierEstimate) -> Result<(), FileError> {
        let (Some(g), true) = (earlier.gravity, self.is_unchanged(Unchanged::Base)) else { return Ok(()) };
        let here = self.session.gravity;
        let magnitude = g.iter().map(|c| c * c).sum::<f64>().sqrt();
        let along = |hemisphere: [f64; 3]| g.iter().zip(hemisphere).map(|(a, b)| a * b).sum::<f64>();
        if here.hemisphere.is_some_and(|hemisphere| along(hemisphere) <= 0.0) {
            let message = "gravity came out on the other side of gravity.hemisphere there: the base has moved, or one of \
                           the two is wrong";
            return Err(self.error("unchanged", message));
        }
        if here.magnitude_std.is_none() && (magnitude / here.magnitude - 1.0).abs() > SAME_PLACE {
            let here = here.magnitude;
            let message = format!(
                "gravity is {magnitude:.4} m/s² there, but {here:.4} m/s² here: a base that has not moved has one gravity"
            );
            return Err(self.error("unchanged", message));
        }
        Ok(())
    }

    /// The arm's lengths and axes, and the strength of gravity, are off by the same there and here: as an error of each calibration they would shrink as
    /// noise does.
    fn check_common_errors(&self) -> Result<(), FileError> {
        let Session { length_std, axis_std, gravity, .. } = self.session;
        let common = [
            (length_std.is_some(), "inertia.length_std_m"),
            (axis_std.is_some(), "inertia.axis_std_deg"),
            (gravity.magnitude_std.is_some() && !self.is_unchanged(Unchanged::Base), "gravity.magnitude_std_m_per_s2"),
        ];
        let Some((_, key)) = common.into_iter().find(|(stated, _)| *stated) else { return Ok(()) };
        let message = format!(
            "{key} states an error that both calibrations have in common, and each would count it as one of its own: calibrate all tables together, \
             without [prior]"
        );
        Err(self.error("calibration", message))
    }

    fn check_inertia(&self) -> Result<(), FileError> {
        match self.session.inertia {
            InertiaPrior::Model { .. } if self.is_unchanged(Unchanged::Links) => Err(self.error(
                "unchanged",
                "the links are known from there and from the model (inertia.links) here; what was stated there as well \
                 would count twice: leave one of them out",
            )),
            _ => Ok(()),
        }
    }

    /// What is known there, of what is here and unchanged.
    fn known(&self, earlier: &EarlierEstimate, source: String) -> Result<EarlierCalibration, FileError> {
        let quantities = &earlier.quantities;
        let kept: Vec<usize> =
            (0..quantities.len()).filter(|i| quantities[*i].terms.iter().all(|(name, _)| self.applies(name))).collect();
        if kept.is_empty() {
            let message = "nothing that it determined is a parameter of this session's sensors, or unchanged: is it of \
                           another robot?";
            return Err(self.error("calibration", message));
        }
        let size = quantities.len();
        let pairs = kept.iter().flat_map(|i| kept.iter().map(move |j| (*i, *j)));
        let widening = match earlier.sandwich_blocks {
            None => 1.0,
            Some(blocks) => of_few_blocks(blocks, kept.len()).ok_or_else(|| {
                let message = format!(
                    "its covariance is a sandwich of {blocks} blocks of poses, too few for {} numbers known together: calibrate there with \
                     uncertainty = {{ kind = \"jackknife\" }}, or by the noise",
                    kept.len()
                );
                self.error("calibration", message)
            })?,
        };
        let covariance = pairs.map(|(i, j)| widening * earlier.covariance[i * size + j]).collect();
        let combination = |i: &usize| KnownCombination {
            terms: quantities[*i].terms.clone(),
            times: None,
            value: quantities[*i].value,
        };
        let kept = kept.iter().map(combination).collect();
        let known = EarlierCalibration::new(source, kept, covariance);
        known.map(|known| known.times_gains(|quantity| self.gain_of(quantity))).map_err(|_| {
            let message = "its covariance is not positive definite (an estimate that leans on constraints, or too few \
                           blocks of poses for its robust uncertainty): it cannot be taken for knowledge";
            self.error("calibration", message)
        })
    }

    /// Name of the torque gain with which readings tell these masses and moments: that of the last joint that moves all of them, or of the rotor's own;
    /// `None` of what is neither.
    fn gain_of(&self, quantity: &KnownCombination) -> Option<String> {
        let chain = &self.session.robot.chain;
        let name_of = |joint: usize| SensorParameter::TorqueGain.name(&chain.joints()[joint].name);
        if let [(name, _)] = quantity.terms.as_slice()
            && let Some(ParameterId::Further(index)) = self.find(name)
            && let Some(joint) = self.session.rotor_of(index)
        {
            return Some(name_of(joint));
        }
        let links: Option<Vec<usize>> = quantity.terms.iter().map(|(name, _)| self.link_of_mass(name)).collect();
        let links = links?;
        let moves_all = |joint: &usize| links.iter().all(|link| chain.moves(*joint, *link));
        let reads =
            |joint: &usize| self.session.fixed(ParameterId::Sensor(*joint, SensorParameter::TorqueGain)).is_none();
        let joint = (0..self.session.joints.len()).rev().filter(reads).find(moves_all)?;
        Some(name_of(joint))
    }

    /// The link whose mass, moment or tensor a component is; that of a load for its mass.
    fn link_of_mass(&self, component: &str) -> Option<usize> {
        let of_load = |load: &&Load| component == format!("load.{}.mass", load.name);
        if let Some(load) = self.session.loads.iter().find(of_load) {
            return Some(load.link);
        }
        let begins = |name: &&str| {
            let rest = component.strip_prefix(*name).and_then(|rest| rest.strip_prefix('.'));
            rest.is_some_and(|rest| ["mass", "first_moment.", "inertia."].iter().any(|kind| rest.starts_with(kind)))
        };
        self.context.link_names.iter().position(begins)
    }

    /// Whether a component is a parameter here, or belongs to what is unchanged.
    fn applies(&self, component: &str) -> bool {
        let begins_with = |name: &str| component.strip_prefix(name).is_some_and(|rest| rest.starts_with('.'));
        match component {
            _ if self.find(component).is_some() => true,
            "gravity.x" | "gravity.y" | "gravity.z" => self.is_unchanged(Unchanged::Base),
            _ if component.starts_with("load.") => self.is_unchanged(Unchanged::Loads),
            _ => self.context.link_names.iter().any(|name| begins_with(name)) && self.is_unchanged(Unchanged::Links),
        }
    }

    fn find(&self, name: &str) -> Option<ParameterId> {
        self.session.parameters().into_iter().find(|id| self.session.parameter_name(*id) == name)
    }
}
