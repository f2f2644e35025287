//! `report.html` in a browser, where there is Chromium: nothing is asked of a network, nothing is complained of, every figure is drawn,
//! on narrow and wide windows, light and dark.

use std::fs;
use std::path::Path;
use std::process::Command;

use tempfile::TempDir;

use crate::program::{Calibration, gravcal_in};
use crate::small_session::small_session;
use crate::studies::Study;
use crate::tree;

/// Looks at the page from inside, and writes what it sees where a dump of the page shows it.
const PROBE: &str = r#"<script>
  const root = document.documentElement.dataset, canvases = [...document.querySelectorAll("canvas")];
  const colours = (canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height), seen = new Set();
    for (let i = 0; i < data.length; i += 4) seen.add((data[i] << 24) | (data[i + 1] << 16) | (data[i + 2] << 8) | data[i + 3]);
    return seen.size;
  };
  root.canvases = canvases.length;
  root.blank = canvases.filter((canvas) => colours(canvas) < 4).length;
  root.overflow = document.documentElement.scrollWidth - document.documentElement.clientWidth;
  root.requests = performance.getEntriesByType("resource").length;
  root.dark = matchMedia("(prefers-color-scheme: dark)").matches;
  root.background = getComputedStyle(document.body).backgroundColor;
</script>"#;

fn chromium() -> Option<&'static str> {
    let there = |name: &&str| Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success());
    let found = ["chromium", "chromium-browser", "google-chrome"].into_iter().find(there);
    if found.is_none() {
        eprintln!("skipped: there is no Chromium");
    }
    found
}

/// What the browser makes of a page, and of what it complained.
struct Seen {
    page: String,
    console: String,
}

fn open(browser: &str, page: &Path, width: u32, dark: bool) -> Seen {
    let folder = tempfile::tempdir().unwrap();
    let probed = folder.path().join("page.html");
    let text = fs::read_to_string(page).unwrap();
    fs::write(&probed, text.replace("</body>", &format!("{PROBE}</body>"))).unwrap();
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run"])
        .args(["--disable-component-update", "--disable-sync", "--host-resolver-rules=MAP * ~NOTFOUND"])
        .args(["--enable-logging=stderr", "--dump-dom", "--virtual-time-budget=10000"])
        .arg(format!("--window-size={width},900"))
        .arg(format!("--blink-settings=preferredColorScheme={}", u8::from(!dark)))
        .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
        .arg(format!("file://{}", probed.display()))
        .output()
        .unwrap();
    Seen {
        page: String::from_utf8(output.stdout).unwrap(),
        console: String::from_utf8_lossy(&output.stderr).lines().filter(|line| line.contains("CONSOLE")).collect(),
    }
}

impl Seen {
    fn reported(&self, name: &str) -> &str {
        let key = format!(" data-{name}=\"");
        self.page.split(&key).nth(1).and_then(|rest| rest.split('"').next()).unwrap_or("")
    }
}

fn assert_drawn(browser: &str, page: &Path, figures: usize) {
    for (width, dark) in [(400, false), (1600, true)] {
        let seen = open(browser, page, width, dark);
        assert_eq!(seen.console, "", "at {width}");
        assert_eq!(seen.reported("requests"), "0", "at {width}");
        assert_eq!(
            (seen.reported("canvases"), seen.reported("blank")),
            (figures.to_string().as_str(), "0"),
            "at {width}"
        );
        assert!(seen.reported("overflow").parse::<i32>().unwrap() <= 0, "{} px at {width}", seen.reported("overflow"));
        assert_eq!(seen.reported("dark"), dark.to_string());
        assert_eq!(seen.reported("background"), if dark { "rgb(20, 24, 28)" } else { "rgb(255, 255, 255)" });
    }
}

