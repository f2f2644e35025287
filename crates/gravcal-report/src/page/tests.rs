//! What a page says first, and how large it is.

use gravcal_calibration::result::{Concern, EstimatorResult, ReadingResidual, Undetermined, Verdict};
use gravcal_robot_model::Session;
use gravcal_robot_model::session::ReadingId;
use gravcal_session::simulation::Simulation;

use super::*;
use crate::provenance::{Options, Provenance};
use crate::testing::{determined, fit, result, undetermined};

/// The shoulder's session with its simulated poses.
fn session() -> Session {
    let path =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments/sarcos-shoulder/simulation.toml");
    Simulation::read(&path).unwrap().session(0)
}

fn provenance() -> Provenance {
    let options = Options {
        estimators: vec!["joint".into()],
        solver: "levenberg-marquardt".into(),
        solver_options: toml::Table::new(),
    };
    Provenance::new(Vec::new(), options)
}

fn page(session: &Session, results: &[EstimatorResult]) -> String {
    CalibrationPage { session, results, provenance: &provenance() }.to_html().unwrap()
}

/// Residuals of every torque reading.
fn residuals(session: &Session) -> Vec<ReadingResidual> {
    let read = (0..session.poses.len())
        .flat_map(|pose| (0..session.joints.len()).map(move |channel| ReadingId { pose, channel }));
    let one = |id: ReadingId| ReadingResidual {
        id,
        residual: ((id.pose * 7 + id.channel) % 13) as f64 - 6.0,
        nominal_residual: 100.0,
        std: 0.8,
        weight: 1.0,
        torque: None,
    };
    read.map(one).collect()
}

fn joint(session: &Session) -> EstimatorResult {
    let mut joint = result("joint");
    joint.parameters = vec![determined("joint1.torque_gain", "count/(N·m)", 7.118, 0.02)];
    joint.fit = Some(gravcal_calibration::result::Fit { residuals: residuals(session), ..fit() });
    joint
}

#[test]
fn a_perfect_a_partly_determined_and_a_failed_calibration_say_first_what_to_do() {
    let session = session();
    let perfect = page(&session, &[joint(&session)]);
    assert!(perfect.contains("Determined: these numbers can be used"));
    // The fit of each joint, and of what was held out.
    assert!(
        perfect.contains("<th>rms, held out</th>") && perfect.contains("<td class=\"number\">0.912</td>"),
        "{perfect}"
    );
    assert!(!perfect.contains("Tests on residuals"), "none were made");
    assert!(perfect.contains("gravcal export calibration.json --to ros2"));

    let mut open = joint(&session);
    open.verdict = Verdict::PartlyDetermined;
    open.parameters.push(undetermined("joint3.torque_gain"));
    open.undetermined = vec![Undetermined {
        combination: "joint3.torque_gain".into(),
        parameters: vec!["joint3.torque_gain".into()],
        why: "no torque".into(),
        cure: "attach a load <of known mass>".into(),
    }];
    let partly = page(&session, &[open]);
    assert!(partly.contains("Partly determined: do not use what has no number"));
    assert!(partly.contains("The data do not determine joint3.torque_gain."));
    assert!(partly.contains("<li>attach a load &lt;of known mass&gt;</li>"));

    let mut wrong = joint(&session);
    wrong.verdict = Verdict::Failed;
    wrong.termination = "the model contradicts the readings: residuals 40 times the stated noise".into();
    wrong.notes = vec!["What to look at: the sign of a torque sensor".into()];
    let failed = page(&session, &[wrong]);
    assert!(
        failed.contains("Failed: there is no answer to rely on") && failed.contains("Use no number of this result.")
    );
    assert!(failed.contains("The model contradicts the readings") && failed.contains("<li>What to look at: the sign"));
    for text in [perfect, partly, failed] {
        let verdict = text.find("class=\"verdict").unwrap();
        assert!(verdict < text.find("<table").unwrap() && text.contains("default-src 'none'"));
    }
}

#[test]
fn a_misfit_is_no_clean_bill() {
    let session = session();
    let mut misfit = joint(&session);
    misfit.concerns = vec![Concern::Misfit { times_noise: 2.0 }];
    let text = page(&session, &[misfit]);
    assert!(text.contains("Usable with care") && text.contains("explained 2.0 times worse than their stated noise"));
}

#[test]
fn nothing_is_fetched_and_no_name_breaks_out() {
    let mut session = session();
    session.robot.name = "</script><script>alert(1)</script>".into();
    session.tables[0].path = "</script><b>.csv".into();
    let text = page(&session, &[joint(&session)]);
    assert_eq!(text.matches("<script").count(), 2);
    assert!(!text.contains("http://") && !text.contains("https://") && !text.contains("<b>.csv"));
}

#[test]
fn without_a_fit_there_are_no_figures_and_still_a_page() {
    let session = session();
    let mut failed = joint(&session);
    (failed.fit, failed.verdict) = (None, Verdict::Failed);
    assert!(!page(&session, &[failed]).contains("<canvas"));
    assert!(page(&session, &[]).contains("No estimator ran"));
}

/// Seven joints, 20,000 poses, two estimators.
#[test]
fn a_large_recording_is_a_small_page() {
    let path =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments/seven-joints-tilted/simulation.toml");
    let mut session = Simulation::read(&path).unwrap().session(0);
    session.poses = session.poses.iter().cycle().take(20_000).cloned().collect();
    let mut sequential = joint(&session);
    sequential.name = "sequential".into();
    let results = [joint(&session), sequential];
    let text = page(&session, &results);
    assert!(text.len() < 5_000_000, "{} bytes", text.len());
    assert_eq!(text, page(&session, &results));
}
