//! Operations that instruction sets with 128-bit registers lack: loading and storing part of a register.

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
