//! Where the numbers of a step lie.

use super::Array;

/// The values of a step: those of the parameters, which no step changes, and its row.
#[derive(Clone, Copy)]
pub(super) struct Frame<'a, R> {
    pub(super) parameters: &'a [R],
    pub(super) row: &'a [R],
}

impl<'a, R: Copy> Frame<'a, R> {
    /// The part in which an array lies.
    #[inline(always)]
    pub(super) fn part(self, array: Array) -> &'a [R] {
        if array.parameter {
            self.parameters
        } else {
            self.row
        }
    }
    #[inline(always)]
    pub(super) fn get(self, array: Array) -> &'a [R] {
        &self.part(array)[array.range()]
    }
    /// So many numbers from the start of an array on, without a check.
    ///
    /// # Safety
    /// They are within a [`Reach`] that was checked.
    #[allow(unsafe_code)] // Checks were a twelfth of a rollout's instructions.
    #[inline(always)]
    pub(super) unsafe fn reached(self, array: Array, len: usize) -> &'a [R] {
        let range = array.start..array.start + len;
        debug_assert!(range.end <= self.part(array).len());
        // SAFETY: the caller's promise.
        unsafe { self.part(array).get_unchecked(range) }
    }
}

/// How far the arrays of an operation reach into the two parts. A step that checks this once need
/// not check every array.
#[derive(Clone, Copy, Default)]
pub(super) struct Reach {
    parameters: usize,
    row: usize,
}

impl Reach {
    /// Of so many numbers from the start of each array on.
    pub(super) fn new(arrays: impl IntoIterator<Item = (Array, usize)>) -> Self {
        let mut reach = Self::default();
        for (array, len) in arrays {
            let end = match array.parameter {
                true => &mut reach.parameters,
                false => &mut reach.row,
            };
            *end = (array.start + len).max(*end);
        }
        reach
    }
    /// # Panics
    /// Unless the parts are as long as that.
    #[inline(always)]
    pub(super) fn check<R>(self, parameters: &[R], row: &[R]) {
        let fits = self.parameters <= parameters.len() && self.row <= row.len();
        assert!(fits, "arrays reach beyond the numbers of a step");
    }
}

/// The cotangents ("bars") in a reverse sweep, laid out as the values are.
pub(super) struct Bars<'a, R> {
    pub(super) parameters: &'a mut [R],
    pub(super) row: &'a mut [R],
}

impl<R> Bars<'_, R> {
    #[inline(always)]
    pub(super) fn part(&self, array: Array) -> &[R] {
        if array.parameter {
            self.parameters
        } else {
            self.row
        }
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
    pub(super) fn get_mut(&mut self, array: Array) -> &mut [R] {
        &mut self.part_mut(array)[array.range()]
    }
}

/// How rows follow one another.
#[derive(Debug, Default)]
pub(super) struct Layout {
    /// From the start of a row to that of the next.
    pub(super) stride: usize,
    /// From the start of a row to the end of all that its step touches.
    pub(super) reach: usize,
    /// The state's parts, neighbours joined.
    pub(super) state: Vec<Array>,
    /// Parts of the new state that are not yet where the next row wants them: from where, and the
    /// part's place there.
    pub(super) moves: Vec<(Array, Array)>,
}

impl Layout {
    /// For parts of the state, what they become, and the row's length.
    pub(super) fn new(states: &[Array], next: &[Array], row: usize) -> Self {
        let end = states.iter().map(|a| a.start + a.len).max().unwrap_or(0);
        let at = next.first().map_or(row, |a| a.start);
        let in_place = |(state, next): (&Array, &Array)| next.start == at + state.start;
        let overlaps = at >= end && at + end >= row && states.iter().zip(next).all(in_place);
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

/// The stretches of arrays, those joined that touch.
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
