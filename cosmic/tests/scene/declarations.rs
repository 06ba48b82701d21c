//! Checks that the structs, the declarations and the texts of scenes agree.

use cosmic::scene::Scene;
use proptest::prelude::*;

/// The key of every setting as `section.key`, in the order in which a scene is written.
fn paths() -> Vec<String> {
    let settings = Scene::paper().settings().into_iter();
    settings.map(|setting| setting.key).collect()
}

#[test]
fn every_key_has_its_own_line_below_a_comment() {
    let text = Scene::paper().to_toml();
    let mut written = Vec::new();
    let (mut section, mut comment) = ("", "");
    for line in text.lines() {
        if let Some(name) = line.strip_prefix('[') {
            section = name.trim_end_matches(']');
            assert!(comment.len() > 10, "no comment above [{section}]");
        } else if let Some((key, _)) = line
            .split_once(" = ")
            .filter(|(key, _)| !key.starts_with('#') && *key != "base")
        {
            let (says, allowed) = comment.split_once(" Allowed: ").unwrap();
            assert!(
                says.len() > 10 && allowed.len() > 5,
                "no comment above {key}"
            );
            written.push(format!("{section}.{key}"));
        }
        comment = line;
    }
    assert_eq!(written, paths());
}

/// The paper's scene with the key `path` set to `value`, even if the value contradicts other settings. `None` if the
/// key does not allow the value.
fn with(path: &str, value: &str) -> Option<Scene> {
    let mut scene = Scene::paper();
    scene.field(path).unwrap().read_text(value).ok()?;
    Some(scene)
}

proptest! {
    #[test]
    fn numbers_read_back_to_the_same_bits(
        row in 0..paths().len(),
        x in prop_oneof![-1.0..1.0, 0.0..1e-6, 0.0..1e6],
    ) {
        let path = &paths()[row];
        let lists = [1, 2, 3].map(|entries| format!("{:?}", vec![x; entries]));
        let number = format!("{x:?}");
        let read = lists.iter().chain([&number]).find_map(|value| with(path, value));
        let Some(mut scene) = read else {
            // The key takes a name or a count, or `x` is out of its range.
            return Ok(());
        };
        let text = scene.field(path).unwrap().value.toml();
        let mut numbers = text.split(['[', ',', ']']).filter_map(|n| n.trim().parse::<f64>().ok());
        prop_assert!(numbers.all(|n| n.to_bits() == f64::to_bits(x)), "{}", text);
        prop_assume!(scene.check().is_ok());
        prop_assert_eq!(Scene::parse("scene", &scene.to_toml()).unwrap(), scene);
    }
}
