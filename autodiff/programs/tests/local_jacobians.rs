//! The Jacobian of a small function at many points.

use autodiff::Real;
use autodiff_programs::{Kernel, data, kernel};

/// A kernel with two results of three inputs.
struct Couple;

#[kernel]
impl Kernel<3, 2> for Couple {
    fn eval<R: Real>(&self, [x, y, z]: [R; 3], _: &[R]) -> [R; 2] {
        [x * y * y + z, (x - z) * y / (R::one() + x * x)]
    }
}

impl Couple {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        Kernel::eval(self, [x[0], x[1], x[2]], &[]).to_vec()
    }
}

fn point(i: usize) -> [f64; 3] {
    let [x, y] = [0.618, 0.414].map(|step| (step * (i as f64 + 1.0)).fract() * 3.0 - 1.4);
    [x, y, x * y]
}

#[test]
fn local_jacobians_are_the_jacobians() {
    for count in [0, 1, 8, 13] {
        let points: Vec<[f64; 3]> = (0..count).map(point).collect();
        let mut values = Vec::new();
        data::values(&Couple, count, |i| points[i], |i, y| values.push((i, y)));
        assert!(values.iter().map(|(i, _)| *i).eq(0..count));
        let mut rows = 0;
        data::jacobians(
            &Couple,
            count,
            |i| points[i],
            |i, local| {
                assert_eq!(i, rows, "the points come in order");
                rows += 1;
                let expected = autodiff::jacobian(|x| Couple.eval(x), &points[i]);
                for result in 0..2 {
                    for (got, exact) in local.row(result).into_iter().zip(&expected[result]) {
                        // The two results come from the same few operations, some of them in a different order.
                        assert!(
                            (got - exact).abs() <= 1e-14 * exact.abs().max(1.0),
                            "{i}: {got} and {exact}"
                        );
                    }
                    assert_eq!(values[i].1[result], local.value(result));
                }
            },
        );
        assert_eq!(rows, count);
    }
}
