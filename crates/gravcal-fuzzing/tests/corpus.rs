//! Replays the corpus of every fuzz target, what once broke a reader among it: `fuzz/corpus/<target>` here.

use std::fs;
use std::path::Path;

#[allow(clippy::unwrap_used)] // clippy does not see that it is part of tests
fn replay(target: &str, read: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(target);
    let mut files: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{}", folder.display());
    for file in files {
        println!("{}", file.display());
        read(&fs::read(&file).unwrap());
    }
}

macro_rules! replayed {
    ($($target:ident),*) => { $(
        #[test]
        fn $target() {
            replay(stringify!($target), gravcal_fuzzing::$target);
        }
    )* };
}

replayed!(
    csv,
    mcap,
    parquet,
    sqlite,
    joint_state,
    urdf,
    session,
    robot,
    calibration,
    simulation,
    study,
    study_folder,
    study_table
);
