//! `cosmic gradcheck` as a user meets it.

use std::fs;

use crate::program::cosmic_in;

const SMALL: &str = "[lattice]\ncolumns = 3\nrows = 2\n[controller]\nhidden = 4\n";

#[test]
fn a_table_with_a_row_a_group_and_a_negative_control() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("small.toml"), SMALL).unwrap();
    let told = cosmic_in(folder.path(), &["gradcheck", "small.toml", "--steps", "64"]);
    assert_eq!(told.code, 0, "{}{}", told.out, told.error);
    let lines: Vec<_> = told.out.lines().collect();
    assert!(
        lines[0].starts_with("gradient of small.toml over 64 steps"),
        "{}",
        lines[0]
    );
    let row = |line: &str| {
        let words: Vec<_> = line.split_whitespace().collect();
        (words[0].to_owned(), words[words.len() - 1].to_owned())
    };
    let rows: Vec<_> = lines[2..9].iter().map(|line| row(line)).collect();
    let groups = ["z", "w1", "b1", "w2", "b2", "x0", "v0"];
    for ((name, verdict), expected) in rows.iter().zip(groups) {
        assert_eq!(name, expected);
        // The robot stands on the ground at the start.
        assert_eq!(verdict, if name == "x0" { "kink" } else { "smooth" });
    }
    assert!(lines[9].starts_with("x0: nodes rest on the ground"));
    let control = "negative control: the gradient by z, made wrong by 1 %, is called wrong";
    assert_eq!(lines[10..], [control]);
}

/// Actuators without stroke: the robot stands where it is, whatever its design and controller.
#[test]
fn groups_that_the_loss_does_not_depend_on_are_named() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("small.toml"), SMALL).unwrap();
    let still = "materials.max_strain=[0, 0, 0]";
    let arguments = ["gradcheck", "small.toml", "--steps", "64"];
    let told = cosmic_in(folder.path(), &[&arguments[..], &["--set", still]].concat());
    assert_eq!(told.code, 0, "{}{}", told.out, told.error);
    let zero = |line: &&str| line.ends_with("  both zero");
    let zero: Vec<_> = told.out.lines().filter(zero).collect();
    let names: Vec<_> = zero.iter().map(|line| &line[..2]).collect();
    assert_eq!(names, ["z ", "w1", "b1", "w2", "b2", "v0"], "{}", told.out);
    assert!(
        told.out
            .contains("z, w1, b1, w2, b2, v0: the gradient is zero, and so are the differences"),
        "{}",
        told.out
    );
    let told = cosmic_in(folder.path(), &arguments);
    assert!(!told.out.contains("zero"), "{}", told.out);
}

/// Of a scene's own task, as every one is optimised.
#[test]
fn the_gradient_of_every_task_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let tables = ["far", "reach", "climb", "back", "economy"].map(|task| {
        let scene = format!("{SMALL}[objective]\ntask = \"{task}\"\n");
        fs::write(folder.path().join("small.toml"), scene).unwrap();
        let told = cosmic_in(folder.path(), &["gradcheck", "small.toml", "--steps", "64"]);
        assert_eq!(told.code, 0, "{task}: {}{}", told.out, told.error);
        assert!(told.out.contains("of its scene's loss"), "{}", told.out);
        told.out
    });
    for (k, table) in tables.iter().enumerate() {
        assert!(!tables[..k].contains(table), "{table}");
    }
}

#[test]
fn bad_input_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let say = |arguments: &[&str]| {
        let told = cosmic_in(folder.path(), &[&["gradcheck"], arguments].concat());
        assert_eq!(told.out, "");
        (told.code, told.error)
    };
    let (code, error) = say(&["stabilty"]);
    assert!(
        code == 4 && error.contains("did you mean `stability`?"),
        "{error}"
    );
    let (code, error) = say(&["missing.json"]);
    assert!(
        code == 4 && error.contains("cannot read missing.json"),
        "{error}"
    );
    fs::write(folder.path().join("wrong.toml"), "[physics]\ndt = nan\n").unwrap();
    let (code, error) = say(&["wrong.toml"]);
    assert!(code == 2 && error.contains("wrong.toml:2:6"), "{error}");
    fs::write(
        folder.path().join("half.json"),
        "{\"format\":\"cosmic-design\",",
    )
    .unwrap();
    let (code, error) = say(&["half.json"]);
    assert!(code == 2 && error.contains("half.json:1:"), "{error}");
    let (code, error) = say(&["stability", "--directions", "0"]);
    assert!(code == 2 && error.contains("--directions"), "{error}");
}

#[test]
fn a_divergence_is_not_called_a_wrong_gradient() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("wild.toml"), "[physics]\ndt = 0.2\n").unwrap();
    let told = cosmic_in(folder.path(), &["gradcheck", "wild.toml"]);
    assert_eq!((told.code, told.out.as_str()), (3, ""));
    assert!(
        told.error.starts_with("error: diverged in step "),
        "{}",
        told.error
    );
}
