//! What an earlier `calibration.json` says: named quantities with their covariance.
//!
//! A quantity is a sensor parameter, a component of gravity, or a combination `Σ coefficient · component` of masses, moments
//! and placements. The covariance is that of all quantities together, as the file gives it.

use std::io;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use thiserror::Error;

use crate::file::{LARGEST_RESULTS, read_whole};
use crate::input_role::InputRole;

/// The version of the file that can be read.
const FORMAT: &str = "gravcal-calibration/1";

/// One estimator's answer in an earlier calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct EarlierEstimate {
    /// Every sensor parameter, determined or not.
    pub parameters: Vec<EarlierParameter>,
    /// Gravity in base coordinates, m/s², where it was determined.
    pub gravity: Option<[f64; 3]>,
    /// 95 % interval of each of its components, m/s², where the file says it.
    pub gravity_ci95: Option<[[f64; 2]; 3]>,
    /// Half-angle of the cone about gravity that holds its true direction with 95 % probability, degrees, where the file says it.
    pub cone95_deg: Option<f64>,
    /// What the covariance is about.
    pub quantities: Vec<EarlierQuantity>,
    /// Covariance of the quantities, row-major, in the products of their units.
    pub covariance: Vec<f64>,
    /// From how many blocks of poses, left out one after the other, the covariance is; absent where it is from the noise.
    pub blocks_left_out: Option<usize>,
    /// How many blocks of poses its covariance is a sum of, where it is a sandwich.
    pub sandwich_blocks: Option<usize>,
    /// Why its intervals may not hold, in words.
    pub doubts: Vec<String>,
    /// The links' inertias as rigid bodies can have them, where the session asked for them.
    pub inertias: Option<Vec<EarlierInertia>>,
    /// Loads of unknown mass.
    pub payloads: Vec<EarlierPayload>,
}

/// What was found of a load of unknown mass; what is undetermined is absent.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct EarlierPayload {
    /// Name of the load.
    pub load: String,
    /// Name of the link that carries it, in whose frame all is told.
    pub link: String,
    /// kg.
    pub mass_kg: Option<EarlierNumber>,
    /// m.
    pub center_of_mass_m: Option<[EarlierNumber; 3]>,
    /// `[I_xx, I_xy, I_yy, I_xz, I_yz, I_zz]` about the centre of mass, kg·m².
    pub tensor_kg_m2: Option<[EarlierNumber; 6]>,
}

/// A number with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct EarlierNumber {
    /// In the unit of the field.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
}

/// A rigid body on a link, in the link's frame.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct EarlierInertia {
    /// Name of the link.
    pub link: String,
    /// kg.
    pub mass_kg: f64,
    /// m.
    pub center_of_mass_m: [f64; 3],
    /// `[I_xx, I_xy, I_yy, I_xz, I_yz, I_zz]` about the centre of mass, kg·m².
    pub tensor_kg_m2: [f64; 6],
}

/// A sensor parameter of an earlier calibration.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct EarlierParameter {
    /// Such as `joint1.torque_gain`.
    pub name: String,
    /// Unit of its value.
    pub unit: String,
    /// Absent where it was undetermined.
    pub value: Option<f64>,
    /// Why it was fixed and not estimated, where it was.
    pub held: Option<String>,
    /// Standard deviation; absent where undetermined, 0 where held.
    #[serde(default)]
    pub std: Option<f64>,
    /// 95 % interval.
    #[serde(default)]
    pub ci95: Option<[f64; 2]>,
    /// The equation in which it stands.
    #[serde(default)]
    pub convention: String,
    /// The value that was assumed, or at which it was fixed.
    pub nominal: f64,
}

/// `Σ coefficient · component = value`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct EarlierQuantity {
    /// Component, such as `joint1.torque_gain`, `gravity.x` or `link2.first_moment.x`, and coefficient.
    pub terms: Vec<(String, f64)>,
    /// In the unit of the components.
    pub value: f64,
}

