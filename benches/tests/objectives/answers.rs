//! Answers against the objectives that are written again.

use benches::distance::distance;
use benches::gradbench::draw::Draw;
use serde_json::{Value, json};

use crate::driver::{TOLERANCE, answer, assert_close};
use crate::naive::{determinant, gradient, kmeans, least_squares, mixture, newton, numbers, ode};

/// Checks a function of a flat list, and its gradient.
fn check(module: &str, input: &Value, right: impl Fn(&[f64]) -> f64, x: &[f64]) {
    assert_close(module, &answer(module, "primal", input), &json!(right(x)));
    let right = json!(gradient(right, x));
    assert_close(module, &answer(module, "gradient", input), &right);
}

#[test]
fn hello() {
    for x in [1.0, 2.0, 8.0, -0.5] {
        assert_eq!(answer("hello", "square", &json!(x)), json!(x * x));
        assert_eq!(answer("hello", "double", &json!(x)), json!(x + x));
    }
    assert_eq!(answer("hello", "double", &json!(1)), json!(2.0));
}

#[test]
fn llsq() {
    for (n, m) in [(2, 1), (3, 2), (16, 128), (33, 7), (100, 20)] {
        let input = Draw::new(n as u64).llsq(n, m);
        check(
            "llsq",
            &input,
            |x| least_squares(n, x),
            &numbers(&input["x"]),
        );
    }
}

#[test]
fn lse() {
    // Without taking the largest out: for small numbers.
    let plain = |x: &[f64]| x.iter().map(|x| x.exp()).sum::<f64>().ln();
    for n in [1, 2, 511, 512, 513, 1300] {
        let input = Draw::new(n as u64).lse(n);
        check("lse", &input, plain, &numbers(&input["x"]));
    }
    // Exponentials of the numbers themselves would not be finite.
    let input = json!({ "x": [1000.0, 1000.0, -1000.0] });
    let [value, slope] = ["primal", "gradient"].map(|function| answer("lse", function, &input));
    assert_close("lse", &value, &json!(1000.0 + 2_f64.ln()));
    assert_close("lse", &slope, &json!([0.5, 0.5, 0.0]));
}

/// Orders below, in and above those that are one sum.
#[test]
fn det() {
    for ell in 1..=10 {
        let input = Draw::new(ell as u64).det(ell);
        check(
            "det",
            &input,
            |x| determinant(ell, x),
            &numbers(&input["A"]),
        );
    }
}

#[test]
fn ode_of_chains() {
    // With 2 steps of 4 stages only the first 8 of 12 numbers are not zero.
    for (n, s) in [
        (1, 1),
        (4, 1),
        (4, 10),
        (4, 100),
        (12, 2),
        (40, 12),
        (100, 30),
    ] {
        let input = Draw::new(n as u64).ode(n, s);
        let x = numbers(&input["x"]);
        assert_close("ode", &answer("ode", "primal", &input), &json!(ode(s, &x)));
        let right = json!(gradient(|x| ode(s, x)[n - 1], &x));
        assert_close("ode", &answer("ode", "gradient", &input), &right);
    }
    let input = json!({ "x": [0.7218521074240813, 0.9664407992811007], "s": 1 });
    let right = json!([1.4437042148481627, 1.3952546553233522]);
    assert_close("ode", &answer("ode", "primal", &input), &right);
}

#[test]
fn kmeans_of_clusters() {
    for (k, n, d) in [(1, 5, 1), (2, 7, 3), (10, 50, 8), (5, 100, 16)] {
        let input = Draw::new(k as u64).kmeans(k, n, d);
        let rows = |name: &str| -> Vec<Vec<f64>> {
            input[name]
                .as_array()
                .expect("rows")
                .iter()
                .map(numbers)
                .collect()
        };
        let (mut points, mut centroids) = (rows("points"), rows("centroids"));
        // Far apart, so that differences do not change which centroid is the closest.
        for (i, point) in points.iter_mut().enumerate() {
            point[0] += 10.0 * (i % k) as f64;
        }
        for (i, centroid) in centroids.iter_mut().enumerate() {
            centroid[0] += 10.0 * ((n - k + i) % k) as f64;
        }
        let input = json!({ "points": points, "centroids": centroids });
        let (cost, x) = (|x: &[f64]| kmeans(&points, x), centroids.concat());
        assert_close(
            "kmeans",
            &answer("kmeans", "cost", &input),
            &json!(cost(&x)),
        );
        let direction = newton(cost, &x);
        let rows: Vec<&[f64]> = direction.chunks(d).collect();
        assert_close("kmeans", &answer("kmeans", "dir", &input), &json!(rows));
    }
    // Every centroid at a point.
    let input = Draw::new(9).kmeans(9, 9, 2);
    assert_close("kmeans", &answer("kmeans", "cost", &input), &json!(0.0));
    assert_close(
        "kmeans",
        &answer("kmeans", "dir", &input),
        &json!(vec![[0.0; 2]; 9]),
    );
}

#[test]
fn gmm() {
    for (d, k, n, m) in [(1, 1, 1, 0), (1, 3, 20, 0), (2, 5, 40, 0), (4, 3, 35, 2)] {
        let mut input = Draw::new(n as u64).gmm(d, k, n);
        input["m"] = json!(m);
        input["gamma"] = json!(1.0 + 0.5 * m as f64);
        let parts = |k: usize| {
            ["mu", "q", "l"]
                .map(|name| numbers(&input[name][k]))
                .concat()
        };
        let mut x = numbers(&input["alpha"]);
        x.extend((0..k).flat_map(parts));
        let value = json!(mixture(&input, &x));
        assert_close("gmm", &answer("gmm", "objective", &input), &value);
        let gradient = gradient(|x| mixture(&input, x), &x);
        let (alpha, parts) = gradient.split_at(k);
        let parts: Vec<&[f64]> = parts.chunks(2 * d + d * (d - 1) / 2).collect();
        let part = |from: usize, to: usize| -> Vec<&[f64]> {
            parts
                .iter()
                .map(|part| &part[from..to.min(part.len())])
                .collect()
        };
        let right = json!({
            "alpha": alpha, "mu": part(0, d), "q": part(d, 2 * d), "l": part(2 * d, usize::MAX),
        });
        assert_close("gmm", &answer("gmm", "jacobian", &input), &right);
    }
}

#[test]
fn particle_and_saddle() {
    for modes in ["rr", "ff", "fr", "rf"] {
        let place = answer("particle", modes, &json!({ "w": 0.0 }));
        assert_close("particle", &place, &json!(0.2071918746486116));
        let point = answer("saddle", modes, &json!({ "start": [1.0, 1.0] }));
        assert_close(
            "saddle",
            &point,
            &json!([8.246324826140356e-06_f64; 4].to_vec()),
        );
    }
}

#[test]
fn a_spoiled_answer_is_told_apart() {
    let input = Draw::new(1).llsq(33, 7);
    let right = gradient(|x| least_squares(33, x), &numbers(&input["x"]));
    let mut got = answer("llsq", "gradient", &input);
    assert!(distance(&got, &json!(right)) <= TOLERANCE);
    let spoiled: Vec<f64> = numbers(&got).iter().map(|g| g * (1.0 + 1e-6)).collect();
    assert!(distance(&json!(spoiled), &json!(right)) > TOLERANCE);
    got[3] = json!(0.0);
    assert!(distance(&got, &json!(right)) > TOLERANCE);
}
