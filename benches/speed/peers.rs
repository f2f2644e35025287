//! The peers: programs that read the same problem from a folder, solve it on one thread and print a [`Row`].

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::table::Row;

const SOURCES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/peers");
/// Keeps the linear algebra of every peer on one thread.
const ONE_THREAD: [(&str, &str); 3] =
    [("OPENBLAS_NUM_THREADS", "1"), ("OMP_NUM_THREADS", "1"), ("MKL_NUM_THREADS", "1")];

/// A program that is there to run.
pub struct Peer {
    pub name: &'static str,
    /// Whether it can take unknowns of single poses out of the problem.
    pub eliminates: bool,
    /// The program and its first arguments; the folder follows.
    command: Vec<PathBuf>,
}

/// The peers that this machine can run; says of the others how to install them.
pub fn available() -> Vec<Peer> {
    let found = [
        ("Ceres", true, ceres(), "apt-get install cmake g++ libceres-dev"),
        ("SciPy", false, scipy(), "pip install numpy scipy"),
    ];
    let mut peers = Vec::new();
    for (name, eliminates, command, install) in found {
        match command {
            Ok(command) => peers.push(Peer { name, eliminates, command }),
            Err(message) => println!("{name} is left out: {message}\n  to install it: {install}\n"),
        }
    }
    peers
}

impl Peer {
    /// Solves the problem in `folder`; with errors of positions of this standard deviation, rad, as further unknowns where one is given.
    pub fn run(&self, folder: &Path, position_error: Option<f64>) -> Result<Row, String> {
        let mut command = Command::new(&self.command[0]);
        command.args(&self.command[1..]).arg(folder).args(position_error.map(|std| std.to_string())).envs(ONE_THREAD);
        let output = output(&mut command)?;
        serde_json::from_str(&output).map_err(|e| format!("printed no result ({e}): {output}"))
    }
}

/// Builds the Ceres program beside this one: like this one for any processor, or for this one only.
fn ceres() -> Result<Vec<PathBuf>, String> {
    let own = std::env::current_exe().map_err(|e| e.to_string())?;
    let build = own.with_file_name("peers-ceres");
    let source = Path::new(SOURCES).join("ceres");
    println!("building the Ceres program in {}", build.display());
    let native = if cfg!(target_feature = "avx2") { "-DNATIVE=ON" } else { "-DNATIVE=OFF" };
    let mut configure = Command::new("cmake");
    output(configure.arg("-S").arg(source).arg("-B").arg(&build).args(["-DCMAKE_BUILD_TYPE=Release", native]))?;
    output(Command::new("cmake").arg("--build").arg(&build))?;
    Ok(vec![build.join("seven_joints")])
}

/// The SciPy program, for the `python3` of the path.
fn scipy() -> Result<Vec<PathBuf>, String> {
    output(Command::new("python3").args(["-c", "import numpy, scipy.optimize"]))?;
    Ok(vec!["python3".into(), Path::new(SOURCES).join("scipy").join("seven_joints.py")])
}

/// What a program prints; where it fails, what it complains of.
fn output(command: &mut Command) -> Result<String, String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command.output().map_err(|e| format!("cannot run {name}: {e}"))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    Err(format!("{name} failed:\n{}", String::from_utf8_lossy(&output.stderr).trim()))
}
