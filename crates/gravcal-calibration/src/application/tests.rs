use std::sync::Arc;

use gravcal_recording::{
    ConditionColumn, ConditionColumns, ConditionUnit, Course, EarlierParameter, EarlierQuantity, Kept, MotionLimits,
    MotionSource, PoseMapping, PositionColumn, PositionUnit, ReadingColumn, Selection, TorqueUnit,
};
use gravcal_robot_model::sensors::{Moment, Options};
use gravcal_session::simulation::Simulation;

use super::*;
use crate::testing::sarcos_shoulder;
use crate::testing::sensor_models::{shoulder, with_model};

/// Columns `q1 … tau1 … v1 … T`; a joint moves from 1 deg/s on.
fn readings() -> PoseMapping {
    let name = |stem: &str, joint: usize| format!("{stem}{}", joint + 1);
    let torque =
        |joint| ReadingColumn { column: name("tau", joint), highest: Some(4095.0), ..ReadingColumn::default() };
    let velocity = |joint| ConditionColumn { column: name("v", joint), unit: ConditionUnit::ANGULAR_VELOCITY[1] };
    PoseMapping {
        positions: (0..3).map(|j| PositionColumn::new(name("q", j), PositionUnit::Degree)).collect(),
        torques: (0..3).map(|joint| Some((torque(joint), TorqueUnit::Count))).collect(),
        conditions: ConditionColumns {
            temperature: vec![ConditionColumn { column: "T".into(), unit: ConditionUnit::TEMPERATURE[0] }; 3],
            velocity: MotionSource::Columns((0..3).map(velocity).collect()),
            ..ConditionColumns::default()
        },
        selection: Selection {
            joint: MotionLimits { speed_above: vec![1_f64.to_radians(); 3], ..MotionLimits::default() },
            ..Selection::default()
        },
        ..PoseMapping::default()
    }
}

fn columns() -> Vec<String> {
    let names = ["other", "q1", "q2", "q3", "tau1", "tau2", "tau3", "v1", "v2", "v3", "T"];
    names.map(str::to_owned).to_vec()
}

/// A session that knows its readings, and a calibration that knows the truth.
fn truth(simulation: &Simulation) -> (Session, EarlierEstimate) {
    let session = Session { readings: readings(), ..simulation.session(0) };
    let truth = &simulation.truth;
    let parameter = |id| EarlierParameter {
        name: session.parameter_name(id),
        unit: session.parameter(id).unit,
        value: Some(truth.value(id)),
        std: None,
        ci95: None,
        convention: String::new(),
        held: None,
        nominal: 0.0,
    };
    let parameters = session.parameters().into_iter().map(parameter).collect();
    let component = |name: String, value: f64| EarlierQuantity { terms: vec![(name, 1.0)], value };
    let axes = ["mass", "first_moment.x", "first_moment.y", "first_moment.z"];
    let links = session.robot.chain.links().iter().zip(&truth.inertia);
    let inertia = links.flat_map(|(link, numbers)| {
        axes.iter().zip(numbers).map(|(axis, number)| component(format!("{}.{axis}", link.name), *number))
    });
    let [a, b] = [truth.loads[0], truth.loads[1]];
    let placements = ["x", "y", "z"].into_iter().enumerate().flat_map(|(axis, name)| {
        let displacement = format!("load.plate-b.displacement_from.plate-a.{name}");
        [component(format!("load.plate-a.position.{name}"), a[axis]), component(displacement, b[axis] - a[axis])]
    });
    let quantities = inertia.chain(placements).collect();
    let calibration = EarlierEstimate {
        parameters,
        gravity: Some(truth.gravity),
        gravity_ci95: None,
        cone95_deg: None,
        quantities,
        covariance: Vec::new(),
        blocks_left_out: None,
        sandwich_blocks: None,
        doubts: Vec::new(),
        inertias: None,
        payloads: Vec::new(),
    };
    (session, calibration)
}

