//! Prints operations that copy and sum: gathers, sums at nodes, and weighted arrays.

use std::fmt::Write;

use autodiff_programs::Array;
use autodiff_programs::internal::{AddedOperation, Gather, NodeSum};

use super::printing::{Printing, place, value};
use super::writer::{By, Writer, each};

/// Prints a gather.
pub(super) fn gather(p: &mut Printing, writer: &mut Writer, of: &Gather) {
    let indices = of.indices();
    let list = indices
        .iter()
        .map(|i| i.map_or(u32::MAX, |i| i as u32))
        .collect();
    let table = p.tables.place(list);
    let (to, from) = (place(of.output, "i"), value(of.input, "source"));
    let body = match indices.contains(&None) {
        true => format!("{to} = 0.0f;\nif (source != 0xffffffffu) {{ {to} = {from}; }}"),
        false => format!("{to} = {from};"),
    };
    let body = format!("let source = table[{table}u + i];\n{body}\n");
    let mut accesses = p.reads([&of.input], By::Any);
    accesses.push(p.write(of.output, By::Element));
    writer.stage(accesses, &each(indices.len(), &body));
}

/// Prints the reverse of a gather.
pub(super) fn gather_reverse(p: &mut Printing, writer: &mut Writer, of: &Gather) {
    if !p.memory.is_active(of.input) {
        return;
    }
    let mut copies = vec![Vec::new(); of.input.len()];
    for (to, from) in of.indices().into_iter().enumerate() {
        if let Some(from) = from {
            copies[from].push(to as u32);
        }
    }
    let sum = p
        .tables
        .lists(&copies)
        .each_item(|item| format!("sum += {};", p.bar_at(of.output, item)));
    let body = format!(
        "var sum = 0.0f;\n{sum}{} += sum;\n",
        p.bar_at(of.input, "i")
    );
    let accesses = vec![
        p.bar(of.output, By::Any, false),
        p.bar(of.input, By::Element, true),
    ];
    writer.stage(accesses, &each(of.input.len(), &body));
}

/// Prints a sum at nodes.
pub(super) fn node_sum(p: &mut Printing, writer: &mut Writer, of: &NodeSum) {
    let mut lists = vec![Vec::new(); of.output.len()];
    for edge in &of.edges {
        lists[edge.tail].push(edge.slot as u32);
        lists[edge.head].push(edge.slot as u32);
    }
    let sum = p
        .tables
        .lists(&lists)
        .each_item(|item| format!("sum += {};", value(of.input, item)));
    let body = format!("var sum = 0.0f;\n{sum}{} = sum;\n", place(of.output, "i"));
    let mut accesses = p.reads([&of.input], By::Any);
    accesses.push(p.write(of.output, By::Element));
    writer.stage(accesses, &each(of.output.len(), &body));
}

/// Prints the reverse of a sum at nodes.
pub(super) fn node_sum_reverse(p: &mut Printing, writer: &mut Writer, of: &NodeSum) {
    if !p.memory.is_active(of.input) {
        return;
    }
    let list = p.edges(&of.edges);
    let mut body = p.edge_head(list);
    let ends = ["tail", "head"]
        .map(|end| p.bar_at(of.output, end))
        .join(" + ");
    let _ = writeln!(body, "{} += {ends};", p.bar_at(of.input, "slot"));
    let accesses = vec![
        p.bar(of.output, By::Any, false),
        p.bar(of.input, By::Edge(list), true),
    ];
    writer.stage(accesses, &each(of.edges.len(), &body));
}

/// Weighted arrays, an operation of `cosmic`.
pub(super) struct Weighted<'a> {
    weights: Array,
    /// The arrays that are multiplied by the weights. The arrays that are centred come first.
    weighed: &'a [Array],
    /// The number of centred arrays.
    offsets: usize,
    /// Arrays that are appended to the result unchanged.
    others: &'a [Array],
    /// The weighted arrays and `others`, the means, and the sum of the weights.
    outputs: [Array; 3],
}

impl<'a> Weighted<'a> {
    /// Returns `None` if this is another operation.
    pub(super) fn of(added: &'a AddedOperation) -> Option<Self> {
        let of = added.of_type::<cosmic::policy::Weighted>()?;
        let (weights, inputs) = added.arrays.inputs.split_first()?;
        let (weighed, others) = inputs.split_at(of.weighed);
        Some(Self {
            weights: *weights,
            weighed,
            offsets: of.offsets,
            others,
            outputs: added.arrays.outputs[..].try_into().ok()?,
        })
    }
}

