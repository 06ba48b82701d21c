use cosmic::design::Material;
use cosmic::geometry::Segment;
use cosmic_lab::export::member::Member;

/// A bar of skeleton between two points, in mm.
pub(super) fn sample(edge: usize, nodes: [usize; 2], [from, to]: [[f64; 2]; 2]) -> Member {
    let axis = Segment::new(from.into(), to.into());
    Member {
        edge,
        nodes,
        material: Material::Skeleton,
        length: axis.length() / 1e3,
        axis,
    }
}

#[test]
fn bars_that_cross_have_the_distance_0_and_others_the_distance_of_their_nearest_points() {
    let bar = |ends| sample(0, [0, 1], ends);
    let level = bar([[0.0, 0.0], [10.0, 0.0]]);
    for (ends, distance) in [
        ([[5.0, -5.0], [5.0, 5.0]], 0.0),
        ([[10.0, 0.0], [20.0, 3.0]], 0.0),
        ([[4.0, 0.0], [6.0, 0.0]], 0.0),
        ([[5.0, 2.0], [5.0, 9.0]], 2.0),
        ([[13.0, 4.0], [20.0, 4.0]], 5.0),
        ([[-3.0, 7.0], [30.0, 7.0]], 7.0),
    ] {
        let other = bar(ends);
        assert_eq!(level.distance(&other), distance, "{ends:?}");
        assert_eq!(other.distance(&level), distance, "{ends:?}");
    }
}
