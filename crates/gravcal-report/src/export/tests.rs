//! What a file says, read back. That it reproduces the residuals of a recording is tried from outside, in the acceptance tests.

use gravcal_recording::{EarlierEstimate, EarlierNumber, EarlierParameter, EarlierPayload, EarlierQuantity};
use gravcal_robot_model::session::LAST_FRAME_CHOICE;

use super::*;

fn parameter(name: &str, unit: &str, value: Option<f64>, nominal: f64) -> EarlierParameter {
    EarlierParameter {
        name: name.into(),
        unit: unit.into(),
        value,
        held: None,
        std: value.map(|_| 0.02),
        ci95: value.map(|value| [value - 0.04, value + 0.04]),
        convention: "an equation".into(),
        nominal,
    }
}

/// One joint of whose sensors everything is known, and one without a torque sensor.
fn estimate() -> EarlierEstimate {
    let held = |why: &str, mut parameter: EarlierParameter| {
        (parameter.held, parameter.value, parameter.std) = (Some(why.into()), None, None);
        parameter
    };
    let none = "the joint has no torque sensor";
    EarlierEstimate {
        parameters: vec![
            parameter("a.torque_gain", "count/(N·m)", Some(7.123_456_789_012_3), 6.69),
            parameter("a.torque_bias", "count", Some(2074.9), 2048.0),
            parameter("a.position_gain", "rad/rad", Some(0.988), 1.0),
            held("it defines the base frame", parameter("a.position_offset", "rad", None, 0.0)),
            held(none, parameter("b.torque_gain", "1/(N·m)", None, 1.0)),
            held(none, parameter("b.torque_bias", "1", None, 0.0)),
            parameter("b.position_gain", "rad/count", Some(7.67e-4), 7.7e-4),
            parameter("b.position_offset", "rad", Some(-0.5), 0.0),
        ],
        gravity: Some([0.1, -0.2, -9.8]),
        gravity_ci95: Some([[0.08, 0.12], [-0.22, -0.18], [-9.9, -9.7]]),
        cone95_deg: Some(0.18),
        quantities: vec![EarlierQuantity { terms: vec![("gravity.x".into(), 1.0)], value: 0.1 }],
        covariance: vec![1e-4],
        blocks_left_out: None,
        sandwich_blocks: None,
        doubts: Vec::new(),
        inertias: None,
        payloads: Vec::new(),
    }
}

fn export<'a>(estimate: &'a EarlierEstimate, nominal: bool) -> Export<'a> {
    Export { estimate, source: "calibration.json (joint)", nominal, robot: None, model: None }
}

fn text(format: ExportFormat) -> String {
    let estimate = estimate();
    export(&estimate, false).to(format).unwrap().text
}

const AFFINE: [ExportFormat; 3] = [ExportFormat::Ros2, ExportFormat::C, ExportFormat::Python];
const TABLES: [ExportFormat; 3] = [ExportFormat::Csv, ExportFormat::Markdown, ExportFormat::Latex];

#[test]
fn doubts_are_told_by_every_format_that_has_comments_and_beside_all() {
    let doubted = EarlierEstimate { doubts: vec!["its residuals drift".into()], ..estimate() };
    for format in
        [ExportFormat::Ros2, ExportFormat::C, ExportFormat::Python, ExportFormat::Markdown, ExportFormat::Latex]
    {
        let (plain, told) = (export(&estimate(), true).to(format).unwrap(), export(&doubted, true).to(format).unwrap());
        assert!(!plain.text.contains("its residuals drift") && told.text.contains("its residuals drift"), "{format:?}");
        assert_eq!(told.remarks.len(), plain.remarks.len() + 1);
    }
    let csv = export(&doubted, false).to(ExportFormat::Csv).unwrap();
    assert!(csv.remarks.len() == 1 && !csv.text.contains("its residuals drift"));
}

#[test]
fn names_read_back() {
    for format in ExportFormat::ALL {
        assert_eq!(format.as_str().parse(), Ok(format));
    }
    let unknown = "yaml".parse::<ExportFormat>().unwrap_err().to_string();
    assert_eq!(
        unknown,
        "unknown format `yaml`; there is: ros2, urdf, mujoco, payload, csv, c, python, markdown, latex"
    );
}

