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
            "if ((bitcast<u32>(row[{state_at}]) & 0x7fffffffu) >= {bits}u) {{\n    \
             carried[member * {state}u + i] += 1.0f;\n}}"
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
        format!("bitcast<f32>(table[{place}u + i])")
    });
    let measured = unit
        .as_ref()
        .map_or("carry[i]".to_owned(), |unit| format!("carry[i] / {unit}"));
    let clipped = unit
        .as_ref()
        .map_or(String::new(), |unit| format!(" * {unit}"));
    let largest = each(
        state,
        &format!("most = max(most, bitcast<u32>({measured}) & 0x7fffffffu);"),
    );
    let squares = each(
        state,
        &format!("let x = ({measured}) / largest;\npart = fma(x, x, part);"),
    );
    let scaled = each(
        state,
        &format!("carry[i] = ({measured}) / largest * factor{clipped};"),
    );
    // The largest magnitude is found by its bits. Divided by it, no square overflows.
    let body = format!(
        "workgroupBarrier();\nvar most = 0u;\n{largest}scratch[lid] = bitcast<f32>(most);\nworkgroupBarrier();\n\
         for (var j = 0u; j < SIZE; j++) {{ most = max(most, bitcast<u32>(scratch[j])); }}\n\
         if (most >= {INFINITE}u) {{\n{}}} else if (most > 0u) {{\n{}}}\n",
        indented(
            &format!(
                "var bits = {}u;\n{}",
                f32::NAN.to_bits(),
                each(state, "carry[i] = bitcast<f32>(bits);")
            ),
            4
        ),
        indented(
            &format!(
                "let largest = bitcast<f32>(most);\nvar part = 0.0f;\n{squares}scratch[SIZE + lid] = part;\n"
            ),
            4
        ),
    );
    let norm = norm as f32;
    let sums = format!(
        "workgroupBarrier();\nif (most > 0u && most < {INFINITE}u) {{\n{}}}\nworkgroupBarrier();\n",
        indented(
            &format!(
                "let largest = bitcast<f32>(most);\nvar squared = 0.0f;\n\
                 for (var j = 0u; j < SIZE; j++) {{ squared += scratch[SIZE + j]; }}\nlet length = sqrt(squared);\n\
                 if (length * largest > {norm:?}f) {{\n    let factor = {norm:?}f / length;\n{}}}\n",
                indented(&scaled, 4)
            ),
            4
        )
    );
    format!(
        "if (({step}) % {every}u == 0u) {{\n{}}}\n",
        indented(&(body + &sums), 4)
    )
}
