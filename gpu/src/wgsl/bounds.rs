//! Prints the bounds on the state and on its cotangent.

use autodiff_programs::CotangentBound;

use super::printed::Options;
use super::printing::Printing;
use super::writer::{block, each};

/// The bits of the smallest float that is not finite.
const INFINITE: u32 = f32::INFINITY.to_bits();

/// The lines that mark numbers of the state that are not below the bound, if there is one. Comparisons of bits see NaN
/// too, which a device may take for any number.
pub(super) fn watch(options: &Options, state_at: &str, state: usize) -> String {
    let Some(bound) = options.state_bound else {
        return String::new();
    };
    let bits = (bound as f32).to_bits();
    let is_marked = format!("if ((bitcast<u32>(row[{state_at}]) & 0x7fffffffu) >= {bits}u)");
    let mark = format!("carried[member * {state}u + i] += 1.0f;");
    each(state, &block(&is_marked, &mark))
}

/// The lines that bound the cotangent of the state, which is in `carry`, after `step` steps.
pub(super) fn clip(printing: &mut Printing, options: &Options, state: usize, step: &str) -> String {
    let Some(CotangentBound { norm, every }) = options.cotangent_bound else {
        return String::new();
    };
    printing.needs_scratch(2 * printing.size);
    let unit = options.cotangent_units.as_ref().map(|units| {
        let bits = units.iter().map(|&unit| (unit as f32).to_bits());
        let place = printing.tables.place(bits.collect());
        format!("bitcast<f32>(table[{place}u + i])")
    });
    let (measured, clipped) = unit.map_or(("carry[i]".to_owned(), String::new()), |unit| {
        (format!("carry[i] / {unit}"), format!(" * {unit}"))
    });
    let largest = format!("most = max(most, bitcast<u32>({measured}) & 0x7fffffffu);");
    let square = format!("let x = ({measured}) / largest;\npart = fma(x, x, part);");
    let scaled = format!("carry[i] = ({measured}) / largest * factor{clipped};");
    let norm = norm as f32;
    // The largest magnitude is found by its bits. Divided by it, no square overflows.
    let mut body = format!(
        "workgroupBarrier();\nvar most = 0u;\n{}scratch[lid] = bitcast<f32>(most);\nworkgroupBarrier();\n\
         for (var j = 0u; j < SIZE; j++) {{ most = max(most, bitcast<u32>(scratch[j])); }}\n",
        each(state, &largest)
    );
    let nan = format!(
        "var bits = {}u;\n{}",
        f32::NAN.to_bits(),
        each(state, "carry[i] = bitcast<f32>(bits);")
    );
    let squares = format!(
        "let largest = bitcast<f32>(most);\nvar part = 0.0f;\n{}scratch[SIZE + lid] = part;\n",
        each(state, &square)
    );
    body += block(&format!("if (most >= {INFINITE}u)"), &nan).trim_end();
    body += &block(" else if (most > 0u)", &squares);
    let scale = format!("let factor = {norm:?}f / length;\n{}", each(state, &scaled));
    let sums = format!(
        "let largest = bitcast<f32>(most);\nvar squared = 0.0f;\n\
         for (var j = 0u; j < SIZE; j++) {{ squared += scratch[SIZE + j]; }}\nlet length = sqrt(squared);\n{}",
        block(&format!("if (length * largest > {norm:?}f)"), &scale)
    );
    body += "workgroupBarrier();\n";
    body += &block(&format!("if (most > 0u && most < {INFINITE}u)"), &sums);
    body += "workgroupBarrier();\n";
    block(&format!("if (({step}) % {every}u == 0u)"), &body)
}
