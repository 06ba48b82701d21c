//! Answers against the objectives that are written again.

use std::path::PathBuf;

use autodiff::VectorFunction;
use benches::gradbench::compare::distance;
use benches::gradbench::inputs::{self, Draw};
use serde_json::{Value, json};

use crate::driver::answer;
use crate::naive::{
    Determinant, KMeans, Last, LeastSquares, LogSumExp, Ode, Square, columns, count, gradient,
    newton, numbers,
};
use crate::naive_scenes::{Hand, Language, Mixture, View};

/// How far an answer may be from the right one, in the relative 2-norm.
const TOLERANCE: f64 = 1e-7;

fn assert_close(what: &str, answer: &Value, right: &Value) {
    let distance = distance(answer, right);
    assert!(distance <= TOLERANCE, "{what} is off by {distance:e}");
}

/// Checks a function of a flat list and its gradient.
fn check(
    module: &str,
    functions: [&str; 2],
    input: &Value,
    right: &impl VectorFunction,
    x: &[f64],
) {
    let values = right.eval(x);
    let value = if values.len() == 1 {
        json!(values[0])
    } else {
        json!(values)
    };
    let what = format!("{module} {input:.60}");
    assert_close(&what, &answer(module, functions[0], input), &value);
    let right = json!(gradient(right, x));
    assert_close(&what, &answer(module, functions[1], input), &right);
}

const PRIMAL: [&str; 2] = ["primal", "gradient"];
const OBJECTIVE: [&str; 2] = ["objective", "jacobian"];

#[test]
fn hello() {
    for x in [1.0, 2.0, 8.0, -0.5] {
        assert_eq!(
            answer("hello", "square", &json!(x)),
            json!(Square.eval(&[x])[0])
        );
        assert_eq!(
            answer("hello", "double", &json!(x)),
            json!(gradient(&Square, &[x])[0])
        );
    }
    assert_eq!(answer("hello", "double", &json!(1)), json!(2.0));
}

#[test]
fn llsq() {
    for (n, m) in [(2, 1), (3, 2), (16, 128), (33, 7), (100, 20)] {
        let input = Draw::new(n as u64).llsq(n, m);
        check(
            "llsq",
            PRIMAL,
            &input,
            &LeastSquares(n),
            &numbers(&input["x"]),
        );
    }
}

#[test]
fn lse() {
    for n in [1, 2, 511, 512, 513, 1300] {
        let input = Draw::new(n as u64).lse(n);
        check("lse", PRIMAL, &input, &LogSumExp, &numbers(&input["x"]));
    }
    // Exponentials of the numbers themselves would not be finite.
    let input = json!({ "x": [1000.0, 1000.0, -1000.0] });
    let [value, slope] = PRIMAL.map(|function| answer("lse", function, &input));
    assert_close("lse", &value, &json!(1000.0 + 2_f64.ln()));
    assert_close("lse", &slope, &json!([0.5, 0.5, 0.0]));
}

#[test]
fn det() {
    for ell in 1..=7 {
        let input = Draw::new(ell as u64).det(ell);
        check(
            "det",
            PRIMAL,
            &input,
            &Determinant(ell),
            &numbers(&input["A"]),
        );
    }
}

/// Above the largest order that is one sum: the gradient of the determinant of a product of triangles, by
/// its inverse, which is the product of their inverses.
#[test]
fn det_of_a_large_matrix() {
    const ELL: usize = 10;
    // Ones on and below the diagonal, times ones on and above it: the entry is the smaller place, and the
    // determinant 1. The inverse has twos (at last a one) between minus ones.
    let entry = |i: usize, j: usize| 1.0 + i.min(j) as f64;
    let cofactor = |i: usize, j: usize| match i.abs_diff(j) {
        0 if i + 1 == ELL => 1.0,
        0 => 2.0,
        1 => -1.0,
        _ => 0.0,
    };
    let table = |of: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
        (0..ELL * ELL).map(|at| of(at / ELL, at % ELL)).collect()
    };
    let input = json!({ "A": table(&entry), "ell": ELL });
    assert_close("det 10", &answer("det", "primal", &input), &json!(1.0));
    let right = json!(table(&cofactor));
    assert_close("det 10", &answer("det", "gradient", &input), &right);
}

#[test]
fn ode() {
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
        assert_close(
            "ode",
            &answer("ode", "primal", &input),
            &json!(Ode(s).eval(&x)),
        );
        let right = json!(gradient(&Last(Ode(s)), &x));
        assert_close("ode", &answer("ode", "gradient", &input), &right);
    }
    let input = json!({ "x": [0.7218521074240813, 0.9664407992811007], "s": 1 });
    let right = json!([1.4437042148481627, 1.3952546553233522]);
    assert_close("ode", &answer("ode", "primal", &input), &right);
}