/// Prints weighted arrays.
pub(super) fn weighted(p: &mut Printing, writer: &mut Writer, of: &Weighted) {
    let (count, width) = (of.weights.len(), p.size + 1);
    let weight = value(of.weights, "i");
    let weighted = |&x: &Array| format!("{weight} * {}", value(x, "i"));
    let mut terms = vec![weight.clone()];
    terms.extend(of.weighed[..of.offsets].iter().map(weighted));
    let read = p.reads([&of.weights].into_iter().chain(of.weighed), By::Element);
    p.sums(writer, count, &terms, read.clone());
    let sum = |k: usize| format!("scratch[{}u]", k * width + p.size);
    let [all, means, total] = of.outputs;
    let mut body = String::new();
    for (c, &x) in of.weighed.iter().enumerate() {
        let mean = match c < of.offsets {
            true => format!("{} / {}", sum(c + 1), sum(0)),
            false => "0.0f".to_owned(),
        };
        let to = format!("row[{}u + i]", all.start() + c * count);
        let _ = writeln!(body, "{to} = {weight} * ({} - {mean});", value(x, "i"));
    }
    let mut text = each(count, &body);
    for k in 0..of.offsets {
        let to = format!("row[{}u]", means.start() + k);
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
        total.start(),
        sum(0)
    );
    let mut accesses = read;
    let mut from = all.start() + of.weighed.len() * count;
    for &other in of.others {
        text += &each(
            other.len(),
            &format!("row[{from}u + i] = {};", value(other, "i")),
        );
        from += other.len();
        accesses.extend(p.read(other, By::Element));
    }
    accesses.push(p.scratch(By::Any, false));
    accesses.extend(of.outputs.map(|y| p.write(y, By::Any)));
    writer.stage(accesses, &text);
}

/// Prints the reverse of weighted arrays; [`Weighted`](cosmic::policy::Weighted) has the formula.
pub(super) fn weighted_reverse(p: &mut Printing, writer: &mut Writer, of: &Weighted) {
    let (count, width) = (of.weights.len(), p.size + 1);
    let weight = value(of.weights, "i");
    let [all, means, total] = of.outputs;
    let y_bar = |c: usize| format!("row_bar[{}u + i]", all.start() + c * count);
    let terms: Vec<String> = (0..of.offsets)
        .map(|c| format!("{weight} * {}", y_bar(c)))
        .collect();
    let mut read = p.reads([&of.weights].into_iter().chain(of.weighed), By::Element);
    read.extend(of.outputs.map(|y| p.bar(y, By::Any, false)));
    read.extend(p.reads(&of.outputs, By::Any));
    if !terms.is_empty() {
        p.sums(writer, count, &terms, read.clone());
    }
    let of_weights = p.memory.is_active(of.weights);
    let mut accesses = read;
    let mut body = String::from("var of_weight = 0.0f;\nvar rest = 0.0f;\n");
    for (c, &x) in of.weighed.iter().enumerate() {
        let (mut shift, mut mean) = ("0.0f".to_owned(), "0.0f".to_owned());
        if c < of.offsets {
            let sum = format!("scratch[{}u]", c * width + p.size);
            let mean_bar = format!("row_bar[{}u]", means.start() + c);
            shift = format!("({sum} - {mean_bar}) / row[{}u]", total.start());
            mean = format!("row[{}u]", means.start() + c);
        }
        let _ = writeln!(body, "rest = {} - {shift};", y_bar(c));
        if p.memory.is_active(x) {
            let _ = writeln!(body, "{} += {weight} * rest;", p.bar_at(x, "i"));
            accesses.push(p.bar(x, By::Element, true));
        }
        let _ = writeln!(
            body,
            "of_weight = fma(rest, {} - {mean}, of_weight);",
            value(x, "i")
        );
    }
    if of_weights {
        let _ = writeln!(body, "{} += of_weight;", p.bar_at(of.weights, "i"));
        accesses.push(p.bar(of.weights, By::Element, true));
    }
    let mut text = each(count, &body);
    let mut from = all.start() + of.weighed.len() * count;
    for &other in of.others {
        if p.memory.is_active(other) {
            let add = format!("{} += row_bar[{from}u + i];", p.bar_at(other, "i"));
            text += &each(other.len(), &add);
            accesses.push(p.bar(other, By::Element, true));
        }
        from += other.len();
    }
    accesses.push(p.scratch(By::Any, false));
    writer.stage(accesses, &text);
}