#[test]
fn the_page_of_the_paper_s_procedure_draws_every_figure() {
    let Some(browser) = chromium() else { return };
    let calibration = Calibration::of(&tree::root().join("experiments/sarcos-shoulder/session.toml"));
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("report.html");
    fs::write(&page, calibration.bytes("report.html")).unwrap();
    // The fit, three joints' residuals, quantiles and autocorrelations, the correlations.
    assert_drawn(browser, &page, 1 + 3 + 6 + 1);
}

/// The small session with another noise than it states.
fn contradicted() -> TempDir {
    let folder = small_session();
    let path = folder.path().join("session.toml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replace("std = 0.8", "std = 0.01")).unwrap();
    folder
}

#[test]
fn a_failed_calibration_has_a_page_that_says_so() {
    let folder = contradicted();
    let run = gravcal_in(folder.path(), ["calibrate", "--full", "session.toml", "--output", "results"]);
    assert_eq!(run.code, 4, "{run:?}");
    let page = folder.path().join("results/report.html");
    let text = fs::read_to_string(&page).unwrap();
    assert!(text.contains("Failed: there is no answer to rely on") && text.contains("Use no number of this result."));
    let Some(browser) = chromium() else { return };
    // No correlations of what has no value.
    assert_drawn(browser, &page, 1 + 3 + 6);
}

#[test]
fn a_study_has_a_page_with_its_figures_and_quiet_prints_no_tables() {
    let study = Study::new("trials = 4\nestimators = ['joint']\n");
    let run = study.run("results", &["--quiet"]);
    assert_eq!(run.code, 0, "{run:?}");
    assert_eq!(run.stdout.lines().count(), 2, "{}", run.stdout);
    let page = study.results("results").join("study.html");
    let text = fs::read_to_string(&page).unwrap();
    assert_eq!((text.matches("<figure").count(), text.matches("<svg").count()), (2, 2));
    assert!(text.contains("joint2.torque_gain") && !text.contains("<script"));
    let Some(browser) = chromium() else { return };
    assert_drawn(browser, &page, 0);
}

#[test]
fn colours_are_for_terminals_and_no_color_is_honoured() {
    let folder = small_session();
    let run = |variables: &[(&str, &str)]| {
        let output = Command::new(env!("CARGO_BIN_EXE_gravcal"))
            .args(["calibrate", "--full", "session.toml", "--output", "results", "--overwrite"])
            .current_dir(folder.path())
            .env_remove("NO_COLOR")
            .env_remove("CLICOLOR_FORCE")
            .envs(variables.iter().copied())
            .output()
            .unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    let escape = '\u{1b}';
    assert!(!run(&[]).contains(escape));
    assert!(run(&[("CLICOLOR_FORCE", "1")]).contains(escape));
    assert!(!run(&[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]).contains(escape));
    assert!(!fs::read_to_string(folder.path().join("results/table.txt")).unwrap().contains(escape));
}

#[test]
fn what_is_printed_follows_quiet_json_verbose_and_no_colour() {
    let folder = small_session();
    let run = |more: &[&str]| {
        let given = ["calibrate", "--full", "session.toml", "--output", "results", "--overwrite"];
        gravcal_in(folder.path(), [&given[..], more].concat())
    };
    let table = run(&[]);
    assert!(table.stdout.starts_with("Calibration of") && !table.stdout.contains('\u{1b}'), "{table:?}");
    let quiet = run(&["--quiet"]);
    assert!(quiet.stdout.starts_with("Results in results (report.html, table.txt, calibration.json"), "{quiet:?}");
    assert_eq!(quiet.code, table.code);
    let json = run(&["--json"]).stdout;
    assert_eq!(json.as_bytes(), fs::read(folder.path().join("results/calibration.json")).unwrap());
    let verbose = run(&["--verbose"]);
    assert!(verbose.stderr.contains("iteration 1, cost") && verbose.stdout == table.stdout, "{verbose:?}");
    assert!(table.stdout.lines().filter(|line| !line.starts_with("Results in")).all(|line| line.chars().count() <= 80));
}