#[test]
fn every_format_states_its_convention_and_where_it_comes_from() {
    for format in AFFINE.into_iter().chain([ExportFormat::Markdown, ExportFormat::Latex]) {
        let reported = text(format).replace('\\', "");
        assert!(reported.contains("calibration.json (joint)"), "{reported}");
        let convention = match format {
            ExportFormat::Ros2 => "raw = gain * true + bias",
            ExportFormat::C | ExportFormat::Python => "position_gain * reading",
            _ => "torque_gain, torque_bias, position_gain, position_offset: an equation",
        };
        assert!(reported.contains(convention), "{reported}");
    }
    assert!(text(ExportFormat::Csv).contains("an equation"));
}

#[test]
fn what_is_not_determined_is_refused_by_name_or_marked() {
    let mut estimate = estimate();
    estimate.parameters[0].value = None;
    estimate.gravity = None;
    for format in AFFINE {
        let error = export(&estimate, false).to(format).unwrap_err().to_string();
        assert_eq!(error, "the calibration does not determine a.torque_gain");
        let Exported { text, remarks } = export(&estimate, true).to(format).unwrap();
        let marks = [
            "a.torque_gain is not determined; its nominal value 6.69 stands here",
            "gravity is not determined, and left out",
            "a.position_offset is held at 0: it defines the base frame",
            "b has no torque sensor",
        ];
        assert!(marks.iter().all(|mark| text.contains(mark) && remarks.iter().any(|remark| remark == mark)), "{text}");
    }
    for format in TABLES {
        let text = export(&estimate, false).to(format).unwrap().text.replace("\\_", "_");
        let line = text.lines().find(|line| line.contains("a.torque_gain")).unwrap();
        assert!(line.contains("undetermined") && !line.contains("7.1"), "{line}");
    }
}

/// A wrist sensor that reads forces in counts, and of the moments only that about z.
fn wrist() -> Vec<EarlierParameter> {
    let unread = |mut parameter: EarlierParameter| {
        (parameter.held, parameter.value) = (Some("the axis is not read".into()), None);
        parameter
    };
    let forces = ["fx", "fy", "fz"].into_iter().zip([20.0, -25.0, 16.0]);
    let gains = forces.map(|(axis, gain)| parameter(&format!("wrist.gain_{axis}"), "count/N", Some(gain), 20.0));
    let forces = ["fx", "fy", "fz"].into_iter().zip([12.0, -7.0, 30.0]);
    let biases = forces.map(|(axis, bias)| parameter(&format!("wrist.bias_{axis}"), "count", Some(bias), 0.0));
    let mut all: Vec<EarlierParameter> = gains.chain(biases).collect();
    for axis in ["nx", "ny"] {
        all.push(unread(parameter(&format!("wrist.gain_{axis}"), "1/(N·m)", None, 1.0)));
        all.push(unread(parameter(&format!("wrist.bias_{axis}"), "1", None, 0.0)));
    }
    all.push(parameter("wrist.gain_nz", "N·m/(N·m)", Some(2.0), 1.0));
    all.push(parameter("wrist.bias_nz", "N·m", Some(0.5), 0.0));
    all.push(parameter("wrist.tool_mass", "kg", Some(1.2), 1.0));
    all
}

#[test]
fn gains_of_a_wrist_sensor_are_exported() {
    let mut more = estimate();
    more.parameters.extend(wrist());
    let exported = |format| export(&more, false).to(format).unwrap();
    for format in AFFINE {
        let Exported { text, remarks } = exported(format);
        let left = "wrist.tool_mass left out, which csv, markdown and latex hold".to_owned();
        assert!(remarks.contains(&left) && text.contains(&left), "{remarks:?}");
    }
    let ros2 = exported(ExportFormat::Ros2).text;
    for line in [
        "      instruments: [\"wrist\"]\n",
        "        axes: [\"fx\", \"fy\", \"fz\", \"nz\"]\n",
        "        gain: [20.0, 0.0, 0.0, 0.0, 0.0, -25.0, 0.0, 0.0, 0.0, 0.0, 16.0, 0.0, 0.0, 0.0, 0.0, 2.0]\n",
        "        bias: [12.0, -7.0, 30.0, 0.5]\n",
        "        inverse_gain: [0.05, 0.0, 0.0, 0.0, 0.0, -0.04, 0.0, 0.0, 0.0, 0.0, 0.0625, 0.0, 0.0, 0.0, 0.0, 0.5]\n",
        "        raw_units: [\"count\", \"count\", \"count\", \"N·m\"]\n",
        "        true_units: [\"N\", \"N\", \"N\", \"N·m\"]\n",
    ] {
        assert!(ros2.contains(line), "{line} in {ros2}");
    }
    let c = exported(ExportFormat::C).text;
    assert!(c.contains("  {\"wrist\", 4, {0.05, 0.0, 0.0, 0.0, 0.0, -0.04,"), "{c}");
    assert!(c.contains("{12.0, -7.0, 30.0, 0.5}}, /* fx in count, fy in count, fz in count, nz in N·m */"), "{c}");
    let python = exported(ExportFormat::Python).text;
    assert!(python.contains("        \"bias\": (12.0, -7.0, 30.0, 0.5,),\n"), "{python}");
    more.parameters.push(parameter("wrist.gain_fx_nx", "count/(N·m)", Some(0.1), 0.0));
    let error = export(&more, false).to(ExportFormat::C).unwrap_err();
    assert_eq!(error, ExportError::UnreadAxis { name: "wrist".into(), axis: "nx".into() });
}

