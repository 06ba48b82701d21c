//! Sources that are emitted from recordings of kernels and checked in.

use std::path::Path;

/// Writes the file where `EMIT` is set; panics unless its text is what is emitted today.
pub(crate) fn assert_fresh(file: &str, header: &str, parts: &[String]) {
    let emitted = [header, &parts.join("\n")].join("\n");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    if std::env::var_os("EMIT").is_some() {
        std::fs::write(&path, &emitted).expect("the source folder can be written");
    }
    let checked_in = std::fs::read_to_string(&path).expect("what is emitted is checked in");
    assert!(
        checked_in == emitted,
        "the kernels have changed: see the head of {path:?}"
    );
}
