use cosmic::lattice::State;
use cosmic::record::history::Frames;

#[test]
fn a_walk_has_the_positions_of_its_states_to_half_a_unit() {
    let state = |k: usize| {
        let x = [[0.1 * k as f64, -0.0333], [0.2, (k * k) as f64]];
        State::new(x, [[0.0; 2]; 2])
    };
    let states: Vec<_> = (0..4).map(state).collect();
    let walk = Frames::of(states.iter(), 0.084, 5e-4).unwrap();
    assert_eq!((walk.every, walk.counts[3][0]), (0.084, 200));
    for (state, places) in states.iter().zip(walk.places()) {
        let mut pairs = state
            .x
            .iter()
            .flat_map(|x| x.array())
            .zip(places.iter().flat_map(|x| x.array()));
        assert!(pairs.all(|(a, b)| (a - b).abs() <= 0.5001 * walk.unit));
    }
    let mut lost = states;
    lost[2].x[1] = lost[2].x[1].with_forward(f64::NAN);
    assert_eq!(Frames::of(lost.iter(), 0.084, 5e-4), None);
}
