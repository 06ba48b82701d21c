//! Inputs of the evaluations' shapes: ADBench's files where there are, else drawn from a seed.

use std::path::Path;

use serde_json::{Value, json};

/// A generator of numbers for inputs: SplitMix64 (Steele, Lea, Flood, *Fast splittable pseudorandom number
/// generators*, 2014).
#[derive(Clone, Debug)]
pub struct Draw(u64);

impl Draw {
    /// Numbers from a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// A number in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A number with the normal distribution, by Box and Muller.
    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (2.0 * std::f64::consts::PI * self.uniform()).cos()
    }

    fn uniforms(&mut self, len: usize) -> Vec<f64> {
        (0..len).map(|_| self.uniform()).collect()
    }

    fn normals(&mut self, len: usize) -> Vec<f64> {
        (0..len).map(|_| self.normal()).collect()
    }

    fn rows(&mut self, rows: usize, columns: usize) -> Vec<Vec<f64>> {
        (0..rows).map(|_| self.uniforms(columns)).collect()
    }

    fn normal_rows(&mut self, rows: usize, columns: usize) -> Vec<Vec<f64>> {
        (0..rows).map(|_| self.normals(columns)).collect()
    }

    /// A mixture of `k` components in `d` dimensions, and `n` points.
    pub fn gmm(&mut self, d: usize, k: usize, n: usize) -> Value {
        json!({
            "d": d, "k": k, "n": n, "m": 0, "gamma": 1.0,
            "x": self.normal_rows(n, d),
            "alpha": self.normals(k),
            "mu": self.rows(k, d),
            "q": self.normal_rows(k, d),
            "l": self.normal_rows(k, d * (d - 1) / 2),
        })
    }

    /// A model of so many layers, and a text of `c` characters.
    pub fn lstm(&mut self, layers: usize, c: usize) -> Value {
        /// Bits of a character, and those that are zero in all.
        const BITS: [usize; 2] = [14, 7];
        let mut character = || {
            let bit = |i| {
                if i < BITS[1] {
                    0.0
                } else {
                    self.uniform().round()
                }
            };
            (0..BITS[0]).map(bit).collect::<Vec<f64>>()
        };
        let text: Vec<_> = (0..c).map(|_| character()).collect();
        json!({
            "main_params": self.rows(2 * layers, 4 * BITS[0]),
            "extra_params": self.rows(3, BITS[0]),
            "state": self.rows(2 * layers, BITS[0]),
            "sequence": text,
        })
    }

    /// `n` points in `d` dimensions, the last `k` of which are the centroids.
    pub fn kmeans(&mut self, k: usize, n: usize, d: usize) -> Value {
        let points = self.rows(n, d);
        json!({ "centroids": points[n - k..], "points": points })
    }

    /// A chain of `n` numbers, and `s` steps.
    pub fn ode(&mut self, n: usize, s: usize) -> Value {
        json!({ "x": self.uniforms(n), "s": s })
    }

    /// A polynomial of `m` coefficients, and `n` points.
    pub fn llsq(&mut self, n: usize, m: usize) -> Value {
        json!({ "x": self.uniforms(m), "n": n })
    }

    /// A matrix of an order.
    pub fn det(&mut self, ell: usize) -> Value {
        json!({ "A": self.uniforms(ell * ell), "ell": ell })
    }

    /// `n` numbers.
    pub fn lse(&mut self, n: usize) -> Value {
        json!({ "x": self.uniforms(n) })
    }
}

/// The numbers of a line.
fn numbers(line: &str) -> Option<Vec<f64>> {
    let tokens = line.split(|c: char| c == ':' || c.is_whitespace());
    let tokens = tokens.filter(|token| !token.is_empty());
    tokens.map(|token| token.parse().ok()).collect()
}

/// The lines of a file, as numbers.
fn lines(path: &Path) -> Option<Vec<Vec<f64>>> {
    let text = std::fs::read_to_string(path).ok()?;
    let lines = text.lines().filter(|line| !line.trim().is_empty());
    lines.map(numbers).collect()
}

/// Whole numbers as such: floats are refused as counts.
fn counts(numbers: &[f64]) -> Vec<i64> {
    numbers.iter().map(|&number| number as i64).collect()
}

/// A file of bundle adjustment; `None` if it cannot be read.
pub fn ba(path: &Path) -> Option<Value> {
    let all = lines(path)?.concat();
    let sizes = counts(all.get(..3)?);
    Some(json!({
        "n": sizes[0], "m": sizes[1], "p": sizes[2],
        "cam": all.get(3..14)?, "x": all.get(14..17)?, "w": all.get(17)?, "feat": all.get(18..20)?,
    }))
}

/// A file of hand tracking, complicated or not, and the model in a folder; `None` if one of them cannot be
/// read.
pub fn ht(path: &Path, model: &Path, complicated: bool) -> Option<Value> {
    let all = lines(path)?;
    let (first, rest) = all.split_first()?;
    let count = counts(first)[0] as usize;
    let (targets, rest) = rest.split_at_checked(count)?;
    let (us, theta) = rest.split_at_checked(if complicated { count } else { 0 })?;
    let correspondences: Vec<i64> = targets.iter().map(|target| target[0] as i64).collect();
    let points: Vec<&[f64]> = targets.iter().map(|target| &target[1..]).collect();
    Some(json!({
        "theta": theta.concat(),
        "us": us,
        "data": { "model": hand(model)?, "correspondences": correspondences, "points": points },
    }))
}

/// The model of a hand, from its three files.
fn hand(folder: &Path) -> Option<Value> {
    let bones = std::fs::read_to_string(folder.join("bones.txt")).ok()?;
    let bones = bones.lines().map(|line| line.split_once(':'));
    let (names, bones): (Vec<&str>, Vec<&str>) =
        bones.collect::<Option<Vec<_>>>()?.into_iter().unzip();
    let bones: Vec<Vec<f64>> = bones.into_iter().map(numbers).collect::<Option<_>>()?;
    let parents: Vec<i64> = bones.iter().map(|bone| bone[0] as i64).collect();
    let matrices = |from: usize| -> Vec<Vec<&[f64]>> {
        let rows = bones.iter().map(|bone| bone[from..from + 16].chunks(4));
        rows.map(Iterator::collect).collect()
    };
    let vertices = lines(&folder.join("vertices.txt"))?;
    let positions = vertices.iter().map(|v| [v[0], v[1], v[2], 1.0]);
    let weights = vertices.iter().map(|vertex| {
        let mut weights = vec![0.0; bones.len()];
        for pair in vertex[9..].chunks_exact(2) {
            weights[pair[0] as usize] = pair[1];
        }
        weights
    });
    let triangles = lines(&folder.join("triangles.txt"))?;
    Some(json!({
        "bone_count": bones.len(),
        "bone_names": names,
        "parents": parents,
        "base_relatives": matrices(1),
        "inverse_base_absolutes": matrices(17),
        "base_positions": positions.collect::<Vec<_>>(),
        "weights": weights.collect::<Vec<_>>(),
        "triangles": triangles.iter().map(|corners| counts(corners)).collect::<Vec<_>>(),
        "is_mirrored": false,
    }))
}
