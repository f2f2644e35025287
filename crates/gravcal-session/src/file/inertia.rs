//! `[inertia]`: what is known of the links' masses and moments.

use gravcal_robot_model::session::{AuxiliarySensorKind, InertiaPrior, Session};
use gravcal_robot_model::sweeps::find_sweeps;
use serde::Deserialize;

use super::context::Context;
use crate::document::{Document, Field, FileError, OneOrNamed};

/// `[inertia]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct InertiaTable {
    /// Whether the links' masses are unknown, or those of the robot's file.
    ///
    /// Default: `"unknown"`.
    /// Example: `links = "model"`
    #[serde(default)]
    links: Links,
    /// With `links = "model"`: how well the masses are known, relative to them; one number, or one for each link by
    /// name.
    ///
    /// Unit: 1.
    /// Default: exact.
    /// Example: `relative_std = { link2 = 0.1 }`
    relative_std: Option<OneOrNamed>,
    /// `"link"`: one first moment for each link. `"sweep"`: one moment for each sweep; lengths are not used.
    ///
    /// Default: `"link"`.
    /// Example: `description = "sweep"`
    #[serde(default)]
    description: Description,
    /// How well the robot's lengths are known: how far each joint may sit from where the robot's file has it on the link before, one standard
    /// deviation along each axis. Intervals of the joint estimate include it.
    ///
    /// Unit: m.
    /// Default: exact.
    /// Example: `length_std_m = 0.0005`
    length_std_m: Option<f64>,
    /// How well the directions of the joints' axes are known: how far each may be tilted against the robot's file, one standard deviation about each of two
    /// axes across its own. Intervals of the joint estimate include it.
    ///
    /// Unit: deg.
    /// Default: exact.
    /// Example: `axis_std_deg = 0.05`
    axis_std_deg: Option<f64>,
}

/// What the moments are those of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Description {
    #[default]
    Link,
    Sweep,
}

/// Where knowledge of the links comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Links {
    #[default]
    Unknown,
    Model,
}

/// What `[inertia]` comes to.
pub(super) fn resolve(context: &Context<'_>, table: &InertiaTable) -> Result<InertiaPrior, FileError> {
    let relative = Field::new("inertia").key("relative_std");
    if table.description == Description::Sweep {
        return by_sweep(context, table);
    }
    match (table.links, &table.relative_std) {
        (Links::Unknown, None) => Ok(InertiaPrior::Unknown),
        (Links::Unknown, Some(_)) => Err(context
            .document
            .error(&relative, "of unknown links nothing is known: write links = \"model\", or leave it out")),
        (Links::Model, None) => {
            let message = "how well is the model known? add relative_std, 0.1 for ten per cent of each value, or by link \
                           { link2 = 0.1 }";
            Err(context.document.error(&relative, message))
        }
        (Links::Model, Some(std)) => {
            let links = ("link", context.link_names.as_slice());
            let what = ("a relative standard deviation", "no unit, such as 0.1");
            let relative_std = context.document.positive_by_name(&relative, std, links, what)?;
            check_known(context, &relative_std)?;
            Ok(InertiaPrior::Model { relative_std })
        }
    }
}

/// How well lengths are known, m.
pub(super) fn length_std(document: &Document, table: &InertiaTable) -> Result<Option<f64>, FileError> {
    let field = Field::new("inertia").key("length_std_m");
    table.length_std_m.map(|std| document.positive(&field, std, "a standard deviation", "m")).transpose()
}

/// How well axes are known, rad.
pub(super) fn axis_std(document: &Document, table: &InertiaTable) -> Result<Option<f64>, FileError> {
    let field = Field::new("inertia").key("axis_std_deg");
    let std =
        table.axis_std_deg.map(|std| document.positive(&field, std, "a standard deviation", "deg")).transpose()?;
    Ok(std.map(f64::to_radians))
}

const MOVES_OBSERVED: &str = "joints that are not where the robot's description says move what [[residual]] observes, too, which is not modelled: \
                              leave this out, and give the residual a standard deviation that covers it";

