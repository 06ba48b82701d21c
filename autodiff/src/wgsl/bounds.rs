//! Prints the bounds on the state and on its cotangent.

use super::printed::Options;
use super::printing::Printing;
use super::writer::{each, indented};
use crate::steps::CotangentBound;

/// The bits of the smallest float that is not finite.
const INFINITE: u32 = f32::INFINITY.to_bits();

/// The lines that mark numbers of the state that are not below the bound, if there is one. Comparisons of bits see NaN
/// too, which a device may take for any number.
pub(super) fn watch(options: &Options, state_at: &str, state: usize) -> String {
    let Some(bound) = options.state_bound else {
        return String::new();
    };
    let bits = (bound as f32).to_bits();
    each(
        state,
        &format!(
            "let exceeds = (bitcast<Bits>(row[{state_at}]) & Bits(0x7fffffffu)) >= Bits({bits}u);\n\
             if (any(exceeds)) {{\n    \
             carried[group * {state}u + i] += select(Number(0.0f), Number(1.0f), exceeds);\n}}"
        ),
    )
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
        format!("Number(bitcast<f32>(table[{place}u + i]))")
    });
    let measured = unit
        .as_ref()
        .map_or("carry[i]".to_owned(), |unit| format!("carry[i] / {unit}"));
    let clipped = unit
        .as_ref()
        .map_or(String::new(), |unit| format!(" * {unit}"));
    let largest = each(
        state,
        &format!("most = max(most, bitcast<Bits>({measured}) & Bits(0x7fffffffu));"),
    );
    let squares = each(
        state,
        &format!("let x = ({measured}) / largest;\npart = fma(x, x, part);"),
    );
    let scaled = each(
        state,
        &format!(
            "let shorter = ({measured}) / largest * factor{clipped};\n\
             carry[i] = select(select(carry[i], shorter, exceeds), bitcast<Number>(bits), is_lost);"
        ),
    );
    let (norm, nan) = (norm as f32, f32::NAN.to_bits());
    // The largest magnitude is found by its bits. Divided by it, no square overflows.
    let body = format!(
        "workgroupBarrier();\nvar most = Bits(0u);\n{largest}scratch[lid] = bitcast<Number>(most);\n\
         workgroupBarrier();\n\
         for (var j = 0u; j < SIZE; j++) {{ most = max(most, bitcast<Bits>(scratch[j])); }}\n\
         let is_lost = most >= Bits({INFINITE}u);\n\
         let largest = select(bitcast<Number>(most), Number(1.0f), is_lost | (most == Bits(0u)));\n\
         var part = Number(0.0f);\n{squares}scratch[SIZE + lid] = part;\nworkgroupBarrier();\n\
         var squared = Number(0.0f);\nfor (var j = 0u; j < SIZE; j++) {{ squared += scratch[SIZE + j]; }}\n\
         let length = sqrt(squared);\nlet exceeds = length * largest > Number({norm:?}f);\n\
         let factor = Number({norm:?}f) / length;\nvar bits = Bits({nan}u);\n\
         if (any(exceeds | is_lost)) {{\n{}}}\nworkgroupBarrier();\n",
        indented(&scaled, 4)
    );
    format!(
        "if (({step}) % {every}u == 0u) {{\n{}}}\n",
        indented(&body, 4)
    )
}
