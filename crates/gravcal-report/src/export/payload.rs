//! Payloads and the mount's gravity as the drivers of some makers take them.
//!
//! | maker | call | frame and sign |
//! |---|---|---|
//! | Franka | `setLoad(mass, F_x_Cload, load_inertia)` | flange; tensor about the centre of mass, column by column |
//! | Universal Robots | `set_target_payload(m, CoG, inertia)`, `set_gravity(d)` | flange; `[Ixx, Iyy, Izz, Ixy, Ixz, Iyz]` about the centre of mass; d is **upward**: minus gravity |
//! | KUKA | load data M, X, Y, Z, A, B, C, JX, JY, JZ | flange; principal moments about the centre of mass along axes turned by A, B, C |
//! | Kinova | `tool_mass`, `tool_mass_center` | tool frame |

use gravcal_dynamics::BodyInertia;
use gravcal_recording::{EarlierParameter, EarlierPayload};
use gravcal_robot_model::session::LAST_FRAME_CHOICE;
use nalgebra::{Matrix3, Rotation3};

use super::numbers::{float, one_line};

pub(super) const CONVENTION: [&str; 4] = [
    "Convention: SI units; centre of mass and tensor in the frame of the link that carries the load, tensors about the centre of mass.",
    "Drivers take them in the frame of the flange: they are the same numbers where that is the link's frame, and must be moved there where",
    "it is not. Each number stands with its standard deviation in the lines of the load itself; the lines of the makers have values alone.",
    "Gravity is that in the frame of the base.",
];

/// What is said where gravity is all that there is.
pub(super) const NONE: &str = "no payload is in it, only the mount's gravity: the session has no load of unknown mass ([[load]] mass_kg = \"unknown\")";

/// Offsets that no reading tells, on which the frames of links hang.
pub(super) fn frame_remarks(parameters: &[EarlierParameter]) -> Vec<String> {
    let chosen = parameters.iter().filter(|parameter| parameter.held.as_deref() == Some(LAST_FRAME_CHOICE));
    let remark = |parameter: &EarlierParameter| {
        format!(
            "{} is held at {} deg, as no reading tells it: by as much as it is off, the centre of mass of a load beyond the joint is turned about its axis",
            parameter.name,
            float(parameter.nominal.to_degrees())
        )
    };
    chosen.map(remark).collect()
}

/// The loads and the mount's gravity, where that is known; `head`: lines of the comment.
pub(super) fn text(payloads: &[EarlierPayload], gravity: Option<[f64; 3]>, head: &[String]) -> String {
    let head: String = head.iter().map(|line| format!("# {line}\n")).collect();
    head + &mount(gravity) + &payloads.iter().map(of_load).collect::<String>()
}

fn mount(gravity: Option<[f64; 3]>) -> String {
    let Some(gravity) = gravity else { return "\n# gravity is not determined, and left out\n".to_owned() };
    let upward = gravity.map(|component| -component);
    format!(
        "\n# The mount.\ngravity_m_per_s2: {}\n# Universal Robots, where the robot's base frame is that of the URDF: upward.\nset_gravity({})\n",
        list(&gravity),
        list(&upward)
    )
}

fn of_load(payload: &EarlierPayload) -> String {
    let Some(mass) = &payload.mass_kg else { return String::new() };
    let mut text = format!("\n# Load {} on link {}.\n", one_line(&payload.load), one_line(&payload.link));
    text += &format!("mass_kg: {}  # ± {}\n", float(mass.value), float(mass.std));
    let Some(center) = &payload.center_of_mass_m else {
        return text + "# its centre of mass is not determined, and left out\n";
    };
    let place = center.map(|number| number.value);
    text += &format!("center_of_mass_m: {}  # ± {}\n", list(&place), list(&center.map(|number| number.std)));
    let stated = payload.tensor_kg_m2.map(|tensor| tensor.map(|number| number.value));
    if let Some((about, tensor)) = stated.zip(payload.tensor_kg_m2) {
        let std = tensor.map(|number| number.std);
        text += &format!("tensor_xx_xy_yy_xz_yz_zz_kg_m2: {}  # ± {}\n", list(&about), list(&std));
    }
    // A driver refuses what no body is, and so errors may have made it.
    let is_body = |about: &[f64; 6]| BodyInertia::about_center(mass.value, place, *about).least_spread() > 0.0;
    let tensor = stated.filter(is_body);
    let left_out = match (stated.is_some(), tensor.is_some()) {
        (false, _) => "# Its tensor is not determined: that of a point stands for it.\n",
        (true, false) => "# Its tensor is that of no body, within its errors: that of a point stands for it.\n",
        (true, true) => "",
    };
    text += left_out;
    let [xx, xy, yy, xz, yz, zz] = tensor.unwrap_or([0.0; 6]);
    let m = float(mass.value);
    text += &format!("# Franka\nsetLoad({m}, {}, {})\n", list(&place), list(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]));
    text += &format!(
        "# Universal Robots (the older set_payload takes the first two)\nset_target_payload({m}, {}, {})\n",
        list(&place),
        list(&[xx, yy, zz, xy, xz, yz])
    );
    text += &kuka(mass.value, place, &Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz));
    let [x, y, z] = place.map(float);
    text + &format!(
        "# Kinova\ntool_mass: {m}\ntool_mass_center_x: {x}\ntool_mass_center_y: {y}\ntool_mass_center_z: {z}\n"
    )
}

/// Millimetres and degrees, principal moments; A, B and C turn about z, then the new y, then the new x.
fn kuka(mass: f64, place: [f64; 3], tensor: &Matrix3<f64>) -> String {
    let eigen = tensor.symmetric_eigen();
    let mut axes = eigen.eigenvectors;
    if axes.determinant() < 0.0 {
        axes = -axes;
    }
    let (c, b, a) = Rotation3::from_matrix_unchecked(axes).euler_angles();
    let [x, y, z] = place.map(|meters| float(1e3 * meters));
    let [a, b, c] = [a, b, c].map(|angle| float(angle.to_degrees()));
    let [jx, jy, jz] = [0, 1, 2].map(|axis| float(eigen.eigenvalues[axis]));
    format!(
        "# KUKA load data: kg, mm, deg, kg·m²\nM {}, X {x}, Y {y}, Z {z}, A {a}, B {b}, C {c}, JX {jx}, JY {jy}, JZ {jz}\n",
        float(mass)
    )
}

fn list(numbers: &[f64]) -> String {
    format!("[{}]", numbers.iter().map(|number| float(*number)).collect::<Vec<_>>().join(", "))
}
