//! README.md and the book in `docs`: what they tell to paste runs as it stands there, and their links lead somewhere.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::program::{gravcal, gravcal_in};
use crate::tree;

/// Where the files of the project stand on the web: how the book refers to what is not in it.
const REPOSITORY: [&str; 2] =
    ["https://github.com/gravcal/gravcal/blob/main/", "https://raw.githubusercontent.com/gravcal/gravcal/main/"];

fn read(path: &str) -> String {
    let path = tree::root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
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

/// The words of a line, however they are set apart.
fn words(line: &str) -> String {
    line.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Pastes the files of a text into a folder and runs its commands there; what each of them prints.
fn follow(text: &str, folder: &Path) -> Vec<String> {
    let files = blocks(text, "toml");
    let names: Vec<&str> = files.iter().map(|file| file_name(file)).collect();
    assert_eq!(names, ["robot.toml", "simulation.toml", "my-session.toml"]);
    for file in files {
        fs::write(folder.join(file_name(file)), file).unwrap();
    }
    let blocks = blocks(text, "sh");
    let lines: Vec<&str> = blocks.iter().flat_map(|block| block.lines()).collect();
    assert_eq!(lines.len(), 3, "{lines:?}");
    let printed = lines.into_iter().map(|line| run(line, folder)).collect();
    assert!(folder.join("my-session-calibration/calibration.json").is_file());
    printed
}

/// Runs a line of a text in a folder; what it prints.
fn run(line: &str, folder: &Path) -> String {
    let run = gravcal_in(folder, line.strip_prefix("gravcal ").unwrap().split(' '));
    assert_eq!(run.code, 0, "{line}: {run:?}");
    run.stdout
}

/// What stands under a heading of the second level.
fn section<'t>(text: &'t str, heading: &str) -> &'t str {
    let (_, below) = text.split_once(&format!("\n## {heading}\n")).unwrap();
    below.split("\n## ").next().unwrap()
}

/// Every line of a block is printed, however it is set apart.
fn assert_prints(printed: &str, reported: &str) {
    let printed: BTreeSet<String> = printed.lines().map(words).collect();
    let absent: Vec<&str> = reported.lines().filter(|line| !printed.contains(&words(line))).collect();
    assert!(absent.is_empty(), "gravcal does not print {absent:#?}, but {printed:#?}");
}

#[test]
fn the_example_of_the_readme_runs_and_prints_what_it_says() {
    let readme = read("README.md");
    let section = section(&readme, "A fault to find");
    let folder = tempfile::tempdir().unwrap();
    assert_prints(&follow(section, folder.path())[2], blocks(section, "text")[0]);
}

#[test]
fn the_tutorial_runs_and_prints_what_it_says() {
    let tutorial = read("docs/tutorial/index.md");
    let folder = tempfile::tempdir().unwrap();
    let printed = follow(&tutorial, folder.path());
    assert_prints(&printed[1], blocks(section(&tutorial, "3. Ask what the poses can tell"), "text")[0]);
    let calibrated = section(&tutorial, "4. Calibrate");
    assert_prints(&printed[2], blocks(calibrated, "text")[0]);
    assert!(printed[2].contains("tilt 17.565 deg") && calibrated.contains("17.565°"), "{}", printed[2]);
    columns_are_swapped(section(&tutorial, "5. Break something"), folder.path());
    a_recording_is_calibrated(section(&tutorial, "6. A recording in motion"), folder.path());
}

fn columns_are_swapped(section: &str, folder: &Path) {
    let [line, command, reported] = blocks(section, "text")[..] else { panic!("{section}") };
    let session = folder.join("my-session.toml");
    let right = fs::read_to_string(&session).unwrap();
    let wrong: Vec<&str> =
        right.lines().map(|old| if old.starts_with("torque = { columns") { line.trim_end() } else { old }).collect();
    assert_ne!(wrong.join("\n"), right.trim_end());
    fs::write(&session, wrong.join("\n")).unwrap();
    let run = gravcal_in(folder, command.trim_end().strip_prefix("gravcal ").unwrap().split(' '));
    assert_eq!(run.code, 4, "{run:?}");
    assert_prints(&run.stdout, reported);
}

fn a_recording_is_calibrated(section: &str, folder: &Path) {
    let [moves, record, hemisphere, load, calibrate, reported] = blocks(section, "text")[..] else {
        panic!("{section}")
    };
    let replaced = |file: &str, start: &str, lines: &str| {
        let text = fs::read_to_string(folder.join(file)).unwrap();
        assert_eq!(text.lines().filter(|line| line.starts_with(start)).count(), 1, "{text}");
        text.lines()
            .map(|line| if line.starts_with(start) { lines.trim_end() } else { line })
            .collect::<Vec<_>>()
            .join("\n")
    };
    fs::write(folder.join("simulation.toml"), replaced("simulation.toml", "random = ", moves)).unwrap();
    let found: Vec<String> = record.lines().map(|line| run(line, folder)).collect();
    assert!(found[1].contains("30 standstills found"), "{}", found[1]);
    let session = replaced("recorded-session.toml", "# hemisphere", hemisphere);
    fs::write(folder.join("recorded-session.toml"), format!("{session}\n{load}")).unwrap();
    let printed: Vec<String> = calibrate.lines().map(|line| run(line, folder)).collect();
    assert_prints(&printed[1], reported);
}

