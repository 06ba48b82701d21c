//! Finds out which inputs the outputs of a recording depend on.

use super::arena::Arena;
use super::index::NONE;
use crate::real::Real;

/// A backward search through the entries. For each output it visits each entry at most once.
pub(super) struct Dependence<'a, R: Real> {
    arena: &'a Arena<R>,
    inputs: usize,
    /// For each entry, the number of the last search that has visited it. Searches are counted from 1.
    visited: Vec<u32>,
    searches: u32,
    pending: Vec<u32>,
}

impl<'a, R: Real> Dependence<'a, R> {
    pub(super) fn new(arena: &'a Arena<R>, inputs: usize) -> Self {
        Self {
            arena,
            inputs,
            visited: vec![0; arena.entries.len()],
            searches: 0,
            pending: Vec::new(),
        }
    }

    /// Returns the inputs that entry `output` depends on, in ascending order. Inputs with a zero derivative are
    /// included.
    pub(super) fn of(&mut self, output: u32) -> Vec<usize> {
        self.searches += 1;
        let mut found = Vec::new();
        self.visit(output);
        while let Some(at) = self.pending.pop() {
            let at = at as usize;
            if at < self.inputs {
                found.push(at);
                continue;
            }
            let arena = self.arena;
            arena.each_parent(at, |parent| self.visit(parent));
        }
        found.sort_unstable();
        found
    }

    fn visit(&mut self, entry: u32) {
        if entry == NONE || self.visited[entry as usize] == self.searches {
            return;
        }
        self.visited[entry as usize] = self.searches;
        self.pending.push(entry);
    }
}
