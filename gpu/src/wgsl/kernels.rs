//! Prints kernels that are mapped over elements or edges.

use std::fmt::Write;

use autodiff_programs::Array;
use autodiff_programs::internal::{Places, ReplayedKernel, SlotEdge};

use super::formula;
use super::printing::{Printing, place, value};
use super::writer::{Access, By, Writer, each};

/// The edges over which a kernel is mapped.
struct Edges<'a> {
    edges: &'a [SlotEdge],
    /// The number of inputs that are differences of node values. They come first.
    differences: usize,
    /// The ends of all edges, as in [`Places::Edges`].
    ends: &'a [(usize, usize, bool)],
    /// Whether results are summed at the nodes.
    sums: bool,
    /// The number of the list of edges.
    list: usize,
}

impl Edges<'_> {
    /// Which invocation reads an input, by its number.
    fn by(&self, input: usize) -> By {
        match input < self.differences {
            true => By::Any,
            false => By::Edge(self.list),
        }
    }

    /// The expression of an input at an edge.
    fn input(&self, (number, &array): (usize, &Array)) -> String {
        match number < self.differences {
            true => format!("{} - {}", value(array, "head"), value(array, "tail")),
            false => value(array, "slot"),
        }
    }

    /// The place in scratch of number `k` of edge `edge`.
    fn scratch(&self, k: usize, edge: &str) -> String {
        format!("scratch[{}u + {edge}]", k * self.edges.len())
    }

    /// Writes the stage after the one that has stored `count` numbers of each edge in scratch: at each node, the numbers
    /// of edges that begin there are added, and those of edges that end there subtracted. `store` are the lines that read
    /// the sums `sum_0, sum_1, ...` of node `i`.
    fn sum_at_ends(
        &self,
        p: &mut Printing,
        writer: &mut Writer,
        (nodes, count): (usize, usize),
        (store, stores): (&str, Vec<Access>),
    ) {
        let mut lists = vec![Vec::new(); nodes];
        for &(node, edge, is_tail) in self.ends {
            lists[node].push(2 * edge as u32 + u32::from(!is_tail));
        }
        let mut body = String::new();
        for k in 0..count {
            let _ = writeln!(body, "var sum_{k} = 0.0f;");
        }
        body += &p.tables.lists(&lists).each_item(|item| {
            let mut text = format!(
                "let item = {item};\nlet edge = item >> 1u;\nlet sign = select(1.0f, -1.0f, (item & 1u) == 1u);\n"
            );
            for k in 0..count {
                let _ = writeln!(text, "sum_{k} = fma(sign, {}, sum_{k});", self.scratch(k, "edge"));
            }
            text
        });
        body += store;
        let mut accesses = vec![p.scratch(By::Any, false)];
        accesses.extend(stores);
        writer.stage(accesses, &each(nodes, &body));
    }
}

/// The edges of a kernel; `None` if it is mapped over elements.
fn edges<'a>(p: &mut Printing, of: &'a ReplayedKernel) -> Option<Edges<'a>> {
    match &of.places {
        Places::Elements(_) => None,
        Places::Edges {
            edges,
            differences,
            sums,
            ends,
        } => Some(Edges {
            edges,
            differences: *differences,
            ends,
            sums: *sums,
            list: p.edges(edges),
        }),
    }
}

/// A stage that calls a kernel or its adjoint.
struct Call {
    /// The number of elements or edges.
    count: usize,
    /// The lines before the call.
    head: String,
    /// The arguments: the inputs, then the uniform inputs.
    arguments: Vec<String>,
    /// The accesses to the arguments.
    accesses: Vec<Access>,
}

impl Call {
    fn new(p: &mut Printing, of: &ReplayedKernel, edges: Option<&Edges>) -> Self {
        let inputs = of.inputs.iter().enumerate();
        let by = |k| edges.map_or(By::Element, |edges| edges.by(k));
        let mut accesses = p.reads(&of.uniforms, By::Any);
        accesses.extend(inputs.clone().filter_map(|(k, &x)| p.read(x, by(k))));
        let x = inputs.map(|(k, x)| match edges {
            None => value(*x, "i"),
            Some(edges) => edges.input((k, x)),
        });
        let uniforms = of.uniforms.iter().map(|&u| value(u, "0u"));
        Self {
            count: edges.map_or(of.outputs[0].len(), |edges| edges.edges.len()),
            arguments: x.chain(uniforms).collect(),
            head: edges.map_or_else(String::new, |edges| p.edge_head(edges.list)),
            accesses,
        }
    }