/// Why an earlier calibration cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum EarlierError {
    /// The file cannot be opened.
    #[error("{}: cannot be read: {cause}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        cause: io::Error,
    },
    /// It is not such a file.
    #[error("{}: not a calibration.json that gravcal wrote: {cause}", path.display())]
    NotCalibration {
        /// The file.
        path: PathBuf,
        /// What is wrong, with line and column.
        cause: serde_json::Error,
    },
    /// It is one of another version.
    #[error("{}: its format is `{found}`, expected `{FORMAT}`: calibrate again with this version", path.display())]
    OtherFormat {
        /// The file.
        path: PathBuf,
        /// The format it names.
        found: String,
    },
    /// It has no answer of that estimator.
    #[error("{}: it has no estimator `{name}`, only: {known}", path.display())]
    NoEstimator {
        /// The file.
        path: PathBuf,
        /// The estimator that was asked for.
        name: String,
        /// Those that there are.
        known: String,
    },
    /// The answer is none to rely on.
    #[error("{}: estimator `{name}` failed ({termination}): nothing in it can be relied on", path.display())]
    Failed {
        /// The file.
        path: PathBuf,
        /// The estimator.
        name: String,
        /// Why it ended.
        termination: String,
    },
    /// There is no covariance, or none that belongs to the values.
    #[error("{}: estimator `{name}`: {what}", path.display())]
    Covariance {
        /// The file.
        path: PathBuf,
        /// The estimator.
        name: String,
        /// What is wrong with it.
        what: String,
    },
}

/// A file from which a calibration was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EarlierInput {
    /// Relative to the session's folder, or absolute.
    pub path: String,
    /// Hash of its contents, hexadecimal.
    pub sha256: String,
    /// What it is for.
    pub role: InputRole,
}

/// Probability below which residuals are no accident.
const IMPROBABLE: f64 = 1e-3;

#[derive(Deserialize)]
struct File {
    format: String,
    #[serde(default)]
    doubts: Vec<String>,
    estimators: Vec<Estimator>,
    provenance: Option<Provenance>,
}

#[derive(Deserialize)]
struct Provenance {
    inputs: Vec<Input>,
}

#[derive(Deserialize)]
struct Input {
    path: String,
    sha256: String,
    /// Older calibrations say none.
    role: Option<InputRole>,
}

impl Input {
    /// `place` among the inputs: where no roles are said, the session stands first, and names tell what else there is.
    fn at(self, place: usize) -> EarlierInput {
        let end = self.path.rsplit_once('.').map_or_else(String::new, |(_, end)| end.to_ascii_lowercase());
        let guessed = match (place, end.as_str()) {
            (0, _) => InputRole::Session,
            (_, "toml" | "urdf" | "xml" | "xacro") => InputRole::Robot,
            (_, "json") => InputRole::Calibration,
            _ => InputRole::Recording,
        };
        EarlierInput { role: self.role.unwrap_or(guessed), path: self.path, sha256: self.sha256 }
    }
}

#[derive(Deserialize)]
struct Estimator {
    name: String,
    verdict: String,
    termination: String,
    gravity: Option<Gravity>,
    parameters: Vec<EarlierParameter>,
    covariance: Matrix,
    moments: Vec<EarlierQuantity>,
    #[serde(default)]
    uncertainty: Option<Uncertainty>,
    #[serde(default)]
    fit: Option<Fit>,
    #[serde(default)]
    residual_tests: Vec<ResidualTest>,
    #[serde(default)]
    payloads: Vec<EarlierPayload>,
    #[serde(default)]
    consistent_model: Option<ConsistentModel>,
}

/// Inertias that rigid bodies can have.
#[derive(Deserialize)]
struct ConsistentModel {
    links: Vec<EarlierInertia>,
}

/// A test on the residuals of a channel.
#[derive(Deserialize)]
struct ResidualTest {
    channel: String,
    /// `torque-harmonic`.
    kind: String,
    /// Of a harmonic, periods a turn.
    order: Option<u32>,
    spoils_intervals: bool,
}

/// Where its covariance comes from.
#[derive(Default, Deserialize)]
struct Uncertainty {
    kind: String,
    #[serde(flatten)]
    own: Blocks,
    /// Where it is the larger of two.
    jackknife: Option<Blocks>,
}

/// Blocks of poses that were left out.
#[derive(Clone, Copy, Default, Deserialize)]
struct Blocks {
    blocks: Option<usize>,
    too_short_for: Option<usize>,
}

impl Uncertainty {
    fn left_out(&self) -> Option<Blocks> {
        if self.kind == "jackknife" { Some(self.own) } else { self.jackknife }
    }

    fn sandwich_blocks(&self) -> Option<usize> {
        self.own.blocks.filter(|_| self.kind == "sandwich")
    }
}

