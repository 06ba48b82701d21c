//! Puts the printed operations together to two entry points.

use std::fmt::Write;

use autodiff_programs::Array;
use autodiff_programs::internal::{Parts, StepOperation};

use super::bounds;
use super::kernels;
use super::layers;
use super::library;
use super::memory::Memory;
use super::printed::{GROUPS_IN_A_ROW, Options, Printed, Refused};
use super::printing::{Printing, value};
use super::spill::Spill;
use super::sums;
use super::writer::{By, Writer, block, each};

/// The declarations of the buffers.
const BUFFERS: &str = "\
struct Plan {
    members: u32,
    first: u32,
    steps: u32,
    read: u32,
    write: u32,
    every: u32,
    observed: u32,
    observes: u32,
}

@group(0) @binding(0) var<uniform> plan: Plan;
@group(0) @binding(1) var<storage, read> inputs: array<f32>;
@group(0) @binding(2) var<storage, read> table: array<u32>;
@group(0) @binding(3) var<storage, read> own: array<f32>;
@group(0) @binding(4) var<storage, read> of_all: array<f32>;
@group(0) @binding(5) var<storage, read_write> states: array<f32>;
@group(0) @binding(6) var<storage, read_write> carried: array<f32>;
@group(0) @binding(7) var<storage, read_write> bars: array<f32>;
@group(0) @binding(8) var<storage, read_write> observed: array<f32>;
@group(0) @binding(9) var<storage, read_write> spilled: array<f32>;
";

#[track_caller]
pub(super) fn print(program: &Parts, options: &Options) -> Result<Printed, Refused> {
    let state = program.states.iter().map(|part| part.len()).sum();
    options.check(program.parameters.len(), state);
    if !program.controls.is_empty() {
        return Err(Refused("it has a control".to_owned()));
    }
    let chosen = |list: &[usize]| {
        let mut all = vec![false; program.parameters.len()];
        list.iter().for_each(|&k| all[k] = true);
        all
    };
    let mut memory = Memory::new(program, &chosen(&options.common), &chosen(&options.wanted));
    propagate(program, &mut memory)?;
    let mut printing = Printing::new(&memory, options.workgroup);
    let step = Step::new(program, options, &mut printing);
    let forward = forward(&step, &mut printing);
    let reverse = reverse(&step, &mut printing);
    if let Some(called) = printing.calls.iter().find(|called| called.loops()) {
        let what = format!("a kernel calls `{}`, whose formula loops", called.name());
        return Err(Refused(what));
    }
    let [parameters, row] = program.ends;
    let arrays = [
        ("row", row),
        ("parameter", parameters),
        ("scratch", printing.scratch),
        ("row_bar", row),
        ("parameter_bar", memory.bars_of_arrays),
        ("carry", step.state),
        ("kept", printing.kept() * options.kept),
    ];
    let mut source = format!("const SIZE = {}u;\n\n{BUFFERS}\n", options.workgroup);
    let spill = Spill::new(&arrays, options.memory);
    for (name, len) in arrays.iter().filter(|(name, _)| !spill.has(name)) {
        let len = len.max(&1);
        let _ = writeln!(source, "var<workgroup> {name}: array<f32, {len}>;");
    }
    let library = library::print(std::mem::take(&mut printing.calls));
    let _ = writeln!(source, "\n{library}");
    for (_, text) in &printing.functions {
        let _ = writeln!(source, "{text}");
    }
    let entries = format!("{forward}\n{reverse}");
    source += &spill.moved(&entries);
    let bytes = |count: usize| spill.left(&arrays[..count]);
    Ok(Printed {
        source,
        state: step.state,
        entries: step.entries.len(),
        inputs: program.inputs_len,
        parameters: memory.parameters.clone(),
        lengths: memory.lengths,
        table: printing.tables.numbers,
        memory: [bytes(3), bytes(arrays.len())],
        spilled: spill.len(),
    })
}

/// The parts of a program that do not depend on the direction of the sweep.
struct Step<'a> {
    program: &'a Parts<'a>,
    options: &'a Options,
    /// How many numbers a state has.
    state: usize,
    /// For each number of the state, its place in the row.
    places: Vec<usize>,
    /// The expression for the place of number `i` of the state in the row.
    state_at: String,
    /// The numbers of the state that are observed.
    entries: Vec<usize>,
    /// The expression that says, in step `n`, which observed state the state after it is: from 1 on, or 0.
    seen: String,
}

