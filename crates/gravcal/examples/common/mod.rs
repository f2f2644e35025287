//! An arm of three joints on a tilted base, and what its sensors would read: for the examples, which have no robot at hand.

use gravcal::calibration::joint::State;
use gravcal::calibration::session::{GravityPrior, Load, PoseTable};
use gravcal::calibration::simulation::{Disturbance, Run, Simulation};
use gravcal::calibration::{Robot, Session};
use gravcal::dynamics::{ChainError, DhConvention, DhRow, JointKind, Link, LinkInertia, chain_from_dh};

/// Noise of a torque reading, N·m.
pub const STD: f64 = 0.02;

/// Three joints by their Denavit-Hartenberg rows. Masses are what the simulation needs; no calibration is told them.
pub fn robot() -> Result<Robot, ChainError> {
    let row = |name: &str, [a, alpha_deg, d]: [f64; 3], mass: f64, centre: [f64; 3]| DhRow {
        name: name.to_owned(),
        kind: JointKind::Revolute,
        a,
        alpha: alpha_deg.to_radians(),
        d,
        theta: 0.0,
        limits: None,
        link: Link {
            name: format!("link of {name}"),
            inertia: Some(LinkInertia { mass, first_moment: centre.map(|component| mass * component) }),
        },
    };
    let rows = [
        row("joint1", [0.0, 90.0, 0.36], 4.0, [0.0, -0.1, 0.02]),
        row("joint2", [0.4, 0.0, 0.0], 3.0, [-0.2, 0.0, 0.03]),
        row("joint3", [0.3, 0.0, 0.0], 2.0, [-0.1, 0.02, 0.0]),
    ];
    let chain = chain_from_dh("base", DhConvention::Standard, &rows)?;
    Ok(Robot { name: "my-arm".to_owned(), chain, sensors: vec![Default::default(); 3] })
}

/// What is known before anything is recorded: how strong gravity is, roughly where it points, and a plate of 2 kg whose place on the last
/// link is not known.
pub fn nothing_recorded() -> Result<Session, ChainError> {
    let hemisphere = [0.3, 0.1, -1.0].map(|component| component / 1.1_f64.sqrt());
    let gravity = GravityPrior { magnitude: 9.80665, magnitude_std: None, hemisphere: Some(hemisphere) };
    let mut session = Session::of_robot(robot()?, gravity);
    session.loads = vec![Load { name: "plate".to_owned(), mass: 2.0, link: 2, position: None, position_std: None }];
    Ok(session)
}

/// 30 poses bare and 30 with the plate, of an arm whose second torque sensor has a gain of 1.08 and a bias of 0.7 N·m.
pub fn simulation() -> Result<Simulation, ChainError> {
    let mut template = nothing_recorded()?;
    let table = |name: &str, load| PoseTable { path: name.into(), load, swept: None, step: None };
    template.tables = vec![table("bare", None), table("with the plate", Some(0))];
    let mut truth = State::nominal(&template);
    truth.sensors[1] = [1.08, 0.7, 1.0, 0.0];
    truth.loads = vec![[0.1, 0.05, 0.0]];
    let runs = vec![Run::Random { poses: 30, moving: None }; 2];
    Ok(Simulation::new(template, truth, runs, Disturbance::noise(vec![STD; 3]), 1))
}