/// Whether this session has lengths and axes that can be known less well.
pub(super) fn check_displacements(document: &Document, session: &Session) -> Result<(), FileError> {
    let (by_sweep, free) = (session.inertia == InertiaPrior::Sweep, session.joints.is_empty());
    let observed = !session.residuals.is_empty();
    let (key, message) = match (session.length_std, session.axis_std) {
        (Some(_), _) if by_sweep => ("length_std_m", "moments of sweeps ask for no lengths: leave it out"),
        (Some(_), _) if free => ("length_std_m", "a body without joints has no lengths: leave it out"),
        (Some(_), _) if observed => ("length_std_m", MOVES_OBSERVED),
        (_, Some(_)) if observed => ("axis_std_deg", MOVES_OBSERVED),
        (_, Some(_)) if free => ("axis_std_deg", "a body without joints has no axes: leave it out"),
        (_, Some(_)) if by_sweep => {
            ("axis_std_deg", "moments of sweeps take axes as exact: leave it out, or write description = \"link\"")
        }
        _ => return Ok(()),
    };
    Err(document.error(&Field::new("inertia").key(key), message))
}

fn by_sweep(context: &Context<'_>, table: &InertiaTable) -> Result<InertiaPrior, FileError> {
    let written = [("links", table.links == Links::Model), ("relative_std", table.relative_std.is_some())];
    match written.iter().find(|(_, written)| *written) {
        None => Ok(InertiaPrior::Sweep),
        Some((key, _)) => {
            let message = "the moments of a sweep are of no single link, so the robot's masses say nothing of them: leave \
                           this out, or write description = \"link\"";
            Err(context.document.error(&Field::new("inertia").key(key), message))
        }
    }
}

/// Whether the moments of sweeps can serve this session.
pub(super) fn check_sweeps(document: &Document, session: &Session) -> Result<(), FileError> {
    if session.inertia != InertiaPrior::Sweep {
        return Ok(());
    }
    let description = Field::new("inertia").key("description");
    let chain = &session.robot.chain;
    if chain.joint_count() < chain.link_count() {
        let message = "some joints mimic others, so that no joint sweeps alone, and what hangs beyond one is no rigid body: \
                       write \"link\"";
        return Err(document.error(&description, message));
    }
    if find_sweeps(session).is_empty() {
        let message = "no pose belongs to a sweep, and no moment to any other pose: write \"link\", or sweep one joint while \
                       the others stand (`gravcal check` tells the rule)";
        return Err(document.error(&description, message));
    }
    let constraints = &session.constraints;
    let of_links = constraints.positive_masses || constraints.center_of_mass_within.iter().any(Option::is_some);
    if of_links || constraints.physical_inertias {
        let message =
            "[constraints] on masses, centres of mass and inertias are on links: write \"link\", or drop them";
        return Err(document.error(&description, message));
    }
    if session.instruments.iter().any(|instrument| instrument.kind == AuxiliarySensorKind::ForceTorque) {
        let message = "a wrist sensor feels where on its link a load is, and sweeps know only how two placements differ: write \
                       \"link\"";
        return Err(document.error(&description, message));
    }
    if session.earlier.as_ref().is_some_and(|earlier| earlier.knows_any("load.")) {
        let message = "an earlier calibration says where loads are on their link, and sweeps know only how two placements \
                       differ: write \"link\", or leave loads out of [prior] unchanged";
        return Err(document.error(&description, message));
    }
    for (index, known) in session.load_distances.iter().enumerate() {
        let [a, b] = known.between.map(|load| session.loads[load].mass);
        if a != b {
            let message = format!(
                "a distance between placements of {a} kg and {b} kg says nothing where moments are described by sweep: \
                 only placements of one mass differ by m (r² − r¹)"
            );
            return Err(document.error(&Field::new("load_distance").at(index).key("between"), message));
        }
    }
    Ok(())
}

/// A link that is said to be known needs a mass in the robot's file.
fn check_known(context: &Context<'_>, relative_std: &[Option<f64>]) -> Result<(), FileError> {
    let links = context.robot.chain.links().iter().zip(relative_std);
    let unknown = links.filter(|(link, std)| std.is_some() && link.inertia.is_none());
    let unknown: Vec<&str> = unknown.map(|(link, _)| link.name.as_str()).collect();
    if unknown.is_empty() {
        return Ok(());
    }
    let message = format!(
        "the model needs the mass of every link, but {} has none for {}: add them there, name only other links in \
         relative_std, or write links = \"unknown\"",
        context.robot_path.display(),
        unknown.join(", ")
    );
    Err(context.document.error(&Field::new("inertia").key("links"), message))
}