impl<'a> Step<'a> {
    fn new(program: &'a Parts<'a>, options: &'a Options, printing: &mut Printing) -> Self {
        let parts = program.states.iter();
        let places: Vec<usize> = parts.flat_map(|part| part.range()).collect();
        let state = places.len();
        let entries = options.entries.clone();
        let inputs = program.inputs_len;
        Self {
            program,
            options,
            state,
            state_at: printing.index(&places),
            places,
            entries: entries.unwrap_or_else(|| (0..state).collect()),
            seen: format!("u32(inputs[n * {}u + {inputs}u])", inputs + 1),
        }
    }

    /// The lines that read the state in a slot.
    fn read_state(&self, slot: &str) -> String {
        let Self {
            state, state_at, ..
        } = self;
        let read =
            format!("row[{state_at}] = states[({slot} * plan.members + member) * {state}u + i];");
        each(*state, &read)
    }

    /// The parts of the state, with the array of the next value and the first number in the state.
    fn parts(&self) -> impl Iterator<Item = (Array, Array, usize)> + '_ {
        let next = self.program.next.iter();
        let next = next
            .map(|next| next.expect("`print` checked that every part of the state is advanced"));
        let parts = self.program.states.iter().zip(next);
        parts.scan(0, |end, (&part, next)| {
            *end += part.len();
            Some((part, next, *end - part.len()))
        })
    }
}

/// Finds out which arrays carry derivatives, and refuses operations that cannot be printed.
fn propagate(program: &Parts, memory: &mut Memory) -> Result<(), Refused> {
    program
        .states
        .iter()
        .for_each(|&part| memory.activate(part));
    for operation in program.operations {
        let (inputs, outputs): (Vec<Array>, Vec<Array>) = match operation {
            StepOperation::Kernel(of) => {
                let of = &of.arrays;
                let computed = of
                    .uniforms
                    .iter()
                    .find(|u| !u.is_parameter() && memory.is_active(**u));
                if computed.is_some() {
                    let what = "a uniform input of a kernel is computed in the step and carries a derivative";
                    return Err(Refused(what.to_owned()));
                }
                ([&of.inputs[..], &of.uniforms].concat(), of.outputs.clone())
            }
            StepOperation::Gather(of) => (vec![of.input], vec![of.output]),
            StepOperation::NodeSum(of) => (vec![of.input], vec![of.output]),
            StepOperation::Dense(of) => {
                let of_inputs = of.x.iter().any(|&x| memory.is_active(x));
                if of_inputs {
                    memory.copy_rows(of.matrix.parameter());
                }
                if of_inputs || memory.is_wanted(of.matrix.parameter()) {
                    memory.activate(of.output);
                }
                ([&of.x[..], &[of.bias]].concat(), vec![of.output])
            }
            StepOperation::Solve(_) => {
                return Err(Refused("it solves linear equations".to_owned()));
            }
            StepOperation::Added(of) if sums::Weighted::of(of).is_none() => {
                let what = "it has an operation that this printer does not know";
                return Err(Refused(what.to_owned()));
            }
            StepOperation::Added(of) => (of.arrays.inputs.clone(), of.arrays.outputs.clone()),
        };
        if inputs.iter().any(|&array| memory.is_active(array)) {
            outputs.iter().for_each(|&array| memory.activate(array));
        }
    }
    Ok(())
}

/// The lines with which both entry points begin.
fn beginning(step: &Step, printing: &Printing) -> String {
    let [own, _, bars] = printing.memory.lengths;
    let mut text = format!(
        "let member = group.x + {GROUPS_IN_A_ROW}u * group.y;\nif (member >= plan.members) {{ return; }}\n\
         let own_at = member * {own}u;\nlet bars_at = member * {bars}u;\n\
         let observed_at = member * plan.observed;\n"
    );
    for (array, placed) in printing.memory.arrays() {
        let line = format!("{} = {} + i];", value(array, "i"), placed.expression());
        text += &each(array.len(), &line);
    }
    text += &each(step.program.ends[1], "row[i] = 0.0f;");
    text
}

/// The lines that read the inputs of step `n`.
fn read_inputs(step: &Step) -> String {
    let (width, mut first) = (step.program.inputs_len + 1, 0);
    let mut text = String::new();
    for &input in step.program.inputs {
        let line = format!(
            "{} = inputs[n * {width}u + {first}u + i];",
            value(input, "i")
        );
        text += &each(input.len(), &line);
        first += input.len();
    }
    text
}

