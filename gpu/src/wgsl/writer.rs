//! Writes the stages of a step: loops over elements, with barriers where one invocation reads what another has written.

use std::collections::HashMap;
use std::ops::Range;

/// The memory that the invocations of a workgroup share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Space {
    /// The numbers of the step.
    Row,
    /// The cotangents of these numbers.
    RowBar,
    /// The cotangents of the parameters.
    ParameterBar,
    /// Numbers that are only used within an operation.
    Scratch,
    /// The inputs and cotangents of layers in recent steps.
    Kept,
}

/// Which invocation accesses an element of a range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum By {
    /// Element `i` of the range belongs to invocation `i` modulo the size of the workgroup.
    Element,
    /// The element belongs to the invocation of its edge, in the list of edges with this number.
    Edge(usize),
    /// Any.
    Any,
}

#[derive(Clone, Debug)]
pub(super) struct Access {
    space: Space,
    range: Range<usize>,
    by: By,
    writes: bool,
}

impl Access {
    pub(super) fn new(space: Space, range: Range<usize>, by: By, writes: bool) -> Self {
        Self {
            space,
            range,
            by,
            writes,
        }
    }

    /// Whether the two accesses need a barrier between them.
    fn conflicts(&self, other: &Self) -> bool {
        let (a, b) = (&self.range, &other.range);
        let meet = self.space == other.space && a.start < b.end && b.start < a.end;
        // Elements of different ranges belong to different invocations, unless the ranges begin alike.
        let same = self.by == other.by
            && match self.by {
                By::Element => a.start == b.start,
                By::Edge(_) => true,
                By::Any => false,
            };
        meet && (self.writes || other.writes) && !same
    }
}

/// The text of a loop over steps, as it is written.
#[derive(Debug, Default)]
pub(super) struct Writer {
    pub(super) text: String,
    /// The accesses since the last barrier.
    since: Vec<Access>,
}

impl Writer {
    /// Writes a stage, after a barrier if one is needed.
    pub(super) fn stage(&mut self, accesses: Vec<Access>, body: &str) {
        let conflict = |access: &Access| self.since.iter().any(|before| before.conflicts(access));
        if accesses.iter().any(conflict) {
            self.barrier();
        }
        self.since.extend(accesses);
        self.text.push_str(body);
    }

    pub(super) fn barrier(&mut self) {
        self.text.push_str("workgroupBarrier();\n");
        self.since.clear();
    }
}

/// A loop in which each invocation takes every element whose index is its own, modulo the size of the workgroup.
pub(super) fn each(count: usize, body: &str) -> String {
    block(&format!("for (var i = lid; i < {count}u; i += SIZE)"), body)
}

/// A block: its head, such as `if (x > 0u)`, and the lines in its braces.
pub(super) fn block(head: &str, body: &str) -> String {
    format!("{head} {{\n{}}}\n", indented(body))
}

/// The lists of whole numbers that a printed program reads, one after the other.
#[derive(Debug, Default)]
pub(super) struct Tables {
    pub(super) numbers: Vec<u32>,
    places: HashMap<Vec<u32>, usize>,
}

impl Tables {
    /// Returns the place of a list, which is stored once.
    pub(super) fn place(&mut self, list: Vec<u32>) -> usize {
        let Self { numbers, places } = self;
        *places.entry(list).or_insert_with_key(|list| {
            numbers.extend(list);
            numbers.len() - list.len()
        })
    }

    /// Stores lists of different lengths.
    pub(super) fn lists(&mut self, lists: &[Vec<u32>]) -> Lists {
        let ends = lists.iter().scan(0, |end, list| {
            *end += list.len() as u32;
            Some(*end)
        });
        let bounds = std::iter::once(0).chain(ends).collect();
        Lists {
            bounds: self.place(bounds),
            items: self.place(lists.concat()),
        }
    }
}

/// Stored lists: the place of their bounds, one more than there are lists, and the place of their items.
#[derive(Clone, Copy)]
pub(super) struct Lists {
    bounds: usize,
    items: usize,
}

impl Lists {
    /// The lines of a loop over the items of list `i`. `body` gets the expression of an item.
    pub(super) fn each_item(self, body: impl FnOnce(&str) -> String) -> String {
        let Self { bounds, items } = self;
        let head = format!(
            "let last = table[{bounds}u + i + 1u];\nfor (var e = table[{bounds}u + i]; e < last; e++)"
        );
        block(&head, &body(&format!("table[{items}u + e]")))
    }
}

/// Indents every line of a text.
fn indented(text: &str) -> String {
    text.lines().map(|line| format!("    {line}\n")).collect()
}
