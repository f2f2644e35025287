//! What README.md tells to paste runs as it stands there.

use std::fs;

use crate::program::gravcal_in;
use crate::tree;

/// A section of README.md, from its heading to the next one of any level.
fn section(heading: &str) -> String {
    let readme = fs::read_to_string(tree::root().join("README.md")).unwrap();
    let from = readme.split_once(&format!("\n{heading}\n")).unwrap_or_else(|| panic!("README.md has no {heading}")).1;
    // A comment in a block begins with one #, too.
    from.split("\n##").next().unwrap().to_owned()
}

/// The blocks of a language in a text, in their order.
fn blocks<'t>(text: &'t str, language: &str) -> Vec<&'t str> {
    let opening = format!("```{language}\n");
    text.split(opening.as_str()).skip(1).map(|rest| rest.split("```").next().unwrap()).collect()
}

/// The name of the file in a block's first line: `# robot.toml: …`.
fn file_name(block: &str) -> &str {
    let comment = block.lines().next().and_then(|line| line.strip_prefix("# ")).unwrap();
    comment.split(':').next().unwrap()
}

#[test]
fn the_smallest_files_run_as_they_stand() {
    let section = section("### Smallest files that run");
    let folder = tempfile::tempdir().unwrap();
    let files = blocks(&section, "toml");
    assert_eq!(
        files.iter().map(|file| file_name(file)).collect::<Vec<_>>(),
        ["robot.toml", "simulation.toml", "my-session.toml"]
    );
    for file in files {
        fs::write(folder.path().join(file_name(file)), file).unwrap();
    }
    let commands = blocks(&section, "sh");
    let lines: Vec<&str> = commands.iter().flat_map(|block| block.lines()).collect();
    assert_eq!(lines.len(), 3, "{lines:?}");
    for line in lines {
        let arguments = line.strip_prefix("gravcal ").unwrap().split(' ');
        let run = gravcal_in(folder.path(), arguments);
        assert_eq!(run.code, 0, "{line}: {run:?}");
    }
    assert!(folder.path().join("my-session-calibration/calibration.json").is_file());
}
