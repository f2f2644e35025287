//! Where the URDFs are, and how numbers are compared.

use std::path::{Path, PathBuf};

use gravcal_dynamics::Chain;

/// `GRAVCAL_SHARED_DATA`, or `../shared/data` beside the project; nothing, and a word about it, where that is not there.
pub fn shared_data() -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("GRAVCAL_SHARED_DATA").map_or_else(beside, PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("SKIPPED: no URDFs at {}; set GRAVCAL_SHARED_DATA to the folder that holds them", folder.display());
    None
}

/// The chain of a file in that folder, with these joints.
pub fn chain(folder: &Path, file: &str, base: &str, tips: &[String], joints: &[String]) -> Chain {
    let text = std::fs::read_to_string(folder.join(file)).unwrap();
    let tips: Vec<&str> = tips.iter().map(String::as_str).collect();
    let chain = Chain::from_urdf(&text, base, &tips).unwrap();
    let names: Vec<_> = chain.joints().iter().map(|joint| joint.name.clone()).collect();
    assert_eq!(names, joints, "{file}");
    chain
}

pub fn largest_difference(left: &[f64], right: &[f64]) -> f64 {
    assert_eq!(left.len(), right.len());
    // `max` would lose a NaN; the sum does not.
    assert!(left.iter().sum::<f64>().is_finite(), "{left:?}");
    left.iter().zip(right).map(|(l, r)| (l - r).abs()).fold(0.0, f64::max)
}
