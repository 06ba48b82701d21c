//! Where the numbers of a step lie.

use super::Array;

/// The values of a step: those of the parameters, which no step changes, and its row.
#[derive(Clone, Copy)]
pub(super) struct Frame<'a, R> {
    pub(super) parameters: &'a [R],
    pub(super) row: &'a [R],
}

impl<'a, R> Frame<'a, R> {
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
