//! No derivative is written by hand.

use std::path::PathBuf;

use super::{code, sources as files};

/// The source files of the application (all crates of `cosmic`), in which derivatives must not be written by hand.
fn application() -> impl Iterator<Item = (PathBuf, String)> {
    let sources = [
        "cosmic/optimiser/src",
        "cosmic/src",
        "cosmic/lab/src",
        "cosmic/program/src",
    ];
    let files = sources.into_iter().flat_map(files);
    files.map(|path| {
        let code = code(&path);
        (path, code)
    })
}

/// The lines of the application's code that contain any of `words`, each as a text `file: line`.
fn lines_with(words: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    for (path, code) in application() {
        let holds = |line: &&str| words.iter().any(|word| line.contains(word));
        let named = |line: &str| format!("{}: {}", path.display(), line.trim());
        found.extend(code.lines().filter(holds).map(named));
    }
    found
}

/// All derivatives come from the engine `autodiff`. The application defines only one derivative rule, a
/// straight-through estimator, and all adjoints of its kernels are generated from recordings.
#[test]
fn nothing_is_differentiated_by_hand() {
    let mut rules = lines_with(&[
        "Fused for",
        "Rule for",
        "custom::apply",
        ".straight_through(",
    ]);
    // Generated code has the rules of the engine, such as that of the length of a vector.
    rules.retain(|rule| !rule.contains("laws/adjoints.rs:"));
    assert!(
        matches!(&rules[..], [one] if one.contains("projection.rs") && one.contains("soft")),
        "{rules:#?}"
    );
    let emitted = lines_with(&["fn emitted_"]);
    assert!(!emitted.is_empty(), "the kernels have adjoints");
    assert!(
        emitted.iter().all(|line| line.contains("adjoints.rs")),
        "{emitted:#?}"
    );
    assert_eq!(adjoints_by_hand(), Vec::<String>::new());
}

/// The hand-written adjoints of kernels. An adjoint is not hand-written if its last line is a call: of generated code, of
/// the default with dual numbers or its last part, or of the adjoint function of a law.
fn adjoints_by_hand() -> Vec<String> {
    let mut found = Vec::new();
    for (path, code) in application() {
        let lines: Vec<&str> = code.lines().collect();
        for (at, line) in lines.iter().enumerate() {
            let (indent, name) = line.split_at(line.len() - line.trim_start().len());
            let name = name
                .strip_prefix("fn ")
                .and_then(|rest| rest.split('<').next());
            let closing = format!("{indent}}}");
            let end = lines[at..].iter().position(|line| *line == closing);
            let calls = |end: usize| is_a_call(lines[at + end - 1].trim());
            if name.is_some_and(|name| name.contains("vjp")) && !end.is_some_and(calls) {
                found.push(format!("{}: {line}", path.display()));
            }
        }
    }
    found
}

/// True for a line that calls generated code, the default with dual numbers or its last part, or the adjoint function of a
/// law.
fn is_a_call(line: &str) -> bool {
    let Some((callee, arguments)) = line.split_once('(') else {
        return false;
    };
    let is_word = |c: char| c.is_alphanumeric() || "_, $()?".contains(c);
    let forwards =
        arguments.chars().all(is_word) && arguments.split([',', ' ', ')']).any(|a| a == "at");
    let name = callee.rsplit(['.', ':']).next().unwrap_or_default();
    let of_law = ["C::", "G::", "L::"]
        .iter()
        .any(|law| callee.starts_with(law));
    if name == "pulled_back" {
        return true;
    }
    let is_adjoint = name.starts_with("emitted_")
        || name == "vjp"
        || name.starts_with("vjp_by_duals")
        || of_law && (name.ends_with("_vjp") || name.ends_with("_vjp_in_space"));
    forwards && is_adjoint
}
