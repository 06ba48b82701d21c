//! A file is written completely or not at all, and a JSON file of another format or version is refused.

use cosmic::Error;
use cosmic::format::Format;
use cosmic::record::files::{make_folder, read_json, sweep, write_atomic};
use serde::Deserialize;
use std::io::Write;
use std::path::Path;
use std::{env, fs, io, process, thread};

const FORMAT: Format = Format {
    name: "cosmic-test",
    version: 3,
};

#[derive(Debug, Deserialize)]
struct Body {
    #[expect(dead_code, reason = "only its name matters")]
    numbers: Vec<f64>,
}

/// The names of the files in a folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name());
    names.map(|name| name.into_string().unwrap()).collect()
}

#[test]
fn json_of_another_format_or_truncated_is_malformed() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("body.json");
    let refusal = |text: &str| {
        fs::write(&file, text).unwrap();
        match read_json::<Body>(&file, FORMAT) {
            Err(error @ Error::Malformed { .. }) => {
                assert_eq!(error.exit_code(), 2);
                error.to_string()
            }
            other => panic!("{text}: {other:?}"),
        }
    };
    for (text, says) in [
        (
            r#"{"format":"cosmic-design","version":3}"#,
            "\"cosmic-design\" version 3",
        ),
        (
            r#"{"format":"cosmic-test","version":4}"#,
            "version 4, not \"cosmic-test\"",
        ),
        (
            r#"{"format":"cosmic-test","version":3}"#,
            "missing field `numbers`",
        ),
        ("{\"format\":\"cosmic-test\",\n\"vers", "body.json:2:5"),
        ("", "the file is empty"),
    ] {
        let refused = refusal(text);
        assert!(refused.contains(says), "{refused}");
    }
    let missing = read_json::<Body>(&folder.path().join("none"), FORMAT);
    assert_eq!(missing.unwrap_err().exit_code(), 4);
}

#[test]
fn a_failed_write_keeps_the_old_file_and_leaves_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("state");
    write_atomic(&file, |out| out.write_all(b"old")).unwrap();
    let full = |out: &mut dyn Write| {
        out.write_all(b"half of the new")?;
        out.flush()?;
        Err(io::Error::from(io::ErrorKind::StorageFull))
    };
    assert_eq!(write_atomic(&file, full).unwrap_err().exit_code(), 4);
    assert_eq!(fs::read(&file).unwrap(), b"old");
    assert_eq!(names(folder.path()), ["state"]);
}

#[test]
fn a_folder_is_swept_while_another_process_checks_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    thread::scope(|scope| {
        let other = scope.spawn(|| (0..3000).try_for_each(|_| make_folder(path)));
        while !other.is_finished() {
            sweep(path).unwrap();
        }
        other.join().unwrap().unwrap();
    });
    assert!(names(path).is_empty());
}

#[cfg(unix)]
#[test]
fn links_and_devices_are_kept() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let [file, link] = ["file", "link"].map(|name| folder.path().join(name));
    fs::write(&file, "old").unwrap();
    std::os::unix::fs::symlink("file", &link).unwrap();
    write_atomic(&link, |out| out.write_all(b"new")).unwrap();
    assert!(link.is_symlink());
    assert_eq!(fs::read(&file).unwrap(), b"new");
    // Writing to a file keeps its permissions.
    let mode = || fs::metadata(&file).unwrap().permissions();
    fs::set_permissions(&file, PermissionsExt::from_mode(0o600)).unwrap();
    write_atomic(&file, |out| out.write_all(b"private")).unwrap();
    assert_eq!(mode().mode() & 0o777, 0o600);
    // Writing works through a link to a missing file.
    let [new, ahead] = ["new", "ahead"].map(|name| folder.path().join(name));
    std::os::unix::fs::symlink("new", &ahead).unwrap();
    write_atomic(&ahead, |out| out.write_all(b"first")).unwrap();
    assert!(ahead.is_symlink() && fs::read(&new).unwrap() == b"first");
    write_atomic(Path::new("/dev/null"), |out| out.write_all(b"nothing")).unwrap();
    assert!(!Path::new("/dev/null").is_file());
    assert_eq!(names(folder.path()).len(), 4);
}

/// The name of an environment variable. If it is set, this test is the victim: a process that the test has started and
/// kills in the middle of a write. The value is the folder in which the victim writes.
const VICTIM: &str = "COSMIC_TEST_VICTIM";

#[test]
fn a_process_killed_while_writing_leaves_the_old_file_whole() {
    if let Some(folder) = env::var_os(VICTIM) {
        let die = |out: &mut dyn Write| {
            out.write_all(b"half of the new")?;
            out.flush()?;
            process::abort()
        };
        return write_atomic(&Path::new(&folder).join("state"), die).unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("state");
    write_atomic(&file, |out| out.write_all(b"old")).unwrap();
    let this_test = [
        "--exact",
        "record_files::a_process_killed_while_writing_leaves_the_old_file_whole",
    ];
    let mut victim = process::Command::new(env::current_exe().unwrap());
    victim.args(this_test).env(VICTIM, folder.path());
    let output = victim.output().unwrap();
    assert!(!output.status.success());
    // The half-written file still exists: the process died during the write.
    assert_eq!(names(folder.path()).len(), 2);
    assert_eq!(fs::read(&file).unwrap(), b"old");
}

#[test]
fn an_unwritable_place_is_an_error_with_the_path() {
    let folder = tempfile::tempdir().unwrap();
    let blocker = folder.path().join("blocker");
    fs::write(&blocker, "").unwrap();
    for file in [
        blocker.join("file"),
        folder.path().join("missing").join("file"),
    ] {
        let error = write_atomic(&file, |_| Ok(())).unwrap_err();
        assert_eq!(error.exit_code(), 4);
        assert!(error.to_string().contains(&file.display().to_string()));
        assert!(!error.to_string().contains(".cosmic-"), "{error}");
    }
    // A folder in which nobody can create files.
    #[cfg(target_os = "linux")]
    {
        let error = make_folder(Path::new("/proc/self"))
            .unwrap_err()
            .to_string();
        let says = "cannot write /proc/self: No such file or directory (os error 2)";
        assert_eq!(error, says);
    }
}
