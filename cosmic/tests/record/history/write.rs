use crate::small::{records, tiny};
use cosmic::record::history::{DESIGNS, DesignRow, History, LINES, read};
use std::fs;

#[test]
fn lines_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = tiny();
    scene.schedule.iterations = 4;
    (scene.schedule.attraction_from, scene.schedule.snap_at) = (2, 3);
    let records = records(&scene);
    let mut history = History::open(folder.path(), 0, 0).unwrap();
    records
        .iter()
        .for_each(|record| history.append(record, 0.25).unwrap());
    assert_eq!(read(folder.path(), 4).unwrap(), records);
}

#[test]
fn designs_are_kept_after_the_first_and_every_tenth_iteration() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(DESIGNS);
    let mut history = History::open(folder.path(), 0, 0).unwrap();
    let z = |iteration: usize| [[1.0 / iteration as f64, 0.0, 1.0]];
    let kept: Vec<usize> = (1..=21).filter(|k| history.keeps_design(*k)).collect();
    for k in kept {
        let row = DesignRow::new(k, &z(k), None);
        history.append_design(&row).unwrap();
    }
    let text = fs::read_to_string(&file).unwrap();
    let row = |line| serde_json::from_str::<DesignRow>(line).unwrap();
    let rows: Vec<_> = text.lines().map(row).collect();
    let seen: Vec<_> = rows
        .iter()
        .map(|row| (row.iteration, row.z[0][0]))
        .collect();
    assert_eq!(seen, [(1, 1.0), (10, 0.1), (20, 0.05)]);
    drop(history);
    // A run is resumed after nine iterations, so every file is cut there. The other file must have lines.
    fs::write(folder.path().join(LINES), "{}\n".repeat(10)).unwrap();
    drop(History::open(folder.path(), 0, 9).unwrap());
    assert_eq!(fs::read_to_string(&file).unwrap().lines().count(), 1);
}
