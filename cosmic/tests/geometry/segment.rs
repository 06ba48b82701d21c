use cosmic::geometry::{Dimension, Segment, crossings};
use cosmic::random::{Purpose, stream, symmetric};

/// The result of [`crossings`] for segments that do not share nodes.
fn swept(segments: &[Segment]) -> Vec<[usize; 2]> {
    let edges: Vec<[usize; 2]> = (0..segments.len()).map(|k| [2 * k, 2 * k + 1]).collect();
    let ends = segments
        .iter()
        .flat_map(|segment| [segment.from, segment.to]);
    crossings(Dimension::Plane, &ends.collect::<Vec<_>>(), &edges)
}

fn of_all_pairs(segments: &[Segment]) -> Vec<[usize; 2]> {
    let later = |i: usize| (i + 1..segments.len()).map(move |j| [i, j]);
    let pairs = (0..segments.len()).flat_map(later);
    pairs
        .filter(|[i, j]| segments[*i].crosses(&segments[*j]))
        .collect()
}

#[test]
fn a_sweep_finds_the_crossings_of_all_pairs() {
    let mut random = stream(5, Purpose::Verification);
    let mut found = 0;
    for case in 0..60 {
        // The cases have wide, high and square fields, and short and long segments. In half of them the ends are
        // on a grid, so that segments meet, overlap and are parallel to the axes.
        let size = [[15.0, 1.0], [1.0, 15.0], [4.0, 4.0]][case % 3];
        let reach = [1.0, 3.0, 30.0][case / 3 % 3];
        let on_grid = case % 2 == 0;
        let segments: Vec<Segment> = (0..150)
            .map(|_| {
                let mut number = |limit: f64| {
                    let x = symmetric(&mut random, limit);
                    if on_grid { x.round() } else { x }
                };
                let from = Dimension::Plane.map(size.into(), &mut number);
                let to = Dimension::Plane.map(from, |x| x + number(reach));
                Segment::new(from, to)
            })
            .collect();
        let expected = of_all_pairs(&segments);
        assert_eq!(swept(&segments), expected, "case {case}");
        found += expected.len();
    }
    assert!(found > 1000, "{found} crossings");
    assert!(swept(&[]).is_empty());
}

#[test]
fn a_segment_with_a_nan_crosses_nothing() {
    let of = |[from, to]: [[f64; 2]; 2]| Segment::new(from.into(), to.into());
    let [up, down] = [[[0.0, 0.0], [1.0, 1.0]], [[0.0, 1.0], [1.0, 0.0]]].map(of);
    let lost = of([[f64::NAN, 0.0], [1.0, 1.0]]);
    let nowhere = of([[f64::NAN; 2]; 2]);
    assert_eq!(swept(&[lost, up, nowhere, down]), [[1, 3]]);
}