/// A row as the sensors truly read it, in the units of its columns, and the torques that they read.
fn row(session: &Session, simulation: &Simulation, load: Option<usize>) -> (Vec<f64>, [f64; 3], Vec<f64>) {
    let (truth, degrees) = (&simulation.truth, 1_f64.to_radians());
    let (readings, velocities, temperature) = ([20.0, -35.0, 50.0], [2.0, -3.0, 4.0], 31.0);
    let conditions = Conditions {
        temperature: vec![temperature; 3],
        velocity: velocities.iter().map(|v| v * degrees).collect(),
        ..Conditions::default()
    };
    let inside: Vec<f64> = readings.iter().map(|q| q * degrees).collect();
    let coordinates = session.terms.coordinates(&inside, &conditions, truth);
    let mut inertia = truth.inertia.concat();
    if let Some(load) = load {
        let mass = session.loads[load].mass;
        let numbers = &mut inertia[4 * session.loads[load].link..];
        numbers[0] += mass;
        (0..3).for_each(|axis| numbers[1 + axis] += mass * truth.loads[load][axis]);
    }
    let mut torque = [0.0; 3];
    session.robot.chain.gravity_torque(&coordinates, truth.gravity, &inertia, &mut torque);
    let counts = session.terms.torque_readings(&Moment::new(&torque, &coordinates, &inside, &conditions), truth);
    let cells = [&[7.0][..], &readings, &counts, &velocities, &[temperature]].concat();
    (cells, torque, coordinates.iter().map(|coordinate| coordinate / degrees).collect())
}

fn near(found: &[f64], expected: &[f64]) {
    assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 1e-9), "{found:?} {expected:?}");
}

/// Sensors with every model that can be applied.
fn bent() -> Simulation {
    let options = Options::default().with("reference_degC", 25).with("orders", vec![1]);
    let models: [(&str, &[f64]); 6] = [
        ("torque-bias-with-temperature", &[0.3]),
        ("torque-gain-polynomial", &[4e-3, -4e-5]),
        ("coulomb-friction", &[1.5]),
        ("viscous-friction", &[20.0]),
        ("torque-crosstalk", &[0.1, -0.2]),
        ("position-harmonics", &[0.02, -0.01]),
    ];
    models.into_iter().fold(shoulder(), |simulation, (model, truth)| with_model(simulation, 1, model, &options, truth))
}

#[test]
fn readings_become_what_they_truly_say() {
    for simulation in [sarcos_shoulder(), bent()] {
        let (session, calibration) = truth(&simulation);
        let (before, torque, coordinates) = row(&session, &simulation, None);
        let mut application = Application::new(&session, &calibration, &Effort::Torque, false, None).unwrap();
        application.find(&columns()).unwrap();
        let mut cells = before.clone();
        application.apply(&columns(), &mut cells);
        near(&cells[1..4], &coordinates);
        near(&cells[4..7], &torque);
        assert_eq!((cells[0], cells[10]), (7.0, 31.0));
        // Velocities are the derivatives of the coordinates.
        let advanced: Vec<f64> =
            (0..3).map(|joint| (before[1 + joint] + 1e-4 * before[7 + joint]).to_radians()).collect();
        let advanced = session.terms.coordinates(&advanced, &Conditions::default(), &simulation.truth);
        for joint in 0..3 {
            let velocity = (advanced[joint].to_degrees() - coordinates[joint]) / 1e-4;
            assert!((cells[7 + joint] - velocity).abs() < 1e-4, "{} {velocity}", cells[7 + joint]);
        }
        assert_eq!(application.remarks(), Vec::<String>::new());
    }
}

#[test]
fn gains_of_other_units_are_refused() {
    let (session, calibration) = truth(&sarcos_shoulder());
    assert_eq!(check_units(&session, &calibration), Ok(()));
    for name in ["joint2.torque_gain", "joint3.position_gain"] {
        let mut other = calibration.clone();
        let parameter = other.parameters.iter_mut().find(|parameter| parameter.name == name).unwrap();
        parameter.unit = "N·m/(N·m)".to_owned();
        let refused = Application::new(&session, &other, &Effort::Torque, true, None).unwrap_err();
        assert!(matches!(&refused, ApplicationError::Unit { name: reported, .. } if reported == name), "{refused}");
        assert_eq!(check_units(&session, &other), Err(refused));
    }
}

