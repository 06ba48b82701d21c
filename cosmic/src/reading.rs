//! Reading files whole, of which some do not end: `/dev/zero` does not.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::error::{Error, Result};

/// The most that is taken from what is no file of a known size, such as a pipe: a hundred times a
/// design of the paper's.
const STREAM: u64 = 1 << 26;

/// A file's bytes: all of a regular file, and of a pipe or a device what it gives up to 64 MiB.
///
/// # Errors
/// [`Error::Read`], and [`Error::Usage`] for a stream that goes on.
pub fn read_whole(path: &Path) -> Result<Vec<u8>> {
    let regular = path.metadata().is_ok_and(|about| about.is_file());
    read_at_most(path, if regular { u64::MAX } else { STREAM })
}

/// A file's bytes where it has so many at most.
///
/// # Errors
/// [`Error::Read`], and [`Error::Usage`] for a longer one.
pub fn read_at_most(path: &Path, most: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let read = |file: File| file.take(most.saturating_add(1)).read_to_end(&mut bytes);
    match File::open(path).and_then(read) {
        Ok(read) if read as u64 <= most => Ok(bytes),
        Ok(_) => Err(Error::Usage(format!(
            "{}: more than the {most} bytes that it may have",
            path.display()
        ))),
        Err(source) => Err(Error::Read {
            path: path.into(),
            source,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::{read_at_most, read_whole};
    use std::path::Path;

    #[test]
    fn a_file_is_read_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a");
        std::fs::write(&file, [7; 100]).unwrap();
        assert_eq!(read_whole(&file).unwrap(), [7; 100]);
        assert_eq!(read_at_most(&file, 100).unwrap().len(), 100);
        let long = read_at_most(&file, 99).unwrap_err();
        assert!(long.exit_code() == 2 && long.to_string().contains("99 bytes"));
        assert_eq!(
            read_whole(&folder.path().join("b"))
                .unwrap_err()
                .exit_code(),
            4
        );
        assert_eq!(read_whole(folder.path()).unwrap_err().exit_code(), 4);
    }

    #[cfg(unix)]
    #[test]
    fn what_does_not_end_is_refused() {
        let endless = read_whole(Path::new("/dev/zero")).unwrap_err();
        assert_eq!(endless.exit_code(), 2);
    }
}
