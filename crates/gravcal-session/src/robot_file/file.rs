//! Robots from files: `robot.toml`, and URDF.
//!
//! ```toml
//! name = "two-joints"
//! convention = "standard-dh"                 # or "modified-dh"
//! base = "base"                              # optional: name of the base frame
//! [[joint]]                                  # one for each joint, proximal first
//! name = "shoulder"
//! kind = "revolute"                          # the default, or "prismatic"
//! a_m = 0.0
//! alpha_deg = 90.0                           # or alpha_rad
//! d_m = 0.3
//! theta_deg = 0.0                            # optional fixed part, or theta_rad
//! parent = "torso"                           # optional: the link it hangs on (or base), where that is not the row before's
//! mounting = { position_m = [0, 0.2, 0.4], rpy_deg = [-90, 0, 0] }   # optional: where the row begins in the parent's frame
//! mimic = { joint = "elbow", multiplier = -1, offset_deg = 90 }      # optional: it follows another joint
//! limits_deg = [-90.0, 90.0]                 # optional; or limits_rad; limits_m of a prismatic joint
//! link = "upper-arm"                         # optional, "link<i>" by default
//! mass_kg = 2.0                              # optional, with center_of_mass_m in the link's frame
//! center_of_mass_m = [0.1, 0.05, 0.15]
//! inertia_kg_m2 = { xx = 0.02, yy = 0.03, zz = 0.01 }                # optional, with mass_kg: about the centre of mass, along the link's axes
//! torque_sensor = { gain = { value = 6.69, unit = "count/(N·m)" }, bias = { value = 2048, unit = "count" } }
//! position_sensor = { gain = { value = 1.0, unit = "deg/deg" }, offset = { value = 135.0, unit = "deg" } }
//! ```
//!
//! Gains of sensors are positive numbers; that a sensor is mounted the other way round is said by the session that
//! reads it.

use std::path::Path;

use gravcal_dynamics::{
    Attachment, BodyInertia, Chain, DhConvention, DhRow, Joint, JointKind, Link, LinkInertia, joint_from_dh,
};
use gravcal_robot_model::robot::{NominalSensors, Robot};
use serde::Deserialize;

use super::branches_file::{Branches, MimicTable, MountingTable};
use super::sensors_file::{PositionSensorTable, SensorTables, TorqueSensorTable};
use crate::document::{Document, Field, FileError, read_text};

/// `robot.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct RobotTable {
    /// The robot's name.
    ///
    /// Example: `name = "my-arm"`
    name: String,
    /// Which Denavit-Hartenberg convention the rows follow.
    ///
    /// Example: `convention = "standard-dh"`
    convention: Convention,
    /// Name of the base.
    ///
    /// Default: `base`.
    /// Example: `base = "pelvis"`
    base: Option<String>,
    /// One table for each joint, from the base outward.
    ///
    /// Example: `joint = [{ name = "joint1", a_m = 0.0, alpha_deg = 90.0, d_m = 0.36 }]`
    joint: Vec<JointTable>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
enum Convention {
    #[serde(rename = "standard-dh")]
    Standard,
    #[serde(rename = "modified-dh")]
    Modified,
}