#[test]
fn kmeans() {
    for (k, n, d) in [(1, 1, 1), (2, 7, 3), (10, 50, 8), (9, 9, 2), (5, 100, 16)] {
        let input = Draw::new(k as u64).kmeans(k, n, d);
        let right = KMeans {
            points: numbers(&input["points"]),
            dimension: d,
        };
        let centroids = numbers(&input["centroids"]);
        let cost = json!(right.eval(&centroids)[0]);
        assert_close("kmeans", &answer("kmeans", "cost", &input), &cost);
        let direction = newton(&right, &centroids);
        let rows: Vec<&[f64]> = direction.chunks(d).collect();
        assert_close("kmeans", &answer("kmeans", "dir", &input), &json!(rows));
    }
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
        let value = json!(Mixture(&input).eval(&x)[0]);
        assert_close("gmm", &answer("gmm", "objective", &input), &value);
        let gradient = gradient(&Mixture(&input), &x);
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
fn lstm() {
    for (layers, characters) in [(1, 2), (2, 5), (3, 4)] {
        let input = Draw::new(layers as u64).lstm(layers, characters);
        let x = [
            numbers(&input["main_params"]),
            numbers(&input["extra_params"]),
        ]
        .concat();
        check("lstm", OBJECTIVE, &input, &Language(&input), &x);
    }
}

/// The project's own data of ADBench.
fn data(path: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../tests/data/adbench/data");
    folder.join(path)
}

#[test]
fn ba() {
    let input = inputs::ba(&data("ba/ba1_n49_m7776_p31843.txt")).expect("the file is there");
    // As published.
    let right = json!({
        "reproj_error": { "elements": [0.10133583791450886, -0.06896776592424401], "repeated": 31843 },
        "w_err": { "element": 0.826092651516, "repeated": 31843 },
    });
    assert_close("ba", &answer("ba", "objective", &input), &right);
    for sizes in [[49, 7776, 31843], [1, 1, 1], [2, 3, 7]] {
        let mut input = input.clone();
        for (name, size) in ["n", "m", "p"].into_iter().zip(sizes) {
            input[name] = json!(size);
        }
        assert_close(
            "ba",
            &answer("ba", "jacobian", &input),
            &jacobian_of_views(&input, sizes),
        );
    }
}

/// The beginning and the last number of the lists of a sparse Jacobian.
fn jacobian_of_views(input: &Value, [n, m, p]: [usize; 3]) -> Value {
    let x = ["cam", "x", "w"].map(|name| numbers(&input[name])).concat();
    let columns = columns(&View(numbers(&input["feat"])), &x);
    let (mut rows, mut cols, mut vals) = (vec![0], Vec::new(), Vec::new());
    for i in 0..p {
        for residual in 0..2 {
            for (input, column) in columns.iter().enumerate() {
                cols.push(match input {
                    0..11 => 11 * (i % n) + input,
                    11..14 => 11 * n + 3 * (i % m) + input - 11,
                    _ => 11 * n + 3 * m + i,
                });
                vals.push(column[residual]);
            }
            rows.push(vals.len());
        }
    }
    for i in 0..p {
        cols.push(11 * n + 3 * m + i);
        vals.push(columns[14][2]);
        rows.push(vals.len());
    }
    fn ends<T: Copy>(list: &[T]) -> Vec<T> {
        [&list[..30.min(list.len())], &list[list.len() - 1..]].concat()
    }
    json!({ "rows": ends(&rows), "cols": ends(&cols), "vals": ends(&vals) })
}

#[test]
fn ht() {
    for (name, complicated) in [("hand_test", false), ("hand_complicated_test", true)] {
        let path = data(&format!("hand/{name}.txt"));
        let input = inputs::ht(&path, &data("hand/model"), complicated);
        let mut input = input.expect("the files are there");
        for mirrored in [false, true] {
            input["data"]["model"]["is_mirrored"] = json!(mirrored);
            let x = [numbers(&input["theta"]), numbers(&input["us"])].concat();
            let right = json!(Hand(&input).eval(&x));
            assert_close(name, &answer("ht", "objective", &input), &right);
            let columns = columns(&Hand(&input), &x);
            let row = |row: usize| -> Vec<f64> {
                let (theta, us) = columns.split_at(26);
                let own = us.chunks(2).nth(row / 3).unwrap_or_default();
                own.iter().chain(theta).map(|column| column[row]).collect()
            };
            let rows: Vec<_> = (0..columns[0].len()).map(row).collect();
            assert_close(name, &answer("ht", "jacobian", &input), &json!(rows));
        }
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
    let x = numbers(&input["x"]);
    assert_eq!(count(&input["n"]), 33);
    let right = gradient(&LeastSquares(33), &x);
    let mut got = answer("llsq", "gradient", &input);
    assert!(distance(&got, &json!(right)) <= TOLERANCE);
    let spoiled: Vec<f64> = numbers(&got).iter().map(|g| g * (1.0 + 1e-6)).collect();
    assert!(distance(&json!(spoiled), &json!(right)) > TOLERANCE);
    got[3] = json!(0.0);
    assert!(distance(&got, &json!(right)) > TOLERANCE);
}
