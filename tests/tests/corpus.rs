//! Every file that fuzzing has found is either read, or refused with a clear error.

use std::fs;
use std::panic::catch_unwind;

use cosmic_tests::readers::READERS;
use cosmic_tests::{entries, workspace};

#[test]
fn no_file_of_the_corpus_makes_a_reader_panic() {
    let corpus = workspace().join("tests/data/corpus");
    for (name, read) in READERS {
        let (mut read_well, mut refused) = (0, 0);
        for path in entries(&corpus.join(name)) {
            let bytes = fs::read(&path).expect("a file of a corpus can be read");
            match catch_unwind(|| read(&bytes)) {
                Ok(Ok(())) => read_well += 1,
                Ok(Err(error)) => {
                    refused += 1;
                    assert!(!error.to_string().is_empty());
                    assert!([2, 3].contains(&error.exit_code()), "{path:?}: {error}");
                }
                Err(_) => panic!("the reader of a {name} panics on {}", path.display()),
            }
        }
        // Each corpus has both valid and invalid files.
        assert!(
            read_well > 0 && refused > 0,
            "{name}: {read_well} {refused}"
        );
    }
}
