//! What is exported, and what comes of it.

use gravcal_dynamics::Chain;
use gravcal_recording::EarlierEstimate;

use super::numbers::one_line;

/// What is exported.
#[derive(Clone, Copy, Debug)]
pub struct Export<'a> {
    /// The calibration.
    pub estimate: &'a EarlierEstimate,
    /// Where it comes from, in words: file, estimator, hash.
    pub source: &'a str,
    /// Whether nominal values stand for what is not determined.
    pub nominal: bool,
    /// The robot's URDF, which only [`ExportFormat::Urdf`](super::ExportFormat::Urdf) needs.
    pub robot: Option<RobotDescription<'a>>,
    /// The robot as the session knows it, which only [`ExportFormat::Mujoco`](super::ExportFormat::Mujoco) needs.
    pub model: Option<RobotModel<'a>>,
}

/// A file's contents.
#[derive(Clone, Debug, PartialEq)]
pub struct Exported {
    /// The file.
    pub text: String,
    /// What whoever takes it should know; the file says it, too.
    pub remarks: Vec<String>,
}

/// The robot's own URDF.
#[derive(Clone, Copy, Debug)]
pub struct RobotDescription<'a> {
    /// Its text.
    pub urdf: &'a str,
    /// The link in whose frame gravity is given.
    pub base: &'a str,
}

/// The robot as gravcal computes with it.
#[derive(Clone, Copy, Debug)]
pub struct RobotModel<'a> {
    /// Name of the robot.
    pub name: &'a str,
    /// Its joints and links.
    pub chain: &'a Chain,
}

/// Why intervals may not hold, which whoever takes the numbers should know.
pub(super) fn doubts(estimate: &EarlierEstimate) -> Vec<String> {
    estimate.doubts.iter().map(|doubt| format!("intervals may not hold: {doubt}")).collect()
}

/// Lines for a file's head: where it comes from, the convention, remarks.
pub(super) fn head(export: &Export<'_>, convention: &[impl AsRef<str>], remarks: &[String]) -> Vec<String> {
    let source = format!("gravcal {}: {}", env!("CARGO_PKG_VERSION"), export.source);
    let convention = convention.iter().map(|line| line.as_ref().to_owned());
    let doubts = doubts(export.estimate);
    let remarks = doubts.iter().chain(remarks).map(|remark| format!("Note: {remark}."));
    std::iter::once(source).chain(convention).chain(remarks).map(|line| one_line(&line)).collect()
}
