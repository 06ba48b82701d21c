use cosmic_lab::sweep::{RunState, iterations};
use std::fs;

#[test]
fn iterations_are_those_of_the_last_whole_row_or_of_the_summary() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let row = |k: usize| format!("{{\"format\":\"h\",\"iteration\":{k},\"x\":[1]}}\n");
    let rows: String = (1..3000).map(row).collect();
    assert_eq!(iterations(folder, RunState::Begun), 0);
    for (text, expected) in [
        (String::new(), 0),
        (row(1), 1),
        (row(1) + "{\"iterat", 1),
        (rows, 2999),
    ] {
        fs::write(folder.join("history.jsonl"), text).unwrap();
        assert_eq!(iterations(folder, RunState::Begun), expected);
    }
    fs::write(folder.join("summary.json"), "{\"iterations\":40,\"V\":0.5}").unwrap();
    assert_eq!(iterations(folder, RunState::Done), 40);
}
