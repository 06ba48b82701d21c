//! Prints dense layers.

use std::fmt::Write;

use autodiff_programs::internal::Layer;

use super::printing::{Kept, Printing, place, start_of, value};
use super::writer::{Access, By, Space, Writer, block, each};

/// How many terms of a sum are printed one after the other, so that a device waits only once for their numbers.
const UNROLLED: usize = 8;

/// The product of a matrix and a vector, whose numbers lie in several arrays. Several invocations share a row if there
/// are more than rows: each sums a part of the columns.
struct Product {
    /// The beginning of the expression for an entry of the matrix, of which the columns lie one after the other.
    matrix: String,
    rows: usize,
    /// The lengths of the arrays, and the beginnings of the expressions for their numbers.
    vector: Vec<(usize, String)>,
    parts: usize,
}

impl Product {
    fn new(size: usize, matrix: String, rows: usize, vector: Vec<(usize, String)>) -> Self {
        let columns: usize = vector.iter().map(|(len, _)| len).sum();
        Self {
            matrix,
            rows,
            vector,
            parts: (size / rows.max(1)).clamp(1, columns.max(1)),
        }
    }

    /// The lines that add the products of row `r` and a part of the columns to `sum`: part `p` has the columns
    /// `p, p + parts, ...` of each array.
    fn terms(&self, part: &str) -> String {
        let Self {
            matrix,
            rows,
            vector,
            parts,
        } = self;
        let (mut text, mut before) = (String::new(), 0);
        for (len, from) in vector {
            let term = |column: &str, more: usize| {
                format!(
                    "sum = fma({matrix} + ({column} + {}u) * {rows}u + r], {from} + {column} + {more}u], sum);\n",
                    before + more
                )
            };
            let (each, rest) = (len / parts, len % parts);
            let bundles = each / UNROLLED;
            let stride = UNROLLED * parts;
            let mut at = 0;
            if bundles > 1 {
                let terms: String = (0..UNROLLED).map(|k| term("c", k * parts)).collect();
                let last = bundles * stride;
                let head = format!("for (var c = {part}; c < {last}u; c += {stride}u)");
                text += &block(&head, &terms);
                at = bundles * UNROLLED;
            }
            text.extend((at..each).map(|k| term(part, k * parts)));
            if rest > 0 {
                let _ = writeln!(
                    text,
                    "if ({part} < {rest}u) {{ {} }}",
                    term(part, each * parts).trim_end()
                );
            }
            before += len;
        }
        text
    }

    /// Writes the product. `stored` are the lines that read the sum, `sum`, of row `i`, which begins as `first`; scratch
    /// is free from place `free` on.
    fn print(
        &self,
        p: &mut Printing,
        writer: &mut Writer,
        free: usize,
        [first, stored]: [&str; 2],
        [reads, stores]: [Vec<Access>; 2],
    ) {
        let Self { rows, parts, .. } = self;
        if *parts == 1 {
            let body = format!(
                "let r = i;\nvar sum = {first};\n{}{stored}",
                self.terms("0u")
            );
            writer.stage([reads, stores].concat(), &each(*rows, &body));
            return;
        }
        p.needs_scratch(free + parts * rows);
        let body = format!(
            "let r = i % {rows}u;\nlet part = i / {rows}u;\nvar sum = 0.0f;\n{}scratch[{free}u + i] = sum;\n",
            self.terms("part")
        );
        let mut accesses = reads;
        accesses.push(p.scratch(By::Any, true));
        writer.stage(accesses, &each(parts * rows, &body));
        let sum = format!("sum += scratch[{free}u + part * {rows}u + i];");
        let sum = block(
            &format!("for (var part = 0u; part < {parts}u; part++)"),
            &sum,
        );
        let body = format!("var sum = {first};\n{sum}{stored}");
        let mut accesses = vec![p.scratch(By::Any, false)];
        accesses.extend(stores);
        writer.stage(accesses, &each(*rows, &body));
    }
}

/// Prints a dense layer.
pub(super) fn forward(p: &mut Printing, writer: &mut Writer, of: &Layer) {
    let inputs = of.inputs();
    let reads = p.reads(&inputs, By::Any);
    let vector = inputs.iter().map(|&x| (x.len(), start_of(x))).collect();
    let matrix = p.memory.matrix(of.matrix.parameter());
    let to = place(of.output, "i");
    let stored = match of.tanh {
        true => format!("{to} = tanh_of(sum);\n"),
        false => format!("{to} = sum;\n"),
    };
    let mut stores = vec![p.write(of.output, By::Any)];
    stores.extend(p.read(of.bias, By::Any));
    let product = Product::new(p.size, matrix, of.matrix.shape()[0], vector);
    product.print(
        p,
        writer,
        0,
        [&value(of.bias, "i"), &stored],
        [reads, stores],
    );
}

