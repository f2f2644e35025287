//! Damaged and monstrous recordings, in `GRAVCAL_SHARED_DATA` or `../shared/data` beside the project; a test says where they are not
//! there. What they are is told in their README.

#![allow(clippy::unwrap_used)] // also in the functions that the tests share

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use gravcal_recording::{CsvWriting, Inspection, Rewriting, inspect, rewrite};

/// Where a file of the shared data is; says so if it is not there.
fn shared(path: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let found = std::env::var_os("GRAVCAL_SHARED_DATA").map_or_else(beside, PathBuf::from).join("damaged").join(path);
    if !found.exists() {
        println!("skipped: there is no {}", found.display());
        return None;
    }
    Some(found)
}

fn inspected(path: &Path) -> Result<Inspection, String> {
    inspect(path, &|_| {}).map_err(|error| error.to_string())
}

/// What rewriting says.
fn rewritten(path: &Path) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("again.mcap");
    let (csv, notes) = (&CsvWriting::default(), BTreeMap::new());
    let what = Rewriting { input: path, output: &output, overwrite: false, csv, notes: &notes };
    rewrite(&what, &mut |_, _| {}, &mut |_| true).unwrap()
}

#[test]
fn damaged_parquet_files_are_refused() {
    for number in 1..=4 {
        let Some(path) = shared(&format!("parquet/damaged-{number}.parquet")) else { return };
        let error = inspected(&path).unwrap_err();
        assert!(error.contains("this Parquet file cannot be read, it seems to be damaged"), "{error}");
    }
}

#[test]
fn a_record_that_announces_four_gigabytes_is_lost_and_said() {
    for (name, what) in [
        ("schema-4G", "the schema at byte"),
        ("chan-4G", "the description of a channel at byte"),
        ("metadata-4G", "the metadata record at byte"),
    ] {
        let Some(path) = shared(&format!("mcap/{name}.mcap")) else { return };
        let found = inspected(&path).unwrap();
        assert_eq!(found.rows, 100);
        assert!(found.remarks.iter().any(|remark| remark.starts_with(what)), "{:?}", found.remarks);
    }
}

#[test]
fn what_rewriting_leaves_out_is_said() {
    for (name, expected) in [
        ("lost", "the attachment at byte 18817 is damaged and left out: it is shorter than it says"),
        ("badcrc", "the attachment at byte 18817 is damaged and left out: its check sum is not that of its bytes"),
        ("lostmeta", "the metadata record at byte 18817 is damaged and left out: it cannot be taken apart"),
    ] {
        let Some(path) = shared(&format!("mcap/{name}.mcap")) else { return };
        assert_eq!(rewritten(&path), [expected], "{name}");
    }
}

#[test]
fn a_bag_whose_every_chunk_is_damaged_says_so() {
    let Some(path) = shared("mcap/allbad.mcap") else { return };
    let error = inspected(&path).unwrap_err();
    assert!(error.contains("the chunk at byte 117") && error.contains("is damaged and left out"), "{error}");
}

#[test]
fn many_topics_are_read_and_many_joints_refused() {
    let Some(path) = shared("mcap/slow-topics-2e5.mcap") else { return };
    assert_eq!(inspected(&path).unwrap().source.topics.len(), 200_001);
    for name in ["slow-alternating-1600joints-1200m", "slow-3333joints-12000msg"] {
        let Some(path) = shared(&format!("mcap/{name}.mcap")) else { return };
        let error = inspected(&path).unwrap_err();
        assert!(error.contains("joints, and no more than 1365 are read"), "{error}");
    }
}
