//! What the printed operations share: the functions, tables and memory that they need, and their accesses.

use std::collections::BTreeSet;
use std::fmt::Write;

use autodiff_programs::Array;
use autodiff_programs::internal::SlotEdge;

use super::calls::Called;
use super::formula;
use super::memory::Memory;
use super::writer::{Access, By, Space, Tables, Writer, each};

/// The printed parts of a program, and what they share.
pub(super) struct Printing<'a> {
    pub(super) memory: &'a Memory,
    pub(super) tables: Tables,
    /// The lists of edges that occur, as slot, tail and head.
    lists_of_edges: Vec<Vec<[usize; 3]>>,
    /// The names and texts of the functions of kernels.
    pub(super) functions: Vec<(String, String)>,
    pub(super) calls: BTreeSet<Called>,
    /// Numbers of scratch that the operations need.
    pub(super) scratch: usize,
    /// The number of invocations of a workgroup.
    pub(super) size: usize,
    /// Variables of an invocation that collect cotangents of uniform inputs over the steps: the parameter's place among
    /// the cotangents.
    pub(super) collected: Vec<usize>,
    /// The numbers of the layers, for the cotangents of their matrices.
    pub(super) layers: Vec<Kept>,
}

/// Where the numbers of a layer lie that the reverse sweep keeps for a few steps.
pub(super) struct Kept {
    pub(super) matrix: usize,
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// The place of the first number in a step's part of the kept numbers: the cotangents of the rows, then the inputs.
    pub(super) first: usize,
}

impl<'a> Printing<'a> {
    pub(super) fn new(memory: &'a Memory, size: usize) -> Self {
        Self {
            memory,
            tables: Tables::default(),
            lists_of_edges: Vec::new(),
            functions: Vec::new(),
            calls: BTreeSet::new(),
            scratch: 0,
            size,
            collected: Vec::new(),
            layers: Vec::new(),
        }
    }

    /// How many numbers of a step are kept for the layers.
    pub(super) fn kept(&self) -> usize {
        self.layers
            .iter()
            .map(|layer| layer.rows + layer.columns)
            .sum()
    }

    pub(super) fn needs_scratch(&mut self, numbers: usize) {
        self.scratch = self.scratch.max(numbers);
    }

    pub(super) fn edges(&mut self, edges: &[SlotEdge]) -> usize {
        let edges: Vec<[usize; 3]> = edges.iter().map(|e| [e.slot, e.tail, e.head]).collect();
        let known = self.lists_of_edges.iter().position(|known| *known == edges);
        known.unwrap_or_else(|| {
            self.lists_of_edges.push(edges);
            self.lists_of_edges.len() - 1
        })
    }

    /// Adds a function, unless it is there: the reverse sweep repeats the step.
    pub(super) fn add(&mut self, name: &str, print: impl FnOnce(&str) -> formula::Function) {
        if self.functions.iter().any(|(known, _)| known == name) {
            return;
        }
        let function = print(name);
        self.functions.push((name.to_owned(), function.text));
        self.calls.extend(function.calls);
    }

    pub(super) fn read(&self, array: Array, by: By) -> Option<Access> {
        (!array.is_parameter()).then(|| Access::new(Space::Row, array.range(), by, false))
    }

    pub(super) fn write(&self, array: Array, by: By) -> Access {
        Access::new(Space::Row, array.range(), by, true)
    }

    pub(super) fn bar(&self, array: Array, by: By, writes: bool) -> Access {
        let (space, start) = match array.is_parameter() {
            true => (Space::ParameterBar, self.memory.bar_of_parameter(array)),
            false => (Space::RowBar, array.start()),
        };
        Access::new(space, start..start + array.len(), by, writes)
    }

    pub(super) fn scratch(&self, by: By, writes: bool) -> Access {
        Access::new(Space::Scratch, 0..usize::MAX, by, writes)
    }

