//! A second, plain implementation of the objectives, with derivatives by finite differences.

use serde_json::Value;

/// Returns all numbers in a JSON value, in order.
pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(list) => list.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().expect("a number")],
    }
}

/// Returns the gradient by finite differences of fourth order.
pub(crate) fn gradient(f: impl Fn(&[f64]) -> f64, x: &[f64]) -> Vec<f64> {
    /// The step of the differences. Rounding errors are about 1e-16 / STEP; the truncation error is STEP^4.
    const STEP: f64 = 1e-3;
    let mut at = x.to_vec();
    let mut partial = |i: usize| {
        let mut moved = |steps: f64| {
            at[i] = x[i] + steps * STEP;
            let y = f(&at);
            at[i] = x[i];
            y
        };
        let (near, far) = (moved(1.0) - moved(-1.0), moved(2.0) - moved(-2.0));
        (8.0 * near - far) / (12.0 * STEP)
    };
    (0..x.len()).map(&mut partial).collect()
}

/// Returns the gradient divided by the diagonal of the Hessian. The function must be quadratic within a distance of
/// 0.1.
pub(crate) fn newton(f: impl Fn(&[f64]) -> f64, x: &[f64]) -> Vec<f64> {
    const STEP: f64 = 0.1;
    let quotient = |i: usize| {
        let moved = |steps: f64| {
            let mut at = x.to_vec();
            at[i] += steps * STEP;
            f(&at)
        };
        let [before, here, after] = [-1.0, 0.0, 1.0].map(moved);
        0.5 * (after - before) * STEP / (after - 2.0 * here + before)
    };
    (0..x.len()).map(quotient).collect()
}

/// Returns half the sum of the squared errors of a polynomial at `n` points.
pub(crate) fn least_squares(n: usize, x: &[f64]) -> f64 {
    let square = |i: usize| {
        let t = -1.0 + 2.0 * i as f64 / (n as f64 - 1.0);
        let sign = if t == 0.0 { 0.0 } else { t.signum() };
        let terms = x.iter().enumerate().map(|(j, x)| x * t.powi(j as i32));
        (sign - terms.sum::<f64>()).powi(2)
    };
    (0..n).map(square).sum::<f64>() / 2.0
}

/// Returns the determinant, by Gaussian elimination.
pub(crate) fn determinant(ell: usize, x: &[f64]) -> f64 {
    let mut rows: Vec<Vec<f64>> = x.chunks(ell).map(Vec::from).collect();
    let mut determinant = 1.0;
    for k in 0..ell {
        let larger = |&i: &usize, &j: &usize| rows[i][k].abs().total_cmp(&rows[j][k].abs());
        let pivot = (k..ell).max_by(larger).expect("a row is left");
        if pivot != k {
            rows.swap(pivot, k);
            determinant = -determinant;
        }
        determinant *= rows[k][k];
        for i in k + 1..ell {
            let factor = rows[i][k] / rows[k][k];
            for j in k..ell {
                rows[i][j] -= factor * rows[k][j];
            }
        }
    }
    determinant
}

/// Returns all entries of `y` after the given number of steps.
pub(crate) fn ode(steps: usize, x: &[f64]) -> Vec<f64> {
    let h = 2.0 / steps as f64;
    let slope = |y: &[f64]| -> Vec<f64> {
        let before = std::iter::once(&1.0).chain(y);
        x.iter().zip(before).map(|(x, before)| x * before).collect()
    };
    let along = |y: &[f64], slope: &[f64], part: f64| -> Vec<f64> {
        y.iter().zip(slope).map(|(y, k)| y + part * h * k).collect()
    };
    let mut y = vec![0.0; x.len()];
    for _ in 0..steps {
        let k1 = slope(&y);
        let k2 = slope(&along(&y, &k1, 0.5));
        let k3 = slope(&along(&y, &k2, 0.5));
        let k4 = slope(&along(&y, &k3, 1.0));
        for (slope, part) in [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)] {
            y = along(&y, &slope, part / 6.0);
        }
    }
    y
}

/// Returns the sum of the squared distances of points from their closest centroids.
pub(crate) fn kmeans(points: &[Vec<f64>], centroids: &[f64]) -> f64 {
    let least = |point: &Vec<f64>| {
        let centroids = centroids.chunks(point.len());
        let distances = centroids.map(|centroid| {
            let gaps = point.iter().zip(centroid).map(|(p, c)| p - c);
            gaps.map(|gap| gap * gap).sum::<f64>()
        });
        distances.fold(f64::INFINITY, f64::min)
    };
    points.iter().map(least).sum()
}

