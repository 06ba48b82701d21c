//! Arrays of NumPy: the format `.npy`, version 1.0, in a zip archive without compression, `.npz`.
//!
//! Specifications: NEP 1 of NumPy, and APPNOTE.TXT 6.3 of PKWARE, sections 4.3.7, 4.3.12 and 4.3.16.

use cosmic::error::Result;
use cosmic::record::files::write_atomic;
use std::path::Path;

/// An array of doubles, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct NumpyArray {
    /// Lengths along the axes; none of them for a single number.
    pub shape: Vec<usize>,
    /// The numbers.
    pub numbers: Vec<f64>,
}

impl NumpyArray {
    /// A single number.
    pub fn scalar(number: f64) -> Self {
        Self {
            shape: Vec::new(),
            numbers: vec![number],
        }
    }

    /// A vector.
    pub fn vector(numbers: Vec<f64>) -> Self {
        Self {
            shape: vec![numbers.len()],
            numbers,
        }
    }

    /// A matrix of so many rows, row by row.
    ///
    /// # Panics
    /// If the numbers do not fill the rows.
    pub fn matrix(rows: usize, numbers: Vec<f64>) -> Self {
        let columns = numbers.len().checked_div(rows).unwrap_or(0);
        assert_eq!(rows * columns, numbers.len(), "a matrix has full rows");
        Self {
            shape: vec![rows, columns],
            numbers,
        }
    }

    /// The array as a file `.npy`.
    fn bytes(&self) -> Vec<u8> {
        let axes: String = self.shape.iter().map(|axis| format!("{axis}, ")).collect();
        let says = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({axes}), }}");
        // The numbers begin at a multiple of 64 bytes; ten come before the header.
        let padded = (10 + says.len() + 1).next_multiple_of(64) - 11;
        let header = format!("{says:padded$}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.bytes());
        bytes.extend(self.numbers.iter().flat_map(|x| x.to_le_bytes()));
        bytes
    }
}

/// Replaces a file by an archive of arrays, each with the name by which `numpy.load` knows it.
///
/// # Errors
/// [`Error::Write`](cosmic::Error::Write).
pub fn write_npz(path: &Path, arrays: &[(&str, NumpyArray)]) -> Result<()> {
    let mut archive = Vec::new();
    let mut directory = Vec::new();
    for (name, array) in arrays {
        let (name, data) = (format!("{name}.npy"), array.bytes());
        let entry = entry(&name, &data);
        // Made by version 2.0 on no system in particular; no comment, no attributes.
        directory.extend(*b"PK\x01\x02\x14\x00");
        directory.extend(&entry);
        directory.extend([0; 10]);
        directory.extend((archive.len() as u32).to_le_bytes());
        directory.extend(name.bytes());
        archive.extend(*b"PK\x03\x04");
        archive.extend(entry);
        archive.extend(name.bytes());
        archive.extend(data);
    }
    let count = (arrays.len() as u16).to_le_bytes();
    let [begins, size] = [archive.len(), directory.len()].map(|n| (n as u32).to_le_bytes());
    archive.extend(directory);
    archive.extend(*b"PK\x05\x06\x00\x00\x00\x00");
    archive.extend([count, count].concat());
    archive.extend([size, begins].concat());
    archive.extend(0u16.to_le_bytes());
    write_atomic(path, |file| file.write_all(&archive))
}

/// The fields of a file that stand before it and in the directory of the archive: stored, of 1 January 1980.
fn entry(name: &str, data: &[u8]) -> Vec<u8> {
    let size = (data.len() as u32).to_le_bytes();
    let mut entry = vec![20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0];
    entry.extend(checksum(data).to_le_bytes());
    entry.extend([size, size].concat());
    entry.extend((name.len() as u16).to_le_bytes());
    entry.extend(0u16.to_le_bytes());
    entry
}

/// The cyclic redundancy check of zip archives.
fn checksum(data: &[u8]) -> u32 {
    let shift = |sum: u32, _| (sum >> 1) ^ (0xedb8_8320 & (sum & 1).wrapping_neg());
    let add = |sum: u32, &byte: &u8| (0..8).fold(sum ^ u32::from(byte), shift);
    !data.iter().fold(u32::MAX, add)
}

#[cfg(test)]
mod tests {
    use super::{NumpyArray, checksum};

    #[test]
    fn the_checksum_is_that_of_the_specification() {
        // The check value that catalogues give for CRC-32.
        assert_eq!(checksum(b"123456789"), 0xcbf4_3926);
    }

    #[test]
    fn a_file_is_its_header_and_its_numbers() {
        let bytes = NumpyArray::matrix(2, vec![1.0, 2.0, 3.0, 4.0]).bytes();
        let says = String::from_utf8_lossy(&bytes[10..128]);
        assert!(says.contains("'shape': (2, 2, ), }"), "{says}");
        assert_eq!((bytes.len(), bytes[127]), (128 + 4 * 8, b'\n'));
        assert_eq!(bytes[128 + 24..], 4.0f64.to_le_bytes());
        let single = NumpyArray::scalar(0.5).bytes();
        assert!(String::from_utf8_lossy(&single).contains("'shape': (), }"));
    }
}
