//! The files in `studies` are sweeps.

use cosmic::Registry;
use cosmic::scene::Scene;
use cosmic_lab::sweep::{Overrides, Plan, read};

/// The files that need no policy of an example program.
const FILES: [&str; 7] = [
    "paper", "ablation", "findings", "transfer", "realism", "worlds", "space",
];

fn scenes(plan: &Plan) -> Vec<(&str, Scene)> {
    let scene = |trial: usize| {
        let run = plan.run(trial * plan.seeds.get(), &Registry::default());
        (&plan.trials[trial].name[..], run.unwrap().scene)
    };
    (0..plan.trials.len()).map(scene).collect()
}

/// All trials of a study differ. The trials `default-*` of the paper's study are built-in scenes.
#[test]
fn all_trials_differ_and_default_trials_are_built_in_scenes() {
    for name in FILES {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../studies/");
        let source = format!("{path}{name}.toml");
        let plan = read(&[source], &Overrides::default(), &Registry::default());
        let plan = plan.unwrap_or_else(|error| panic!("{name}: {error}"));
        let scenes = scenes(&plan);
        for (k, (name, scene)) in scenes.iter().enumerate() {
            assert!(
                !scenes[..k].iter().any(|(_, other)| other == scene),
                "{name}"
            );
            if let Some(builtin) = name.strip_prefix("default-") {
                assert_eq!(*scene, Scene::load(builtin).unwrap());
            }
        }
        assert_eq!(
            scenes.iter().any(|(name, _)| name.starts_with("default-")),
            name == "paper"
        );
    }
}