/// Returns the log-likelihood of the points of an input. `x` has `alpha`, then for each component `mu`, `q` and `l`.
pub(crate) fn mixture(input: &Value, x: &[f64]) -> f64 {
    let [d, k, m] = ["d", "k", "m"].map(|name| input[name].as_u64().expect("a count") as usize);
    let (points, gamma) = (numbers(&input["x"]), numbers(&input["gamma"])[0]);
    let (alpha, components) = x.split_at(k);
    let components: Vec<&[f64]> = components.chunks(2 * d + d * (d - 1) / 2).collect();
    let weights: f64 = alpha.iter().map(|alpha| alpha.exp()).sum();
    let density = |point: &[f64], alpha: f64, component: &[f64]| {
        let (mu, q, l) = (&component[..d], &component[d..2 * d], &component[2 * d..]);
        let mut exponent = alpha;
        for row in 0..d {
            let mut y = q[row].exp() * (point[row] - mu[row]);
            for column in 0..row {
                let above: usize = (0..column).map(|j| d - 1 - j).sum();
                y += l[above + row - column - 1] * (point[column] - mu[column]);
            }
            exponent += q[row] - 0.5 * y * y;
        }
        exponent.exp()
    };
    let likelihood = |point: &[f64]| {
        let densities = alpha.iter().zip(&components);
        let densities = densities.map(|(&alpha, component)| density(point, alpha, component));
        (densities.sum::<f64>() / weights).ln()
    };
    let nu = d + m + 1;
    let gammas: f64 = (1..=d)
        .map(|j| libm::lgamma(0.5 * (nu + 1 - j) as f64))
        .sum();
    let log_gamma = 0.25 * (d * (d - 1)) as f64 * std::f64::consts::PI.ln() + gammas;
    let scale = (nu * d) as f64 * (gamma.ln() - 0.5 * 2_f64.ln()) - log_gamma;
    let prior = |component: &&[f64]| {
        let (q, l) = component[d..].split_at(d);
        let squares = q
            .iter()
            .map(|q| q.exp().powi(2))
            .chain(l.iter().map(|l| l * l));
        m as f64 * q.iter().sum::<f64>() - 0.5 * gamma * gamma * squares.sum::<f64>()
    };
    let normaliser = points.len() as f64 * 0.5 * (2.0 * std::f64::consts::PI).ln();
    let total: f64 = points.chunks(d).map(likelihood).sum();
    total + k as f64 * scale - normaliser + components.iter().map(prior).sum::<f64>()
}

/// Returns the loss of a language model. `x` has `main_params` and then `extra_params`.
pub(crate) fn language(input: &Value, x: &[f64]) -> f64 {
    let [mut state, sequence]: [Vec<Vec<f64>>; 2] = ["state", "sequence"]
        .map(|name| serde_json::from_value(input[name].clone()).expect("rows"));
    let (bits, layers) = (sequence[0].len(), state.len() / 2);
    let (main, extra) = x.split_at(8 * bits * layers);
    let sigmoid = |z: f64| 1.0 / (1.0 + (-z).exp());
    let mut loss = 0.0;
    for pair in sequence.windows(2) {
        let mut v: Vec<f64> = pair[0].iter().zip(extra).map(|(x, a)| x * a).collect();
        for layer in 0..layers {
            let weights = &main[8 * bits * layer..];
            for j in 0..bits {
                let gate =
                    |k: usize, v: f64| v * weights[k * bits + j] + weights[(k + 4) * bits + j];
                let (hidden, cell) = (state[2 * layer][j], state[2 * layer + 1][j]);
                let change = sigmoid(gate(1, hidden)) * gate(3, hidden).tanh();
                let cell = cell * sigmoid(gate(0, v[j])) + change;
                state[2 * layer + 1][j] = cell;
                state[2 * layer][j] = sigmoid(gate(2, v[j])) * cell.tanh();
            }
            v.clone_from(&state[2 * layer]);
        }
        let y = |j: usize| v[j] * extra[bits + j] + extra[2 * bits + j];
        let normaliser = (2.0 + (0..bits).map(|j| y(j).exp()).sum::<f64>()).ln();
        loss += (0..bits)
            .map(|j| pair[1][j] * (y(j) - normaliser))
            .sum::<f64>();
    }
    -loss / ((sequence.len() - 1) * bits) as f64
}

/// Rotates `v` by the rotation vector `r`.
pub(crate) fn rotated(r: &[f64], v: [f64; 3]) -> [f64; 3] {
    let angle = r.iter().map(|x| x * x).sum::<f64>().sqrt();
    let cross = |i: usize| r[(i + 1) % 3] * v[(i + 2) % 3] - r[(i + 2) % 3] * v[(i + 1) % 3];
    let dot: f64 = r.iter().zip(v).map(|(r, v)| r * v).sum();
    // The limits of `sin(angle) / angle` and of `(1 - cos(angle)) / angle^2` at zero.
    let (across, along) = match angle {
        0.0 => (1.0, 0.5),
        _ => (
            angle.sin() / angle,
            2.0 * ((angle / 2.0).sin() / angle).powi(2),
        ),
    };
    [0, 1, 2].map(|i| v[i] * angle.cos() + across * cross(i) + along * dot * r[i])
}

/// Returns the residuals of an observation. `x` has the camera, the point and the weight.
pub(crate) fn observation(x: &[f64], feature: &[f64]) -> [f64; 3] {
    let (camera, weight) = (&x[..11], x[14]);
    let [p, q, depth] = rotated(&camera[..3], [3, 4, 5].map(|i| x[i + 8] - x[i]));
    let (p, q) = (p / depth, q / depth);
    let squared = p * p + q * q;
    let scale = camera[6] * (1.0 + camera[9] * squared + camera[10] * squared * squared);
    [
        weight * (scale * p + camera[7] - feature[0]),
        weight * (scale * q + camera[8] - feature[1]),
        1.0 - weight * weight,
    ]
}
