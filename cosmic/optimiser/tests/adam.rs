use cosmic_optimiser::adam::{Adam, bound_norm};

/// The paper's mean as a sum (section 3): `m_t = (1 - beta) sum_i beta^(t - i) g_i`, divided by `1 - beta^t`.
fn corrected_mean(decay: f64, values: &[f64]) -> f64 {
    let last = values.len() as i32;
    let weighted: f64 = (values.iter().zip(1..))
        .map(|(value, i)| (1.0 - decay) * decay.powi(last - i) * value)
        .sum();
    weighted / (1.0 - decay.powi(last))
}

#[test]
fn steps_are_those_of_the_weighted_means() {
    let (adam, rate) = (Adam::default(), 0.1);
    let mut state = adam.init(1);
    let mut x = [2.0];
    let (mut slopes, mut squares) = (Vec::new(), Vec::new());
    for _ in 0..50 {
        let (before, slope) = (x[0], 3.0 * x[0]);
        slopes.push(slope);
        squares.push(slope * slope);
        adam.update(&mut state, &mut x, &[slope], rate).unwrap();
        let mean = corrected_mean(adam.betas[0], &slopes);
        let square = corrected_mean(adam.betas[1], &squares);
        let expected = before - rate * mean / (square.sqrt() + adam.epsilon);
        // The rounding error is 1e-16 * 50 * 1e3: fifty terms, some with opposite signs, are divided by
        // 1 - beta2 = 1e-3.
        assert!((x[0] - expected).abs() < 1e-11, "{} {expected}", x[0]);
    }
}

#[test]
fn bad_gradients_change_nothing() {
    let adam = Adam::default();
    let (mut state, mut x) = (adam.init(2), [1.0, 2.0]);
    let huge = [1.0, 1e155];
    for bad in [&[1.0, f64::NAN][..], &[f64::INFINITY, 0.0], &huge, &[1.0]] {
        assert!(adam.update(&mut state, &mut x, bad, 0.1).is_err());
    }
    assert_eq!((state, x), (adam.init(2), [1.0, 2.0]));
}

#[test]
fn norms_are_bounded() {
    let mut long = [3.0, 4.0];
    assert_eq!(bound_norm(&mut long, 2.5), 5.0);
    assert_eq!(long, [1.5, 2.0]);
    let mut short = [0.3, 0.4];
    bound_norm(&mut short, 1.0);
    assert_eq!(short, [0.3, 0.4]);
    // The square of this number would overflow. It is a power of two, so that nothing is rounded.
    let big = 2.0_f64.powi(700);
    assert_eq!(bound_norm(&mut [3.0 * big, 4.0 * big], 5.0), 5.0 * big);
    // Here the norm itself overflows.
    let mut largest = [f64::MAX; 4];
    assert_eq!(bound_norm(&mut largest, 5.0), f64::INFINITY);
    assert_eq!(largest, [2.5; 4]);
    assert_eq!(bound_norm(&mut [0.0, 0.0], 1.0), 0.0);
    for bad in [f64::NAN, f64::INFINITY] {
        let mut vector = [1.0, bad, 0.0];
        assert!(!bound_norm(&mut vector, 1.0).is_finite());
        assert_eq!(vector[0], 1.0);
    }
    assert!(bound_norm(&mut [0.0, f64::NAN], 1.0).is_nan());
}
