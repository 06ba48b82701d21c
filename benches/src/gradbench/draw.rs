//! Inputs of the evaluations' shapes, drawn from a seed.

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
        const BITS: usize = 14;
        /// Bits that are zero in all characters.
        const UNUSED: usize = 7;
        let mut character = || {
            let mut bits = vec![0.0; UNUSED];
            bits.extend((UNUSED..BITS).map(|_| self.uniform().round()));
            bits
        };
        let text: Vec<_> = (0..c).map(|_| character()).collect();
        json!({
            "main_params": self.rows(2 * layers, 4 * BITS),
            "extra_params": self.rows(3, BITS),
            "state": self.rows(2 * layers, BITS),
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