#[derive(Deserialize)]
struct Fit {
    chi_squared: f64,
    degrees_of_freedom: usize,
    p_value: Option<f64>,
    median_ratio: Option<f64>,
    /// Older files have none.
    times_noise: Option<f64>,
}

impl Fit {
    /// How many times worse than its stated noise it explains the readings, where that is no accident.
    fn misfit(&self) -> Option<f64> {
        let by_squares = || (self.chi_squared / self.degrees_of_freedom.max(1) as f64).sqrt();
        let times = || self.times_noise.or(self.median_ratio).unwrap_or_else(by_squares);
        self.p_value.filter(|p| *p < IMPROBABLE).map(|_| times())
    }
}

#[derive(Deserialize)]
struct Gravity {
    vector_m_per_s2: [f64; 3],
    #[serde(default)]
    ci95_m_per_s2: Option<[[f64; 2]; 3]>,
    #[serde(default)]
    cone95_deg: Option<f64>,
}

#[derive(Deserialize)]
struct Matrix {
    order: Vec<String>,
    matrix: Vec<Vec<f64>>,
}

/// Reads the answer of one estimator in a `calibration.json`.
///
/// # Errors
/// There is no such file or estimator, the estimator has failed, or its covariance is absent or of other quantities.
pub fn read_earlier(path: &Path, estimator: &str) -> Result<EarlierEstimate, EarlierError> {
    let file = read_file(path)?;
    let known: Vec<String> = file.estimators.iter().map(|e| format!("`{}`", e.name)).collect();
    let found = file.estimators.into_iter().find(|e| e.name == estimator).ok_or_else(|| EarlierError::NoEstimator {
        path: path.to_owned(),
        name: estimator.to_owned(),
        known: known.join(", "),
    })?;
    if found.verdict == "failed" {
        return Err(EarlierError::Failed { path: path.to_owned(), name: found.name, termination: found.termination });
    }
    let name = found.name.clone();
    let mut estimate =
        found.estimate().map_err(|what| EarlierError::Covariance { path: path.to_owned(), name, what })?;
    estimate.doubts.extend(file.doubts);
    Ok(estimate)
}

/// The files that a `calibration.json` was made from; none where it does not say.
///
/// # Errors
/// There is no such file.
pub fn read_earlier_inputs(path: &Path) -> Result<Vec<EarlierInput>, EarlierError> {
    let inputs = read_file(path)?.provenance.map_or_else(Vec::new, |provenance| provenance.inputs);
    Ok(inputs.into_iter().enumerate().map(|(place, input)| input.at(place)).collect())
}

/// The session file that a `calibration.json` was made from; `None` where it does not say, or was made from arrays.
///
/// # Errors
/// There is no such file.
pub fn read_earlier_session(path: &Path) -> Result<Option<EarlierInput>, EarlierError> {
    Ok(read_earlier_inputs(path)?.into_iter().find(|input| input.role == InputRole::Session))
}

/// The names of the estimators whose answers a `calibration.json` holds.
///
/// # Errors
/// There is no such file.
pub fn read_earlier_estimators(path: &Path) -> Result<Vec<String>, EarlierError> {
    Ok(read_file(path)?.estimators.into_iter().map(|estimator| estimator.name).collect())
}

fn read_file(path: &Path) -> Result<File, EarlierError> {
    let bytes = read_whole(path, LARGEST_RESULTS).map_err(|cause| EarlierError::Io { path: path.to_owned(), cause })?;
    let not_ours = |cause| EarlierError::NotCalibration { path: path.to_owned(), cause };
    let file: File = serde_json::from_slice(&bytes).map_err(not_ours)?;
    match file.format == FORMAT {
        true => Ok(file),
        false => Err(EarlierError::OtherFormat { path: path.to_owned(), found: file.format }),
    }
}