/// `[[joint]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct JointTable {
    /// The joint's name.
    ///
    /// Example: `name = "joint1"`
    name: String,
    /// Whether it turns or slides.
    ///
    /// Default: `"revolute"`.
    /// Example: `kind = "prismatic"`
    kind: Option<JointKind>,
    /// Length of the link.
    ///
    /// Example: `a_m = 0.4`
    a_m: f64,
    /// Twist. Give this or `alpha_rad`.
    ///
    /// Example: `alpha_deg = 90.0`
    alpha_deg: Option<f64>,
    /// The same in radians.
    ///
    /// Example: `alpha_rad = 1.5707963`
    alpha_rad: Option<f64>,
    /// Offset along the axis.
    ///
    /// Example: `d_m = 0.36`
    d_m: f64,
    /// Constant part of the angle.
    ///
    /// Default: 0.
    /// Example: `theta_deg = 180`
    theta_deg: Option<f64>,
    /// The same in radians.
    ///
    /// Default: 0.
    /// Example: `theta_rad = 3.1415927`
    theta_rad: Option<f64>,
    /// The link, or base, on which it hangs.
    ///
    /// Default: that of the row before.
    /// Example: `parent = "torso"`
    parent: Option<String>,
    /// Where the row begins in the parent's frame.
    ///
    /// Default: the parent's frame.
    /// Example: `mounting = { position_m = [0, 0.2, 0.4], rpy_deg = [-90, 0, 0] }`
    #[serde(default)]
    mounting: MountingTable,
    /// The joint has no coordinate and no sensor of its own: it follows another.
    ///
    /// Example: `mimic = { joint = "joint2", multiplier = -1 }`
    mimic: Option<MimicTable>,
    /// Range of a joint that turns.
    ///
    /// Default: none.
    /// Example: `limits_deg = [-170.0, 170.0]`
    limits_deg: Option<[f64; 2]>,
    /// The same in radians.
    ///
    /// Default: none.
    /// Example: `limits_rad = [-2.9, 2.9]`
    limits_rad: Option<[f64; 2]>,
    /// Range of a joint that slides.
    ///
    /// Default: none.
    /// Example: `limits_m = [0.0, 0.5]`
    limits_m: Option<[f64; 2]>,
    /// Name of the link that it moves.
    ///
    /// Default: `link` and the number of the row.
    /// Example: `link = "forearm"`
    link: Option<String>,
    /// Assumed mass of the link, with `center_of_mass_m`.
    ///
    /// Default: unknown.
    /// Example: `mass_kg = 4.0`
    mass_kg: Option<f64>,
    /// Assumed centre of mass in the link's frame.
    ///
    /// Default: unknown.
    /// Example: `center_of_mass_m = [0.0, -0.15, 0.03]`
    center_of_mass_m: Option<[f64; 3]>,
    /// Assumed inertia of the link, with `mass_kg`: what an arm in motion feels beyond its mass.
    ///
    /// Default: unknown.
    /// Example: `inertia_kg_m2 = { xx = 0.02, yy = 0.03, zz = 0.01 }`
    inertia_kg_m2: Option<TensorTable>,
    /// Nominal torque sensor.
    ///
    /// Default: gain 1, bias 0 of readings in N·m.
    /// Example: `torque_sensor = { gain = { value = 6.69, unit = "count/(N·m)" }, bias = { value = 2048.0, unit = "count" } }`
    torque_sensor: Option<TorqueSensorTable>,
    /// Nominal position sensor.
    ///
    /// Default: gain 1, offset 0 of readings in deg or rad.
    /// Example: `position_sensor = { gain = { value = 1.0, unit = "deg/deg" }, offset = { value = 0.0, unit = "deg" } }`
    position_sensor: Option<PositionSensorTable>,
}

/// `inertia_kg_m2`: an inertia tensor about the link's centre of mass, along the axes of the link's frame; as in a URDF.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct TensorTable {
    /// About x.
    ///
    /// Unit: kg·m².
    /// Example: `xx = 0.02`
    xx: f64,
    /// About y.
    ///
    /// Unit: kg·m².
    /// Example: `yy = 0.03`
    yy: f64,
    /// About z.
    ///
    /// Unit: kg·m².
    /// Example: `zz = 0.01`
    zz: f64,
    /// `−∫ x y dm`.
    ///
    /// Unit: kg·m².
    /// Default: 0.
    /// Example: `xy = 0.001`
    #[serde(default)]
    xy: f64,
    /// `−∫ x z dm`.
    ///
    /// Unit: kg·m².
    /// Default: 0.
    /// Example: `xz = 0.0`
    #[serde(default)]
    xz: f64,
    /// `−∫ y z dm`.
    ///
    /// Unit: kg·m².
    /// Default: 0.
    /// Example: `yz = 0.002`
    #[serde(default)]
    yz: f64,
}

impl JointTable {
    fn kind(&self) -> JointKind {
        self.kind.unwrap_or(JointKind::Revolute)
    }

    fn sensors(&self, document: &Document, field: &Field) -> Result<NominalSensors, FileError> {
        let (torque, position) = (self.torque_sensor.as_ref(), self.position_sensor.as_ref());
        SensorTables { kind: self.kind(), torque, position }.nominal(document, field)
    }
}