/// Prints the reverse of a dense layer.
pub(super) fn reverse(p: &mut Printing, writer: &mut Writer, of: &Layer) {
    let of_inputs = of.x.iter().any(|&x| p.memory.is_active(x));
    if of_inputs || p.memory.is_wanted(of.matrix.parameter()) || p.memory.is_active(of.bias) {
        reverse_activation(p, writer, of);
    }
    if of_inputs {
        reverse_product(p, writer, of);
    }
}

/// Prints the cotangents before the activation, and keeps the numbers for the cotangents of the matrix.
fn reverse_activation(p: &mut Printing, writer: &mut Writer, of: &Layer) {
    let ([rows, columns], inputs) = (of.matrix.shape(), of.inputs());
    let first = p.kept();
    let bar = p.bar_at(of.output, "i");
    let slope = match of.tanh {
        true => format!(
            "let y = {};\nlet bar = fma(-y, y, 1.0f) * {bar};\n",
            value(of.output, "i")
        ),
        false => format!("let bar = {bar};\n"),
    };
    let mut body = format!("{slope}scratch[i] = bar;\n");
    let mut accesses = vec![
        p.scratch(By::Element, true),
        p.bar(of.output, By::Any, false),
    ];
    accesses.extend(p.read(of.output, By::Any));
    if p.memory.is_active(of.bias) {
        let _ = writeln!(body, "{} += bar;", p.bar_at(of.bias, "i"));
        accesses.push(p.bar(of.bias, By::Element, true));
    }
    let mut text = String::new();
    if p.memory.is_wanted(of.matrix.parameter()) {
        let _ = writeln!(body, "kept[kept_at + {first}u + i] = bar;");
        accesses.push(Access::new(Space::Kept, 0..usize::MAX, By::Any, true));
        let mut from = first + rows;
        for &x in &inputs {
            let keep = format!("kept[kept_at + {from}u + i] = {};", value(x, "i"));
            text += &each(x.len(), &keep);
            from += x.len();
        }
        accesses.extend(p.reads(&inputs, By::Any));
        p.layers.push(Kept {
            matrix: of.matrix.parameter(),
            rows,
            columns,
            first,
        });
    }
    p.needs_scratch(rows);
    writer.stage(accesses, &(each(rows, &body) + &text));
}

/// Prints the cotangents of the inputs: the product of the transpose and the numbers in scratch.
fn reverse_product(p: &mut Printing, writer: &mut Writer, of: &Layer) {
    let ([rows, columns], inputs) = (of.matrix.shape(), of.inputs());
    let matrix = p.memory.transpose(of.matrix.parameter());
    let vector = vec![(rows, "scratch[0u".to_owned())];
    let product = Product::new(p.size, matrix, columns, vector);
    let (mut stored, mut before, mut stores) = (String::new(), 0, Vec::new());
    for &x in &inputs {
        let end = before + x.len();
        if p.memory.is_active(x) {
            let add = format!("{} += sum;", p.bar_at(x, &format!("i - {before}u")));
            stored += &match inputs.len() {
                1 => format!("{add}\n"),
                _ => format!("if (i >= {before}u && i < {end}u) {{ {add} }}\n"),
            };
            let by = if before == 0 { By::Element } else { By::Any };
            stores.push(p.bar(x, by, true));
        }
        before = end;
    }
    let reads = vec![p.scratch(By::Any, false)];
    product.print(p, writer, rows, ["0.0f", &stored], [reads, stores]);
}

/// The lines that add the products of the kept numbers of a layer, of which each step has `kept`, to the cotangents of its
/// matrix, which begin at `start`.
pub(super) fn add_products(layer: &Kept, start: usize, kept: usize, size: usize) -> String {
    let Kept {
        rows,
        columns,
        first,
        ..
    } = layer;
    // The entries `from..to`, several at once, so that a device waits only once for their numbers.
    let entries = |[from, to]: [usize; 2], at_once: usize| {
        let [mut before, mut adds, mut after] = [const { String::new() }; 3];
        for e in 0..at_once {
            let _ = write!(
                before,
                "let at_{e} = i + {}u;\nlet r_{e} = {first}u + at_{e} % {rows}u;\n\
                 let c_{e} = {}u + at_{e} / {rows}u;\nvar sum_{e} = bars[bars_at + {start}u + at_{e}];\n",
                e * size,
                first + rows
            );
            let sum = format!("sum_{e} = fma(kept[s + r_{e}], kept[s + c_{e}], sum_{e});");
            let _ = writeln!(adds, "{sum}");
            let _ = writeln!(after, "bars[bars_at + {start}u + at_{e}] = sum_{e};");
        }
        let sums = block(
            &format!("for (var s = 0u; s <= kept_at; s += {kept}u)"),
            &adds,
        );
        let stride = at_once * size;
        let head = format!("for (var i = {from}u + lid; i < {to}u; i += {stride}u)");
        block(&head, &(before + &sums + &after))
    };
    let (count, at_once) = (rows * columns, UNROLLED * size);
    let whole = count / at_once * at_once;
    entries([0, whole], UNROLLED) + &entries([whole, count], 1)
}