/// At a noise of velocity of either sign the torque of a resting joint is one and the same, with and without gravity.
#[test]
fn a_resting_joint_has_no_sign_of_coulomb_friction() {
    let friction = 1.5;
    let simulation = with_model(shoulder(), 1, "coulomb-friction", &Options::default(), &[friction]);
    let (session, calibration) = truth(&simulation);
    let (moving, torque, _) = row(&session, &simulation, None);
    let step = friction / simulation.truth.sensors[1][0];
    let reported = |session: &Session, effort: &Effort| {
        let mut application = Application::new(session, &calibration, effort, false, None).unwrap();
        let torques = [moving[8], -0.01, 0.0, 0.01].map(|velocity| {
            let mut cells = moving.clone();
            cells[8] = velocity;
            application.apply(&columns(), &mut cells);
            cells[5]
        });
        (torques, application.remarks())
    };
    let mut lax = session.clone();
    lax.readings.selection = Selection::default();
    for (effort, gravity) in [(Effort::Torque, 0.0), (Effort::Residual { load: None }, torque[1])] {
        let expected = torque[1] - gravity;
        let (found, remarks) = reported(&session, &effort);
        // The reading holds the friction of a falling joint.
        near(&found, &[expected, expected - step, expected - step, expected - step]);
        assert_eq!(
            remarks,
            [
                "joint joint2: at 3 of its 4 torque readings it was no faster than speed_above of readings.select, where the sign \
              of Coulomb friction is not known: none was taken off"
            ]
        );
        let (found, remarks) = reported(&lax, &effort);
        near(&found, &[expected, expected, expected - step, expected - 2.0 * step]);
        assert!(remarks[0].starts_with("joint joint2: at 1 of its 4 torque readings its speed was 0"), "{remarks:?}");
        assert!(remarks[1].starts_with("joint joint2: Coulomb friction has the sign of the velocity"), "{remarks:?}");
    }
}

#[test]
fn without_gravity_nothing_is_left_of_a_standing_arm() {
    for simulation in [sarcos_shoulder(), bent()] {
        let (session, calibration) = truth(&simulation);
        for (load, name) in [(None, None), (Some(0), Some("plate-a")), (Some(1), Some("plate-b"))] {
            let (mut cells, ..) = row(&session, &simulation, load);
            let effort = Effort::Residual { load: name.map(str::to_owned) };
            let mut application = Application::new(&session, &calibration, &effort, false, None).unwrap();
            application.apply(&columns(), &mut cells);
            near(&cells[4..7], &[0.0; 3]);
        }
    }
}

#[test]
fn what_a_row_does_not_say_is_as_it_was_said_last() {
    let simulation = sarcos_shoulder();
    let (session, calibration) = truth(&simulation);
    let (whole, ..) = row(&session, &simulation, None);
    let effort = Effort::Residual { load: None };
    let mut application = Application::new(&session, &calibration, &effort, false, None).unwrap();
    let mut arm = whole.clone();
    arm[3] = f64::NAN;
    application.apply(&columns(), &mut arm);
    assert!(arm[4..7].iter().all(|cell| cell.is_nan()), "{arm:?}");
    let mut hand = vec![f64::NAN; whole.len()];
    hand[3] = whole[3];
    application.apply(&columns(), &mut hand);
    assert!(hand[1].is_nan() && !hand[3].is_nan() && hand[4].is_nan());
    let mut arm = whole.clone();
    arm[3] = f64::NAN;
    application.apply(&columns(), &mut arm);
    near(&arm[4..7], &[0.0; 3]);
    assert_eq!(application.remarks().len(), 1);
}

