use crate::small::tiny;
use cosmic::Registry;
use cosmic::record::{RunPlan, optimise, resume};
use std::fs;

#[test]
fn a_refusal_leaves_no_lock() {
    let folder = tempfile::tempdir().unwrap();
    let resumed = resume(folder.path(), &Registry::default(), &mut ());
    assert_eq!(resumed.unwrap_err().exit_code(), 4);
    fs::write(folder.path().join("b"), "").unwrap();
    let begun = optimise(folder.path(), &RunPlan::new("tiny", tiny(), 0), &mut ());
    assert_eq!(begun.unwrap_err().exit_code(), 2);
    let files = fs::read_dir(folder.path()).unwrap();
    assert!(files.map(|file| file.unwrap().file_name()).eq(["b"]));
}
