//! Every wrong scene is refused, and the error has the right line and column. The message says what is wrong, and the
//! report says what is allowed.

use cosmic::scene::Scene;
use cosmic::{Error, Registry, error};
use proptest::prelude::*;
use std::fs;

/// Parses a scene in which `^` marks the place of an error. Asserts that the error is at that place, and returns its
/// message and its report.
fn refusal(text: &str) -> (String, String) {
    let (before, after) = text.split_once('^').unwrap();
    match Scene::parse("my.toml", &[before, after].concat()) {
        Err(Error::Malformed {
            file,
            line,
            column,
            message,
            report,
            ..
        }) => {
            let last = before.rsplit('\n').next().unwrap();
            let place = (before.matches('\n').count() + 1, last.chars().count() + 1);
            assert_eq!((line, column), place, "{report}");
            assert_eq!(file, "my.toml");
            let place = format!("my.toml:{line}:{column}");
            assert!(report.contains(&place), "{report}");
            (message, report)
        }
        other => panic!("{text:?} gave {other:?}"),
    }
}

/// Each scene of `wrong_scenes.txt` is refused at the marked place, with the words that the file lists.
#[test]
fn wrong_scenes_are_refused_where_they_are_wrong() {
    let (head, scenes) = include_str!("wrong_scenes.txt").split_once("\n\n").unwrap();
    assert!(head.starts_with("# "));
    let mut count = 0;
    for scene in scenes.trim_end().split("\n\n") {
        let (words, text): (Vec<&str>, Vec<&str>) =
            scene.lines().partition(|line| line.starts_with("! "));
        let (message, report) = refusal(&text.join("\n"));
        for (k, words) in words.iter().map(|words| &words[2..]).enumerate() {
            let said = if k == 0 { &message } else { &report };
            assert!(said.contains(words), "{scene}\n{said}");
        }
        assert!(!words.is_empty() && report.contains('^'), "{report}");
        count += 1;
    }
    assert!(count > 50, "{count}");
}

#[test]
fn a_profile_has_64_points_at_most() {
    let points = |n: usize| (0..n).map(|k| [k as f64, 0.0]).collect::<Vec<_>>();
    let text = |n| format!("[ground]\nprofile = \"points\"\npoints = ^{:?}", points(n));
    let (message, _) = refusal(&text(65));
    assert!(message.contains("has 65 points"), "{message}");
    let scene = Scene::parse("most", &text(64).replace('^', "")).unwrap();
    assert_eq!(scene.physics.ground.resolved().points(), points(64));
}

#[test]
fn every_fault_is_reported_up_to_a_limit() {
    let (_, report) = refusal("[physics]\ndt = ^9.0\nsteps = \"x\"\n[lattice]\nrows = 0");
    assert_eq!(report.matches("error: ").count(), 3, "{report}");
    let flood: String = (0..30).map(|n| format!("key{n} = 1\n")).collect();
    let (_, report) = refusal(&format!("[physics]\n^{flood}"));
    assert!(report.ends_with("... and 20 more"), "{report}");
}

#[test]
fn unreadable_files_and_malformed_files_are_different_errors() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str| {
        Registry::default()
            .read(&folder.path().join(name))
            .unwrap_err()
    };
    let code = |name: &str| read(name).exit_code();
    assert_eq!(code("missing.toml"), 4);
    assert_eq!(code("."), 4);
    let latin = b"[physics]\n# \xe9t\xe9\n";
    fs::write(folder.path().join("latin1.toml"), latin).unwrap();
    assert_eq!(code("latin1.toml"), 2);
    match read("latin1.toml") {
        Error::Malformed {
            line: 2,
            column: 3,
            message,
            ..
        } => assert!(message.contains("0xe9")),
        other => panic!("{other:?}"),
    }
    fs::write(folder.path().join("huge.toml"), vec![b'#'; 2 << 20]).unwrap();
    assert_eq!(code("huge.toml"), 2);
    assert!(read("huge.toml").to_string().contains("1048576 bytes"));
}

/// Asserts that the reader either accepts a text as a scene, or refuses it with an error at a place inside the text.
fn survives(text: &str) -> error::Result<()> {
    match Scene::parse("any", text) {
        Err(Error::Malformed { line, column, .. }) => {
            assert!(line >= 1 && column >= 1 && line <= text.matches('\n').count() + 1);
            Ok(())
        }
        other => other.map(drop),
    }
}

/// A list nested so deeply that a recursive reader would overflow the stack.
const NESTED: &str = match str::from_utf8(&[b'['; 4000]) {
    Ok(text) => text,
    Err(_) => "",
};

proptest! {
    #[test]
    fn no_bytes_make_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("any.toml");
        fs::write(&file, &bytes).unwrap();
        let _ = Registry::default().read(&file);
        survives(&String::from_utf8_lossy(&bytes)).unwrap();
    }

    #[test]
    fn no_mutation_of_a_scene_makes_the_reader_panic(
        at in any::<prop::sample::Index>(),
        cut in 0..40usize,
        inserted in prop::sample::select(vec![
            "", "nan", "[", "]", "\"", "\"\"\"", "=", "\n", "\r", "\t", "\0",
            "é", "🤖", "{", "1e999", "-", "'",
            NESTED,
        ]),
    ) {
        let mut text = Scene::paper().to_toml();
        let from = at.index(text.len());
        let to = (from + cut).min(text.len());
        text.replace_range(from..to, inserted);
        survives(&text).unwrap();
    }
}
