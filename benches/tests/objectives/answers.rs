//! Compares the answers of the objectives with the answers of a second, plain implementation in `naive`.

use std::ops::Range;

use serde_json::{Value, json};

use crate::draw::Draw;
use crate::driver::{agrees, answer};
use crate::naive::{
    determinant, gradient, kmeans, language, least_squares, mixture, newton, numbers, observation,
    ode,
};

/// Checks the value and the gradient of a function whose argument is a flat list.
fn check(module: &str, input: &Value, right: impl Fn(&[f64]) -> f64, x: &[f64]) {
    agrees(module, "primal", input, &json!(right(x)));
    agrees(module, "gradient", input, &json!(gradient(right, x)));
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
        let input = Draw(n as u64).llsq(n, m);
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
    // This plain formula is accurate only for small numbers.
    let plain = |x: &[f64]| x.iter().map(|x| x.exp()).sum::<f64>().ln();
    for n in [1, 2, 511, 512, 513, 1300] {
        let input = json!({ "x": Draw(n as u64).uniforms(n) });
        check("lse", &input, plain, &numbers(&input["x"]));
    }
    // The exponentials of these numbers overflow.
    let input = json!({ "x": [1000.0, 1000.0, -1000.0] });
    agrees("lse", "primal", &input, &json!(1000.0 + 2_f64.ln()));
    agrees("lse", "gradient", &input, &json!([0.5, 0.5, 0.0]));
}

/// The tested orders are below, at and above the largest order for which the determinant is a single sum.
#[test]
fn det() {
    for ell in 1..=10 {
        let input = json!({ "A": Draw(1).uniforms(ell * ell), "ell": ell });
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
    // In the case of 2 steps, which have 4 stages each, only the first 8 of the 12 numbers differ from zero.
    for (n, s) in [(1, 1), (4, 1), (4, 100), (12, 2), (40, 12), (100, 30)] {
        let input = json!({ "x": Draw(1).uniforms(n), "s": s });
        let x = numbers(&input["x"]);
        agrees("ode", "primal", &input, &json!(ode(s, &x)));
        let right = json!(gradient(|x| ode(s, x)[n - 1], &x));
        agrees("ode", "gradient", &input, &right);
    }
    let input = json!({ "x": [0.7218521074240813, 0.9664407992811007], "s": 1 });
    let right = json!([1.4437042148481627, 1.3952546553233522]);
    agrees("ode", "primal", &input, &right);
}

#[test]
fn kmeans_of_clusters() {
    for (k, n, d) in [(1, 5, 1), (2, 7, 3), (10, 50, 8), (5, 100, 16)] {
        let input = Draw(k as u64).kmeans(k, n, d);
        let rows = |name: &str| serde_json::from_value(input[name].clone()).expect("rows");
        let [mut points, mut centroids]: [Vec<Vec<f64>>; 2] = ["points", "centroids"].map(rows);
        // The clusters are so far apart that finite differences do not change which centroid is closest.
        for (i, point) in points.iter_mut().enumerate() {
            point[0] += 10.0 * (i % k) as f64;
        }
        for (i, centroid) in centroids.iter_mut().enumerate() {
            centroid[0] += 10.0 * ((n - k + i) % k) as f64;
        }
        let input = json!({ "points": points, "centroids": centroids });
        let (cost, x) = (|x: &[f64]| kmeans(&points, x), centroids.concat());
        agrees("kmeans", "cost", &input, &json!(cost(&x)));
        let direction = newton(cost, &x);
        let rows: Vec<&[f64]> = direction.chunks(d).collect();
        agrees("kmeans", "dir", &input, &json!(rows));
    }
    // There is one centroid at each point.
    let input = Draw(9).kmeans(9, 9, 2);
    agrees("kmeans", "cost", &input, &json!(0.0));
    agrees("kmeans", "dir", &input, &json!(vec![[0.0; 2]; 9]));
}

#[test]
fn gmm() {
    for (d, k, n, m) in [(1, 1, 1, 0), (1, 3, 20, 0), (2, 5, 40, 0), (4, 3, 35, 2)] {
        let mut input = Draw(n as u64).gmm(d, k, n);
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
        agrees("gmm", "objective", &input, &value);
        let gradient = gradient(|x| mixture(&input, x), &x);
        let (alpha, parts) = gradient.split_at(k);
        let parts: Vec<&[f64]> = parts.chunks(2 * d + d * (d - 1) / 2).collect();
        let columns = |range: Range<usize>| -> Vec<&[f64]> {
            parts.iter().map(|part| &part[range.clone()]).collect()
        };
        let [mu, q, l] = [0..d, d..2 * d, 2 * d..parts[0].len()].map(columns);
        let right = json!({ "alpha": alpha, "mu": mu, "q": q, "l": l });
        agrees("gmm", "jacobian", &input, &right);
    }
}

#[test]
fn lstm() {
    for (layers, characters) in [(1, 2), (2, 5), (3, 3)] {
        let input = Draw(layers as u64).lstm(layers, characters);
        let x = ["main_params", "extra_params"].map(|name| numbers(&input[name]));
        let (loss, x) = (|x: &[f64]| language(&input, x), x.concat());
        agrees("lstm", "objective", &input, &json!(loss(&x)));
        agrees("lstm", "jacobian", &input, &json!(gradient(loss, &x)));
    }
}

/// The first 30 numbers of a list, and its last number.
fn ends<T: Copy>(list: &[T]) -> Vec<T> {
    let first = &list[..30.min(list.len())];
    [first, &list[list.len() - 1..]].concat()
}

/// The tested rotation vectors are one of ordinary length and the zero vector.
#[test]
fn ba() {
    for ([n, m, p], turn) in [([1, 1, 1], 0.4), ([2, 3, 6], 0.4), ([2, 3, 40], 0.0)] {
        let mut x = Draw(p as u64).uniforms(15);
        x[..3].iter_mut().for_each(|r| *r *= turn);
        x[13] += 3.0; // in front of the camera
        let feature = [0.3, 0.7];
        let input = json!({
            "n": n, "m": m, "p": p, "cam": x[..11], "x": x[11..14], "w": x[14], "feat": feature,
        });
        let [u, v, weight] = observation(&x, &feature);
        let right = json!({
            "reproj_error": { "elements": [u, v], "repeated": p },
            "w_err": { "element": weight, "repeated": p },
        });
        agrees("ba", "objective", &input, &right);
        let slopes = [0, 1, 2].map(|k| gradient(|x| observation(x, &feature)[k], &x));
        let vals = [&slopes[0][..], &slopes[1], &slopes[2][14..]].concat();
        let (points, weights) = (11 * n, 11 * n + 3 * m);
        let row = || (0..11).chain(points..points + 3).chain([weights]);
        let cols: Vec<usize> = row().chain(row()).chain([weights + p - 1]).collect();
        let rows: Vec<usize> = (0..=2 * p)
            .map(|i| 15 * i)
            .chain((1..=p).map(|i| 30 * p + i))
            .collect();
        let right = json!({ "rows": ends(&rows), "cols": cols, "vals": vals });
        agrees("ba", "jacobian", &input, &right);
    }
}

#[test]
fn particle_and_saddle() {
    for modes in ["rr", "ff", "fr", "rf"] {
        let start = json!({ "w": 0.0, "start": [1.0, 1.0] });
        agrees("particle", modes, &start, &json!(0.2071918746486116));
        let point = json!(vec![8.246324826140356e-06; 4]);
        agrees("saddle", modes, &start, &point);
    }
}