/// Prints the operations of a step.
fn operations(step: &Step, printing: &mut Printing, writer: &mut Writer) {
    for (number, operation) in step.program.operations.iter().enumerate() {
        match operation {
            StepOperation::Kernel(of) => {
                kernels::forward(printing, writer, number, &of.replayed());
            }
            StepOperation::Gather(of) => sums::gather(printing, writer, of),
            StepOperation::NodeSum(of) => sums::node_sum(printing, writer, of),
            StepOperation::Dense(of) => layers::forward(printing, writer, of),
            StepOperation::Added(of) => {
                let of = sums::Weighted::of(of).expect("others are refused");
                sums::weighted(printing, writer, &of);
            }
            StepOperation::Solve(_) => unreachable!("it is refused"),
        }
    }
}

/// Prints the reverse of the operations.
fn operations_reverse(step: &Step, printing: &mut Printing, writer: &mut Writer) {
    for (number, operation) in step.program.operations.iter().enumerate().rev() {
        match operation {
            StepOperation::Kernel(of) => {
                kernels::reverse(printing, writer, number, &of.replayed());
            }
            StepOperation::Gather(of) => sums::gather_reverse(printing, writer, of),
            StepOperation::NodeSum(of) => sums::node_sum_reverse(printing, writer, of),
            StepOperation::Dense(of) => layers::reverse(printing, writer, of),
            StepOperation::Added(of) => {
                let of = sums::Weighted::of(of).expect("others are refused");
                sums::weighted_reverse(printing, writer, &of);
            }
            StepOperation::Solve(_) => unreachable!("it is refused"),
        }
    }
}

/// An entry point with these lines before, in and after its loop over the steps.
fn entry_point(name: &str, before: &str, [head, step]: [&str; 2], after: &str) -> String {
    let function = format!(
        "@compute @workgroup_size(SIZE)\nfn {name}(\n    @builtin(workgroup_id) group: vec3<u32>,\n    \
         @builtin(local_invocation_index) lid: u32,\n)"
    );
    let body = format!("{before}{}{after}", block(head, step));
    block(&function, &body)
}

/// Prints how the state takes its next value.
fn advance(step: &Step, printing: &mut Printing, writer: &mut Writer) {
    // A part that takes its value from another part must be read before that part is replaced.
    let is_state = |array: &Array| step.program.states.contains(array);
    let mut moves = String::new();
    let mut moved = 0;
    for (_, next, first) in step
        .parts()
        .filter(|(part, next, _)| is_state(next) && part != next)
    {
        moves += &each(
            next.len(),
            &format!("scratch[{first}u + i] = {};", value(next, "i")),
        );
        moved = moved.max(first + next.len());
    }
    printing.scratch = printing.scratch.max(moved);
    if moved > 0 {
        writer.barrier();
        writer.text += &moves;
    }
    writer.barrier();
    for (part, next, first) in step.parts().filter(|(part, next, _)| part != next) {
        let from = match is_state(&next) {
            true => format!("scratch[{first}u + i]"),
            false => value(next, "i"),
        };
        writer.text += &each(part.len(), &format!("{} = {from};", value(part, "i")));
    }
    writer.barrier();
}

fn forward(step: &Step, printing: &mut Printing) -> String {
    let Step {
        state,
        state_at,
        seen,
        ..
    } = step;
    let places = step.entries.iter().map(|&entry| step.places[entry]);
    let places: Vec<usize> = places.collect();
    let (entries, entry_at) = (places.len(), printing.index(&places));
    let mut start = beginning(step, printing);
    start += "workgroupBarrier();\n";
    start += &step.read_state("plan.read");
    let mut writer = Writer::default();
    writer.text += "let n = plan.first + k;\n";
    writer.text += &read_inputs(step);
    writer.barrier();
    operations(step, printing, &mut writer);
    advance(step, printing, &mut writer);
    writer.text += &bounds::watch(step.options, state_at, *state);
    let store = format!("states[(slot * plan.members + member) * {state}u + i] = row[{state_at}];");
    let store = each(*state, &store);
    writer.text += &block(
        "if ((k + 1u) % plan.every == 0u)",
        &format!("let slot = plan.write + (k + 1u) / plan.every;\n{store}"),
    );
    let observe =
        format!("observed[(observed_at + seen - 1u) * {entries}u + i] = row[{entry_at}];");
    let observe = each(entries, &observe);
    let _ = writeln!(writer.text, "let seen = {seen};");
    writer.text += &block("if (seen > 0u && plan.observes == 1u)", &observe);
    let head = "for (var k = 0u; k < plan.steps; k++)";
    entry_point("forward", &start, [head, &writer.text], "")
}

