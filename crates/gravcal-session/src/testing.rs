//! The reference protocol of the Sarcos shoulder, and a small robot, for tests.

use gravcal_dynamics::{DhConvention, DhRow, JointKind, Link, LinkInertia, Transform, chain_from_dh};
use gravcal_recording::{PositionUnit, TorqueUnit};
use gravcal_robot_model::State;
use gravcal_robot_model::parameter::{Limit, Parameter};
use gravcal_robot_model::robot::Robot;
use gravcal_robot_model::session::{
    AuxiliarySensor, AuxiliarySensorKind, GravityPrior, JointPriors, Load, LoadDistance, ParameterPrior, PoseTable,
    PriorKind, Session,
};

use gravcal_session::simulation::{Disturbance, Run, Simulation};

/// A `robot.toml` of two joints that carry gravity.
pub const TWO_JOINTS: &str = r#"
name = "two-joints"
convention = "standard-dh"
[[joint]]
name = "shoulder"
a_m = 0.0
alpha_deg = 90
d_m = 0.0
link = "upper-arm"
mass_kg = 2
center_of_mass_m = [0, 0, 0.1]
[[joint]]
name = "elbow"
a_m = 0.3
alpha_deg = 90
d_m = 0.0
link = "forearm"
mass_kg = 1
center_of_mass_m = [0.1, 0, 0.1]
"#;

/// Three axes through the shoulder, twists 90°, −90°, 90°.
pub fn sarcos_robot() -> Robot {
    let row = |i: usize, alpha: f64, moment: [f64; 3]| DhRow {
        name: format!("joint{i}"),
        kind: JointKind::Revolute,
        a: 0.0,
        alpha: alpha.to_radians(),
        d: 0.0,
        theta: 0.0,
        limits: None,
        link: Link { name: format!("link{i}"), inertia: Some(LinkInertia { mass: 2.0, first_moment: moment }) },
    };
    let rows = [row(1, 90.0, [0.2, 0.1, 0.3]), row(2, -90.0, [0.5, -1.0, 0.8]), row(3, 90.0, [1.5, 0.8, 2.5])];
    let chain = chain_from_dh("base", DhConvention::Standard, &rows).unwrap();
    Robot { name: "sarcos".into(), chain, sensors: vec![Default::default(); 3] }
}

/// The reference protocol: nine sweeps of 37 readings.
pub fn sarcos_shoulder() -> Simulation {
    let start = |nominal| ParameterPrior { nominal, kind: PriorKind::Flat };
    let joint = |offset: f64| JointPriors {
        torque_unit: Some(TorqueUnit::Count),
        torque_sign_declared: false,
        position_unit: PositionUnit::Radian,
        parameters: [start(6.69), start(2048.0), start(1.0), start(offset)],
    };
    let quarter = std::f64::consts::FRAC_PI_2;
    let sweep =
        |swept: usize, held: [f64; 3]| Run::Sweep { swept, range: [-quarter, quarter], poses: 37, held: held.to_vec() };
    let rest = [-quarter; 3];
    let at = |joint: usize, q: f64| {
        let mut held = rest;
        held[joint] = q;
        held
    };
    let runs = vec![
        (sweep(0, rest), None, 1),
        (sweep(1, rest), None, 1),
        (sweep(2, rest), None, 1),
        (sweep(1, at(0, -0.6)), None, 2),
        (sweep(1, at(0, 0.9)), None, 2),
        (sweep(1, at(0, 0.3)), Some(0), 3),
        (sweep(1, at(0, 0.3)), Some(1), 3),
        (sweep(2, at(1, -0.7)), Some(0), 3),
        (sweep(2, at(1, -0.7)), Some(1), 3),
        (sweep(2, at(1, 0.8)), Some(0), 3),
        (sweep(2, at(1, 0.8)), Some(1), 3),
    ];
    let direction: nalgebra::Vector3<f64> = nalgebra::Vector3::new(-3.43, -5.94, -7.0).normalize();
    let load = |name: &str| Load { name: name.into(), mass: 1.724, link: 2, position: None, position_std: None };
    let centre: nalgebra::Vector3<f64> = nalgebra::Vector3::new(0.15, 0.05, 0.45);
    let arm: nalgebra::Vector3<f64> = 0.201 * nalgebra::Vector3::new(0.8, 0.0, 0.6);
    let template = Session {
        loads: vec![load("plate-a"), load("plate-b")],
        load_distances: vec![LoadDistance { between: [0, 1], distance: 0.402, std: None }],
        tables: runs
            .iter()
            .enumerate()
            .map(|(i, (_, load, step))| PoseTable {
                path: format!("sweep-{i}.csv").into(),
                load: *load,
                swept: None,
                step: Some(*step),
            })
            .collect(),
        ..Session::new(
            sarcos_robot(),
            GravityPrior { magnitude: 9.8, magnitude_std: None, hemisphere: Some(direction.into()) },
            vec![joint(0.0), joint(135f64.to_radians()), joint(0.2)],
        )
    };
    let mut truth = State::nominal(&template);
    truth.gravity = (9.8 * direction).into();
    truth.sensors =
        vec![[7.12, 2075.0, 0.988, 0.0], [5.97, 2008.0, 0.995, 134.2_f64.to_radians()], [6.5, 2050.0, 1.01, 0.2]];
    truth.loads = vec![[0, 1, 2].map(|i| centre[i] + arm[i]), [0, 1, 2].map(|i| centre[i] - arm[i])];
    let runs = runs.into_iter().map(|(run, _, _)| run).collect();
    Simulation::new(template, truth, runs, Disturbance::noise(vec![0.8; 3]), 1)
}

