//! Access to the numbers of a step and to their cotangents.

use std::ptr::null_mut;
use std::slice::{from_raw_parts, from_raw_parts_mut};

use autodiff::Real;
use autodiff::internal::{Unchecked, WIDEST};
use autodiff::simd::Lane;

use super::array::Array;

/// The numbers of a step: the parameters, which are the same for all steps, and the row of this step.
#[derive(Clone, Copy)]
pub(crate) struct StepValues<'a, R> {
    pub(crate) parameters: &'a [R],
    pub(crate) row: &'a [R],
}

impl<'a, R: Copy> StepValues<'a, R> {
    /// Divides a row into the numbers that an operation may read and those of its outputs, which are adjacent.
    #[inline(always)]
    pub(super) fn and_outputs(
        parameters: &'a [R],
        row: &'a mut [R],
        outputs: &[Array],
    ) -> (Self, &'a mut [R]) {
        let [start, end] = ends(outputs);
        let (row, after) = row.split_at_mut(start);
        (Self { parameters, row }, &mut after[..end - start])
    }
    /// Returns the parameters or the row, whichever contains the array.
    #[inline(always)]
    pub(super) fn part(self, array: Array) -> &'a [R] {
        if array.parameter {
            self.parameters
        } else {
            self.row
        }
    }
    #[inline(always)]
    pub(crate) fn get(self, array: Array) -> &'a [R] {
        &self.part(array)[array.range()]
    }
    /// Returns `len` numbers from the beginning of an array, without a bounds check.
    ///
    /// # Safety
    /// The numbers must be within a [`Reach`] that was checked.
    #[allow(unsafe_code)] // Bounds checks took a twelfth of a rollout's instructions.
    #[inline(always)]
    pub(super) unsafe fn reached(self, array: Array, len: usize) -> &'a [R] {
        let range = array.start..array.start + len;
        debug_assert!(range.end <= self.part(array).len());
        // SAFETY: guaranteed by the caller.
        unsafe { self.part(array).get_unchecked(range) }
    }
}

/// The positions in the row at which adjacent arrays begin and end.
#[inline(always)]
fn ends(arrays: &[Array]) -> [usize; 2] {
    [arrays[0].start, arrays[arrays.len() - 1].range().end]
}

/// The part of the parameters and of the row that an operation may access. It is checked once for all arrays of the
/// operation, so that single accesses need no bounds checks.
#[derive(Clone, Copy, Default)]
pub(super) struct Reach {
    parameters: usize,
    row: usize,
}

impl Reach {
    /// Creates the reach of an operation from its arrays. Each array comes with the number of elements that the
    /// operation may access, counted from the beginning of the array.
    pub(super) fn new(arrays: impl IntoIterator<Item = (Array, usize)>) -> Self {
        let mut reach = Self::default();
        for (array, len) in arrays {
            let end = if array.parameter {
                &mut reach.parameters
            } else {
                &mut reach.row
            };
            *end = (array.start + len).max(*end);
        }
        reach
    }
    /// # Panics
    /// If the parameters or the row are shorter than the reach.
    #[inline(always)]
    pub(super) fn check<R>(self, parameters: &[R], row: &[R]) {
        let fits = self.parameters <= parameters.len() && self.row <= row.len();
        assert!(
            fits,
            "too few numbers were given: an array reaches past the end of the parameters or of the row of inputs"
        );
    }
}

/// The cotangents ("bars") of a step during a reverse sweep. They have the layout of [`StepValues`].
pub(crate) struct Bars<'a, R> {
    pub(crate) parameters: &'a mut [R],
    pub(crate) row: &'a mut [R],
}

impl<R> Bars<'_, R> {
    /// Divides the cotangents into those that an operation may change and those of its outputs, which are adjacent.
    #[inline(always)]
    pub(super) fn and_outputs(&mut self, outputs: &[Array]) -> (Bars<'_, R>, &[R]) {
        let [start, end] = ends(outputs);
        let (row, after) = self.row.split_at_mut(start);
        let parameters = &mut *self.parameters;
        (Bars { parameters, row }, &after[..end - start])
    }
    #[inline(always)]
    pub(super) fn part_mut(&mut self, array: Array) -> &mut [R] {
        if array.parameter {
            self.parameters
        } else {
            self.row
        }
    }
    #[inline(always)]
    pub(crate) fn get_mut(&mut self, array: Array) -> &mut [R] {
        &mut self.part_mut(array)[array.range()]
    }
}

/// Pointers to the cotangents of a step. A loop looks up each array only once, before it starts. Slices would not work:
/// several mutable slices of the cotangents cannot exist at the same time.
#[derive(Clone, Copy)]
pub(super) struct BarPointers<R> {
    parameters: *mut R,
    row: *mut R,
}

impl<R: Real> BarPointers<R> {
    pub(super) fn new(bars: &mut Bars<R>) -> Self {
        Self {
            parameters: bars.parameters.as_mut_ptr(),
            row: bars.row.as_mut_ptr(),
        }
    }

