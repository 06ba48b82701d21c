//! Hand tracking, compared with a plain implementation for hands of random bones.

use serde_json::{Value, json};

use crate::draw::Draw;
use crate::driver::agrees;
use crate::naive::{gradient, numbers, rotated};

const BONES: usize = 22;
const VERTICES: usize = 5;

/// A homogeneous matrix, row by row.
type Matrix = [[f64; 4]; 4];

fn after(a: &Matrix, b: &Matrix) -> Matrix {
    let entry = |i: usize, j: usize| (0..4).map(|k| a[i][k] * b[k][j]).sum();
    [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| entry(i, j)))
}

/// The rotation by `angle` about a coordinate axis.
fn turn(axis: usize, angle: f64) -> Matrix {
    let mut turn = [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| f64::from(u8::from(i == j))));
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    (turn[next][next], turn[next][last]) = (angle.cos(), -angle.sin());
    (turn[last][next], turn[last][last]) = (angle.sin(), angle.cos());
    turn
}

/// The bone that a bone hangs on: the wrist for the first bone of a finger and for the forearm.
fn parent(bone: usize) -> i64 {
    match bone {
        0 => -1,
        _ if bone % 4 == 1 => 0,
        _ => bone as i64 - 1,
    }
}

fn draw(seed: u64, complicated: bool, mirrored: bool) -> Value {
    let mut draw = Draw(seed);
    let mut matrices = || -> Vec<Vec<Vec<f64>>> {
        let mut matrix = || [draw.rows(3, 4), vec![vec![0.0, 0.0, 0.0, 1.0]]].concat();
        (0..BONES).map(|_| matrix()).collect()
    };
    let (relatives, inverses) = (matrices(), matrices());
    let mut positions = draw.rows(VERTICES, 4);
    positions.iter_mut().for_each(|position| position[3] = 1.0);
    json!({
        "theta": draw.uniforms(26),
        "data": {
            "model": {
                "parents": (0..BONES).map(parent).collect::<Vec<_>>(),
                "base_relatives": relatives, "inverse_base_absolutes": inverses,
                "base_positions": positions, "weights": draw.rows(VERTICES, BONES),
                "triangles": [[0, 1, 2], [4, 1, 3]], "is_mirrored": mirrored,
            },
            "correspondences": [1, 0, 1], "points": draw.rows(3, 3),
        },
        "us": draw.rows(if complicated { 3 } else { 0 }, 2),
    })
}

fn matrices(value: &Value) -> Vec<Matrix> {
    serde_json::from_value(value.clone()).expect("a list of matrices")
}

/// The positions of the vertices.
fn skin(model: &Value, theta: &[f64]) -> Vec<[f64; 3]> {
    let [relatives, inverses] =
        ["base_relatives", "inverse_base_absolutes"].map(|name| matrices(&model[name]));
    let mut absolute: Vec<Matrix> = Vec::new();
    for (bone, relative) in relatives.iter().enumerate() {
        let mut relative = *relative;
        if (1..21).contains(&bone) && bone % 4 != 1 {
            let angles = &theta[6 + 4 * ((bone - 1) / 4)..][..4];
            let (x, z) = match bone % 4 {
                2 => (angles[0], angles[1]),
                3 => (angles[2], 0.0),
                _ => (angles[3], 0.0),
            };
            relative = after(&relative, &after(&turn(2, z), &turn(0, x)));
        }
        let above = usize::try_from(parent(bone)).map(|parent| absolute[parent]);
        absolute.push(above.map_or(relative, |above| after(&above, &relative)));
    }
    let moved: Vec<Matrix> = absolute
        .iter()
        .zip(&inverses)
        .map(|(a, b)| after(a, b))
        .collect();
    let (positions, weights) = (
        numbers(&model["base_positions"]),
        numbers(&model["weights"]),
    );
    let vertex = |position: &[f64], weights: &[f64]| {
        let coordinate = |i: usize| -> f64 {
            let along = |bone: &Matrix| (0..4).map(|k| bone[i][k] * position[k]).sum::<f64>();
            moved
                .iter()
                .zip(weights)
                .map(|(bone, weight)| weight * along(bone))
                .sum()
        };
        let mut place = [0, 1, 2].map(coordinate);
        if model["is_mirrored"] == true {
            place[0] = -place[0];
        }
        let turned = rotated(&theta[..3], place);
        [0, 1, 2].map(|i| turned[i] + theta[3 + i])
    };
    let vertices = positions.chunks(4).zip(weights.chunks(BONES));
    vertices
        .map(|(position, weights)| vertex(position, weights))
        .collect()
}

/// The residuals of a correspondence. `x` has the position on the triangle, if the problem is complicated, and `theta`.
fn residuals(input: &Value, correspondence: usize, x: &[f64]) -> [f64; 3] {
    let (u, theta) = x.split_at(x.len() - 26);
    let (data, model) = (&input["data"], &input["data"]["model"]);
    let (skin, point) = (skin(model, theta), numbers(&data["points"][correspondence]));
    let index = numbers(&data["correspondences"])[correspondence] as usize;
    let triangle = numbers(&model["triangles"][index]);
    let on_skin = |i: usize| match *u {
        [u, v] => {
            let [a, b, c] = [0, 1, 2].map(|k| skin[triangle[k] as usize][i]);
            u * a + v * b + (1.0 - u - v) * c
        }
        _ => skin[index][i],
    };
    [0, 1, 2].map(|i| point[i] - on_skin(i))
}

#[test]
fn ht() {
    for (seed, complicated, mirrored) in [(1, false, false), (2, true, false), (3, true, true)] {
        let input = draw(seed, complicated, mirrored);
        let (mut values, mut rows) = (Vec::new(), Vec::new());
        for k in 0..3 {
            let u = if complicated {
                numbers(&input["us"][k])
            } else {
                Vec::new()
            };
            let x = [u, numbers(&input["theta"])].concat();
            values.extend(residuals(&input, k, &x));
            rows.extend([0, 1, 2].map(|i| gradient(|x| residuals(&input, k, x)[i], &x)));
        }
        agrees("ht", "objective", &input, &json!(values));
        agrees("ht", "jacobian", &input, &json!(rows));
    }
}