/// The same with a wrist sensor on the last link and an accelerometer on the first, whose gains are one an axis.
pub fn sarcos_with_instruments() -> Simulation {
    let mut simulation = sarcos_shoulder();
    let wrist = AuxiliarySensor {
        name: "wrist".into(),
        kind: AuxiliarySensorKind::ForceTorque,
        link: 2,
        mounting: Transform::from_xyz_rpy([0.02, -0.01, 0.1], [0.2, -0.3, 0.4]),
        in_base: false,
        sign_declared: true,
        units: vec![Some("count".into()); 6],
        gains: (0..6).map(|axis| (axis, axis)).collect(),
        biases: 1,
        drifts: Vec::new(),
        first_parameter: 0,
        first_reading: 0,
    };
    let imu = AuxiliarySensor {
        name: "imu".into(),
        kind: AuxiliarySensorKind::Accelerometer,
        link: 0,
        mounting: Transform::about_x(0.7),
        in_base: false,
        sign_declared: true,
        units: vec![Some("g".into()); 3],
        gains: (0..3).map(|axis| (axis, axis)).collect(),
        biases: 1,
        drifts: Vec::new(),
        first_parameter: 16,
        first_reading: 6,
    };
    let nominal_and_true = [
        ([20.0, 20.0, 20.0, 400.0, 400.0, 400.0].as_slice(), [20.6, 19.5, 20.2, 410.0, 391.0, 404.0].as_slice()),
        (&[0.0; 6], &[12.0, -7.0, 30.0, -15.0, 4.0, 9.0]),
        (&[1.0, 0.03, 0.02, 0.05], &[1.3, 0.01, -0.02, 0.06]),
        (&[0.102; 3], &[0.1035, 0.1012, 0.1023]),
        (&[0.0; 3], &[0.004, -0.003, 0.002]),
        (&[0.0; 3], &[0.0; 3]),
    ];
    let template = &mut simulation.template;
    for (group, (nominal, truth)) in nominal_and_true.into_iter().enumerate() {
        let owner = if group < 3 { "wrist" } else { "imu" };
        let fixed = group == 5;
        template.further.extend(nominal.iter().enumerate().map(|(axis, nominal)| Parameter {
            owner: owner.into(),
            quantity: format!("{}_{axis}", ["gain", "bias", "tool", "gain", "bias", "mounting"][group]),
            unit: String::new(),
            convention: "".into(),
            prior: ParameterPrior { nominal: *nominal, kind: if fixed { PriorKind::Fixed } else { PriorKind::Flat } },
            fixed: fixed.then_some("given"),
            limit: match group % 3 {
                0 => Limit::ShareOfNominal(0.1),
                _ => Limit::Absolute(f64::INFINITY),
            },
            cure: "".into(),
            linear: group % 3 == 1 || group == 2,
            same_as: None,
        }));
        simulation.truth.further.extend(truth);
    }
    template.instruments = vec![wrist, imu];
    simulation.disturbance.instrument_std = [[1.0; 3].as_slice(), &[2.0; 3], &[0.002; 3]].concat();
    simulation
}
