use cosmic::geometry::Vector;

/// Vectors of two components give the same results as vectors of three components with a zero in the middle.
#[test]
fn planar_vectors_agree_with_spatial_vectors() {
    let planar = Vector::new([0.3, -0.4]);
    let space = Vector::new([0.3, 0.0, -0.4]);
    assert_eq!(planar.norm(), space.norm());
    assert_eq!(
        planar.distance(Vector::zero()),
        space.distance(Vector::zero())
    );
    assert_eq!(planar.softened_norm(1e-12), space.softened_norm(1e-12));
    assert_eq!(Vector::upright(0.3, -0.4), space);
    assert_eq!(
        [planar.up(), planar.forward()],
        [space.up(), space.forward()]
    );
    for by in [0.1, 0.3, 0.5] {
        let [planar, space] = [
            planar.along().shortened(by).forward(),
            space.along().shortened(by).forward(),
        ];
        // The tolerance covers the rounding of a division and a product of numbers below 1.
        assert!((planar - space).abs() < 1e-16);
    }
    assert_eq!(Vector::<f64, 3>::zero().shortened(0.1), Vector::zero());
}

#[test]
fn vectors_turn_to_the_left() {
    let vector = Vector::from([0.6, 0.8]);
    assert_eq!(vector.turned_left(), [-0.8, 0.6]);
    assert_eq!(vector.cross(vector.turned_left()), 1.0);
}
