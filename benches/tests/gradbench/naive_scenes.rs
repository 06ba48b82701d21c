//! ADBench's four objectives once more, number by number.

use autodiff::{Real, VectorFunction};
use serde_json::Value;

use crate::naive::{count, numbers};

/// Of `alpha`, then per component `mu`, `q` and `l`.
pub(crate) struct Mixture<'a>(pub(crate) &'a Value);

/// The logarithm of the gamma function at half of a whole number.
fn log_gamma_of_half(twice: usize) -> f64 {
    match twice {
        1 => 0.5 * std::f64::consts::PI.ln(),
        2 => 0.0,
        _ => (0.5 * twice as f64 - 1.0).ln() + log_gamma_of_half(twice - 2),
    }
}

impl VectorFunction for Mixture<'_> {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let [d, k] = ["d", "k"].map(|name| count(&self.0[name]));
        let (m, gamma) = (count(&self.0["m"]), numbers(&self.0["gamma"])[0]);
        let points = numbers(&self.0["x"]);
        let (alpha, components) = x.split_at(k);
        let components: Vec<&[R]> = components.chunks(2 * d + d * (d - 1) / 2).collect();
        let (mut total, mut weights) = (R::zero(), R::zero());
        for &alpha in alpha {
            weights += alpha.exp();
        }
        for point in points.chunks(d) {
            let mut likelihood = R::zero();
            for (&alpha, component) in alpha.iter().zip(&components) {
                let (mu, q, l) = (&component[..d], &component[d..2 * d], &component[2 * d..]);
                let mut exponent = alpha;
                for row in 0..d {
                    exponent += q[row];
                    let gap = |i: usize| R::lit(point[i]) - mu[i];
                    let mut y = q[row].exp() * gap(row);
                    for column in 0..row {
                        let above: usize = (0..column).map(|j| d - 1 - j).sum();
                        y += l[above + row - column - 1] * gap(column);
                    }
                    exponent -= R::lit(0.5) * y * y;
                }
                likelihood += exponent.exp();
            }
            total += (likelihood / weights).ln();
        }
        let nu = d + m + 1;
        let gammas: f64 = (1..=d).map(|j| log_gamma_of_half(nu + 1 - j)).sum();
        let log_gamma = 0.25 * (d * (d - 1)) as f64 * std::f64::consts::PI.ln() + gammas;
        let scale = (nu * d) as f64 * (gamma.ln() - 0.5 * 2_f64.ln());
        total += R::lit(k as f64 * (scale - log_gamma));
        total -= R::lit(points.len() as f64 * 0.5 * (2.0 * std::f64::consts::PI).ln());
        for component in components {
            for (i, &entry) in component.iter().enumerate().skip(d) {
                let (factor, linear) = if i < 2 * d {
                    (entry.exp(), R::lit(m as f64) * entry)
                } else {
                    (entry, R::zero())
                };
                total += linear - R::lit(0.5 * gamma * gamma) * factor * factor;
            }
        }
        vec![total]
    }
}

/// `v` turned by `r`, an angle and an axis.
fn rotate<R: Real>(r: &[R], v: [R; 3]) -> [R; 3] {
    let angle = (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]).sqrt();
    let axis = [r[0] / angle, r[1] / angle, r[2] / angle];
    let along = axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2];
    let turned = |i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let across = axis[j] * v[k] - axis[k] * v[j];
        v[i] * angle.cos() + across * angle.sin() + axis[i] * along * (R::one() - angle.cos())
    };
    [turned(0), turned(1), turned(2)]
}

/// Two reprojection errors and that of the weight, of a camera, a point and a weight.
pub(crate) struct View(pub(crate) Vec<f64>);

impl VectorFunction for View {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let p = rotate(&x[..3], [x[11] - x[3], x[12] - x[4], x[13] - x[5]]);
        let (u, v, weight) = (p[0] / p[2], p[1] / p[2], x[14]);
        let r2 = u * u + v * v;
        let bend = R::one() + x[9] * r2 + x[10] * r2 * r2;
        let error = |u: R, centre: R, seen: f64| weight * (x[6] * bend * u + centre - R::lit(seen));
        vec![
            error(u, x[7], self.0[0]),
            error(v, x[8], self.0[1]),
            R::one() - weight * weight,
        ]
    }
}

/// Of all main parameters, then the extra ones.
pub(crate) struct Language<'a>(pub(crate) &'a Value);

fn sigmoid<R: Real>(x: R) -> R {
    (R::one() + (-x).exp()).recip()
}

