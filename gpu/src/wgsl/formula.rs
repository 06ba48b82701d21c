//! Prints recorded kernels and their adjoints as functions of single numbers.

use std::collections::BTreeSet;
use std::fmt::Write;

use autodiff_programs::internal::{Binary, Formula, Logic, Op, Place, ReplayedKernel, Unary};

use super::calls::{Called, constant};

/// A function of the printed program, and the functions of the library that it calls.
pub(super) struct Function {
    pub(super) text: String,
    pub(super) calls: BTreeSet<Called>,
}

/// Prints a kernel. The function takes the inputs `x0, x1, ...` and then the uniform inputs, and returns an array of the
/// results.
pub(super) fn forward(name: &str, of: &ReplayedKernel) -> Function {
    let inputs = of.inputs.len() + of.uniforms.len();
    Printer::new(&Formula::of_kernel(of), [inputs, 0]).print(name)
}

/// Prints the adjoint of a kernel. The function takes the arguments of [`forward`] and then the cotangents `b0, b1, ...`
/// of the results. It returns an array of the cotangents of the arguments that are `wanted`.
pub(super) fn adjoint(name: &str, of: &ReplayedKernel, wanted: &[bool]) -> Function {
    let counts = [of.inputs.len() + of.uniforms.len(), of.outputs.len()];
    Printer::new(&Formula::of_adjoint(of, wanted), counts).print(name)
}

/// Prints a function of one number.
pub(super) fn of_one(name: &str, formula: &Formula) -> Function {
    let mut printed = Printer::new(formula, [1, 0]);
    printed.single = true;
    printed.print(name)
}

struct Printer<'a> {
    formula: &'a Formula,
    /// The number of inputs `x`, and of cotangents `b` after them.
    inputs: usize,
    cotangents: usize,
    /// For each operation, whether the results depend on it.
    is_read: Vec<bool>,
    /// Whether the function returns a number and not an array.
    single: bool,
    calls: BTreeSet<Called>,
}

impl<'a> Printer<'a> {
    fn new(formula: &'a Formula, [inputs, cotangents]: [usize; 2]) -> Self {
        let mut is_read = vec![false; formula.ops.len()];
        let mut pending = formula.results.clone();
        while let Some(place) = pending.pop() {
            if !std::mem::replace(&mut is_read[place.at()], true) {
                pending.extend(formula.ops[place.at()].operands());
            }
        }
        Self {
            formula,
            inputs,
            cotangents,
            is_read,
            single: false,
            calls: BTreeSet::new(),
        }
    }

    fn print(mut self, name: &str) -> Function {
        let x = (0..self.inputs).map(|k| format!("x{k}: f32"));
        let b = (0..self.cotangents).map(|k| format!("b{k}: f32"));
        let arguments: Vec<String> = x.chain(b).collect();
        let results = self.formula.results.iter();
        let results: Vec<String> = results.map(|&place| self.name(place)).collect();
        let (kind, result) = match self.single {
            true => ("f32".to_owned(), results[0].clone()),
            false => {
                let kind = format!("array<f32, {}>", results.len());
                let result = format!("{kind}({})", results.join(", "));
                (kind, result)
            }
        };
        let mut text = format!("fn {name}({}) -> {kind} {{\n", arguments.join(", "));
        for (at, &op) in self.formula.ops.iter().enumerate() {
            if self.is_read[at] && !matches!(op, Op::Input(_) | Op::Constant(_)) {
                let expression = self.expression(op);
                let _ = writeln!(text, "    let t{at} = {expression};");
            }
        }
        let _ = writeln!(text, "    return {result};\n}}");
        Function {
            text,
            calls: self.calls,
        }
    }

    fn name(&self, place: Place) -> String {
        match self.formula.ops[place.at()] {
            Op::Input(k) if (k as usize) < self.inputs => format!("x{k}"),
            Op::Input(k) => format!("b{}", k as usize - self.inputs),
            Op::Constant(bits) => constant(f64::from_bits(bits)),
            _ => format!("t{}", place.at()),
        }
    }

    fn expression(&mut self, op: Op) -> String {
        let name = |place| self.name(place);
        match op {
            Op::Input(_) | Op::Constant(_) => unreachable!("inputs and constants have names"),
            Op::Dot(..) | Op::Sum(..) => {
                unreachable!("a formula has neither dot products nor sums")
            }
            Op::Always(value) => value.to_string(),
            Op::Unary(f, x) => {
                let x = name(x);
                self.unary(f, &x)
            }
            Op::Binary(f, x) => binary(f, x.map(name)),
            Op::Logic(Logic::And, [a, b]) => format!("{} && {}", name(a), name(b)),
            Op::Logic(Logic::Or, [a, b]) => format!("{} || {}", name(a), name(b)),
            Op::Logic(Logic::Not, [x, _]) => format!("!{}", name(x)),
            Op::Logic(Logic::Less, [a, b]) => format!("{} < {}", name(a), name(b)),
            Op::Logic(Logic::LessEqual, [a, b]) => format!("{} <= {}", name(a), name(b)),
            Op::Fma([a, b, c]) => format!("fma({}, {}, {})", name(a), name(b), name(c)),
            Op::Select(m, [a, b]) => format!("select({}, {}, {})", name(b), name(a), name(m)),
        }
    }

    fn unary(&mut self, f: Unary, x: &str) -> String {
        let called = match f {
            Unary::Neg => return format!("-({x})"),
            Unary::Abs => return format!("abs({x})"),
            Unary::Detach => return x.to_owned(),
            Unary::Recip => return format!("1.0f / {x}"),
            Unary::Sqrt => return format!("sqrt({x})"),
            Unary::Rsqrt => return format!("inverseSqrt({x})"),
            Unary::Exp => return format!("exp_of({x})"),
            Unary::Ln => return format!("ln_of({x})"),
            Unary::Sin => return format!("sin_of({x})"),
            Unary::Cos => return format!("cos_of({x})"),
            Unary::Tan => return format!("tan_of({x})"),
            Unary::Tanh | Unary::LayerTanh => return format!("tanh_of({x})"),
            Unary::Powi(exponent) => Called::Power(exponent),
            Unary::Elementary(function) => Called::Elementary(function),
        };
        self.calls.insert(called);
        format!("{}({x})", called.name())
    }
}

fn binary(f: Binary, [a, b]: [String; 2]) -> String {
    match f {
        Binary::Add => format!("{a} + {b}"),
        Binary::Sub => format!("{a} - {b}"),
        Binary::Mul => format!("{a} * {b}"),
        Binary::Div => format!("{a} / {b}"),
        Binary::Chain => format!("select({a} * {b}, 0.0f, {b} == 0.0f)"),
        Binary::StraightThrough => a,
        Binary::Atan2 => format!("atan2_of({a}, {b})"),
        Binary::Powf => format!("powf_of({a}, {b})"),
        Binary::Hypot => format!("hypot_of({a}, {b})"),
    }
}