/// A joint at 179° and then −179° has moved by two degrees. Its position gain of 1.01 acts on the turn that the session takes its angles within.
#[test]
fn angles_are_taken_as_the_session_took_its_own() {
    let (mut session, mut calibration) = truth(&shoulder());
    calibration
        .parameters
        .iter_mut()
        .filter(|own| own.name == "joint2.position_gain")
        .for_each(|own| own.value = Some(1.01));
    let offset = calibration.parameters.iter().find(|own| own.name == "joint2.position_offset").unwrap().value.unwrap();
    let (cells, ..) = row(&session, &shoulder(), None);
    let calibrated = |session: &Session| {
        let mut applied = Application::new(session, &calibration, &Effort::Torque, true, None).unwrap();
        [179.0, -179.0].map(|reading| {
            let mut cells = cells.clone();
            cells[2] = reading;
            applied.apply(&columns(), &mut cells);
            (cells[2] - offset.to_degrees()) / 1.01
        })
    };
    let near = |found: [f64; 2], expected: [f64; 2]| {
        found.iter().zip(expected).for_each(|(a, b)| assert!((a - b).abs() < 1e-9, "{found:?} {expected:?}"));
    };
    near(calibrated(&session), [179.0, -179.0]);
    session.turns = vec![None, Some(-350_f64.to_radians()), None];
    near(calibrated(&session), [-181.0, -179.0]);
    session.turns.clear();
    let course = Course { stretches: Vec::new(), kept: Kept::default() };
    session.poses[0].course = Some(Arc::new(course));
    near(calibrated(&session), [179.0, 181.0]);
}

#[test]
fn a_saturated_reading_has_no_torque() {
    let simulation = sarcos_shoulder();
    let (session, calibration) = truth(&simulation);
    let (mut cells, torque, _) = row(&session, &simulation, None);
    cells[5] = 4095.0;
    let mut application = Application::new(&session, &calibration, &Effort::Torque, false, None).unwrap();
    application.apply(&columns(), &mut cells);
    assert!(cells[5].is_nan() && (cells[4] - torque[0]).abs() < 1e-9);
    assert!(application.remarks()[0].starts_with("joint joint2: 1 torque readings are at an end"));
}

#[test]
fn what_is_not_determined_is_refused_by_name_or_nominal() {
    let simulation = sarcos_shoulder();
    let (session, mut calibration) = truth(&simulation);
    for parameter in &mut calibration.parameters {
        match parameter.name.as_str() {
            "joint1.torque_gain" | "joint3.position_offset" => parameter.value = None,
            _ => {}
        }
    }
    let offset = calibration.parameters.iter_mut().find(|found| found.name == "joint3.position_offset").unwrap();
    (offset.held, offset.nominal) = (Some("a choice of frame".into()), 0.7);
    let error = Application::new(&session, &calibration, &Effort::Torque, false, None).unwrap_err();
    assert_eq!(error.to_string(), "the calibration does not determine joint1.torque_gain");
    let taken = Application::new(&session, &calibration, &Effort::Torque, true, None).unwrap();
    assert_eq!(
        (taken.values.sensors[0][0], taken.values.sensors[2][3]),
        (session.joints[0].parameters[0].nominal, 0.7)
    );
}

#[test]
fn moments_that_no_torque_shows_may_be_undetermined_and_others_not() {
    let simulation = sarcos_shoulder();
    let (session, calibration) = truth(&simulation);
    let effort = Effort::Residual { load: None };
    let without = |names: &[&str]| {
        let mut calibration = calibration.clone();
        calibration.quantities.retain(|known| !names.contains(&known.terms[0].0.as_str()));
        Application::new(&session, &calibration, &effort, false, None).map(|_| ()).map_err(|error| error.to_string())
    };
    // A first link's mass hangs on its own axis.
    assert_eq!(without(&["link1.mass"]), Ok(()));
    let expected = "the calibration does not determine the masses and moments that gravity's torque depends on at joint1, \
                    joint2, joint3";
    assert_eq!(without(&["link3.first_moment.x"]), Err(expected.to_owned()));
    let mut blind = calibration.clone();
    blind.gravity = None;
    assert_eq!(Application::new(&session, &blind, &effort, false, None).unwrap_err(), ApplicationError::NoGravity);
    let wrong = Effort::Residual { load: Some("plate-c".into()) };
    let error = Application::new(&session, &calibration, &wrong, false, None).unwrap_err().to_string();
    assert_eq!(error, "the session has no load `plate-c`; it has plate-a, plate-b");
    let swept = Session { inertia: gravcal_robot_model::session::InertiaPrior::Sweep, ..session.clone() };
    assert_eq!(Application::new(&swept, &calibration, &effort, false, None).unwrap_err(), ApplicationError::BySweep);
}

