use cosmic_lab::export::stl::{Prism, binary};

/// Reads an STL file. Returns the normal and the three corners of each triangle.
fn read(bytes: &[u8]) -> Vec<[[f64; 3]; 4]> {
    let (head, triangles) = bytes.split_at(84);
    let count = u32::from_le_bytes(head[80..].try_into().unwrap());
    assert_eq!(triangles.len(), 50 * count as usize);
    let number = |word: &[u8]| f64::from(f32::from_le_bytes(word.try_into().unwrap()));
    let point = |bytes: &[u8]| [0, 4, 8].map(|at| number(&bytes[at..at + 4]));
    let triangle = |bytes: &[u8]| [0, 12, 24, 36].map(|at| point(&bytes[at..at + 12]));
    triangles.chunks(50).map(triangle).collect()
}

/// Tests a hexagonal prism that is shifted sideways and up.
#[test]
fn normals_are_of_unit_length_and_point_outwards() {
    let corner = |k: usize| {
        let (sin, cos) = (k as f64 * std::f64::consts::TAU / 6.0).sin_cos();
        [10.0 + 3.0 * cos, -20.0 + 3.0 * sin, 5.0]
    };
    let prism = Prism {
        base: (0..6).map(corner).collect(),
        along: [2.0, 1.0, 7.0],
    };
    let middle = [11.0, -19.5, 8.5];
    let triangles = read(&binary(&[prism]));
    assert_eq!(triangles.len(), 4 * 6 - 4);
    let (mut volume, mut vector_area) = (0.0, [0.0; 3]);
    for [n, a, b, c] in triangles {
        let dot = |x: [f64; 3]| (0..3).map(|k| n[k] * x[k]).sum::<f64>();
        // A unit vector in single precision has a few rounding errors of 6e-8 each.
        assert!((dot(n) - 1.0).abs() < 1e-6, "{n:?}");
        let minus = |x: [f64; 3], y: [f64; 3]| [0, 1, 2].map(|k| x[k] - y[k]);
        assert!(dot(minus(b, a)).abs() < 1e-5 && dot(minus(c, a)).abs() < 1e-5);
        // All corners of a convex solid lie behind each of its faces.
        assert!(dot(minus(middle, a)) < -1.0);
        let (u, v) = (minus(b, a), minus(c, a));
        let cross = [(1, 2), (2, 0), (0, 1)].map(|(k, l)| u[k] * v[l] - u[l] * v[k]);
        let area = 0.5 * dot(cross);
        assert!(area > 0.0);
        volume += area * dot(a) / 3.0;
        (0..3).for_each(|k| vector_area[k] += area * n[k]);
    }
    // Coordinates of up to 20 mm are rounded to 1e-6 mm, and faces have about 20 mm2, so the relative error of the
    // volume is small.
    let expected = 1.5 * 3.0_f64.sqrt() * 9.0 * 7.0;
    assert!(
        (volume / expected - 1.0).abs() < 1e-5,
        "{volume}, not {expected}"
    );
    assert!(
        vector_area.iter().all(|x| x.abs() < 1e-4),
        "{vector_area:?}"
    );
    // A triangle without an area has no normal.
    let flat = Prism {
        base: vec![[1.0; 3]; 3],
        along: [0.0; 3],
    };
    assert!(
        read(&binary(&[flat]))
            .iter()
            .all(|triangle| triangle[0] == [0.0; 3])
    );
}