    /// Makes the cotangents of these outputs further arguments.
    fn take_bars(&mut self, p: &Printing, outputs: &[Array], edges: Option<&Edges>) {
        for &y in outputs {
            let (bar, by) = match edges {
                None => (p.bar_at(y, "i"), By::Element),
                Some(edges) if edges.sums => {
                    let [tail, head] = ["tail", "head"].map(|end| p.bar_at(y, end));
                    (format!("{tail} - {head}"), By::Any)
                }
                Some(edges) => (p.bar_at(y, "slot"), By::Edge(edges.list)),
            };
            self.arguments.push(bar);
            self.accesses.push(p.bar(y, by, false));
        }
    }

    /// The lines that call a function; its result is `result`.
    fn text(&self, result: &str, function: &str) -> String {
        format!(
            "{}let {result} = {function}({});\n",
            self.head,
            self.arguments.join(", ")
        )
    }
}

/// Prints a kernel.
pub(super) fn forward(p: &mut Printing, writer: &mut Writer, number: usize, of: &ReplayedKernel) {
    let name = format!("kernel_{number}");
    p.add(&name, |name| formula::forward(name, of));
    let edges = edges(p, of);
    let mut call = Call::new(p, of, edges.as_ref());
    let mut body = call.text("y", &name);
    let outputs = of.outputs.iter().enumerate();
    let summed = edges.as_ref().filter(|edges| edges.sums);
    for (k, &y) in outputs.clone() {
        let (to, by) = match (&edges, summed) {
            (_, Some(edges)) => (edges.scratch(k, "i"), None),
            (Some(edges), None) => (place(y, "slot"), Some(By::Edge(edges.list))),
            (None, None) => (place(y, "i"), Some(By::Element)),
        };
        let _ = writeln!(body, "{to} = y[{k}];");
        call.accesses.extend(by.map(|by| p.write(y, by)));
    }
    if let Some(edges) = summed {
        p.needs_scratch(of.outputs.len() * call.count);
        call.accesses.push(p.scratch(By::Edge(edges.list), true));
    }
    writer.stage(call.accesses, &each(call.count, &body));
    if let Some(edges) = summed {
        let store: String = outputs
            .map(|(k, &y)| format!("{} = sum_{k};\n", place(y, "i")))
            .collect();
        let stores = of
            .outputs
            .iter()
            .map(|&y| p.write(y, By::Element))
            .collect();
        let size = (of.outputs[0].len(), of.outputs.len());
        edges.sum_at_ends(p, writer, size, (&store, stores));
    }
}

/// Prints the reverse of a kernel.
pub(super) fn reverse(p: &mut Printing, writer: &mut Writer, number: usize, of: &ReplayedKernel) {
    let wanted = of.inputs.iter().chain(&of.uniforms);
    let wanted: Vec<bool> = wanted.map(|&array| p.memory.is_active(array)).collect();
    if !wanted.contains(&true) {
        return;
    }
    let name = format!("adjoint_{number}");
    p.add(&name, |name| formula::adjoint(name, of, &wanted));
    let edges = edges(p, of);
    let mut call = Call::new(p, of, edges.as_ref());
    call.take_bars(p, &of.outputs, edges.as_ref());
    let mut body = call.text("x", &name);
    // The differences whose cotangents are summed at the nodes.
    let mut of_ends = Vec::new();
    let all = of.inputs.iter().chain(&of.uniforms).enumerate();
    for (at, (k, &x)) in all.filter(|(k, _)| wanted[*k]).enumerate() {
        let to = match &edges {
            _ if k >= of.inputs.len() => p.collect(x),
            Some(edges) if k < edges.differences => {
                of_ends.push(x);
                let _ = writeln!(body, "{} = x[{at}];", edges.scratch(of_ends.len() - 1, "i"));
                continue;
            }
            Some(edges) => {
                call.accesses.push(p.bar(x, By::Edge(edges.list), true));
                p.bar_at(x, "slot")
            }
            None => {
                call.accesses.push(p.bar(x, By::Element, true));
                p.bar_at(x, "i")
            }
        };
        let _ = writeln!(body, "{to} += x[{at}];");
    }
    let summed = edges.filter(|_| !of_ends.is_empty());
    if let Some(edges) = &summed {
        p.needs_scratch(of_ends.len() * call.count);
        call.accesses.push(p.scratch(By::Edge(edges.list), true));
    }
    writer.stage(call.accesses, &each(call.count, &body));
    if let Some(edges) = summed {
        let subtract = |(k, &x): (usize, &Array)| format!("{} -= sum_{k};\n", p.bar_at(x, "i"));
        let store: String = of_ends.iter().enumerate().map(subtract).collect();
        let stores = of_ends
            .iter()
            .map(|&x| p.bar(x, By::Element, true))
            .collect();
        edges.sum_at_ends(
            p,
            writer,
            (of_ends[0].len(), of_ends.len()),
            (&store, stores),
        );
    }
}
