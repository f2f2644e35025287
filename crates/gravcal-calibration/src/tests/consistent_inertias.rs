//! Inertias that rigid bodies can have, from an arm in motion whose file states other ones than it has.

use std::fs;
use std::path::Path;

use gravcal_dynamics::{BodyInertia, Chain, DynamicParameters, InverseDynamics, JointMotion, Single};
use gravcal_robot_model::session::Session;
use gravcal_session::read_session;
use gravcal_session::simulation::{Simulation, write_session};
use gravcal_solvers::LevenbergMarquardt;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::joint::{Signals, estimate_jointly};
use crate::result::{ConsistentModel, EstimatorResult};
use gravcal_identification::SolveEnvironment;

const JOINT: &str = r#"<joint name="NAME" type="revolute"><parent link="PARENT"/><child link="CHILD"/>
    <origin xyz="0.1 0.05 0.3" rpy="1.2 0.3 0"/><axis xyz="0 0 1"/><limit lower="-1.5" upper="1.5" effort="1" velocity="1"/></joint>"#;
const SIMULATION: &str = r#"
robot = { urdf = "arm.urdf", base = "base", tip = "c" }
seed = 3
[gravity]
direction = [0.1, -0.2, -3]
magnitude_m_per_s2 = 9.81
[torque]
unit = "N·m"
std = 0.02
[position]
unit = "rad"
[recording]
rate_hz = 200
samples = 3000
move_s = 1
motion = { harmonics = 5, period_s = 10, seed = 2 }
[[load]]
name = "plate"
mass_kg = 1.5
link = "c"
position_m = [0.1, 0.05, 0.1]
[[joint]]
name = "j2"
sensor_models = [{ kind = "coulomb-friction", parameters = { coulomb_friction = { value = 0.4, unit = "N·m" } } }]
[[random]]
file = "bare.csv"
poses = 2
[[random]]
file = "loaded.csv"
poses = 2
load = "plate"
"#;

/// Three links, each so many times as heavy as 2 kg.
fn urdf(times: [f64; 3]) -> String {
    let link = |(name, times): (&str, f64)| {
        let entries = [0.03, 0.025, 0.02, 0.002, -0.001, 0.003].map(|entry| times * entry);
        let [xx, yy, zz, xy, xz, yz] = entries;
        let mass = 2.0 * times;
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"0.1 0.05 0.12\"/><mass value=\"{mass}\"/><inertia ixx=\"{xx}\" \
             iyy=\"{yy}\" izz=\"{zz}\" ixy=\"{xy}\" ixz=\"{xz}\" iyz=\"{yz}\"/></inertial></link>"
        )
    };
    let joint = |name: &str, parent: &str, child: &str| {
        JOINT.replace("NAME", name).replace("PARENT", parent).replace("CHILD", child)
    };
    let joints = [joint("j1", "base", "a"), joint("j2", "a", "b"), joint("j3", "b", "c")].concat();
    let links: String = ["a", "b", "c"].into_iter().zip(times).map(link).collect();
    format!("<robot name=\"arm\"><link name=\"base\"/>{links}{joints}</robot>")
}

/// A recording of the arm with masses of 2 kg, and the session's file beside a robot whose links are `times` as heavy.
fn recorded(folder: &Path, times: [f64; 3]) -> std::path::PathBuf {
    fs::write(folder.join("arm.urdf"), urdf([1.0; 3])).unwrap();
    fs::write(folder.join("simulation.toml"), SIMULATION).unwrap();
    let simulation = Simulation::read(&folder.join("simulation.toml")).unwrap();
    let files = write_session(&simulation, 0, folder, false).unwrap();
    fs::write(folder.join("arm.urdf"), urdf(times)).unwrap();
    files[0].clone()
}

fn session(path: &Path, more: &str) -> Session {
    let text = fs::read_to_string(path).unwrap();
    fs::write(path, format!("{text}\n{more}")).unwrap();
    let session = read_session(path);
    fs::write(path, text).unwrap();
    session.unwrap()
}