    /// Returns a pointer to the first cotangent of an array. Use it only while nothing else accesses the cotangents.
    #[inline(always)]
    pub(super) fn of(self, array: Array) -> *mut R {
        let part = if array.parameter {
            self.parameters
        } else {
            self.row
        };
        part.wrapping_add(array.start)
    }

    /// For each input, returns a pointer to its first cotangent; null if the input carries no derivative.
    #[inline(always)]
    pub(super) fn of_active<const I: usize>(
        self,
        inputs: &[Array; I],
        active: &[bool; I],
    ) -> [*mut R; I] {
        let mut places = [null_mut(); I];
        for k in 0..I {
            if active[k] {
                places[k] = self.of(inputs[k]);
            }
        }
        places
    }
}

/// Loads `n` numbers from index `at` on; the other lanes are zero.
///
/// # Safety
/// `from` must point to at least `at + n` numbers, nothing may write to them at the same time, and `n` must be at most
/// `N`.
#[allow(unsafe_code)] // See `BarPointers`.
#[inline(always)]
pub(super) unsafe fn load<R, L: Lane<R>>(from: *const R, at: usize, n: usize) -> L {
    // SAFETY: guaranteed by the caller.
    unsafe { L::load_n(from_raw_parts(from.add(at), n), 0, n) }
}

/// Adds a register to the `n` numbers from index `at` on. Does nothing if the pointer is null.
///
/// # Safety
/// `to` must be null or point to at least `at + n` numbers, nothing else may access them at the same time, and `n` must
/// be at most `N`.
#[allow(unsafe_code)] // See `BarPointers`.
#[inline(always)]
pub(super) unsafe fn add<R, L: Lane<R>>(to: *mut R, at: usize, n: usize, lane: L) {
    if !to.is_null() {
        // SAFETY: guaranteed by the caller.
        let to = unsafe { from_raw_parts_mut(to.add(at), n) };
        unsafe { (L::load_n(to, 0, n) + lane).store_n(to, 0, n) };
    }
}

/// How the rows of consecutive steps lie in memory.
#[derive(Debug, Default)]
pub(crate) struct RowLayout {
    /// The distance from the beginning of one row to the beginning of the next.
    pub(crate) stride: usize,
    /// The length that a step needs, from the beginning of its row to the end of the new state, which is part of the
    /// next row.
    pub(crate) reach: usize,
    /// The parts of the state, with adjacent parts joined.
    pub(crate) state: Vec<Array>,
    /// The copies that move the new state to the next row. Each copy goes from an array of this row to a part of the
    /// state. The list is empty if the operations already write the new state to the next row.
    pub(crate) moves: Vec<(Array, Array)>,
}

impl RowLayout {
    /// Computes the layout from the parts of the state, the new value of each part, and the length of a row.
    ///
    /// Two rows overlap if the new state can also serve as the beginning of the next row. For this, the new values must
    /// be at the end of the row, in the order of the parts of the state.
    pub(crate) fn new(states: &[Array], next: &[Array], row: usize) -> Self {
        let end = states.iter().map(|a| a.start + a.len).max().unwrap_or(0);
        let at = next.first().map_or(row, |a| a.start);
        let in_place =
            |(state, next): (&Array, &Array)| !next.parameter && next.start == at + state.start;
        // Rows must not overlap if there are inputs between the parts of the state: the inputs of the next step would
        // overwrite what lies between the parts of the new state.
        let contiguous = end == states.iter().map(|a| a.len).sum();
        let overlaps =
            contiguous && at >= end && at + end >= row && states.iter().zip(next).all(in_place);
        let stride = if overlaps { at } else { row };
        let moves = if overlaps {
            Vec::new()
        } else {
            next.iter().copied().zip(states.iter().copied()).collect()
        };
        Self {
            stride,
            reach: stride + end,
            state: joined(states),
            moves,
        }
    }
}

/// Joins adjacent arrays.
pub(super) fn joined(arrays: &[Array]) -> Vec<Array> {
    let mut stretches: Vec<Array> = Vec::new();
    for &array in arrays {
        match stretches.last_mut() {
            Some(last) if last.parameter == array.parameter && last.range().end == array.start => {
                last.len += array.len;
            }
            _ => stretches.push(array),
        }
    }
    stretches
}

/// Loads one number for each start (initial state). The numbers repeat, to fill a register. If there are more starts than
/// lanes, the register has those of the first starts.
#[inline(always)]
pub fn each<R: Real, L: Lane<R>>(numbers: &[R], starts: usize) -> L {
    if starts == 1 {
        return L::splat(numbers[0]);
    }
    if starts >= L::N {
        return L::load(numbers);
    }
    if starts == 2 {
        return L::splat(numbers[0]).zip(L::splat(numbers[1]))[0];
    }
    let mut all = [R::zero(); WIDEST];
    for k in 0..L::N {
        all[k] = numbers[k % starts];
    }
    L::load(&all)
}
