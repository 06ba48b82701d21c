use cosmic::scene::Scene;

#[test]
fn departures_are_the_keys_that_differ_from_the_paper_s_scene() {
    assert_eq!(Scene::paper().departures(), []);
    // A key that states the value of `stability` is not a departure.
    let text = "base = 'stability'\nphysics = {forces = ['stops'], dt = 0.002, gravity = 9.81}\nloss.kind = 'final'";
    let departures = Scene::parse("own", text).unwrap().departures();
    let shown: Vec<String> = departures
        .iter()
        .map(|d| {
            let there = d.there.as_deref().unwrap_or("none");
            format!("{} = {} here, {there} there", d.key, d.here)
        })
        .collect();
    let expected = [
        "physics.gravity = 9.81 here, 4.8 there",
        "physics.forces = [\"stops\"] here, [] there",
        "loss.kind = \"final\" here, \"mean\" there",
        "stops.at = 0.35 here, none there",
        "stops.stiffness = 400.0 here, none there",
    ];
    assert_eq!(shown, expected);
}

/// What knows only some keys of the physics learns which others the scene sets.
#[test]
fn physics_beyond_what_is_known_is_found() {
    let text = "base = 'stability'\nphysics = {dt = 0.001, gravity = 9.81}\nloss.kind = 'final'";
    let scene = Scene::parse("own", text).unwrap();
    let beyond = scene.physics_beyond(&["dt", "friction"]);
    let [gravity] = &beyond[..] else {
        panic!("{beyond:?}")
    };
    assert_eq!(
        (&gravity.key[..], &gravity.here[..], gravity.unit),
        ("physics.gravity", "9.81", "m/s2")
    );
    assert_eq!(scene.physics_beyond(&["gravity", "dt"]), []);
}
