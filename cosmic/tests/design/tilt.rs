use crate::small::lattice;
use cosmic::design::tilted;

#[test]
fn the_mean_surplus_of_void_is_the_tilt() {
    for seed in 0..20 {
        let tilted = tilted(&[0.3; 110], &lattice(6, 6, 0.0), 0.1, seed);
        // The lattice is symmetric, so the mean surplus is the tilt, up to 110 roundings below 1e-16.
        let mean = tilted.iter().sum::<f64>() / 110.0;
        assert!((mean - 0.4).abs() < 1e-14, "{mean}");
        // The largest surplus is 2 tilt for a direction along an axis, because the edges reach the sides of the
        // lattice. It is larger for directions towards a corner.
        let most = tilted.iter().copied().fold(0.0, f64::max);
        assert!((0.5..0.55).contains(&most), "{most}");
    }
}

#[test]
fn the_direction_depends_on_the_seed() {
    let of = |seed| tilted(&[1.0 / 3.0; 110], &lattice(6, 6, 0.0), 0.1, seed);
    assert_eq!(of(3), of(3));
    assert_ne!(of(3), of(4));
    assert_eq!(
        tilted(&[0.25; 110], &lattice(6, 6, 0.0), 0.0, 3),
        [0.25; 110]
    );
}
