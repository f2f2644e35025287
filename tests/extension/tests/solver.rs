//! A method of this crate estimates what those of gravcal do.

use std::path::Path;

use gravcal::calibration::result::EstimatorResult;
use gravcal::calibration::simulation::Simulation;
use gravcal::calibration::{EstimatorName, Session, SolveEnvironment, calibrate};
use gravcal::estimation::Solver;
use gravcal::solvers::SolverName;
use gravcal_extension::{Marquardt, registry};

fn session() -> Session {
    let folder = tempfile::tempdir().unwrap();
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models/sarcos-dextrous-arm/robot.toml");
    std::fs::copy(robot, folder.path().join("robot.toml")).unwrap();
    std::fs::write(folder.path().join("simulation.toml"), include_str!("simulation.toml")).unwrap();
    Simulation::read_with(&folder.path().join("simulation.toml"), &registry()).unwrap().session(0)
}

fn calibrated(session: &Session, solver: &dyn Solver) -> EstimatorResult {
    calibrate(session, &[EstimatorName::Joint], &SolveEnvironment::new(solver, &|_| {})).remove(0)
}

#[test]
fn a_method_of_this_crate_finds_the_same() {
    let session = session();
    let own = calibrated(&session, &Marquardt::default());
    let known = calibrated(&session, SolverName::LevenbergMarquardt.build().as_ref());
    assert!(own.parameters.iter().filter(|reported| reported.std.is_some()).count() > 15, "{:?}", own.undetermined);
    for (own, known) in own.parameters.iter().zip(&known.parameters) {
        assert_eq!((&own.name, own.determined), (&known.name, known.determined));
        if let (Some(a), Some(b), Some(std)) = (own.value, known.value, known.std) {
            assert!((a - b).abs() <= 0.02 * std, "{}: {a} {b} ± {std}", own.name);
        }
    }
}
