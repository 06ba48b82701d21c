//! Every kernel in sources and documentation has `#[inline(always)]`. Without it, a kernel still computes the same
//! numbers, but fifty times slower.

use std::fs;

use cosmic_tests::{files_below, workspace};

/// The code in a line, which may be a line of documentation.
fn code(line: &str) -> &str {
    line.trim_start_matches(['/', '!', ' '])
        .trim_start_matches("# ")
}

/// Counts the functions `eval` and `eval_with` of kernels in a text. Also returns the functions among them that do not
/// have `#[inline(always)]`.
fn kernels(text: &str) -> (usize, Vec<String>) {
    let lines: Vec<&str> = text.lines().map(code).collect();
    let (mut seen, mut wrong) = (0, Vec::new());
    for (at, line) in lines.iter().enumerate() {
        if !line.starts_with("impl") || !line.contains("Kernel<") || !line.ends_with('{') {
            continue;
        }
        let body = lines[at..].iter().take_while(|line| **line != "}");
        let is_eval = |line: &&str| {
            ["fn eval<", "fn eval_with<"]
                .iter()
                .any(|name| line.starts_with(name))
        };
        if let Some(eval) = body.clone().position(is_eval) {
            seen += 1;
            if lines[at + eval - 1] != "#[inline(always)]" {
                wrong.push((*line).to_string());
            }
        }
    }
    (seen, wrong)
}

#[test]
fn kernels_are_inlined() {
    let root = workspace();
    let mut seen = 0;
    for folder in [
        "autodiff/src",
        "autodiff/examples",
        "cosmic",
        "benches/src",
        "benches/benches",
    ] {
        for file in files_below(&root.join(folder), &["rs", "md"]) {
            let text = fs::read_to_string(&file).expect("a source file can be read");
            let (here, wrong) = kernels(&text);
            // The kernels in this file of tests need not be fast.
            let is_test = file.ends_with("steps/tests.rs");
            assert!(is_test || wrong.is_empty(), "{}: {wrong:?}", file.display());
            seen += here;
        }
    }
    assert!(seen > 20, "{seen} kernels");
}

#[test]
fn a_kernel_that_is_not_inlined_is_found() {
    let kernel = |above: &str| {
        format!(
            "/// # impl Kernel<1, 1> for A {{\n///     {above}\n///     fn eval<R: Real>(\n/// }}\n"
        )
    };
    assert_eq!(kernels(&kernel("#[inline(always)]")), (1, vec![]));
    let (seen, wrong) = kernels(&kernel("// A comment."));
    assert_eq!((seen, wrong.len()), (1, 1));
}