impl Estimator {
    /// What it says, or what is wrong with its covariance.
    fn estimate(self) -> Result<EarlierEstimate, String> {
        let size = self.covariance.order.len();
        if size == 0 {
            return Err("it has no covariance".to_owned());
        }
        if self.covariance.matrix.len() != size || self.covariance.matrix.iter().any(|row| row.len() != size) {
            return Err(format!("its covariance must be a matrix of {size} rows and columns, as its order names them"));
        }
        check_covariance(&self.covariance)?;
        check_intervals(&self.parameters)?;
        let quantity = |name: &String| {
            self.quantity(name).ok_or_else(|| format!("its covariance is of `{name}`, which has no value in the file"))
        };
        let quantities = self.covariance.order.iter().map(quantity).collect::<Result<_, _>>()?;
        Ok(EarlierEstimate {
            quantities,
            gravity: self.gravity.as_ref().map(|gravity| gravity.vector_m_per_s2),
            gravity_ci95: self.gravity.as_ref().and_then(|gravity| gravity.ci95_m_per_s2),
            cone95_deg: self.gravity.as_ref().and_then(|gravity| gravity.cone95_deg),
            covariance: self.covariance.matrix.concat(),
            blocks_left_out: self.uncertainty.as_ref().and_then(Uncertainty::left_out).and_then(|left| left.blocks),
            sandwich_blocks: self.uncertainty.as_ref().and_then(Uncertainty::sandwich_blocks),
            doubts: self.doubts(),
            parameters: self.parameters,
            inertias: self.consistent_model.map(|model| model.links),
            payloads: self.payloads,
        })
    }

    /// Why its intervals may not hold.
    fn doubts(&self) -> Vec<String> {
        let misfit = self.fit.as_ref().and_then(Fit::misfit);
        let misfit =
            misfit.map(|ratio| format!("its readings are explained {ratio:.1} times worse than their stated noise"));
        let too_short = self.uncertainty.as_ref().and_then(Uncertainty::left_out).and_then(|left| left.too_short_for);
        let too_short =
            too_short.map(|_| "neighbouring poses share errors that outlast its blocks of poses".to_owned());
        misfit.into_iter().chain(too_short).chain(self.shapes()).collect()
    }

    /// What its residuals show that its model lacks.
    fn shapes(&self) -> Option<String> {
        let spoilt = self.residual_tests.iter().filter(|test| test.spoils_intervals);
        let in_words = |test: &ResidualTest| {
            let order = test.order.map_or_else(String::new, |order| format!(" {order}"));
            format!("{} {}{order}", test.channel, test.kind.replace('-', " "))
        };
        let reported: Vec<String> = spoilt.map(in_words).collect();
        (!reported.is_empty()).then(|| format!("its residuals show what its model lacks: {}", reported.join(", ")))
    }

    /// What an entry of the covariance's order stands for: a parameter, `gravity.x`, or `moments[3]`.
    fn quantity(&self, name: &str) -> Option<EarlierQuantity> {
        let alone = |value| EarlierQuantity { terms: vec![(name.to_owned(), 1.0)], value };
        if let Some(parameter) = self.parameters.iter().find(|parameter| parameter.name == name) {
            return parameter.value.map(alone);
        }
        if let Some(axis) = ["gravity.x", "gravity.y", "gravity.z"].iter().position(|axis| *axis == name) {
            return self.gravity.as_ref().map(|gravity| alone(gravity.vector_m_per_s2[axis]));
        }
        let index: usize = name.strip_prefix("moments[")?.strip_suffix(']')?.parse().ok()?;
        self.moments.get(index).cloned()
    }
}

/// What parameters say of their own uncertainty.
fn check_intervals(parameters: &[EarlierParameter]) -> Result<(), String> {
    for EarlierParameter { name, std, ci95, .. } in parameters {
        if let Some(std) = std.filter(|std| *std < 0.0) {
            return Err(format!("`{name}` has the standard deviation {std}, and none is negative"));
        }
        if let Some([low, high]) = ci95.filter(|[low, high]| low > high) {
            return Err(format!("the 95 % interval of `{name}` goes from {low} down to {high}"));
        }
    }
    Ok(())
}

/// Share of the standard deviations by which a covariance may miss what every covariance is: far more than rounding.
const ROUNDING: f64 = 1e-6;

