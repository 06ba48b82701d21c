//! Operations that instruction sets with 128-bit registers lack: loading and storing part of a register, and moving
//! lanes by tables (here, tables of bytes).

use super::places::{RANK, SET_BIT};
use crate::real::Lane;

/// Copies `part`, which has fewer than `N` numbers, to an array of `N` numbers. The remaining numbers are zero.
#[inline(always)]
pub(super) fn padded<S: Copy + Default, const N: usize>(part: &[S]) -> [S; N] {
    let mut numbers = [S::default(); N];
    for (number, &of_part) in numbers.iter_mut().zip(part) {
        *number = of_part;
    }
    numbers
}

/// Fills a slice of fewer than `N` numbers with the first lanes of a register.
#[inline(always)]
pub(super) fn store_first<S: Copy + Default, const N: usize>(to: &mut [S], lanes: impl Lane<S>) {
    let mut numbers = [S::default(); N];
    lanes.store(&mut numbers);
    for (to, number) in to.iter_mut().zip(numbers) {
        *to = number;
    }
}

/// For each mask of four 32-bit lanes, the table of bytes with which `expand` moves lanes. It says for bytes what
/// [`RANK`] says for lanes. Lanes whose mask bit is not set have the index 255. No register has a byte 255, so these
/// lanes become zero.
pub(super) static EXPANDED: [[u8; 16]; 16] = bytes(true);
/// For each mask of four 32-bit lanes, the table of bytes with which `compress` moves lanes. It says for bytes what
/// [`SET_BIT`] says for lanes.
pub(super) static COMPRESSED: [[u8; 16]; 16] = bytes(false);

const fn bytes(expand: bool) -> [[u8; 16]; 16] {
    let mut table = [[u8::MAX; 16]; 16];
    let mut at = 0;
    while at < 16 * 16 {
        let (bits, lane) = (at / 16, at % 16 / 4);
        let (from, filled) = if expand {
            (RANK[bits][lane], bits >> lane & 1 == 1)
        } else {
            (SET_BIT[bits][lane], lane < bits.count_ones() as usize)
        };
        if filled {
            table[bits][at % 16] = 4 * from + (at % 4) as u8;
        }
        at += 1;
    }
    table
}