/// The lines that, after the last of `steps_kept` steps or of a stretch, add the products of the kept numbers to the
/// cotangents of the matrices.
fn add_kept(printing: &Printing, steps_kept: usize) -> String {
    let kept = printing.kept();
    if kept == 0 {
        return String::new();
    }
    let mut flush = String::new();
    for layer in &printing.layers {
        let bars = printing.memory.parameters[layer.matrix].bar;
        let start = bars.expect("it is wanted");
        flush += &layers::add_products(layer, start, kept, printing.size);
    }
    flush += "workgroupBarrier();\nkept_at = 0u;\n";
    let most = (steps_kept - 1) * kept;
    let head = format!("if (kept_at == {most}u || k == 1u)");
    block(&head, &flush).trim_end().to_owned() + &block(" else", &format!("kept_at += {kept}u;"))
}

fn reverse(step: &Step, printing: &mut Printing) -> String {
    let text = reverse_step(step, printing);
    let carried = format!("carried[member * {}u + i]", step.state);
    let mut before = beginning(step, printing);
    before += &each(printing.memory.bars_of_arrays, "parameter_bar[i] = 0.0f;");
    before += &each(step.state, &format!("carry[i] = {carried};"));
    for number in 0..printing.collected.len() {
        let _ = writeln!(before, "var collected_{number} = 0.0f;");
    }
    before += "var kept_at = 0u;\nworkgroupBarrier();\n";
    // The cotangent of the start; of a later stretch, the next dispatch bounds it.
    let of_start = bounds::clip(printing, step.options, step.state, "0u");
    let mut after = match of_start.is_empty() {
        true => String::new(),
        false => block("if (plan.first == 0u)", &of_start),
    };
    after += &each(step.state, &format!("{carried} = carry[i];"));
    for (number, place) in printing.collected.iter().enumerate() {
        printing.scratch = printing.scratch.max(printing.size);
        let _ = write!(
            after,
            "scratch[lid] = collected_{number};\nworkgroupBarrier();\nif (lid == 0u) {{\n    var sum = 0.0f;\n    \
             for (var i = 0u; i < SIZE; i++) {{ sum += scratch[i]; }}\n    parameter_bar[{place}u] += sum;\n}}\n\
             workgroupBarrier();\n"
        );
    }
    after += "workgroupBarrier();\n";
    let add = "bars[bars_at + i] += parameter_bar[i];";
    after += &each(printing.memory.bars_of_arrays, add);
    let head = "for (var k = plan.steps; k > 0u; k--)";
    entry_point("reverse", &before, [head, &text], &after)
}

/// The lines of a step of the reverse sweep.
fn reverse_step(step: &Step, printing: &mut Printing) -> String {
    let Step {
        state,
        state_at,
        seen,
        ..
    } = step;
    let (entries, entry_at) = (step.entries.len(), printing.index(&step.entries));
    let mut writer = Writer::default();
    let _ = write!(
        writer.text,
        "let n = plan.first + k - 1u;\nlet slot = select(plan.write + k - 1u, plan.read, k == 1u);\n\
         let seen = {seen};\n"
    );
    let take =
        format!("carry[{entry_at}] += observed[(observed_at + seen - 1u) * {entries}u + i];");
    writer.text += &block("if (seen > 0u)", &each(entries, &take));
    writer.text += &bounds::clip(printing, step.options, *state, "n + 1u");
    writer.text += &step.read_state("slot");
    writer.text += &each(step.program.ends[1], "row_bar[i] = 0.0f;");
    writer.text += &read_inputs(step);
    writer.barrier();
    operations(step, printing, &mut writer);
    for (_, next, first) in step.parts() {
        if printing.memory.is_active(next) {
            let bar = printing.bar_at(next, "i");
            let add = each(next.len(), &format!("{bar} += carry[{first}u + i];"));
            writer.stage(vec![printing.bar(next, By::Element, true)], &add);
        }
    }
    operations_reverse(step, printing, &mut writer);
    writer.barrier();
    writer.text += &each(*state, &format!("carry[i] = row_bar[{state_at}];"));
    writer.text += &add_kept(printing, step.options.kept);
    writer.barrier();
    writer.text
}
