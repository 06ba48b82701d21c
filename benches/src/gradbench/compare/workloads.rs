//! The default workloads of the evaluations, at middle sizes.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::super::inputs::{self, Draw};

/// An input of an evaluation.
pub struct Workload {
    /// What tells it from the others of the evaluation.
    pub name: String,
    /// The input.
    pub input: Value,
}

/// The evaluations that have a primal function, and the names of both functions.
pub const TIMED: [(&str, [&str; 2]); 9] = [
    ("gmm", ["objective", "jacobian"]),
    ("ba", ["objective", "jacobian"]),
    ("lstm", ["objective", "jacobian"]),
    ("ht", ["objective", "jacobian"]),
    ("kmeans", ["cost", "dir"]),
    ("ode", ["primal", "gradient"]),
    ("llsq", ["primal", "gradient"]),
    ("det", ["primal", "gradient"]),
    ("lse", ["primal", "gradient"]),
];

/// The seed of all inputs that are drawn.
const SEED: u64 = 31337;

/// The workloads of an evaluation; `evals` is the folder of that name in GradBench's checkout.
pub fn workloads(module: &str, evals: &Path) -> Vec<Workload> {
    let mut draw = Draw::new(SEED);
    let mut list = Vec::new();
    let mut add = |name: String, input: Value| list.push(Workload { name, input });
    match module {
        "gmm" => pairs([2, 10, 20, 32], [5, 25], |d, k| {
            add(format!("d={d} k={k}"), draw.gmm(d, k, 1000));
        }),
        "ba" => {
            for i in 1..=5 {
                let path = found(&evals.join("ba/data"), &format!("ba{i}_"));
                if let Some(input) = path.and_then(|path| inputs::ba(&path)) {
                    add(format!("ba{i}"), input);
                }
            }
        }
        "lstm" => pairs([2, 4], [1024, 4096], |layers, c| {
            add(format!("l={layers} c={c}"), draw.lstm(layers, c));
        }),
        "ht" => {
            let folder = evals.join("ht/data/complicated_big");
            for i in 1..=5 {
                let path = found(&folder, &format!("hand{i}_"));
                let read = |path: PathBuf| inputs::ht(&path, &folder.join("model"), true);
                if let Some(input) = path.and_then(read) {
                    add(format!("hand{i}"), input);
                }
            }
        }
        "kmeans" => pairs([10, 100], [1000, 10000], |k, n| {
            for d in [8, 16] {
                add(format!("k={k} n={n} d={d}"), draw.kmeans(k, n, d));
            }
        }),
        "ode" => pairs([4, 1000, 10000], [1, 10, 100], |n, s| {
            add(format!("n={n} s={s}"), draw.ode(n, s));
        }),
        "llsq" => [16, 128, 1024, 4096].into_iter().for_each(|n| {
            add(format!("n={n}"), draw.llsq(n, 128));
        }),
        "det" => (5..=9).for_each(|ell| add(format!("{ell}"), draw.det(ell))),
        "lse" => [1_000, 10_000, 100_000, 1_000_000]
            .into_iter()
            .for_each(|n| {
                add(format!("n={n}"), draw.lse(n));
            }),
        _ => {}
    }
    list
}

fn pairs<const A: usize, const B: usize>(
    a: [usize; A],
    b: [usize; B],
    mut add: impl FnMut(usize, usize),
) {
    for a in a {
        for b in b {
            add(a, b);
        }
    }
}

/// The file of a folder whose name begins so.
fn found(folder: &Path, prefix: &str) -> Option<PathBuf> {
    let mut files = std::fs::read_dir(folder).ok()?.flatten();
    files
        .find(|file| file.file_name().to_string_lossy().starts_with(prefix))
        .map(|file| file.path())
}