#[test]
fn an_answer_fits_on_a_screen() {
    let session = tree::experiment("seven-joints-tilted").join("session.toml");
    let results = tempfile::tempdir().unwrap();
    let calibrate = ["calibrate".as_ref(), session.as_os_str(), "--output".as_ref(), results.path().as_os_str()];
    for arguments in [&calibrate[..], &["check".as_ref(), session.as_os_str()]] {
        let run = gravcal(arguments);
        assert_eq!(run.code, 0, "{run:?}");
        assert!(run.stdout.lines().count() <= 25, "{}", run.stdout);
        let mut lines = run.stdout.lines().filter(|line| !line.starts_with("Results in "));
        assert!(lines.all(|line| line.chars().count() <= 80), "{}", run.stdout);
        assert_eq!((1..=7).filter(|i| run.stdout.contains(&format!("\njoint{i} "))).count(), 7, "{}", run.stdout);
    }
}

#[test]
fn who_reads_first_reads_little() {
    for (file, most) in [("README.md", 150), ("ARCHITECTURE.md", 120)] {
        let lines = read(file).lines().count();
        assert!(lines <= most, "{file} has {lines} lines, more than {most}");
    }
}

/// Every page of the book, by its path in the project.
fn pages() -> Vec<PathBuf> {
    let files = tree::files_below(&tree::root().join("docs"));
    files.into_iter().filter(|file| file.extension().is_some_and(|extension| extension == "md")).collect()
}

#[test]
fn every_page_of_the_book_is_in_its_summary() {
    let docs = tree::root().join("docs");
    let summary = docs.join("SUMMARY.md");
    let listed: BTreeSet<PathBuf> = links(&fs::read_to_string(&summary).unwrap()).map(|link| docs.join(link)).collect();
    let written: BTreeSet<PathBuf> = pages().into_iter().filter(|page| *page != summary).collect();
    assert_eq!(listed, written);
    // mdBook gives such a page another name, and leaves links to it as they were.
    assert!(written.iter().all(|page| tree::name(page) != "README.md"), "name it index.md");
}

/// What a text in Markdown links to, code left out.
fn links(text: &str) -> impl Iterator<Item = &str> {
    let outside = text.split("```").step_by(2);
    let inline = outside.flat_map(|part| part.split("](").skip(1).filter_map(|rest| rest.split(')').next()));
    let named = text.lines().filter(|line| line.starts_with('[')).filter_map(|line| line.split_once("]: "));
    inline.chain(named.map(|(_, target)| target))
}

/// The names by which the headings of a page can be linked to, as GitHub and mdBook form them.
fn anchors(page: &Path) -> BTreeSet<String> {
    let text = fs::read_to_string(page).unwrap();
    let outside: String = text.split("```").step_by(2).collect();
    let headings = outside.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim());
    headings.map(|heading| anchor(&heading.to_lowercase())).collect()
}

fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter(|letter| letter.is_alphanumeric() || matches!(letter, ' ' | '-' | '_'));
    kept.map(|letter| if letter == ' ' { '-' } else { letter }).collect()
}

/// Whether a link of a page leads somewhere; one into the web is taken on trust, unless it means this repository.
fn leads_somewhere(page: &Path, link: &str) -> bool {
    if let Some(path) = REPOSITORY.iter().find_map(|repository| link.strip_prefix(repository)) {
        return tree::root().join(path).is_file();
    }
    if link.starts_with("https://") {
        return true;
    }
    let (path, heading) = link.split_once('#').unwrap_or((link, ""));
    let target = if path.is_empty() { page.to_owned() } else { page.parent().unwrap().join(path) };
    target.is_file() && (heading.is_empty() || anchors(&target).contains(heading))
}

#[test]
fn links_lead_somewhere() {
    let files = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(|file| tree::root().join(file));
    let mut broken = Vec::new();
    for page in pages().into_iter().chain(files) {
        let text = fs::read_to_string(&page).unwrap();
        let lost = links(&text).filter(|link| !leads_somewhere(&page, link));
        broken.extend(lost.map(|link| format!("{}: {link}", page.display())));
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn pictures_of_the_book_are_those_of_the_experiments() {
    for picture in tree::entries(&tree::root().join("docs/pictures")) {
        let experiment = tree::root().join("experiments").join(picture.file_stem().unwrap());
        assert_eq!(
            fs::read(&picture).unwrap(),
            fs::read(experiment.join("figure.svg")).unwrap(),
            "{}",
            picture.display()
        );
    }
}

#[test]
fn the_guide_on_extending_sends_to_files_that_exist() {
    let guide = read("docs/how-to/extend.md");
    let rows: Vec<&str> = guide.lines().skip_while(|line| !line.starts_with("| to add |")).skip(2).collect();
    let rows: Vec<&str> = rows.into_iter().take_while(|line| line.starts_with('|')).collect();
    assert!(rows.iter().any(|row| row.starts_with("| solver |")), "{rows:?}");
    let paths = rows.iter().flat_map(|row| quoted(row)).filter(|word| word.contains('/') && !word.contains('<'));
    let absent: Vec<&str> = paths.filter(|path| !tree::root().join(path).exists()).collect();
    assert!(absent.is_empty(), "docs/how-to/extend.md sends to {absent:?}");
}

/// What stands between backquotes.
fn quoted(line: &str) -> impl Iterator<Item = &str> {
    line.split('`').skip(1).step_by(2)
}
