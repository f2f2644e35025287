//! What a file says, read back. That it reproduces the residuals of a recording is tried from outside, in the acceptance tests.

use gravcal_recording::{EarlierParameter, EarlierQuantity};

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
        quantities: vec![EarlierQuantity { terms: vec![("gravity.x".into(), 1.0)], value: 0.1 }],
        covariance: vec![1e-4],
    }
}

fn export<'a>(estimate: &'a EarlierEstimate, nominal: bool) -> Export<'a> {
    Export { estimate, source: "calibration.json (joint)", nominal, robot: None }
}

fn text(format: ExportFormat) -> String {
    let estimate = estimate();
    export(&estimate, false).to(format).unwrap().text
}

const AFFINE: [ExportFormat; 3] = [ExportFormat::Ros2, ExportFormat::C, ExportFormat::Python];
const TABLES: [ExportFormat; 3] = [ExportFormat::Csv, ExportFormat::Markdown, ExportFormat::Latex];

#[test]
fn names_read_back() {
    for format in ExportFormat::ALL {
        assert_eq!(format.as_str().parse(), Ok(format));
    }
    let unknown = "yaml".parse::<ExportFormat>().unwrap_err().to_string();
    assert_eq!(unknown, "unknown format `yaml`; there is: ros2, urdf, csv, c, python, markdown, latex");
}

#[test]
fn every_format_states_its_convention_and_where_it_comes_from() {
    for format in AFFINE.into_iter().chain([ExportFormat::Markdown, ExportFormat::Latex]) {
        let told = text(format).replace("\\_", "_").replace("\\*", "*");
        assert!(told.contains("calibration.json (joint)"), "{told}");
        let convention =
            if format == ExportFormat::Ros2 { "raw = gain * true + bias" } else { "position_gain * reading" };
        assert!(told.contains(convention), "{told}");
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

#[test]
fn sensors_beyond_gain_and_bias_are_refused_by_name_and_instruments_left_out_aloud() {
    let mut more = estimate();
    more.parameters.push(parameter("wrist.force_gain_x", "count/N", Some(20.0), 20.0));
    for format in AFFINE {
        let remarks = export(&more, false).to(format).unwrap().remarks;
        assert!(remarks.contains(&"wrist left out, which csv, markdown and latex hold".to_owned()), "{remarks:?}");
    }
    more.parameters.insert(4, parameter("a.coulomb_friction", "count", Some(1.5), 0.0));
    for format in AFFINE {
        let error = export(&more, true).to(format).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{format} holds gain and bias only")), "{error}");
        assert!(error.contains("a.coulomb_friction"), "{error}");
    }
    for format in TABLES {
        let text = export(&more, false).to(format).unwrap().text.replace("\\_", "_");
        assert!(text.contains("a.coulomb_friction") && text.contains("wrist.force_gain_x"), "{text}");
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
fn a_urdf_needs_one() {
    let estimate = estimate();
    assert_eq!(export(&estimate, false).to(ExportFormat::Urdf), Err(ExportError::NoUrdf));
}
