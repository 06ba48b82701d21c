//! Tests that all commands that show a displacement mark unreliable robots.

use crate::common::Bench;
use crate::program::has;
use serde_json::Value;

/// Every command that shows a displacement also shows whether the summary calls the robot unreliable.
#[test]
fn an_unreliable_robot_is_marked_and_shown_without_percentages() {
    let bench = Bench::finished();
    let text = bench.read("a/summary.json");
    let mut summary: Value = serde_json::from_str(&text).unwrap();
    let verdict = summary["reliability"]["verdict"].as_str().unwrap();
    assert!(["reliable", "unreliable"].contains(&verdict), "{summary}");
    let mut shown = |verdict: &str, clock: f64| {
        let object = summary.as_object_mut().unwrap();
        let found = serde_json::json!({ "verdict": verdict, "reason": "it falls < 3 times" });
        object.insert("reliability".to_owned(), found);
        for key in ["displacement_robust_p50", "displacement_p50"] {
            object.insert(key.to_owned(), 2.0.into());
        }
        object.insert("displacement_clock_p50".to_owned(), clock.into());
        bench.write("a/summary.json", summary.to_string());
        let told = bench.ok("resume a").out;
        bench.ok("report a");
        let table = bench.ok("report a a").out;
        (told, bench.read("a/report.html"), table)
    };
    let (told, page, table) = shown("unreliable", 1.0);
    has(&told, &["\nunreliable: it falls < 3 times\n"]);
    let last = told.lines().last().unwrap();
    has(last, &["), unreliable, V "]);
    assert!(!told.contains("keeps") && !page.contains("50 %"), "{told}");
    for words in ["Unreliable robot:", "it falls &lt; 3 times"] {
        has(&page, &[words]);
    }
    has(&table, &["unreliable"]);
    let (told, page, table) = shown("reliable", 1.0);
    has(
        &told,
        &["1.000 m, 50 % of 2.000 m with feedback from the same starts"],
    );
    assert!(page.contains("<b>50 %</b>"));
    for text in [&told, &table] {
        assert!(!text.contains("unreliable"), "{text}");
    }
    assert!(!page.contains("median: unreliable") && !page.contains("Unreliable robot"));
    // This robot walks backwards without feedback, so no percentage of its displacement is shown.
    let (told, page, _) = shown("reliable", -2.74);
    has(&told, &["open loop, without feedback: -2.740 m\n"]);
    assert!(!page.contains("137 %"));
}
