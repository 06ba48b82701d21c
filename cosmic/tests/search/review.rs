use cosmic::scene::{BUILTIN, Scene};
use cosmic::search::Review;

#[test]
fn built_in_scenes_have_neither_refusals_nor_warnings() {
    for builtin in BUILTIN {
        let scene = Scene::load(builtin.name).unwrap();
        assert_eq!(Review::new(&scene, 0).unwrap().refusals, []);
        assert_eq!(scene.warnings(), []);
    }
    // A lattice of that many nodes needs other numbers than the default scene.
    let large = ["lattice.columns=24", "lattice.rows=24"];
    let warnings = Scene::paper().set(&large).unwrap().warnings();
    assert!(warnings[0].says.contains("\"large\""), "{warnings:?}");
}

#[test]
fn an_unstable_step_that_the_scene_allows_is_a_warning() {
    let scene = Scene::paper().set(&["physics.dt=0.05", "physics.unstable_step=warn"]);
    let warned = Review::new(&scene.unwrap(), 0).unwrap();
    assert_eq!(warned.refusals, []);
    assert!(
        warned.warnings[0].says.contains("is unstable"),
        "{warned:?}"
    );
}

#[test]
fn probable_mistakes_give_warnings_with_their_values() {
    for (setting, warning) in [
        (
            "materials.stiffness=[1000, 400, 30]",
            "void is at least as stiff as skeleton (materials.stiffness = [1000.0, 400.0, 30.0])",
        ),
        ("materials.density=[1, 0.03, 0.1]", "void is heavier"),
        ("materials.max_strain=[0, 0, 0]", "actuators do not move"),
        ("volume.actuator=[0, 0]", "no edge may be an actuator"),
        (
            "physics.gravity=-4.8",
            "gravity points up (physics.gravity = -4.8)",
        ),
        ("physics.contact=none", "the robot falls forever"),
        (
            "ground.profile=rough",
            "the rough ground ends within eight lengths of the robot",
        ),
        ("lattice.drop=-0.1", "below the ground"),
        ("controller.omega=0", "the clock does not advance"),
        ("controller.omega=2000", "half a period"),
    ] {
        let warnings = Scene::paper().set(&[setting]).unwrap().warnings();
        assert!(
            warnings[0].to_string().contains(warning),
            "{setting}: {warnings:?}"
        );
    }
    // The robot is a row of six nodes and 0.5 m long. The rough ground starts at 0.6 m, and its length grows with
    // `count`.
    for (count, warns) in [(11, true), (13, false)] {
        let rough = [
            "ground.profile=rough".to_owned(),
            format!("ground.count={count}"),
        ];
        assert_eq!(
            !Scene::paper().set(&rough).unwrap().warnings().is_empty(),
            warns
        );
    }
    let ice = Scene::paper().set(&["physics.contact=coulomb", "physics.friction=0"]);
    assert_eq!(
        ice.unwrap().warnings()[0].settings[0].key,
        "physics.friction"
    );
}
