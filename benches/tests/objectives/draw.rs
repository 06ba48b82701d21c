//! Draws random inputs in the shapes of GradBench's evaluations.

use serde_json::{Value, json};

/// A generator of random numbers: SplitMix64 (Steele, Lea, Flood, *Fast splittable pseudorandom number generators*,
/// 2014).
pub(crate) struct Draw(pub(crate) u64);

impl Draw {
    /// Draws a number in [0, 1).
    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Draws numbers in [0, 1).
    pub(crate) fn uniforms(&mut self, len: usize) -> Vec<f64> {
        (0..len).map(|_| self.uniform()).collect()
    }

    pub(crate) fn rows(&mut self, rows: usize, columns: usize) -> Vec<Vec<f64>> {
        (0..rows).map(|_| self.uniforms(columns)).collect()
    }

    /// Draws a mixture of `k` components in `d` dimensions, and `n` points.
    pub(crate) fn gmm(&mut self, d: usize, k: usize, n: usize) -> Value {
        let mut centred = |rows, columns| {
            let mut rows = self.rows(rows, columns);
            rows.iter_mut().flatten().for_each(|x| *x = 2.0 * *x - 1.0);
            rows
        };
        json!({
            "d": d, "k": k, "n": n, "m": 0, "gamma": 1.0,
            "x": centred(n, d),
            "alpha": centred(1, k)[0],
            "mu": centred(k, d),
            "q": centred(k, d),
            "l": centred(k, d * (d - 1) / 2),
        })
    }

    /// Draws a language model of `l` layers, and a text of `c` characters.
    pub(crate) fn lstm(&mut self, l: usize, c: usize) -> Value {
        const BITS: usize = 14;
        json!({
            "main_params": self.rows(2 * l, 4 * BITS),
            "extra_params": self.rows(3, BITS),
            "state": self.rows(2 * l, BITS),
            "sequence": self.rows(c, BITS),
        })
    }

    /// Draws `n` points in `d` dimensions. The last `k` of them are the centroids.
    pub(crate) fn kmeans(&mut self, k: usize, n: usize, d: usize) -> Value {
        let points = self.rows(n, d);
        json!({ "centroids": points[n - k..], "points": points })
    }

    /// Draws a polynomial of `m` coefficients, and `n` points.
    pub(crate) fn llsq(&mut self, n: usize, m: usize) -> Value {
        json!({ "x": self.uniforms(m), "n": n })
    }
}