#[test]
fn instruments_alone_are_exported_without_joints() {
    let alone = EarlierEstimate { parameters: wrist(), ..estimate() };
    let text = |format| export(&alone, false).to(format).unwrap().text;
    assert!(!text(ExportFormat::C).contains("JOINT_COUNT") && text(ExportFormat::C).contains("gravcal_sensed"));
    assert!(!text(ExportFormat::Ros2).contains("joints:"));
    assert!(text(ExportFormat::Python).contains("JOINTS = {\n}\n"));
}

#[test]
fn a_bias_of_each_table_and_drifts_of_a_wrist_sensor_are_refused_by_name() {
    for name in ["wrist.bias_fx_1", "wrist.bias_fx_drift"] {
        let mut more = EarlierEstimate { parameters: wrist(), ..estimate() };
        more.parameters.push(parameter(name, "count", Some(3.0), 0.0));
        for format in AFFINE {
            let error = export(&more, false).to(format).unwrap_err();
            assert_eq!(error, ExportError::BeyondAffine { format, names: vec![name.to_owned()] });
        }
    }
}

#[test]
fn sensors_beyond_gain_and_bias_are_refused_by_name() {
    let mut more = estimate();
    more.parameters.extend(wrist());
    more.parameters.insert(4, parameter("a.torque_gain_2", "count/(N·m)^2", Some(1.5), 0.0));
    for format in AFFINE {
        let error = export(&more, true).to(format).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{format} holds gain and bias only")), "{error}");
        assert!(error.contains("a.torque_gain_2"), "{error}");
    }
    let further = more.parameters.iter_mut().find(|parameter| parameter.name == "a.torque_gain_2").unwrap();
    further.convention = "reading = ... + torque_gain_2 * torque^2".into();
    for format in TABLES {
        let text = export(&more, false).to(format).unwrap().text.replace('\\', "");
        assert!(text.contains("reading = ... + torque_gain_2 * torque"), "{text}");
        assert!(text.contains("a.torque_gain_2") && text.contains("wrist.gain_fx"), "{text}");
    }
}

/// Friction is the joint's, and no part of its sensor.
#[test]
fn friction_is_left_out_with_a_remark() {
    let mut more = estimate();
    more.parameters.insert(4, parameter("a.coulomb_friction", "count", Some(1.5), 0.0));
    for format in AFFINE {
        let with = export(&more, true).to(format).unwrap();
        let without = export(&estimate(), true).to(format).unwrap();
        let gains =
            |text: &str| text.lines().filter(|line| line.contains("gain")).map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(gains(&with.text), gains(&without.text));
        let remark = with.remarks.iter().find(|remark| remark.starts_with("friction of a left out")).unwrap();
        let told = with.text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(told.contains("friction of a left out"), "{remark} is not in {}", with.text);
    }
}

