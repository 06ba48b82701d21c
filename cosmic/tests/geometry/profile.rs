use cosmic::geometry::{MOST_POINTS, Profile, Range, Vector};

fn of(points: &[[f64; 2]]) -> Result<Profile, String> {
    Profile::new(points.iter().copied().map(Vector::from).collect())
}

fn kerb() -> Profile {
    of(&[[1.0, 0.0], [1.5, 0.5], [2.0, 0.25]]).unwrap()
}

#[test]
fn terrain_is_straight_between_points_and_level_beyond() {
    let kerb = kerb();
    for (along, height) in [
        (-9.0, 0.0),
        (1.0, 0.0),
        (1.25, 0.25),
        (1.5, 0.5),
        (1.75, 0.375),
        (2.0, 0.25),
        (9.0, 0.25),
    ] {
        assert_eq!(kerb.height(along), height, "at {along}");
    }
    assert_eq!(Profile::default().height(3.0), 0.0);
    let line = kerb.between(Range::new(0.0, 1.75));
    assert_eq!(line, [[0.0, 0.0], [1.0, 0.0], [1.5, 0.5], [1.75, 0.375]]);
}

#[test]
fn points_must_be_finite_in_order_and_few() {
    for (points, says) in [
        (vec![[1.0, 0.1], [1.0, 0.1]], "same point twice"),
        (vec![[1.0, 0.1], [1.0, 0.2], [1.0, 0.1]], "turns back"),
        (vec![[0.0, 0.0], [-1.0, 0.1]], "must not overhang"),
        (vec![[0.0, f64::NAN]], "not finite"),
        (vec![[f64::INFINITY, 0.0]], "not finite"),
    ] {
        let error = of(&points).unwrap_err();
        assert!(error.contains(says), "{error}");
    }
    let many = |n: usize| Profile::new((0..n).map(|k| Vector::from([k as f64, 0.0])).collect());
    assert!(many(MOST_POINTS).is_ok() && many(MOST_POINTS + 1).is_err());
}

/// Two steps up and one down, with vertical walls. The first wall has a point between its ends.
fn stairs() -> Profile {
    let points = [
        [1.0, 0.0],
        [1.0, 0.25],
        [1.0, 0.5],
        [2.0, 0.5],
        [2.0, 0.75],
        [3.0, 0.75],
        [3.0, -0.5],
    ];
    of(&points).unwrap()
}

#[test]
fn walls_have_a_foot_and_an_edge() {
    let stairs = stairs();
    for (along, height) in [
        (0.5, 0.0),
        (1.0, 0.0),
        (1.5, 0.5),
        (2.0, 0.5),
        (2.5, 0.75),
        (3.0, -0.5),
        (9.0, -0.5),
    ] {
        assert_eq!(stairs.height(along), height, "at {along}");
    }
    // Behind a wall, the depth is the distance from the wall or from the ground above, whichever is smaller.
    for (point, above) in [
        ([1.0, 0.25], 0.25),
        ([1.0 + 1e-15, 0.25], -1.1102230246251565e-15),
        ([1.125, 0.25], -0.125),
        ([1.375, 0.25], -0.25),
        ([2.9375, -0.25], -0.0625),
        ([1.125, -0.25], -0.75),
    ] {
        assert_eq!(stairs.above(Vector::from(point)), above, "{point:?}");
    }
}