    /// The accesses to the arrays of these that lie in the row.
    pub(super) fn reads<'b>(
        &self,
        arrays: impl IntoIterator<Item = &'b Array>,
        by: By,
    ) -> Vec<Access> {
        arrays
            .into_iter()
            .filter_map(|&array| self.read(array, by))
            .collect()
    }

    /// The lines that look up the slot and the nodes of edge `i`.
    pub(super) fn edge_head(&mut self, list: usize) -> String {
        let edges = self.lists_of_edges[list].clone();
        let mut text = String::new();
        for (k, name) in ["slot", "tail", "head"].into_iter().enumerate() {
            let numbers = edges.iter().map(|edge| edge[k] as u32).collect();
            let place = self.tables.place(numbers);
            let _ = writeln!(text, "let {name} = table[{place}u + i];");
        }
        text
    }

    /// The index at which number `i` of a list of places lies.
    pub(super) fn index(&mut self, places: &[usize]) -> String {
        if places.iter().enumerate().all(|(k, &place)| k == place) {
            return "i".to_owned();
        }
        let table = self
            .tables
            .place(places.iter().map(|&at| at as u32).collect());
        format!("table[{table}u + i]")
    }

    /// Returns the variable that collects the cotangent of a uniform input over elements and steps.
    pub(super) fn collect(&mut self, uniform: Array) -> String {
        let place = self.memory.bar_of_parameter(uniform);
        let known = self.collected.iter().position(|known| *known == place);
        let number = known.unwrap_or_else(|| {
            self.collected.push(place);
            self.collected.len() - 1
        });
        format!("collected_{number}")
    }

    /// The place of the cotangent of an array's element.
    pub(super) fn bar_at(&self, array: Array, at: &str) -> String {
        match array.is_parameter() {
            true => format!(
                "parameter_bar[{}u + {at}]",
                self.memory.bar_of_parameter(array)
            ),
            false => format!("row_bar[{}u + {at}]", array.start()),
        }
    }

    /// Writes sums over elements: each invocation sums its own elements to scratch, and the first invocations add these up.
    /// `terms` are the terms of each sum at element `i`. After this, `scratch[k * (SIZE + 1) + SIZE]` has sum `k`.
    pub(super) fn sums(
        &mut self,
        writer: &mut Writer,
        count: usize,
        terms: &[String],
        mut accesses: Vec<Access>,
    ) {
        let width = self.size + 1;
        self.needs_scratch(terms.len() * width);
        let mut body = String::new();
        for k in 0..terms.len() {
            let _ = writeln!(body, "var part_{k} = 0.0f;");
        }
        let adds = terms.iter().enumerate();
        let adds = adds
            .map(|(k, term)| format!("part_{k} += {term};\n"))
            .collect::<String>();
        body += &each(count, &adds);
        for k in 0..terms.len() {
            let _ = writeln!(body, "scratch[{}u + lid] = part_{k};", k * width);
        }
        accesses.push(self.scratch(By::Any, true));
        writer.stage(accesses, &format!("{{\n{body}}}\n"));
        let used = count.min(self.size);
        let body = format!(
            "var sum = 0.0f;\nfor (var k = 0u; k < {used}u; k++) {{\n    sum += scratch[i * {width}u + k];\n}}\n\
             scratch[i * {width}u + {}u] = sum;\n",
            self.size
        );
        writer.stage(vec![self.scratch(By::Any, true)], &each(terms.len(), &body));
    }
}

/// The beginning of the expressions for the elements of an array.
pub(super) fn start_of(array: Array) -> String {
    match array.is_parameter() {
        true => format!("parameter[{}u", array.start()),
        false => format!("row[{}u", array.start()),
    }
}

/// The expression that reads an array's element.
pub(super) fn value(array: Array, at: &str) -> String {
    format!("{} + {at}]", start_of(array))
}

/// The place of an element of an array of the row.
pub(super) fn place(array: Array, at: &str) -> String {
    format!("row[{}u + {at}]", array.start())
}
