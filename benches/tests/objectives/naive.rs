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
