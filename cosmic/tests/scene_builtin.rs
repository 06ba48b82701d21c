//! The built-in scenes are the files of the folder `scenes/`.

use cosmic::scene::{BUILTIN, Scene};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The text of every file in the folder `scenes/`, by the name of the file without its extension.
fn files() -> BTreeMap<String, String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let stem = |path: &Path| path.file_stem().unwrap().to_string_lossy().into_owned();
    let paths = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.is_file());
    paths
        .map(|path| (stem(&path), fs::read_to_string(&path).unwrap()))
        .collect()
}

#[test]
fn every_scene_of_the_folder_is_built_in_and_reads_back() {
    let files = files();
    assert_eq!(files.len(), BUILTIN.len());
    for (name, text) in files {
        let scene = Scene::load(&name).unwrap();
        assert_eq!(Scene::parse(&name, &text).unwrap(), scene);
        assert_eq!(Scene::parse(&name, &scene.to_toml()).unwrap(), scene);
    }
    assert!(BUILTIN.iter().all(|builtin| builtin.about().len() > 10));
}

/// Built-in scenes still have the settings that they had before scene files could name a base. The file
/// `resolved_scenes.txt` has those settings: all settings of `stability`, and for each other scene the settings that
/// differ. Since then only `earth` has changed (its gain, its clock, its selection and its schedule).
#[test]
fn no_built_in_scene_has_changed() {
    let mut scenes = include_str!("resolved_scenes.txt").split("\n[");
    let lines = |text: &str| -> BTreeMap<String, String> {
        let pairs = text.lines().filter_map(|line| line.split_once(" = "));
        pairs
            .map(|(key, value)| (key.to_owned(), value.to_owned()))
            .collect()
    };
    let paper = lines(scenes.next().unwrap());
    assert!(paper.len() > 60);
    let check = |name: &str, expected: &BTreeMap<String, String>| {
        let settings = Scene::load(name).unwrap().settings().into_iter();
        let found: BTreeMap<_, _> = settings.map(|s| (s.key, s.value)).collect();
        for (key, value) in expected {
            assert_eq!(found.get(key), Some(value), "{name}: {key}");
        }
    };
    check("stability", &paper);
    let mut checked = 1;
    for scene in scenes {
        let (name, changes) = scene.split_once(']').unwrap();
        let mut expected = paper.clone();
        expected.extend(lines(changes));
        check(name, &expected);
        checked += 1;
    }
    assert_eq!(checked, BUILTIN.len());
    assert_eq!(Scene::load("stability").unwrap(), Scene::paper());
}
