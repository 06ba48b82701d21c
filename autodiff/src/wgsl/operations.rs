//! Prints the operations of a step, forward and in reverse.

use std::collections::BTreeSet;
use std::fmt::Write;

use super::calls::Called;
use super::formula;
use super::memory::Memory;
use super::writer::{Access, By, Space, Tables, Writer, each};
use crate::arrays::{Array, DenseLayer, Gather, NodeSum, SlotEdge, Weighted};
use crate::record::symbol::Symbol;
use crate::record::{Places, ReplayedKernel};

/// What the printed operations share.
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

/// What is kept of a layer in recent steps.
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

    fn needs_scratch(&mut self, numbers: usize) {
        self.scratch = self.scratch.max(numbers);
    }

    fn edges(&mut self, edges: &[SlotEdge]) -> usize {
        let edges: Vec<[usize; 3]> = edges.iter().map(|e| [e.slot, e.tail, e.head]).collect();
        let known = self.lists_of_edges.iter().position(|known| *known == edges);
        known.unwrap_or_else(|| {
            self.lists_of_edges.push(edges);
            self.lists_of_edges.len() - 1
        })
    }

    /// Adds a function, unless it is there: the reverse sweep repeats the step.
    fn add(&mut self, name: &str, print: impl FnOnce(&str) -> formula::Printed) {
        if self.functions.iter().any(|(known, _)| known == name) {
            return;
        }
        let function = print(name);
        self.functions.push((name.to_owned(), function.text));
        self.calls.extend(function.calls);
    }

    // ---- accesses

    fn read(&self, array: Array, by: By) -> Option<Access> {
        (!array.parameter).then(|| Access {
            space: Space::Row,
            range: array.range(),
            by,
            writes: false,
        })
    }

    fn write(&self, array: Array, by: By) -> Access {
        Access {
            space: Space::Row,
            range: array.range(),
            by,
            writes: true,
        }
    }

    fn bar(&self, array: Array, by: By, writes: bool) -> Access {
        let (space, start) = match array.parameter {
            true => (Space::ParameterBar, self.memory.bar_of_parameter(array)),
            false => (Space::RowBar, array.start),
        };
        Access {
            space,
            range: start..start + array.len,
            by,
            writes,
        }
    }

    fn scratch(&self, by: By, writes: bool) -> Access {
        Access {
            space: Space::Scratch,
            range: 0..usize::MAX,
            by,
            writes,
        }
    }

    // ---- kernels

    /// Prints a kernel that is mapped over elements or edges.
    pub(super) fn kernel(&mut self, number: usize, of: &ReplayedKernel, writer: &mut Writer) {
        let counts = [of.inputs.len(), of.uniforms.len()];
        self.add(&format!("kernel_{number}"), |name| {
            formula::forward(name, &of.kernel, counts)
        });
        let uniforms: Vec<String> = of.uniforms.iter().map(|&u| value(u, "0u")).collect();
        let read = |this: &Self, by, array: &Array| this.read(*array, by);
        let mut accesses: Vec<Access> = of
            .uniforms
            .iter()
            .filter_map(|u| read(self, By::Any, u))
            .collect();
        match &of.places {
            Places::Elements(count) => {
                let x: Vec<String> = of.inputs.iter().map(|&x| value(x, "i")).collect();
                let call = format!(
                    "let y = kernel_{number}({});\n",
                    [x, uniforms].concat().join(", ")
                );
                let store = of.outputs.iter().enumerate();
                let store = store.map(|(k, &y)| format!("{} = y[{k}];\n", place(y, "i")));
                accesses.extend(of.inputs.iter().filter_map(|x| read(self, By::Element, x)));
                accesses.extend(of.outputs.iter().map(|&y| self.write(y, By::Element)));
                writer.stage(
                    accesses,
                    &each(*count, &(call + &store.collect::<String>())),
                );
            }
            Places::Edges {
                edges,
                differences,
                sums,
                ends,
            } => {
                let list = self.edges(edges);
                let by = By::Edge(list);
                let x = self.edge_inputs(of, *differences);
                let head = self.edge_head(list);
                let call = format!(
                    "let y = kernel_{number}({});\n",
                    [x, uniforms].concat().join(", ")
                );
                for (k, &x) in of.inputs.iter().enumerate() {
                    accesses.extend(self.read(x, if k < *differences { By::Any } else { by }));
                }
                let mut body = head + &call;
                for (k, &y) in of.outputs.iter().enumerate() {
                    let to = match sums {
                        true => format!("scratch[{}u + i]", k * edges.len()),
                        false => place(y, "slot"),
                    };
                    let _ = writeln!(body, "{to} = y[{k}];");
                }
                if *sums {
                    self.needs_scratch(of.outputs.len() * edges.len());
                    accesses.push(self.scratch(by, true));
                } else {
                    accesses.extend(of.outputs.iter().map(|&y| self.write(y, by)));
                }
                writer.stage(accesses, &each(edges.len(), &body));
                if *sums {
                    let nodes = of.outputs[0].len;
                    let mut body = self.sum_of_ends(ends, nodes, edges.len(), of.outputs.len());
                    for (k, &y) in of.outputs.iter().enumerate() {
                        let _ = writeln!(body, "{} = sum_{k};", place(y, "i"));
                    }
                    let mut accesses = vec![self.scratch(By::Any, false)];
                    accesses.extend(of.outputs.iter().map(|&y| self.write(y, By::Element)));
                    writer.stage(accesses, &each(nodes, &body));
                }
            }
        }
    }

    /// The lines that look up the slot and the nodes of edge `i`.
    fn edge_head(&mut self, list: usize) -> String {
        let edges = self.lists_of_edges[list].clone();
        let mut text = String::new();
        for (k, name) in ["slot", "tail", "head"].into_iter().enumerate() {
            let numbers = edges.iter().map(|edge| edge[k] as u32).collect();
            let place = self.tables.place(numbers);
            let _ = writeln!(text, "let {name} = table[{place}u + i];");
        }
        text
    }

    fn edge_inputs(&self, of: &ReplayedKernel, differences: usize) -> Vec<String> {
        let input = |(k, &x): (usize, &Array)| match k < differences {
            true => format!("{} - {}", value(x, "head"), value(x, "tail")),
            false => value(x, "slot"),
        };
        of.inputs.iter().enumerate().map(input).collect()
    }

    /// The lines that compute `sum_0, sum_1, ...` at node `i`: numbers of edges that begin there are added, numbers of
    /// edges that end there are subtracted.
    fn sum_of_ends(
        &mut self,
        ends: &[(usize, usize, bool)],
        nodes: usize,
        edges: usize,
        sums: usize,
    ) -> String {
        let mut lists = vec![Vec::new(); nodes];
        for &(node, edge, is_tail) in ends {
            lists[node].push(2 * edge as u32 + u32::from(!is_tail));
        }
        let [bounds, items] = self.tables.lists(&lists);
        let mut text = String::new();
        for k in 0..sums {
            let _ = writeln!(text, "var sum_{k} = 0.0f;");
        }
        let _ = writeln!(
            text,
            "let last = table[{bounds}u + i + 1u];\nfor (var e = table[{bounds}u + i]; e < last; e++) {{\n    \
             let item = table[{items}u + e];\n    let edge = item >> 1u;\n    \
             let sign = select(1.0f, -1.0f, (item & 1u) == 1u);"
        );
        for k in 0..sums {
            let _ = writeln!(
                text,
                "    sum_{k} = fma(sign, scratch[{}u + edge], sum_{k});",
                k * edges
            );
        }
        text + "}\n"
    }

    /// Prints the reverse of [`kernel`](Self::kernel).
    pub(super) fn kernel_reverse(
        &mut self,
        number: usize,
        of: &ReplayedKernel,
        writer: &mut Writer,
    ) {
        let active = |array: &Array| self.memory.is_active(*array);
        let wanted: Vec<bool> = of.inputs.iter().chain(&of.uniforms).map(active).collect();
        if !wanted.contains(&true) {
            return;
        }
        let counts = [of.inputs.len(), of.uniforms.len()];
        let adjoint = |name: &str| formula::adjoint(name, &of.kernel, counts, &wanted);
        self.add(&format!("adjoint_{number}"), adjoint);
        let uniforms: Vec<String> = of.uniforms.iter().map(|&u| value(u, "0u")).collect();
        let of_uniforms = |this: &mut Self, body: &mut String, mut at: usize| {
            for (k, &u) in of.uniforms.iter().enumerate() {
                if wanted[of.inputs.len() + k] {
                    let name = this.collect(u);
                    let _ = writeln!(body, "{name} += x[{at}];");
                    at += 1;
                }
            }
        };
        let mut accesses: Vec<Access> = of
            .uniforms
            .iter()
            .filter_map(|&u| self.read(u, By::Any))
            .collect();
        let inputs = of.inputs.iter().enumerate();
        let wanted_inputs: Vec<(usize, Array)> = inputs
            .filter(|(k, _)| wanted[*k])
            .map(|(k, &x)| (k, x))
            .collect();
        match &of.places {
            Places::Elements(count) => {
                let x = of.inputs.iter().map(|&x| value(x, "i"));
                let b = of.outputs.iter().map(|&y| self.bar_at(y, "i"));
                let arguments: Vec<String> = x.chain(uniforms).chain(b).collect();
                let mut body = format!("let x = adjoint_{number}({});\n", arguments.join(", "));
                for (at, (_, x)) in wanted_inputs.iter().enumerate() {
                    let _ = writeln!(body, "{} += x[{at}];", self.bar_at(*x, "i"));
                }
                of_uniforms(self, &mut body, wanted_inputs.len());
                accesses.extend(of.inputs.iter().filter_map(|&x| self.read(x, By::Element)));
                accesses.extend(of.outputs.iter().map(|&y| self.bar(y, By::Element, false)));
                accesses.extend(
                    wanted_inputs
                        .iter()
                        .map(|(_, x)| self.bar(*x, By::Element, true)),
                );
                writer.stage(accesses, &each(*count, &body));
            }
            Places::Edges {
                edges,
                differences,
                sums,
                ends,
            } => {
                let list = self.edges(edges);
                let by = By::Edge(list);
                let x = self.edge_inputs(of, *differences);
                let b = of.outputs.iter().map(|&y| match sums {
                    true => format!("{} - {}", self.bar_at(y, "tail"), self.bar_at(y, "head")),
                    false => self.bar_at(y, "slot"),
                });
                let arguments: Vec<String> = x.into_iter().chain(uniforms).chain(b).collect();
                let mut body = self.edge_head(list);
                let _ = writeln!(body, "let x = adjoint_{number}({});", arguments.join(", "));
                let mut of_ends = Vec::new();
                for (at, (k, x)) in wanted_inputs.iter().enumerate() {
                    if k < differences {
                        let _ = writeln!(
                            body,
                            "scratch[{}u + i] = x[{at}];",
                            of_ends.len() * edges.len()
                        );
                        of_ends.push(*x);
                    } else {
                        let _ = writeln!(body, "{} += x[{at}];", self.bar_at(*x, "slot"));
                        accesses.push(self.bar(*x, by, true));
                    }
                }
                of_uniforms(self, &mut body, wanted_inputs.len());
                for (k, &x) in of.inputs.iter().enumerate() {
                    accesses.extend(self.read(x, if k < *differences { By::Any } else { by }));
                }
                let by_bars = if *sums { By::Any } else { by };
                accesses.extend(of.outputs.iter().map(|&y| self.bar(y, by_bars, false)));
                if !of_ends.is_empty() {
                    self.needs_scratch(of_ends.len() * edges.len());
                    accesses.push(self.scratch(by, true));
                }
                writer.stage(accesses, &each(edges.len(), &body));
                if !of_ends.is_empty() {
                    let nodes = of_ends[0].len;
                    let mut body = self.sum_of_ends(ends, nodes, edges.len(), of_ends.len());
                    let mut accesses = vec![self.scratch(By::Any, false)];
                    for (k, &x) in of_ends.iter().enumerate() {
                        let _ = writeln!(body, "{} -= sum_{k};", self.bar_at(x, "i"));
                        accesses.push(self.bar(x, By::Element, true));
                    }
                    writer.stage(accesses, &each(nodes, &body));
                }
            }
        }
    }

    /// Returns the variable that collects the cotangent of a uniform input over elements and steps.
    fn collect(&mut self, uniform: Array) -> String {
        let place = self.memory.bar_of_parameter(uniform);
        let known = self.collected.iter().position(|known| *known == place);
        let number = known.unwrap_or_else(|| {
            self.collected.push(place);
            self.collected.len() - 1
        });
        format!("collected_{number}")
    }

    /// The place of the cotangent of an array's element.
    fn bar_at(&self, array: Array, at: &str) -> String {
        match array.parameter {
            true => format!(
                "parameter_bar[{}u + {at}]",
                self.memory.bar_of_parameter(array)
            ),
            false => format!("row_bar[{}u + {at}]", array.start),
        }
    }

    // ---- other operations

    pub(super) fn gather(&mut self, of: &Gather, writer: &mut Writer) {
        let indices = of.indices();
        let list = indices
            .iter()
            .map(|i| i.map_or(u32::MAX, |i| i as u32))
            .collect();
        let table = self.tables.place(list);
        let mut body = format!("let source = table[{table}u + i];\n");
        let _ = match indices.contains(&None) {
            true => writeln!(
                body,
                "{} = 0.0f;\nif (source != 0xffffffffu) {{ {} = {}; }}",
                place(of.output, "i"),
                place(of.output, "i"),
                value(of.input, "source")
            ),
            false => writeln!(
                body,
                "{} = {};",
                place(of.output, "i"),
                value(of.input, "source")
            ),
        };
        let mut accesses: Vec<Access> = self.read(of.input, By::Any).into_iter().collect();
        accesses.push(self.write(of.output, By::Element));
        writer.stage(accesses, &each(indices.len(), &body));
    }

    pub(super) fn gather_reverse(&mut self, of: &Gather, writer: &mut Writer) {
        if !self.memory.is_active(of.input) {
            return;
        }
        let mut copies = vec![Vec::new(); of.input.len];
        for (to, from) in of.indices().into_iter().enumerate() {
            if let Some(from) = from {
                copies[from].push(to as u32);
            }
        }
        let [bounds, items] = self.tables.lists(&copies);
        let body = format!(
            "var sum = 0.0f;\nlet last = table[{bounds}u + i + 1u];\n\
             for (var e = table[{bounds}u + i]; e < last; e++) {{\n    sum += {};\n}}\n{} += sum;\n",
            self.bar_at(of.output, &format!("table[{items}u + e]")),
            self.bar_at(of.input, "i")
        );
        let accesses = vec![
            self.bar(of.output, By::Any, false),
            self.bar(of.input, By::Element, true),
        ];
        writer.stage(accesses, &each(of.input.len, &body));
    }

    pub(super) fn node_sum(&mut self, of: &NodeSum, writer: &mut Writer) {
        let mut lists = vec![Vec::new(); of.output.len];
        for edge in &of.edges {
            lists[edge.tail].push(edge.slot as u32);
            lists[edge.head].push(edge.slot as u32);
        }
        let [bounds, items] = self.tables.lists(&lists);
        let body = format!(
            "var sum = 0.0f;\nlet last = table[{bounds}u + i + 1u];\n\
             for (var e = table[{bounds}u + i]; e < last; e++) {{\n    sum += {};\n}}\n{} = sum;\n",
            value(of.input, &format!("table[{items}u + e]")),
            place(of.output, "i")
        );
        let mut accesses: Vec<Access> = self.read(of.input, By::Any).into_iter().collect();
        accesses.push(self.write(of.output, By::Element));
        writer.stage(accesses, &each(of.output.len, &body));
    }

    pub(super) fn node_sum_reverse(&mut self, of: &NodeSum, writer: &mut Writer) {
        if !self.memory.is_active(of.input) {
            return;
        }
        let list = self.edges(&of.edges);
        let mut body = self.edge_head(list);
        let ends = format!(
            "{} + {}",
            self.bar_at(of.output, "tail"),
            self.bar_at(of.output, "head")
        );
        let _ = writeln!(body, "{} += {ends};", self.bar_at(of.input, "slot"));
        let accesses = vec![
            self.bar(of.output, By::Any, false),
            self.bar(of.input, By::Edge(list), true),
        ];
        writer.stage(accesses, &each(of.edges.len(), &body));
    }

    /// Writes sums over elements: each invocation sums its own elements to scratch, and the first invocations add these up.
    /// `terms` are the terms of each sum at element `i`. After this, `scratch[k * (SIZE + 1) + SIZE]` has sum `k`.
    fn sums(&mut self, count: usize, terms: &[String], accesses: Vec<Access>, writer: &mut Writer) {
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
        let mut accesses = accesses;
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

    pub(super) fn weighted(&mut self, of: &Weighted, writer: &mut Writer) {
        let (count, width) = (of.weights.len, self.size + 1);
        let weight = value(of.weights, "i");
        let weighted = |&x: &Array| format!("{weight} * {}", value(x, "i"));
        let mut terms = vec![weight.clone()];
        terms.extend(of.weighed[..of.offsets].iter().map(weighted));
        let read: Vec<Access> = [of.weights]
            .iter()
            .chain(&of.weighed)
            .filter_map(|&x| self.read(x, By::Element))
            .collect();
        self.sums(count, &terms, read.clone(), writer);
        let sum = |k: usize| format!("scratch[{}u]", k * width + self.size);
        let [all, means, total] = of.outputs;
        let mut body = String::new();
        for (c, &x) in of.weighed.iter().enumerate() {
            let mean = match c < of.offsets {
                true => format!("{} / {}", sum(c + 1), sum(0)),
                false => "0.0f".to_owned(),
            };
            let to = format!("row[{}u + i]", all.start + c * count);
            let _ = writeln!(body, "{to} = {weight} * ({} - {mean});", value(x, "i"));
        }
        let mut text = each(count, &body);
        for k in 0..of.offsets {
            let to = format!("row[{}u]", means.start + k);
            let _ = writeln!(
                text,
                "if (lid == 0u) {{ {to} = {} / {}; }}",
                sum(k + 1),
                sum(0)
            );
        }
        let _ = writeln!(
            text,
            "if (lid == 0u) {{ row[{}u] = {}; }}",
            total.start,
            sum(0)
        );
        let mut accesses = read;
        let mut from = all.start + of.weighed.len() * count;
        for &other in &of.others {
            text += &each(
                other.len,
                &format!("row[{from}u + i] = {};", value(other, "i")),
            );
            from += other.len;
            accesses.extend(self.read(other, By::Element));
        }
        accesses.push(self.scratch(By::Any, false));
        accesses.extend(of.outputs.map(|y| self.write(y, By::Any)));
        writer.stage(accesses, &text);
    }

    /// See the reverse of [`Weighted`].
    pub(super) fn weighted_reverse(&mut self, of: &Weighted, writer: &mut Writer) {
        let (count, width) = (of.weights.len, self.size + 1);
        let weight = value(of.weights, "i");
        let [all, means, total] = of.outputs;
        let y_bar = |c: usize| format!("row_bar[{}u + i]", all.start + c * count);
        let terms: Vec<String> = (0..of.offsets)
            .map(|c| format!("{weight} * {}", y_bar(c)))
            .collect();
        let mut read: Vec<Access> = [of.weights]
            .iter()
            .chain(&of.weighed)
            .filter_map(|&x| self.read(x, By::Element))
            .collect();
        read.extend(of.outputs.map(|y| self.bar(y, By::Any, false)));
        read.extend(of.outputs.iter().filter_map(|&y| self.read(y, By::Any)));
        if !terms.is_empty() {
            self.sums(count, &terms, read.clone(), writer);
        }
        let of_weights = self.memory.is_active(of.weights);
        let mut accesses = read;
        let mut body = String::from("var of_weight = 0.0f;\nvar rest = 0.0f;\n");
        for (c, &x) in of.weighed.iter().enumerate() {
            let (mut shift, mut mean) = ("0.0f".to_owned(), "0.0f".to_owned());
            if c < of.offsets {
                let sum = format!("scratch[{}u]", c * width + self.size);
                let mean_bar = format!("row_bar[{}u]", means.start + c);
                shift = format!("({sum} - {mean_bar}) / row[{}u]", total.start);
                mean = format!("row[{}u]", means.start + c);
            }
            let _ = writeln!(body, "rest = {} - {shift};", y_bar(c));
            if self.memory.is_active(x) {
                let _ = writeln!(body, "{} += {weight} * rest;", self.bar_at(x, "i"));
                accesses.push(self.bar(x, By::Element, true));
            }
            let _ = writeln!(
                body,
                "of_weight = fma(rest, {} - {mean}, of_weight);",
                value(x, "i")
            );
        }
        if of_weights {
            let _ = writeln!(body, "{} += of_weight;", self.bar_at(of.weights, "i"));
            accesses.push(self.bar(of.weights, By::Element, true));
        }
        let mut text = each(count, &body);
        let mut from = all.start + of.weighed.len() * count;
        for &other in &of.others {
            if self.memory.is_active(other) {
                let add = format!("{} += row_bar[{from}u + i];", self.bar_at(other, "i"));
                text += &each(other.len, &add);
                accesses.push(self.bar(other, By::Element, true));
            }
            from += other.len;
        }
        accesses.push(self.scratch(By::Any, false));
        writer.stage(accesses, &text);
    }

    /// Prints a dense layer. Several invocations share a row if there are more than rows: each sums a part of the columns.
    pub(super) fn dense(&mut self, of: &DenseLayer<Symbol>, writer: &mut Writer) {
        let [rows, columns] = [of.matrix.rows, of.matrix.columns];
        let parts = (self.size / rows.max(1)).clamp(1, columns.max(1));
        let matrix = self.memory.matrix(of.matrix.parameter);
        let accesses: Vec<Access> = of
            .inputs
            .iter()
            .filter_map(|&x| self.read(x, By::Any))
            .collect();
        let start = self.memory.matrix_at(of.matrix.parameter);
        let products = |of_part: &str, step: usize| {
            let (mut text, mut before) = (String::new(), 0);
            for &x in &of.inputs {
                // Part `p` has the columns `p, p + parts, ...` of each input.
                let _ = writeln!(
                    text,
                    "for (var c = {of_part}; c < {}u; c += {step}u) {{\n    \
                     sum = fma({matrix}[{start} + (c + {before}u) * {rows}u + r], {}, sum);\n}}",
                    x.len,
                    value(x, "c")
                );
                before += x.len;
            }
            text
        };
        let activated = |sum: &str| match of.tanh {
            true => format!("tanh_of({sum})"),
            false => sum.to_owned(),
        };
        let places = of.places();
        let to = match places.iter().enumerate().all(|(row, &place)| row == place) {
            true => place(of.output, "i"),
            false => {
                let table = self
                    .tables
                    .place(places.iter().map(|&at| at as u32).collect());
                place(of.output, &format!("table[{table}u + i]"))
            }
        };
        self.calls.insert(Called::Basic("tanh_of"));
        let bias = value(of.bias, "i");
        let reads_bias = self.read(of.bias, By::Any);
        if parts == 1 {
            let body = format!(
                "let r = i;\nvar sum = {bias};\n{}{to} = {};\n",
                products("0u", 1),
                activated("sum")
            );
            let mut accesses = accesses;
            accesses.extend(reads_bias);
            accesses.push(self.write(of.output, By::Any));
            writer.stage(accesses, &each(rows, &body));
            return;
        }
        self.needs_scratch(parts * rows);
        let body = format!(
            "let r = i % {rows}u;\nlet part = i / {rows}u;\nvar sum = 0.0f;\n{}scratch[i] = sum;\n",
            products("part", parts)
        );
        let mut accesses = accesses;
        accesses.push(self.scratch(By::Any, true));
        writer.stage(accesses, &each(parts * rows, &body));
        let body = format!(
            "var sum = {bias};\nfor (var part = 0u; part < {parts}u; part++) {{\n    \
             sum += scratch[part * {rows}u + i];\n}}\n{to} = {};\n",
            activated("sum")
        );
        let mut accesses = vec![self.scratch(By::Any, false), self.write(of.output, By::Any)];
        accesses.extend(reads_bias);
        writer.stage(accesses, &each(rows, &body));
    }

    pub(super) fn dense_reverse(&mut self, of: &DenseLayer<Symbol>, writer: &mut Writer) {
        let [rows, columns] = [of.matrix.rows, of.matrix.columns];
        let of_inputs = of
            .inputs_active
            .iter()
            .any(|&id| self.memory.is_active_id(id));
        let of_matrix = self.memory.is_wanted(of.matrix.parameter);
        let of_bias = self.memory.is_active(of.bias);
        if !(of_inputs || of_matrix || of_bias) {
            return;
        }
        let places = of.places();
        let at = match places.iter().enumerate().all(|(row, &place)| row == place) {
            true => "i".to_owned(),
            false => {
                let table = self
                    .tables
                    .place(places.iter().map(|&at| at as u32).collect());
                format!("table[{table}u + i]")
            }
        };
        // 1. The cotangents before the activation.
        let first = self.kept();
        let (bar, kept) = (self.bar_at(of.output, "at"), of_matrix);
        let slope = match of.tanh {
            true => format!(
                "let y = {};\nlet bar = fma(-y, y, 1.0f) * {bar};\n",
                value(of.output, "at")
            ),
            false => format!("let bar = {bar};\n"),
        };
        let mut body = format!("let at = {at};\n{slope}scratch[i] = bar;\n");
        let mut accesses = vec![
            self.scratch(By::Element, true),
            self.bar(of.output, By::Any, false),
        ];
        accesses.extend(self.read(of.output, By::Any));
        if of_bias {
            let _ = writeln!(body, "{} += bar;", self.bar_at(of.bias, "i"));
            accesses.push(self.bar(of.bias, By::Element, true));
        }
        let mut text = String::new();
        if kept {
            let _ = writeln!(body, "kept[kept_at + {first}u + i] = bar;");
            accesses.push(Access {
                space: Space::Kept,
                range: 0..usize::MAX,
                by: By::Any,
                writes: true,
            });
        }
        text += &each(rows, &body);
        if kept {
            let mut from = first + rows;
            for &x in &of.inputs {
                text += &each(
                    x.len,
                    &format!("kept[kept_at + {from}u + i] = {};", value(x, "i")),
                );
                from += x.len;
                accesses.extend(self.read(x, By::Any));
            }
            self.layers.push(Kept {
                matrix: of.matrix.parameter,
                rows,
                columns,
                first,
            });
        }
        self.needs_scratch(rows);
        writer.stage(accesses, &text);
        // 2. The cotangents of the inputs.
        if of_inputs {
            let matrix = self.memory.matrix(of.matrix.parameter);
            let start = self.memory.matrix_at(of.matrix.parameter);
            let (mut text, mut before) = (String::new(), 0);
            let mut accesses = vec![self.scratch(By::Any, false)];
            for &x in &of.inputs {
                let body = format!(
                    "var sum = 0.0f;\nlet column = {start} + (i + {before}u) * {rows}u;\n\
                     for (var r = 0u; r < {rows}u; r++) {{\n    sum = fma({matrix}[column + r], scratch[r], sum);\n}}\n\
                     {} += sum;\n",
                    self.bar_at(x, "i")
                );
                before += x.len;
                if self.memory.is_active(x) {
                    text += &each(x.len, &body);
                    accesses.push(self.bar(x, By::Element, true));
                }
            }
            writer.stage(accesses, &text);
        }
    }
}

/// The expression that reads an array's element.
pub(super) fn value(array: Array, at: &str) -> String {
    match array.parameter {
        true => format!("parameter[{}u + {at}]", array.start),
        false => format!("row[{}u + {at}]", array.start),
    }
}

/// The place of an element of an array of the row.
fn place(array: Array, at: &str) -> String {
    format!("row[{}u + {at}]", array.start)
}
