//! Prints dense layers.

use std::fmt::Write;

use super::printing::{Kept, Printing, place, value};
use super::writer::{Access, By, Space, Writer, each};
use crate::arrays::DenseLayer;
use crate::record::symbol::Symbol;

/// Prints a dense layer. Several invocations share a row if there are more than rows: each sums a part of the columns.
pub(super) fn forward(p: &mut Printing, writer: &mut Writer, of: &DenseLayer<Symbol>) {
    let [rows, columns] = [of.matrix.rows, of.matrix.columns];
    let parts = (p.size / rows.max(1)).clamp(1, columns.max(1));
    let accesses: Vec<Access> = of
        .inputs
        .iter()
        .filter_map(|&x| p.read(x, By::Any))
        .collect();
    let matrix = p.memory.matrix(of.matrix.parameter);
    let products = |of_part: &str, step: usize| {
        let (mut text, mut before) = (String::new(), 0);
        for &x in &of.inputs {
            // Part `p` has the columns `p, p + parts, ...` of each input.
            let _ = writeln!(
                text,
                "for (var c = {of_part}; c < {}u; c += {step}u) {{\n    \
                     sum = fma({matrix} + (c + {before}u) * {rows}u + r], {}, sum);\n}}",
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
            let table = p.tables.place(places.iter().map(|&at| at as u32).collect());
            place(of.output, &format!("table[{table}u + i]"))
        }
    };
    let bias = value(of.bias, "i");
    let reads_bias = p.read(of.bias, By::Any);
    if parts == 1 {
        let body = format!(
            "let r = i;\nvar sum = {bias};\n{}{to} = {};\n",
            products("0u", 1),
            activated("sum")
        );
        let mut accesses = accesses;
        accesses.extend(reads_bias);
        accesses.push(p.write(of.output, By::Any));
        writer.stage(accesses, &each(rows, &body));
        return;
    }
    p.needs_scratch(parts * rows);
    let body = format!(
        "let r = i % {rows}u;\nlet part = i / {rows}u;\nvar sum = 0.0f;\n{}scratch[i] = sum;\n",
        products("part", parts)
    );
    let mut accesses = accesses;
    accesses.push(p.scratch(By::Any, true));
    writer.stage(accesses, &each(parts * rows, &body));
    let body = format!(
        "var sum = {bias};\nfor (var part = 0u; part < {parts}u; part++) {{\n    \
             sum += scratch[part * {rows}u + i];\n}}\n{to} = {};\n",
        activated("sum")
    );
    let mut accesses = vec![p.scratch(By::Any, false), p.write(of.output, By::Any)];
    accesses.extend(reads_bias);
    writer.stage(accesses, &each(rows, &body));
}

/// Prints the reverse of a dense layer.
pub(super) fn reverse(p: &mut Printing, writer: &mut Writer, of: &DenseLayer<Symbol>) {
    let [rows, columns] = [of.matrix.rows, of.matrix.columns];
    let of_inputs = of.inputs_active.iter().any(|&id| p.memory.is_active_id(id));
    let of_matrix = p.memory.is_wanted(of.matrix.parameter);
    let of_bias = p.memory.is_active(of.bias);
    if !(of_inputs || of_matrix || of_bias) {
        return;
    }
    let places = of.places();
    let at = match places.iter().enumerate().all(|(row, &place)| row == place) {
        true => "i".to_owned(),
        false => {
            let table = p.tables.place(places.iter().map(|&at| at as u32).collect());
            format!("table[{table}u + i]")
        }
    };
    // 1. The cotangents before the activation.
    let first = p.kept();
    let bar = p.bar_at(of.output, "at");
    let slope = match of.tanh {
        true => format!(
            "let y = {};\nlet bar = fma(-y, y, 1.0f) * {bar};\n",
            value(of.output, "at")
        ),
        false => format!("let bar = {bar};\n"),
    };
    let mut body = format!("let at = {at};\n{slope}scratch[i] = bar;\n");
    let mut accesses = vec![
        p.scratch(By::Element, true),
        p.bar(of.output, By::Any, false),
    ];
    accesses.extend(p.read(of.output, By::Any));
    if of_bias {
        let _ = writeln!(body, "{} += bar;", p.bar_at(of.bias, "i"));
        accesses.push(p.bar(of.bias, By::Element, true));
    }
    let mut text = String::new();
    if of_matrix {
        let _ = writeln!(body, "kept[kept_at + {first}u + i] = bar;");
        accesses.push(Access {
            space: Space::Kept,
            range: 0..usize::MAX,
            by: By::Any,
            writes: true,
        });
    }
    text += &each(rows, &body);
    if of_matrix {
        let mut from = first + rows;
        for &x in &of.inputs {
            text += &each(
                x.len,
                &format!("kept[kept_at + {from}u + i] = {};", value(x, "i")),
            );
            from += x.len;
            accesses.extend(p.read(x, By::Any));
        }
        p.layers.push(Kept {
            matrix: of.matrix.parameter,
            rows,
            columns,
            first,
        });
    }
    p.needs_scratch(rows);
    writer.stage(accesses, &text);
    // 2. The cotangents of the inputs.
    if of_inputs {
        let matrix = p.memory.matrix(of.matrix.parameter);
        let (mut text, mut before) = (String::new(), 0);
        let mut accesses = vec![p.scratch(By::Any, false)];
        for &x in &of.inputs {
            let body = format!(
                "var sum = 0.0f;\nlet column = (i + {before}u) * {rows}u;\n\
                     for (var r = 0u; r < {rows}u; r++) {{\n    sum = fma({matrix} + column + r], scratch[r], sum);\n}}\n\
                     {} += sum;\n",
                p.bar_at(x, "i")
            );
            before += x.len;
            if p.memory.is_active(x) {
                text += &each(x.len, &body);
                accesses.push(p.bar(x, By::Element, true));
            }
        }
        writer.stage(accesses, &text);
    }
}
