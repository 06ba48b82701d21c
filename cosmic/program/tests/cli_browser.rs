//! The pages of `cosmic report` and `cosmic check`, opened in a browser.

use crate::cli_report::{design_alone, finished, in_space, report};
use cosmic::geometry::Vector;
use cosmic_lab::report::eye::Eye;
use std::fs;
use std::io::{self, Write};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Finds a browser of the Chromium family; `None` if none is installed.
pub(crate) fn browser() -> Option<&'static str> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let runs = |name: &&str| Command::new(name).arg("--version").output().is_ok();
    names.into_iter().find(runs)
}

/// Options for the browser: it loads only the page and does not use a graphics card.
const OPTIONS: &str = "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run \
    --disable-background-networking --disable-sync --disable-component-update \
    --virtual-time-budget=5000 --dump-dom";

/// Opens a file in the browser. Returns the document after its scripts have run for five seconds of virtual time: on a busy
/// machine, one second has passed before the first frame is drawn.
pub(crate) fn document(browser: &str, file: &str) -> String {
    let profile = TempDir::new().unwrap();
    let page = profile.path().join("page.html");
    let mut child = Command::new(browser)
        .args(OPTIONS.split_whitespace())
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("file://{file}"))
        .stdout(fs::File::create(&page).unwrap())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let began = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if began.elapsed() > Duration::from_secs(120) {
            child.kill().unwrap();
            panic!("{browser} hangs");
        }
        thread::sleep(Duration::from_millis(20));
    }
    fs::read_to_string(page).unwrap()
}

#[test]
fn a_browser_draws_the_page_without_errors() {
    let Some(browser) = browser() else {
        // Written directly to standard error, because the test harness hides what passing tests print.
        writeln!(io::stderr(), "SKIPPED: no Chromium: no page is opened").unwrap();
        return;
    };
    let bench = finished();
    report(&bench).ok();
    let document = |name: &str| {
        let file = bench.path("run").join(name);
        document(browser, &file.display().to_string())
    };
    let space = in_space();
    fs::rename(space.path("run"), bench.path("run/space")).unwrap();
    bench.cosmic("report run/space").ok();
    bench
        .cosmic("report run run/space --out run/compare.html")
        .ok();
    design_alone(&bench, "run/alone");
    bench.cosmic("report run/alone").ok();
    bench.unfinished("run/early", 2);
    bench.cosmic("report run/early").ok();
    bench.cosmic("check run --steps 16 --accuracy --out run/check");
    let pages = [
        "report.html",
        "compare.html",
        "alone/report.html",
        "early/report.html",
        "space/report.html",
        "check/check.html",
    ];
    for name in pages {
        let page = document(name);
        // The page's script sets `ready` at its end. It sets `error` if anything is thrown.
        assert!(
            page.contains("data-ready=\"true\""),
            "{name}: the script did not end"
        );
        assert!(!page.contains("data-error"), "{name}: the script failed");
        // A design whose edges have no material yet is called undecided, and not a robot of void edges.
        let is_undecided = page.contains("20 edges, all undecided") && !page.contains("20 void");
        assert_eq!(is_undecided, name.starts_with("early"), "{name}");
        // A canvas that is not folded has the width that the script gave it. Folded ones are drawn when they are opened.
        let folded =
            ["volumes", "measures", "gradients", "ternary"].map(|id| format!("id=\"{id}\""));
        for canvas in page.split("<canvas").skip(1) {
            let (tag, _) = canvas.split_once('>').unwrap();
            let is_folded = folded.iter().any(|id| tag.contains(id));
            assert!(is_folded || tag.contains(" width=\""), "{name}: {tag}");
        }
    }
    let picture = document("robot.svg");
    // If the XML is malformed, the browser shows a `parsererror` instead.
    assert!(picture.contains("</svg>") && !picture.contains("parsererror"));
}

/// On paper everything is open, and words in drawings are as large as the text: no drawing is wider than the paper.
#[test]
fn paper_shows_what_is_folded() {
    let Some(browser) = browser() else {
        writeln!(io::stderr(), "SKIPPED: no Chromium: no page is opened").unwrap();
        return;
    };
    let bench = finished();
    report(&bench).ok();
    let page = bench.read("run/report.html");
    let prints =
        "<script>setTimeout(() => dispatchEvent(new Event(\"beforeprint\")), 1000)</script>";
    bench.write(
        "print.html",
        page.replace("</body>", &format!("{prints}</body>")),
    );
    let page = document(browser, &bench.path("print.html").display().to_string());
    assert!(
        page.contains("<details") && !page.contains("<details>"),
        "something is folded"
    );
    let mut count = 0;
    for canvas in page.split("<canvas").skip(1) {
        let (tag, _) = canvas.split_once('>').unwrap();
        let (_, width) = tag.split_once(" width=\"").expect(tag);
        let width: usize = width[..width.find('"').unwrap()].parse().unwrap();
        assert!(width <= 700, "{tag}");
        count += 1;
    }
    assert!(count > 10, "{count} drawings");
}

/// The pages and the pictures see a point at the same place.
#[test]
fn scripts_and_pictures_have_the_same_projection() {
    let Some(browser) = browser() else {
        writeln!(io::stderr(), "SKIPPED: no Chromium: no page is opened").unwrap();
        return;
    };
    let views = [
        Eye::SIDE,
        Eye::THREE_QUARTERS,
        Eye::FRONT,
        Eye::TOP,
        [123.0, 45.0],
    ];
    let points = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, -0.7, 1.9]];
    let folder = TempDir::new().unwrap();
    let page = folder.path().join("page.html");
    let script = include_str!("../../lab/src/report/page/painter.js");
    let seen = format!(
        "[SIDE, THREE_QUARTERS, ...{:?}].map(view => {points:?}.map(point => new Eye(view).see(...point)))",
        &views[2..]
    );
    let html = format!(
        "<body><script>{script}\ndocument.body.textContent = JSON.stringify({seen});</script>"
    );
    fs::write(&page, html).unwrap();
    let document = document(browser, &page.display().to_string());
    let json = &document[document.find("[[[").unwrap()..=document.rfind("]]]").unwrap() + 2];
    let seen: Vec<Vec<[f64; 3]>> = serde_json::from_str(json).unwrap();
    for (view, seen) in views.into_iter().zip(seen) {
        for (point, [right, up, away]) in points.into_iter().zip(seen) {
            let expected = Eye::new(view).see(Vector::new(point)).array();
            for (found, expected) in [right, away, up].into_iter().zip(expected) {
                // The browser and the program round sines differently.
                assert!((found - expected).abs() < 1e-14, "{view:?}: {point:?}");
            }
        }
    }
}