#[test]
fn csv_has_every_digit() {
    let text = text(ExportFormat::Csv);
    let mut reader = ::csv::Reader::from_reader(text.as_bytes());
    let records: Vec<::csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let of = |name: &str| records.iter().find(|record| &record[0] == name).unwrap();
    assert_eq!(of("a.torque_gain")[2].parse(), Ok(7.123_456_789_012_3));
    assert_eq!((&of("a.torque_gain")[1], &of("a.torque_gain")[7]), ("count/(N·m)", "determined"));
    assert_eq!(of("gravity.x")[3].parse(), Ok(0.01));
    assert_eq!((of("gravity.y")[4].parse(), of("gravity.y")[5].parse()), (Ok(-0.22), Ok(-0.18)));
    assert_eq!(
        (of("gravity.cone95")[1].to_owned(), of("gravity.cone95")[2].parse()),
        ("rad".into(), Ok(0.18_f64.to_radians()))
    );
    let tilt: f64 = of("gravity.tilt")[2].parse().unwrap();
    assert!((tilt - 0.05_f64.sqrt().atan2(9.8)).abs() < 1e-15, "{tilt}");
    assert_eq!((&of("b.torque_gain")[7], &of("b.torque_gain")[8]), ("held", "the joint has no torque sensor"));
}

#[test]
fn tables_for_people_are_rounded_to_the_standard_deviation() {
    let markdown = text(ExportFormat::Markdown);
    assert!(markdown.contains("| a.torque\\_gain | count/(N·m) | 7.123 | 0.020 | 6.69 |\n"), "{markdown}");
    assert!(markdown.contains("| b.position\\_offset | deg | -28.6 | 1.1 | 0 |\n"), "{markdown}");
    let latex = text(ExportFormat::Latex);
    assert!(latex.contains("  a.torque\\_gain & count/(N$\\cdot$m) & $7.123$ & $0.020$ & $6.69$ \\\\\n"), "{latex}");
    assert!(latex.contains("  gravity.x & m/s$^2$ & $0.100$ & $0.010$ &  \\\\\n"), "{latex}");
}

#[test]
fn a_joint_of_which_something_is_missing_is_refused_by_name() {
    for (gone, name) in [(3, "a.position_offset"), (5, "b.torque_bias"), (6, "b.position_gain")] {
        let mut estimate = estimate();
        estimate.parameters.remove(gone);
        for format in AFFINE {
            let error = export(&estimate, true).to(format).unwrap_err();
            assert_eq!(error, ExportError::Missing { names: vec![name.to_owned()] });
        }
    }
}

#[test]
fn names_that_mean_something_to_a_format_are_written_so_that_they_do_not() {
    let mut odd = estimate();
    for parameter in &mut odd.parameters {
        parameter.name = parameter.name.replace("a.", "<b>|`---.");
    }
    let text = |format| export(&odd, false).to(format).unwrap().text;
    assert!(text(ExportFormat::Markdown).contains("| \\<b\\>\\|\\`---.torque\\_gain | "));
    assert!(
        text(ExportFormat::Latex).contains("\\textless{}b\\textgreater{}\\textbar{}\\textasciigrave{}-{}-{}-.torque")
    );
    for key in ["joints", "gravity_m_per_s2"] {
        let mut taken = estimate();
        for parameter in &mut taken.parameters {
            parameter.name = parameter.name.replace("a.", &format!("{key}."));
        }
        let error = export(&taken, false).to(ExportFormat::Ros2).unwrap_err();
        assert_eq!(error, ExportError::NameTaken { format: ExportFormat::Ros2, name: key.to_owned() });
        assert!(export(&taken, false).to(ExportFormat::C).is_ok());
    }
}

#[test]
fn a_urdf_needs_one() {
    let estimate = estimate();
    assert_eq!(export(&estimate, false).to(ExportFormat::Urdf), Err(ExportError::NoUrdf));
    assert_eq!(export(&estimate, false).to(ExportFormat::Mujoco), Err(ExportError::NoModel));
}

fn tool() -> EarlierPayload {
    let number = |value: f64| EarlierNumber { value, std: 0.01 };
    EarlierPayload {
        load: "tool".into(),
        link: "link7".into(),
        mass_kg: Some(number(1.5)),
        center_of_mass_m: Some([0.01, -0.02, 0.1].map(number)),
        tensor_kg_m2: Some([0.02, 0.001, 0.03, 0.0, 0.0, 0.015].map(number)),
    }
}

