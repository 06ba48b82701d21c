use cosmic::scene::{Scene, TomlFile};

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
    let changed = |path: &str| file.change(&Scene::paper(), path).unwrap();
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
        let changed = read.and_then(|()| file.change(&Scene::paper(), "trials[0].settings"));
        changed.unwrap_err().to_string()
    };
    for (from, to, says) in [
        (
            "seeds",
            "seds",
            [
                "unknown key `seds`",
                "a.toml:1:1",
                "expected `seeds` or `trials`",
            ],
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
    assert!(file.has("seeds") && !file.has("sead"));
}