/// That variances are not negative, and covariances the same both ways and no larger than variances allow.
fn check_covariance(Matrix { order, matrix }: &Matrix) -> Result<(), String> {
    for (i, row) in matrix.iter().enumerate() {
        if row[i] < 0.0 {
            return Err(format!("its covariance gives `{}` the variance {}, and none is negative", order[i], row[i]));
        }
        for (j, entry) in row[..i].iter().enumerate() {
            let (other, most) = (matrix[j][i], row[i].sqrt() * matrix[j][j].sqrt());
            if (entry - other).abs() > ROUNDING * most {
                let [a, b] = [&order[i], &order[j]];
                return Err(format!("its covariance is not symmetric: {entry} and {other} stand for `{a}` with `{b}`"));
            }
            if entry.abs() > (1.0 + ROUNDING) * most {
                let [a, b] = [&order[i], &order[j]];
                return Err(format!(
                    "its covariance of `{a}` with `{b}` is {entry}, larger than their variances allow"
                ));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const CALIBRATION: &str = r#"{ "format": "gravcal-calibration/1", "estimators": [
        { "name": "sequential", "verdict": "failed", "termination": "no sweeps", "gravity": null, "parameters": [],
          "covariance": { "order": [], "matrix": [] }, "moments": [] },
        { "name": "joint", "verdict": "determined", "termination": "converged",
          "gravity": { "vector_m_per_s2": [0.0, -6.0, -8.0], "cone95_deg": 0.1 },
          "parameters": [
            { "name": "j.torque_gain", "unit": "count/(N·m)", "value": 7.5, "held": null, "nominal": 7.0 },
            { "name": "j.position_offset", "unit": "rad", "value": 0.0, "held": "base", "nominal": 0.0 },
            { "name": "j.torque_bias", "unit": "count", "value": null, "held": null, "nominal": 2048.0 } ],
          "covariance": { "order": ["gravity.y", "j.torque_gain", "moments[0]"],
                          "matrix": [[4, 1, 0], [1, 9, 0], [0, 0, 1]] },
          "moments": [{ "terms": [["a.mass", 0.5], ["b.mass", 1.0]], "value": 3.0, "std": 1.0 }] } ] }"#;

    fn read(change: (&str, &str), estimator: &str) -> Result<EarlierEstimate, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("calibration.json");
        std::fs::write(&path, CALIBRATION.replace(change.0, change.1)).unwrap();
        read_earlier(&path, estimator).map_err(|e| e.to_string().replace(&format!("{}/", folder.path().display()), ""))
    }

    #[test]
    fn quantities_are_those_of_the_covariance() {
        let joint = read(("", ""), "joint").unwrap();
        let alone = |name: &str, value| EarlierQuantity { terms: vec![(name.to_owned(), 1.0)], value };
        let sum = EarlierQuantity { terms: vec![("a.mass".into(), 0.5), ("b.mass".into(), 1.0)], value: 3.0 };
        assert_eq!(joint.quantities, [alone("gravity.y", -6.0), alone("j.torque_gain", 7.5), sum]);
        assert_eq!(joint.covariance, [4.0, 1.0, 0.0, 1.0, 9.0, 0.0, 0.0, 0.0, 1.0]);
        assert_eq!(joint.gravity, Some([0.0, -6.0, -8.0]));
        assert_eq!((joint.gravity_ci95, joint.cone95_deg), (None, Some(0.1)));
        assert_eq!(joint.parameters.len(), 3);
    }

    #[test]
    fn what_each_input_is_for_is_read_or_guessed() {
        let roles = |written: &str| {
            let inputs: Vec<Input> = serde_json::from_str(written).unwrap();
            inputs.into_iter().enumerate().map(|(place, input)| input.at(place).role).collect::<Vec<InputRole>>()
        };
        let from_arrays = r#"[{"path": "models/arm/robot.toml", "sha256": "r", "role": "robot"}]"#;
        assert_eq!(roles(from_arrays), [InputRole::Robot]);
        let before = ["session.toml", "arm.URDF", "a.csv", "last/calibration.json"];
        let before = before.map(|path| format!(r#"{{"path": "{path}", "sha256": "h"}}"#)).join(",");
        let expected = [InputRole::Session, InputRole::Robot, InputRole::Recording, InputRole::Calibration];
        assert_eq!(roles(&format!("[{before}]")), expected);
    }

    #[test]
    fn what_its_intervals_rest_on_is_read_and_doubted() {
        let plain = read(("", ""), "joint").unwrap();
        assert_eq!((plain.blocks_left_out, plain.doubts), (None, vec![]));
        let with =
            |text: &str| read((r#""name": "joint","#, &format!(r#""name": "joint", {text},"#)), "joint").unwrap();
        let fit = |p: f64| {
            format!(
                r#""fit": {{ "chi_squared": 400.0, "degrees_of_freedom": 100, "p_value": {p}, "median_ratio": null }}"#
            )
        };
        assert_eq!(with(&fit(1e-9)).doubts, ["its readings are explained 2.0 times worse than their stated noise"]);
        assert!(with(&fit(0.2)).doubts.is_empty());
        let jackknife = with(r#""uncertainty": { "kind": "jackknife", "blocks": 25, "too_short_for": null }"#);
        assert_eq!((jackknife.blocks_left_out, jackknife.doubts), (Some(25), vec![]));
        let larger = with(
            r#""uncertainty": { "kind": "larger-of-noise-and-jackknife", "source": "stated", "widened_by": 2.0,
               "jackknife": { "blocks": 14, "block_poses": [1, 2], "correlation": 0.8, "too_short_for": 9 } }"#,
        );
        assert_eq!(larger.blocks_left_out, Some(14));
        assert_eq!(larger.doubts, ["neighbouring poses share errors that outlast its blocks of poses"]);
        let tested = with(
            r#""residual_tests": [{ "channel": "joint6", "kind": "torque-harmonic", "order": 2, "p_value": 1e-9, "spoils_intervals": true },
               { "channel": "joint1", "kind": "neighbours", "p_value": 1e-9, "spoils_intervals": false }]"#,
        );
        let shape = "its residuals show what its model lacks: joint6 torque harmonic 2";
        assert_eq!(tested.doubts, [shape]);
        let sandwich = with(r#""uncertainty": { "kind": "sandwich", "blocks": 40, "block_poses": 3 }"#);
        assert_eq!((sandwich.blocks_left_out, sandwich.sandwich_blocks), (None, Some(40)));
        let doubted = read((r#""estimators""#, r#""doubts": ["joint1: degrees?"], "estimators""#), "joint").unwrap();
        assert_eq!(doubted.doubts, ["joint1: degrees?"]);
    }

    #[test]
    fn what_cannot_be_relied_on_is_refused() {
        let refused = |old: &str, new: &str, estimator: &str| read((old, new), estimator).unwrap_err();
        assert_eq!(
            refused("", "", "joint-paper-signals"),
            "calibration.json: it has no estimator `joint-paper-signals`, only: `sequential`, `joint`"
        );
        assert!(refused("", "", "sequential").contains("estimator `sequential` failed (no sweeps)"));
        assert!(refused("calibration/1", "calibration/2", "joint").contains("expected `gravcal-calibration/1`"));
        assert!(refused("\"moments[0]\"", "\"moments[1]\"", "joint").contains("`moments[1]`, which has no value"));
        assert!(refused("\"gravity.y\",", "\"j.torque_bias\",", "joint").contains("`j.torque_bias`, which has no"));
        assert!(refused(", [0, 0, 1]", "", "joint").contains("a matrix of 3 rows"));
        let none = refused(r#"["gravity.y", "j.torque_gain", "moments[0]"]"#, "[]", "joint");
        assert!(none.ends_with("it has no covariance"), "{none}");
        let covariances = [
            ("[[4, 1, 0], [1, 9, 0]", "[[-4, 1, 0], [1, 9, 0]", "gives `gravity.y` the variance -4"),
            (
                "[[4, 1, 0], [1, 9, 0]",
                "[[4, 1, 0], [1.1, 9, 0]",
                "not symmetric: 1.1 and 1 stand for `j.torque_gain` with",
            ),
            (
                "[[4, 1, 0], [1, 9, 0]",
                "[[4, 7, 0], [7, 9, 0]",
                "with `gravity.y` is 7, larger than their variances allow",
            ),
        ];
        for (old, new, reported) in covariances {
            let refused = refused(old, new, "joint");
            assert!(refused.contains(reported), "{refused}");
        }
        assert!(read(("[[4, 1, 0]", "[[4, 1.00000001, 0]"), "joint").is_ok());
        let said = |of_gain: &str| refused("\"value\": 7.5,", &format!("\"value\": 7.5, {of_gain},"), "joint");
        assert!(said("\"std\": -3").ends_with("`j.torque_gain` has the standard deviation -3, and none is negative"));
        assert!(said("\"ci95\": [9, 6]").ends_with("interval of `j.torque_gain` goes from 9 down to 6"));
        assert!(refused("\"nominal\"", "\"start\"", "joint").contains("not a calibration.json that gravcal wrote"));
        assert!(read_earlier(Path::new("no-such.json"), "joint").unwrap_err().to_string().starts_with("no-such.json"));
    }
}
