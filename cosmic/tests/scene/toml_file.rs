use cosmic::scene::{Scene, TomlFile};
use std::collections::BTreeMap;

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Keys {
    #[allow(dead_code)]
    seeds: usize,
    #[allow(dead_code)]
    trials: Vec<serde::de::IgnoredAny>,
}

const TEXT: &str = "seeds = 2\n[[trials]]\nsettings.physics.gravity = 3.0\n[[trials]]\n";

#[test]
fn settings_within_a_file_change_a_scene() {
    let file = TomlFile::parse("a.toml", TEXT).unwrap();
    assert_eq!(file.read::<Keys>().unwrap().seeds, 2);
    let changed = |path: &str| {
        file.change(&Scene::paper(), path, &BTreeMap::new())
            .unwrap()
    };
    assert_eq!(changed("trials[0].settings").physics.gravity, 3.0);
    assert_eq!(changed("trials[1].settings"), Scene::paper());
}

#[test]
fn errors_name_the_line_the_value_and_what_is_allowed() {
    let refusal = |from: &str, to: &str| {
        let text = TEXT.replace(from, to);
        let file = match TomlFile::parse("a.toml", &text) {
            Ok(file) => file,
            Err(error) => return error.to_string(),
        };
        let read = file.read::<Keys>().map(drop);
        let changed = read
            .and_then(|()| file.change(&Scene::paper(), "trials[0].settings", &BTreeMap::new()));
        changed.unwrap_err().to_string()
    };
    for (from, to, says) in [
        (
            "seeds",
            "seds",
            ["unknown key `seds`", "a.toml:1:1", "did you mean `seeds`?"],
        ),
        (
            "= 2",
            "= 'x'",
            [
                "invalid type: string \"x\"",
                "a.toml:1:9",
                "expected a whole number",
            ],
        ),
        (
            "gravity",
            "gravty",
            [
                "unknown key `gravty`",
                "a.toml:3:18",
                "did you mean `gravity`?",
            ],
        ),
        (
            "3.0",
            "1e9",
            [
                "`physics.gravity` is out of range: 1e9",
                "a.toml:3:28",
                "allowed: ",
            ],
        ),
        ("seeds = 2", "", ["missing key `seeds`", "a.toml:", ""]),
        (
            "= 3.0",
            "= 3,0",
            [
                "`3,0` is not a number",
                "a.toml:3:28",
                "a decimal point: 3.0",
            ],
        ),
    ] {
        let refusal = refusal(from, to);
        for part in says {
            assert!(refusal.contains(part), "{part}: {refusal}");
        }
    }
    let file = TomlFile::parse("a.toml", TEXT).unwrap();
    let names = ["stabilty".to_owned()];
    let known = ["stability", "uniform"].map(str::to_owned);
    let error = file.check_names("seeds", &names, &known).unwrap_err();
    assert!(
        error.to_string().contains("did you mean `stability`?"),
        "{error}"
    );
    let error = file.check_names("seeds", &names, &[]).unwrap_err();
    assert!(error.to_string().contains("none is defined"), "{error}");
}

#[test]
fn the_file_of_a_sweep_is_told_from_a_scene() {
    for (text, is_of_sweep) in [
        (TEXT, true),
        ("[[trial]]\nscene = 'earth'", true),
        ("trials = []", true),
        ("[physics]\nfriction = 1", false),
        ("iterations = 3\nbase = 'earth'", false),
        ("base = []", false),
        ("[[physics]]\nfriction = 1", false),
        ("", false),
    ] {
        let file = TomlFile::parse("my sweep.toml", text).unwrap();
        assert_eq!(file.is_of_sweep(), is_of_sweep, "{text}");
        if is_of_sweep {
            let error = Scene::parse("my sweep.toml", text).unwrap_err().to_string();
            let remedy = "run it with: cosmic sweep run 'my sweep.toml' --out DIR";
            assert!(
                error.contains(remedy) && error.contains("my sweep.toml:"),
                "{error}"
            );
        }
    }
}

/// Each combination of a grid takes one entry of each list. An error points at that entry in the file.
#[test]
fn a_grid_changes_a_scene_and_its_errors_have_their_place() {
    let text =
        "[grid]\nphysics = { gravity = [1.0, -3e9], dt = [1e-3, 2e-3] }\nloss.window = [16, 'x']\n";
    let file = TomlFile::parse("a.toml", text).unwrap();
    let chosen = |gravity: usize, window: usize| {
        let chosen = [
            ("physics.gravity", gravity),
            ("physics.dt", 1),
            ("loss.window", window),
        ];
        let chosen = chosen.map(|(key, index)| (key.to_owned(), index));
        file.change(&Scene::paper(), "grid", &chosen.into())
    };
    let scene = chosen(0, 0).unwrap();
    assert_eq!((scene.physics.gravity, scene.physics.dt), (1.0, 2e-3));
    assert_eq!(scene.loss.window, 16);
    for (gravity, window, places) in [
        (
            1,
            0,
            ["`physics.gravity` is out of range: -3e9", "a.toml:2:29"],
        ),
        (0, 1, ["`loss.window` is a string: 'x'", "a.toml:3:20"]),
    ] {
        let error = chosen(gravity, window).unwrap_err().to_string();
        assert!(places.iter().all(|place| error.contains(place)), "{error}");
    }
}