#[test]
fn payloads_are_in_the_forms_of_the_makers() {
    let with = EarlierEstimate { payloads: vec![tool()], ..estimate() };
    let text = export(&with, false).to(ExportFormat::Payload).unwrap().text;
    for line in [
        "# Load tool on link link7.\nmass_kg: 1.5  # ± 0.01\n",
        "set_gravity([-0.1, 0.2, 9.8])\n",
        "setLoad(1.5, [0.01, -0.02, 0.1], [0.02, 0.001, 0.0, 0.001, 0.03, 0.0, 0.0, 0.0, 0.015])\n",
        "set_target_payload(1.5, [0.01, -0.02, 0.1], [0.02, 0.03, 0.015, 0.001, 0.0, 0.0])\n",
        "tool_mass: 1.5\ntool_mass_center_x: 0.01\n",
    ] {
        assert!(text.contains(line), "{line} in {text}");
    }
}

#[test]
fn without_a_load_of_unknown_mass_no_payload_is_told() {
    let Exported { text, remarks } = export(&estimate(), false).to(ExportFormat::Payload).unwrap();
    assert!(remarks.len() == 1 && remarks[0].starts_with("no payload is in it"), "{remarks:?}");
    assert!(text.contains("# Note: no payload is in it") && text.contains("set_gravity(["), "{text}");
}

/// The last joint's offset turns the frame in which the centre of mass stands.
#[test]
fn a_held_offset_on_which_a_payload_hangs_is_told() {
    let mut with = EarlierEstimate { payloads: vec![tool()], ..estimate() };
    assert_eq!(export(&with, false).to(ExportFormat::Payload).unwrap().remarks, [""; 0]);
    let offset = with.parameters.last_mut().unwrap();
    (offset.held, offset.value, offset.std) = (Some(LAST_FRAME_CHOICE.into()), None, None);
    let Exported { text, remarks } = export(&with, false).to(ExportFormat::Payload).unwrap();
    assert!(remarks[0].starts_with("b.position_offset is held at 0.0 deg, as no reading tells it: "), "{remarks:?}");
    assert!(text.contains("# Note: b.position_offset is held at 0.0 deg"), "{text}");
}

/// Load data of KUKA turn the principal moments back to the tensor: Rz(A) Ry(B) Rx(C) diag(J) of it.
#[test]
fn principal_moments_turn_back_to_the_tensor() {
    let with = EarlierEstimate { payloads: vec![tool()], ..estimate() };
    let text = export(&with, false).to(ExportFormat::Payload).unwrap().text;
    let line = text.lines().find(|line| line.starts_with("M 1.5, X 10.0, Y -20.0, Z 100.0, A ")).unwrap();
    let of = |name: &str| -> f64 {
        let part = line.split(", ").find_map(|part| part.strip_prefix(&format!("{name} "))).unwrap();
        part.parse().unwrap()
    };
    let turned = |angle: f64, axis: usize| {
        let axis = nalgebra::Vector3::ith_axis(axis);
        nalgebra::Rotation3::from_axis_angle(&axis, angle.to_radians())
    };
    let axes = turned(of("A"), 2) * turned(of("B"), 1) * turned(of("C"), 0);
    let moments = nalgebra::Matrix3::from_diagonal(&nalgebra::Vector3::new(of("JX"), of("JY"), of("JZ")));
    let tensor = axes.matrix() * moments * axes.matrix().transpose();
    let expected = nalgebra::Matrix3::new(0.02, 0.001, 0.0, 0.001, 0.03, 0.0, 0.0, 0.0, 0.015);
    assert!((tensor - expected).abs().max() < 1e-12, "{tensor}");
}

#[test]
fn what_is_open_of_a_payload_is_refused_or_said() {
    let export_of = |tool: EarlierPayload| {
        let with = EarlierEstimate { payloads: vec![tool], ..estimate() };
        export(&with, true).to(ExportFormat::Payload)
    };
    let error = export_of(EarlierPayload { mass_kg: None, ..tool() }).unwrap_err().to_string();
    assert_eq!(error, "the calibration does not determine the mass of load tool");
    let standing = export_of(EarlierPayload { tensor_kg_m2: None, ..tool() }).unwrap().text;
    assert!(
        standing.contains("Its tensor is not determined") && standing.contains("[0.0, 0.0, 0.0, 0.0, 0.0, 0.0])"),
        "{standing}"
    );
    let mut broken = tool();
    broken.tensor_kg_m2.as_mut().unwrap()[2].value = 0.3;
    assert!(
        export_of(broken).unwrap().text.contains("that of no body"),
        "a tensor that breaks the triangle inequality"
    );
}
