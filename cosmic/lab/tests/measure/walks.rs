use cosmic_lab::measure::Walks;

#[test]
fn a_failed_walk_counts_as_the_lowest_in_the_median() {
    let walks = Walks {
        mujoco: String::new(),
        frictions: vec![5.0, 1.0],
        walks: vec![
            vec![Some(1.0), Some(3.0), None, Some(2.0), Some(2.0)],
            vec![None],
        ],
        own: vec![Some(1.6), None],
    };
    assert_eq!([0, 1, 2].map(|k| walks.there(k)), [Some(2.0), None, None]);
    assert_eq!([0, 1, 2].map(|k| walks.own(k)), [Some(1.6), None, None]);
}
