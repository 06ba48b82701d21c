use cosmic::error::{Error, in_shell};
use std::io;
use std::path::Path;

#[test]
fn a_full_disk_or_quota_says_what_to_do() {
    let told = |kind: io::ErrorKind| Error::writing("run/a.json")(kind.into()).to_string();
    for kind in [io::ErrorKind::StorageFull, io::ErrorKind::QuotaExceeded] {
        let told = told(kind);
        assert!(told.starts_with("cannot write run/a.json: "), "{told}");
        assert!(
            told.ends_with("; free some space there, then resume the run or repeat the command")
        );
    }
    assert!(!told(io::ErrorKind::PermissionDenied).contains("space"));
}

#[test]
fn paths_are_one_word_of_a_command() {
    for (path, word) in [
        ("runs/a-1.2", "runs/a-1.2"),
        ("-run", "./-run"),
        ("my runs/a", "'my runs/a'"),
        ("it's", r"'it'\''s'"),
        ("", "''"),
    ] {
        assert_eq!(in_shell(Path::new(path)), word);
    }
}