#[test]
fn what_a_recording_cannot_say_is_refused() {
    let (simulation, options) = (shoulder(), Options::default());
    let drift = with_model(simulation.clone(), 1, "torque-bias-in-time", &options, &[0.1]);
    let (session, calibration) = truth(&drift);
    let error = Application::new(&session, &calibration, &Effort::Torque, false, None).unwrap_err();
    assert_eq!(error, ApplicationError::Drift { joint: "joint2".into(), model: "torque-bias-in-time".into() });

    let friction = with_model(simulation, 1, "viscous-friction", &options, &[0.1]);
    let (mut session, calibration) = truth(&friction);
    // Without rows to read ahead.
    for unsaid in [MotionSource::Slope(Slope { window: 0.1 }), MotionSource::Unknown] {
        session.readings.conditions.velocity = unsaid;
        let error = Application::new(&session, &calibration, &Effort::Torque, false, None).unwrap_err();
        assert_eq!(error, ApplicationError::NoVelocities { joint: "joint2".into(), model: "viscous-friction".into() });
    }

    let (mut session, calibration) = truth(&sarcos_shoulder());
    session.let_joints_give_way(&[0.0, 1e-4, 1e-4]);
    let error = Application::new(&session, &calibration, &Effort::Torque, false, None).unwrap_err();
    let names = ["joint2.compliance", "joint3.compliance"].map(str::to_owned).into();
    assert_eq!(error, ApplicationError::Compliance { names });
    session.deflection.compliance = None;
    session.let_joints_give_way(&[0.0; 3]);
    assert!(Application::new(&session, &calibration, &Effort::Torque, false, None).is_ok());

    let (session, mut calibration) = truth(&sarcos_shoulder());
    let mut application = Application::new(&session, &calibration, &Effort::Torque, false, None).unwrap();
    let error = application.find(&columns()[..5]).unwrap_err().to_string();
    assert!(error.starts_with("the recording has no column `tau2`, which the session's [readings] name"), "{error}");
    drop(application);
    calibration.parameters.remove(0);
    let error = Application::new(&session, &calibration, &Effort::Torque, false, None).unwrap_err();
    assert_eq!(error, ApplicationError::OtherSession { name: "joint1.torque_gain".into() });
}

/// A model that the calibration found and another session leaves out would pass into torques and angles.
#[test]
fn a_model_that_the_session_leaves_out_is_refused() {
    let (plain, _) = truth(&shoulder());
    let (_, mut calibration) = truth(&with_model(shoulder(), 1, "viscous-friction", &Options::default(), &[0.1]));
    let error = Application::new(&plain, &calibration, &Effort::Torque, false, None).unwrap_err();
    assert_eq!(error, ApplicationError::OtherModels { names: vec!["joint2.viscous_friction".into()] });

    // What was held at nothing changes nothing; what belongs to no joint is of no joint's readings.
    let parameter = calibration.parameters.iter_mut().find(|found| found.name == "joint2.viscous_friction").unwrap();
    parameter.held = Some("the session fixes it".into());
    calibration.parameters.push(EarlierParameter { name: "wrist.fx.gain".into(), ..calibration.parameters[0].clone() });
    assert!(Application::new(&plain, &calibration, &Effort::Torque, false, None).is_ok());
}