impl VectorFunction for Language<'_> {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let lists = |name: &str| -> Vec<Vec<f64>> {
            let rows = self.0[name].as_array().expect("a list");
            rows.iter().map(numbers).collect()
        };
        let (sequence, start) = (lists("sequence"), lists("state"));
        let bits = sequence[0].len();
        let lift = |row: &Vec<f64>| row.iter().map(|&v| R::lit(v)).collect::<Vec<R>>();
        let mut state: Vec<Vec<R>> = start.iter().map(lift).collect();
        let (main, extra) = x.split_at(4 * bits * state.len());
        let rows: Vec<&[R]> = main.chunks(4 * bits).collect();
        let mut loss = R::zero();
        for pair in sequence.windows(2) {
            let mut v: Vec<R> = (0..bits).map(|b| R::lit(pair[0][b]) * extra[b]).collect();
            for (layer, state) in state.chunks_mut(2).enumerate() {
                let (w, bias) = (rows[2 * layer], rows[2 * layer + 1]);
                for b in 0..bits {
                    let gate = |k: usize, v: R| v * w[k * bits + b] + bias[k * bits + b];
                    let (hidden, cell) = (state[0][b], state[1][b]);
                    let forgotten = cell * sigmoid(gate(0, v[b]));
                    let cell = forgotten + sigmoid(gate(1, hidden)) * gate(3, hidden).tanh();
                    state[1][b] = cell;
                    state[0][b] = sigmoid(gate(2, v[b])) * cell.tanh();
                    v[b] = state[0][b];
                }
            }
            let guess = |b: usize| v[b] * extra[bits + b] + extra[2 * bits + b];
            let mut normaliser = R::lit(2.0);
            for b in 0..bits {
                normaliser += guess(b).exp();
            }
            for (b, &next) in pair[1].iter().enumerate() {
                loss += R::lit(next) * (guess(b) - normaliser.ln());
            }
        }
        vec![-loss / R::lit((bits * (sequence.len() - 1)) as f64)]
    }
}

/// All residuals, of `theta`, then the places on the triangles if there are any.
pub(crate) struct Hand<'a>(pub(crate) &'a Value);

type Matrix<R> = [[R; 4]; 4];

fn product<R: Real>(a: &Matrix<R>, b: &Matrix<R>) -> Matrix<R> {
    let mut c = [[R::zero(); 4]; 4];
    for i in 0..4 {
        for j in 0..4 {
            for k in 0..4 {
                c[i][j] += a[i][k] * b[k][j];
            }
        }
    }
    c
}

/// The rotation by an angle in the plane of two axes.
fn turn<R: Real>(angle: R, [from, to]: [usize; 2]) -> Matrix<R> {
    let mut matrix = [[R::zero(); 4]; 4];
    for i in 0..4 {
        matrix[i][i] = R::one();
    }
    matrix[from][from] = angle.cos();
    matrix[to][to] = angle.cos();
    matrix[to][from] = angle.sin();
    matrix[from][to] = -angle.sin();
    matrix
}

impl Hand<'_> {
    fn transforms<R: Real>(&self, theta: &[R]) -> Vec<Matrix<R>> {
        let model = &self.0["data"]["model"];
        let matrices = |name: &str| -> Vec<Matrix<R>> {
            let all = numbers(&model[name]);
            let matrix =
                |m: &[f64]| std::array::from_fn(|i| std::array::from_fn(|j| R::lit(m[4 * i + j])));
            all.chunks(16).map(matrix).collect()
        };
        let (relatives, inverses) = (
            matrices("base_relatives"),
            matrices("inverse_base_absolutes"),
        );
        let (mut absolutes, mut transforms): (Vec<Matrix<R>>, Vec<_>) = (Vec::new(), Vec::new());
        for (i, parent) in numbers(&model["parents"]).into_iter().enumerate() {
            let mut angles = [R::zero(); 3];
            if (1..21).contains(&i) {
                let finger = &theta[6 + (i - 1) / 4 * 4..];
                match (i - 1) % 4 {
                    1 => angles = [finger[0], finger[1], R::zero()],
                    2 => angles[0] = finger[2],
                    3 => angles[0] = finger[3],
                    _ => {}
                }
            }
            let [x, z, y] = angles;
            let local = product(
                &turn(z, [0, 1]),
                &product(&turn(y, [2, 0]), &turn(x, [1, 2])),
            );
            let mut absolute = product(&relatives[i], &local);
            if parent >= 0.0 {
                absolute = product(&absolutes[parent as usize], &absolute);
            }
            transforms.push(product(&absolute, &inverses[i]));
            absolutes.push(absolute);
        }
        transforms
    }

    /// The place of a vertex.
    fn vertex<R: Real>(&self, at: usize, theta: &[R], transforms: &[Matrix<R>]) -> [R; 3] {
        let model = &self.0["data"]["model"];
        let (place, weights) = (
            numbers(&model["base_positions"][at]),
            numbers(&model["weights"][at]),
        );
        let mut sum = [R::zero(); 3];
        for (weight, transform) in weights.into_iter().zip(transforms) {
            for i in 0..3 {
                for j in 0..4 {
                    sum[i] += R::lit(weight * place[j]) * transform[i][j];
                }
            }
        }
        if model["is_mirrored"] == true {
            sum[0] = -sum[0];
        }
        let turned = rotate(&theta[..3], sum);
        std::array::from_fn(|i| turned[i] + theta[3 + i])
    }
}

impl VectorFunction for Hand<'_> {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let (theta, us) = x.split_at(26);
        let transforms = self.transforms(theta);
        let (data, mut residuals) = (&self.0["data"], Vec::new());
        let points = numbers(&data["points"]);
        for (i, point) in points.chunks(3).enumerate() {
            let index = count(&data["correspondences"][i]);
            let mut place = [R::zero(); 3];
            if us.is_empty() {
                place = self.vertex(index, theta, &transforms);
            } else {
                let (u, v) = (us[2 * i], us[2 * i + 1]);
                let corners = numbers(&data["model"]["triangles"][index]);
                for (corner, share) in corners.into_iter().zip([u, v, R::one() - u - v]) {
                    let vertex = self.vertex(corner as usize, theta, &transforms);
                    for k in 0..3 {
                        place[k] += share * vertex[k];
                    }
                }
            }
            residuals.extend((0..3).map(|k| R::lit(point[k]) - place[k]));
        }
        residuals
    }
}