/// Reads `robot.toml`: Denavit-Hartenberg rows with limits, assumed masses and nominal sensors.
///
/// # Errors
/// Names the file, the line and the field.
pub fn read_robot(path: &Path) -> Result<Robot, FileError> {
    let document = Document::read(path)?;
    let table: RobotTable = document.parse()?;
    let chain = chain(&document, &table)?;
    let joints = table.joint.iter().enumerate().filter(|(_, joint)| joint.mimic.is_none());
    let sensors = joints.map(|(i, joint)| joint.sensors(&document, &joint_field(i))).collect::<Result<_, _>>()?;
    Ok(Robot { name: table.name, chain, sensors })
}

/// Reads the chain from link `base` to the links `tips` of a URDF. It is named after the file, and nothing is nominally
/// known of its sensors.
///
/// # Errors
/// Names the file, and what in it does not make a chain (see [`Chain::from_urdf`]).
pub fn read_urdf(path: &Path, base: &str, tips: &[&str]) -> Result<Robot, FileError> {
    let text = read_text(path)?;
    let chain = Chain::from_urdf(&text, base, tips).map_err(|error| FileError::new(path, error))?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let sensors = vec![Default::default(); chain.joint_count()];
    Ok(Robot { name, chain, sensors })
}

fn joint_field(index: usize) -> Field {
    Field::new("joint").at(index)
}

fn chain(document: &Document, table: &RobotTable) -> Result<Chain, FileError> {
    let base = table.base.as_deref().unwrap_or("base");
    let convention = match table.convention {
        Convention::Standard => DhConvention::Standard,
        Convention::Modified => DhConvention::Modified,
    };
    document.check_names(table.joint.iter().map(|joint| joint.name.as_str()), |i| joint_field(i).key("name"))?;
    let rows: Vec<DhRow> =
        table.joint.iter().enumerate().map(|(i, joint)| row(document, i, joint)).collect::<Result<_, _>>()?;
    document.check_names(rows.iter().map(|row| row.link.name.as_str()), |i| joint_field(i).key("link"))?;
    let branches = Branches { document, base, names: rows.iter().map(|row| row.name.as_str()).collect(), rows: &rows };
    let attached = table.joint.iter().enumerate();
    let attached = attached.map(|(i, joint)| attachment(&branches, i, joint)).collect::<Result<Vec<_>, _>>()?;
    let joint = |(row, table): (&DhRow, &JointTable)| {
        let joint = joint_from_dh(convention, row);
        Joint { before: table.mounting.transform() * joint.before, ..joint }
    };
    let joints = rows.iter().zip(&table.joint).map(joint).collect();
    let links = rows.iter().map(|row| row.link.clone()).collect();
    let tensors = table.joint.iter().enumerate().map(|(i, joint)| tensor(document, &joint_field(i), joint));
    let tensors = tensors.collect::<Result<_, _>>()?;
    // What is left: no joints at all, a link that bears the base's name, branches in pieces, joints that mimic each other.
    let chain = Chain::branched(base, joints, links, &attached);
    Ok(chain.map_err(|error| document.error(&Field::new("joint"), error))?.with_tensors(tensors))
}

/// Where a row hangs, and whom it follows.
fn attachment(branches: &Branches<'_>, index: usize, joint: &JointTable) -> Result<Attachment, FileError> {
    let field = joint_field(index);
    let parent = branches.parent(&field, index, joint.parent.as_deref())?;
    let Some(mimic) = &joint.mimic else { return Ok(Attachment { parent, mimic: None }) };
    let sensors =
        [("torque_sensor", joint.torque_sensor.is_some()), ("position_sensor", joint.position_sensor.is_some())];
    if let Some((key, _)) = sensors.into_iter().find(|(_, there)| *there) {
        let message = format!(
            "a joint that mimics has no sensor of its own: what it carries is in the torque of `{}`; drop this, or mimic",
            mimic.joint
        );
        return Err(branches.document.error(&field.key(key), message));
    }
    Ok(Attachment { parent, mimic: Some(branches.mimic(&field.key("mimic"), joint.kind(), mimic)?) })
}

