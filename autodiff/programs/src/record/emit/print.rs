//! Prints the adjoint of a kernel as Rust code.

use std::fmt::Write;

use crate::record::operation::{Binary, Logic, Op, Place, Unary};
use crate::record::recording::Recording;

/// The adjoint of a kernel: a list of places (numbers) in a recording. The first operations of the recording are the
/// inputs of the kernel, followed by the cotangents of its results.
pub(crate) struct Adjoint {
    /// The results of the kernel. The printed code receives their values as `y`.
    pub(crate) results: Vec<Place>,
    /// The cotangents of the inputs. The printed code computes them.
    pub(crate) x_bar: Vec<Place>,
}

/// The names of uniform inputs begin with this text. The printed code receives uniform inputs as numbers of type `R`,
/// not as literals.
const UNIFORMS: &str = "at.uniforms[";

pub(super) struct Printer<'a> {
    recording: &'a Recording,
    adjoint: &'a Adjoint,
    /// For each field, the expression that reads it, and the constant that represents it in the recording.
    fields: &'a [(&'a str, f64)],
    /// For each number, how often the adjoint reads it.
    reads: Vec<usize>,
    /// For each number of the adjoint, whether it depends on the cotangents of the kernel's results.
    of_bars: Vec<bool>,
}

impl<'a> Printer<'a> {
    pub(super) fn new(
        recording: &'a Recording,
        adjoint: &'a Adjoint,
        fields: &'a [(&'a str, f64)],
    ) -> Self {
        let mut printer = Self {
            recording,
            adjoint,
            fields,
            reads: vec![0; recording.ops.len()],
            of_bars: Vec::new(),
        };
        printer.count_reads();
        for &op in &recording.ops {
            let depends = match op {
                Op::Input(k) => k as usize >= printer.inputs(),
                _ => op.operands().iter().any(|x| printer.of_bars[x.at()]),
            };
            printer.of_bars.push(depends);
        }
        printer
    }

    fn inputs(&self) -> usize {
        self.adjoint.x_bar.len()
    }

    /// Returns the body of the method. Numbers that do not depend on cotangents are computed before the loop over the
    /// rows of cotangents.
    pub(super) fn print(self) -> String {
        let (adjoint, inputs) = (self.adjoint, self.inputs());
        let all: Vec<Place> = (0..inputs + adjoint.results.len())
            .map(Place::own)
            .collect();
        let (x, y_bar) = all.split_at(inputs);
        let names = |letter, places| self.names(letter, places);
        let [before, inside] = [false, true].map(|of_bars| self.statements(of_bars));
        let inside: String = inside.lines().map(|line| format!("    {line}\n")).collect();
        format!(
            "let autodiff_programs::Pullback {{ x, y, y_bar, .. }} = at;\nlet [{}] = x;\nlet [{}] = y;\n{before}\
             let mut x_bar = [[R::zero(); {inputs}]; M];\nfor m in 0..M {{\n    \
             let [{}] = y_bar[m];\n{inside}    x_bar[m] = {};\n}}\nx_bar",
            names('x', x),
            names('r', &adjoint.results),
            names('y', y_bar),
            self.array(&adjoint.x_bar)
        )
    }

    /// Returns the definitions of the numbers that depend on the cotangents (if `of_bars`), or of the numbers that do
    /// not.
    fn statements(&self, of_bars: bool) -> String {
        let mut text = String::new();
        for (at, &op) in self.recording.ops.iter().enumerate() {
            let place = Place::own(at);
            let has_name = matches!(op, Op::Input(_)) || self.given(place).is_some();
            let is_read = self.reads[at] > 0 && self.of_bars[at] == of_bars;
            if is_read && !has_name && !self.is_folded(place) {
                let _ = writeln!(text, "let t{at} = {};", self.expression(op));
            }
        }
        text
    }

    fn count_reads(&mut self) {
        let mut pending = self.adjoint.x_bar.clone();
        while let Some(place) = pending.pop() {
            self.reads[place.at()] += 1;
            if self.reads[place.at()] == 1 && self.given(place).is_none() {
                pending.extend(self.recording.op(place).operands());
            }
        }
    }

    fn array(&self, places: &[Place]) -> String {
        let names: Vec<String> = places.iter().map(|&place| self.name(place)).collect();
        format!("[{}]", names.join(", "))
    }

    /// Returns the pattern that destructures an argument of the printed method. It has `_` for numbers that are not
    /// read or have another name.
    fn names(&self, letter: char, places: &[Place]) -> String {
        let name = |(k, &place): (usize, &Place)| {
            let own = format!("{letter}{k}");
            let used = self.reads[place.at()] > 0 && self.name(place) == own;
            if used { own } else { "_".to_owned() }
        };
        let names: Vec<String> = places.iter().enumerate().map(name).collect();
        names.join(", ")
    }

    /// If the number at this place is a result of the kernel, returns the index of the result.
    fn given(&self, place: Place) -> Option<usize> {
        let results = &self.adjoint.results;
        results.iter().position(|&result| result == place)
    }

    /// If `op` adds a term to a product, and nothing else reads the product, returns the product and the term. The two
    /// operations are then printed as one fused multiply-add.
    fn fused(&self, op: Op) -> Option<(Place, Place)> {
        match op {
            Op::Binary(Binary::Add | Binary::Sub, [a, b]) if self.is_lone_product(b) => {
                Some((b, a))
            }
            Op::Binary(Binary::Add, [a, b]) if self.is_lone_product(a) => Some((a, b)),
            _ => None,
        }
    }

    fn is_lone_product(&self, place: Place) -> bool {
        matches!(self.recording.op(place), Op::Binary(Binary::Mul, _))
            && self.reads[place.at()] == 1
            && self.given(place).is_none()
    }

    /// Whether a product is not printed by itself, but as part of a fused multiply-add.
    fn is_folded(&self, place: Place) -> bool {
        let read = self.recording.ops.iter().zip(&self.reads);
        let mut read = read.filter(|(_, reads)| **reads > 0);
        let folds = |op| self.fused(op).is_some_and(|(product, _)| product == place);
        self.is_lone_product(place) && read.any(|(&op, _)| folds(op))
    }

    fn name(&self, place: Place) -> String {
        let inputs = self.inputs();
        match (self.recording.op(place), self.given(place)) {
            (Op::Input(k), _) if (k as usize) < inputs => format!("x{k}"),
            (Op::Input(k), _) => format!("y{}", k as usize - inputs),
            (_, Some(result)) => format!("r{result}"),
            (_, None) => format!("t{}", place.at()),
        }
    }

    fn expression(&self, op: Op) -> String {
        let name = |place| self.name(place);
        if let Some((product, term)) = self.fused(op) {
            let [f, g] = self.recording.op(product).operands()[..] else {
                unreachable!("a product has two factors")
            };
            let minus = matches!(op, Op::Binary(Binary::Sub, _));
            let f = if minus {
                format!("(-{})", name(f))
            } else {
                name(f)
            };
            return format!("{f}.fma({}, {})", name(g), name(term));
        }
        match op {
            Op::Input(_) => unreachable!("inputs have names"),
            Op::Dot(..) | Op::Sum(..) => {
                unreachable!("a simplified recording has neither dot products nor sums")
            }
            Op::Constant(bits) => self.constant(f64::from_bits(bits)),
            Op::Always(value) => format!("<R::Mask as Mask>::splat({value})"),
            Op::Unary(f, x) => unary(f, &name(x)),
            Op::Binary(f, x) => binary(f, x.map(name)),
            Op::Logic(Logic::And, [a, b]) => format!("{} & {}", name(a), name(b)),
            Op::Logic(Logic::Or, [a, b]) => format!("{} | {}", name(a), name(b)),
            Op::Logic(Logic::Not, [x, _]) => format!("!{}", name(x)),
            Op::Logic(Logic::Less, [a, b]) => format!("{}.less({})", name(a), name(b)),
            Op::Logic(Logic::LessEqual, [a, b]) => {
                format!("{}.less_equal({})", name(a), name(b))
            }
            Op::Fma([a, b, c]) => format!("{}.fma({}, {})", name(a), name(b), name(c)),
            Op::Select(m, [a, b]) => format!("R::select({}, {}, {})", name(m), name(a), name(b)),
        }
    }

    fn constant(&self, value: f64) -> String {
        for (name, field) in self.fields {
            let [is_field, is_minus] = [value == *field, value == -field];
            match (name.starts_with(UNIFORMS), is_field, is_minus) {
                (_, false, false) => {}
                (true, true, _) => return (*name).to_owned(),
                (true, false, true) => return format!("-{name}"),
                (false, true, _) => return format!("R::lit({name})"),
                (false, false, true) => return format!("R::lit(-{name})"),
            }
        }
        match value {
            f64::INFINITY => "R::lit(f64::INFINITY)".into(),
            f64::NEG_INFINITY => "R::lit(f64::NEG_INFINITY)".into(),
            _ if value.is_nan() => "R::lit(f64::NAN)".into(),
            _ => format!("R::lit({value:?})"),
        }
    }
}

fn unary(f: Unary, x: &str) -> String {
    match f {
        Unary::Neg => format!("-{x}"),
        Unary::Powi(exponent) => format!("{x}.powi({exponent})"),
        _ => format!("{x}.{}()", f.method()),
    }
}

fn binary(f: Binary, [a, b]: [String; 2]) -> String {
    match f {
        Binary::Add => format!("{a} + {b}"),
        Binary::Sub => format!("{a} - {b}"),
        Binary::Mul => format!("{a} * {b}"),
        Binary::Div => format!("{a} / {b}"),
        Binary::Chain => format!("R::chain({a}, {b})"),
        Binary::StraightThrough => format!("{a}.straight_through({b})"),
        Binary::Atan2 => format!("{a}.atan2({b})"),
        Binary::Powf => format!("{a}.powf({b})"),
        Binary::Hypot => format!("{a}.hypot({b})"),
    }
}
