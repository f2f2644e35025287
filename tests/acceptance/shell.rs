//! What shells and `man` are given.

use std::fs;

use crate::program::gravcal_in;
use crate::tree;

#[test]
fn completions_know_every_command() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish"] {
        let run = gravcal_in(folder.path(), ["completions", shell]);
        assert_eq!(run.code, 0, "{run:?}");
        for known in ["calibrate", "check", "inspect", "overwrite"] {
            assert!(run.stdout.contains(known), "{shell} does not know {known}");
        }
    }
    assert_eq!(gravcal_in(folder.path(), ["completions", "abacus"]).refusal(&["abacus", "bash"]), None);
}

#[test]
fn the_manual_has_a_page_for_each_command() {
    let folder = tempfile::tempdir().unwrap();
    let run = gravcal_in(folder.path(), ["manual", "man/man1"]);
    assert!(run.code == 0 && run.stdout == "Manual in man/man1\n", "{run:?}");
    let pages: Vec<String> =
        tree::entries(&folder.path().join("man/man1")).iter().map(|page| tree::name(page)).collect();
    for page in ["gravcal.1", "gravcal-calibrate.1", "gravcal-study-run.1"] {
        assert!(pages.iter().any(|name| name == page), "{page} is not among {pages:?}");
    }
    fs::write(folder.path().join("file"), "").unwrap();
    assert_eq!(gravcal_in(folder.path(), ["manual", "file"]).refusal(&["file"]), None);
}