fn row(document: &Document, index: usize, joint: &JointTable) -> Result<DhRow, FileError> {
    let field = joint_field(index);
    let alpha = angle(document, &field, "alpha", joint.alpha_deg, joint.alpha_rad)?;
    let alpha = alpha.ok_or_else(|| {
        document.error(&field, "the twist is missing: give alpha_deg or alpha_rad (0 where the axes are parallel)")
    })?;
    let theta = angle(document, &field, "theta", joint.theta_deg, joint.theta_rad)?.unwrap_or(0.0);
    let limits = limits(document, &field, joint)?;
    let name = joint.link.clone().unwrap_or_else(|| format!("link{}", index + 1));
    let link = Link { name, inertia: inertia(document, &field, joint)? };
    Ok(DhRow { name: joint.name.clone(), kind: joint.kind(), a: joint.a_m, alpha, d: joint.d_m, theta, limits, link })
}

/// An angle that may be written in degrees or radians, in rad.
fn angle(
    document: &Document,
    joint: &Field,
    name: &str,
    deg: Option<f64>,
    rad: Option<f64>,
) -> Result<Option<f64>, FileError> {
    if deg.is_some() && rad.is_some() {
        let message = format!("{name} is given in degrees and in radians: keep one");
        return Err(document.error(&joint.key(&format!("{name}_rad")), message));
    }
    Ok(deg.map(f64::to_radians).or(rad))
}

/// Limits in rad or m.
fn limits(document: &Document, joint: &Field, table: &JointTable) -> Result<Option<[f64; 2]>, FileError> {
    let all = [
        ("limits_deg", table.limits_deg, JointKind::Revolute),
        ("limits_rad", table.limits_rad, JointKind::Revolute),
        ("limits_m", table.limits_m, JointKind::Prismatic),
    ];
    let mut written = all.into_iter().filter_map(|(name, limits, kind)| Some((name, limits?, kind)));
    let Some((name, [lower, upper], kind)) = written.next() else { return Ok(None) };
    let field = joint.key(name);
    if kind != table.kind() {
        let message = "limits of a revolute joint are limits_deg or limits_rad, those of a prismatic one limits_m";
        return Err(document.error(&field, message));
    }
    if let Some((other, ..)) = written.next() {
        return Err(document.error(&joint.key(other), format!("{name} is given as well: keep one")));
    }
    if lower >= upper {
        let message = format!("the limits {lower}, {upper} are the wrong way round: expected [lower, upper]");
        return Err(document.error(&field, message));
    }
    let to_si = if name == "limits_deg" { f64::to_radians } else { |value| value };
    Ok(Some([lower, upper].map(to_si)))
}

fn inertia(document: &Document, joint: &Field, table: &JointTable) -> Result<Option<LinkInertia>, FileError> {
    match (table.mass_kg, table.center_of_mass_m) {
        (None, None) => Ok(None),
        (Some(mass), _) if mass < 0.0 => {
            let message = format!("{mass} is not a mass: expected a number of kg, zero or more");
            Err(document.error(&joint.key("mass_kg"), message))
        }
        (Some(mass), Some(center)) => Ok(Some(LinkInertia { mass, first_moment: center.map(|c| mass * c) })),
        (Some(_), None) => {
            Err(document.error(&joint.key("mass_kg"), "a mass without its place: add center_of_mass_m = [x, y, z]"))
        }
        (None, Some(_)) => {
            Err(document.error(&joint.key("center_of_mass_m"), "a centre of mass without a mass: add mass_kg"))
        }
    }
}

/// `[I_xx, I_xy, I_yy, I_xz, I_yz, I_zz]` of a link about its frame's origin; zero where nothing is stated.
fn tensor(document: &Document, joint: &Field, table: &JointTable) -> Result<[f64; 6], FileError> {
    let Some(TensorTable { xx, yy, zz, xy, xz, yz }) = table.inertia_kg_m2 else { return Ok([0.0; 6]) };
    let field = joint.key("inertia_kg_m2");
    let (Some(mass), Some(center)) = (table.mass_kg, table.center_of_mass_m) else {
        return Err(document.error(&field, "an inertia without a mass: add mass_kg and center_of_mass_m"));
    };
    if [xx, yy, zz].iter().any(|entry| *entry < 0.0) {
        return Err(
            document.error(&field, "nothing has a negative inertia about an axis: xx, yy and zz are zero or more")
        );
    }
    Ok(BodyInertia::about_center(mass, center, [xx, xy, yy, xz, yz, zz]).tensor)
}