fn estimate(session: &Session) -> EstimatorResult {
    let solver = LevenbergMarquardt::default();
    estimate_jointly(session, Signals::All, None, &SolveEnvironment::new(&solver, &|_| {})).unwrap()
}

fn bodies(model: &ConsistentModel) -> Vec<BodyInertia> {
    let body = |link: &crate::result::LinkInertiaResult| {
        BodyInertia::about_center(link.mass_kg, link.center_of_mass_m, link.tensor_kg_m2)
    };
    model.links.iter().map(body).collect()
}

/// Root mean square over some motions of the difference of two arms' torques, N·m.
fn difference(chain: &Chain, one: &[f64], other: &[f64]) -> f64 {
    let mut random = Pcg64::seed_from_u64(4);
    let mut draw = |size: f64| -> Vec<f64> { (0..3).map(|_| size * random.random_range(-1.0..1.0)).collect() };
    let mut squares = 0.0;
    for _ in 0..200 {
        let (q, v, a) = (draw(1.5), draw(2.0), draw(5.0));
        let motion = JointMotion { coordinates: &q, velocities: &v, accelerations: &a };
        let torques = [one, other].map(|links| {
            let mut dynamics = InverseDynamics::new(chain);
            let parameters = DynamicParameters { links, rotor_inertia: &[0.0; 3] };
            chain.inverse_dynamics(Single, motion, [0.3, -0.6, -9.7], parameters, &mut dynamics);
            dynamics.torque
        });
        squares += torques[0].iter().zip(&torques[1]).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    }
    (squares / 600.0).sqrt()
}

#[test]
fn bodies_are_found_that_move_as_the_true_ones_though_the_file_states_others() {
    let folder = tempfile::tempdir().unwrap();
    let path = recorded(folder.path(), [1.4, 0.8, 1.3]);
    let assumed = session(&path, "[constraints]\ninertia = \"physical\"\n");
    let result = estimate(&assumed);
    let model = result.consistent_model.as_ref().unwrap();
    let found = bodies(model);
    assert!(found.iter().all(|body| body.mass > 0.0 && body.least_spread() > 0.0), "{model:?}");
    let found: Vec<f64> = found.iter().flat_map(BodyInertia::parameters).collect();
    let chain = Chain::from_urdf(&urdf([1.0; 3]), "base", &["c"]).unwrap();
    let truth = chain.inertial_parameters().unwrap();
    let stated = assumed.robot.chain.inertial_parameters().unwrap();
    let [off, before] = [found.as_slice(), &stated].map(|parameters| difference(&chain, parameters, &truth));
    assert!(off < 0.05 && before > 0.5, "{off} {before} {model:?}");
    assert!(model.tensors_from_readings && model.variance_inflation > 0.0);
}

#[test]
fn what_is_reported_of_sensors_does_not_depend_on_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = recorded(folder.path(), [1.4, 0.8, 1.3]);
    let [with, without] = ["[constraints]\ninertia = \"physical\"\n", ""].map(|more| estimate(&session(&path, more)));
    assert!(without.consistent_model.is_none());
    assert_eq!(format!("{:?}", with.parameters), format!("{:?}", without.parameters));
    assert_eq!(format!("{:?}", with.gravity), format!("{:?}", without.gravity));
}

#[test]
fn a_file_without_tensors_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = recorded(folder.path(), [1.0; 3]);
    let bare = urdf([1.0, 0.0, 1.0]).replace("ixx=\"0.03\" iyy=\"0.025\"", "ixx=\"0\" iyy=\"0\"");
    let bare = bare
        .replace("izz=\"0.02\" ixy=\"0.002\" ixz=\"-0.001\" iyz=\"0.003\"", "izz=\"0\" ixy=\"0\" ixz=\"0\" iyz=\"0\"");
    fs::write(folder.path().join("arm.urdf"), bare).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, format!("{text}\n[constraints]\ninertia = \"physical\"\n")).unwrap();
    let reported = read_session(&path).unwrap_err().to_string();
    for expected in ["constraints.inertia", "a mass for b", "an inertia tensor for a, c", "<inertial>"] {
        assert!(reported.contains(expected), "{expected}: {reported}");
    }
}
