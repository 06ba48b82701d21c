//! Writes the adjoint of a [`Kernel`] as straight-line Rust.
//!
//! The kernel is run once on the reverse tape over [`Symbol`]s, numbers that note how they were
//! made: the pullback then *is* the formula of the adjoint. What is printed is checked in beside
//! the kernel, and a test compares it with what [`adjoint`] prints today.
//!
//! A product with a cotangent goes through [`Real::chain`] only where the partial may be
//! infinite: where it comes from a quotient, root or logarithm of something that is not a sum of
//! squares and positive constants.

use std::cell::RefCell;
use std::collections::HashMap;
use std::fmt::Write;
use std::ops::{
    Add, AddAssign, BitAnd, BitOr, Div, DivAssign, Mul, MulAssign, Neg, Not, Sub, SubAssign,
};

use num_traits::{One, Zero};

use crate::kernel::Kernel;
use crate::real::{Mask, Real};
use crate::reverse::Tape;

/// A node of the formula, by its place in the list of all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Symbol(u32);

/// A comparison, or several of them joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SymbolMask(u32);

/// How a node was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Node {
    Input(u32),
    /// The bits of an f64.
    Constant(u64),
    /// A method of [`Real`] on one or two numbers.
    Unary(&'static str, u32),
    Binary(&'static str, u32, u32),
    Powi(u32, i32),
    Add(u32, u32),
    Sub(u32, u32),
    Mul(u32, u32),
    Neg(u32),
    Fma(u32, u32, u32),
    Chain(u32, u32),
    Compare(&'static str, u32, u32),
    Join(char, u32, u32),
    Not(u32),
    Always(bool),
    Select(u32, u32, u32),
}

impl Node {
    fn operands(self) -> Vec<u32> {
        match self {
            Node::Input(_) | Node::Constant(_) | Node::Always(_) => vec![],
            Node::Unary(_, a) | Node::Powi(a, _) | Node::Neg(a) | Node::Not(a) => vec![a],
            Node::Binary(_, a, b)
            | Node::Add(a, b)
            | Node::Sub(a, b)
            | Node::Mul(a, b)
            | Node::Chain(a, b)
            | Node::Compare(_, a, b)
            | Node::Join(_, a, b) => vec![a, b],
            Node::Fma(a, b, c) | Node::Select(a, b, c) => vec![a, b, c],
        }
    }
}

/// What is known of a node's value wherever its inputs are finite.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Known {
    sign: Sign,
    /// May be infinite or NaN.
    singular: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Sign {
    Unknown,
    NonNegative,
    Positive,
}

/// All nodes, each formula once.
#[derive(Default)]
struct Graph {
    nodes: Vec<(Node, Known)>,
    places: HashMap<Node, u32>,
}

thread_local! {
    static GRAPH: RefCell<Graph> = RefCell::default();
}

impl Graph {
    fn place(&mut self, node: Node) -> u32 {
        if let Some(&place) = self.places.get(&node) {
            return place;
        }
        let place = u32::try_from(self.nodes.len()).expect("a kernel is a small function");
        self.nodes.push((node, self.known(node)));
        self.places.insert(node, place);
        place
    }

    fn known(&self, node: Node) -> Known {
        let of = |place: u32| self.nodes[place as usize].1;
        let sign = |place| of(place).sign;
        let product = |a, b| {
            if a == b {
                sign(a).max(NonNegative)
            } else {
                sign(a).min(sign(b))
            }
        };
        // A sum of non-negative terms is positive where one of them is.
        let sum = |a: Sign, b: Sign| {
            if a.min(b) == Unknown {
                Unknown
            } else {
                a.max(b)
            }
        };
        use Sign::{NonNegative, Positive, Unknown};
        let (result, domain_is_safe) = match node {
            Node::Constant(bits) if f64::from_bits(bits) > 0.0 => (Positive, true),
            Node::Constant(bits) if f64::from_bits(bits) == 0.0 => (NonNegative, true),
            Node::Mul(a, b) => (product(a, b), true),
            Node::Add(a, b) => (sum(sign(a), sign(b)), true),
            Node::Fma(a, b, c) => (sum(product(a, b), sign(c)), true),
            Node::Select(_, a, b) => (sign(a).min(sign(b)), true),
            Node::Unary("abs", a) => (sign(a).max(NonNegative), true),
            Node::Unary("exp", _) => (Positive, true),
            Node::Unary("sqrt", a) => (sign(a).max(NonNegative), sign(a) >= NonNegative),
            Node::Unary("recip", a) => (sign(a), sign(a) == Positive),
            Node::Unary("ln", a) => (Unknown, sign(a) == Positive),
            Node::Binary(..) | Node::Powi(..) => (Unknown, false),
            _ => (Unknown, true),
        };
        let singular = !domain_is_safe || node.operands().into_iter().any(|a| of(a).singular);
        Known {
            sign: result,
            singular,
        }
    }

    fn constant(&self, place: u32) -> Option<f64> {
        match self.nodes[place as usize].0 {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }
}

fn place(node: Node) -> u32 {
    GRAPH.with_borrow_mut(|graph| graph.place(node))
}

impl Symbol {
    fn constant(self) -> Option<f64> {
        GRAPH.with_borrow(|graph| graph.constant(self.0))
    }
    fn is(self, value: f64) -> bool {
        self.constant() == Some(value)
    }
    fn known(self) -> Known {
        GRAPH.with_borrow(|graph| graph.nodes[self.0 as usize].1)
    }
    fn unary(self, method: &'static str) -> Self {
        Symbol(place(Node::Unary(method, self.0)))
    }
}

impl Add for Symbol {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        match () {
            () if self.is(0.0) => other,
            () if other.is(0.0) => self,
            () => Symbol(place(Node::Add(self.0, other.0))),
        }
    }
}
impl Sub for Symbol {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        match () {
            () if other.is(0.0) => self,
            () if self.is(0.0) => -other,
            () => Symbol(place(Node::Sub(self.0, other.0))),
        }
    }
}
impl Mul for Symbol {
    type Output = Self;
    /// Only trivial products are folded: other constants may stand for fields of the kernel. A product with a constant zero is zero here: the formula has no cotangent there.
    fn mul(self, other: Self) -> Self {
        let (a, b) = if self.0 <= other.0 {
            (self, other)
        } else {
            (other, self)
        };
        match (a.constant(), b.constant()) {
            (Some(0.0), _) | (_, Some(0.0)) => Symbol::lit(0.0),
            (Some(1.0), _) => b,
            (_, Some(1.0)) => a,
            (Some(-1.0), _) => -b,
            (_, Some(-1.0)) => -a,
            _ => Symbol(place(Node::Mul(a.0, b.0))),
        }
    }
}
impl Div for Symbol {
    type Output = Self;
    /// As a product with the reciprocal, which an adjoint needs anyway.
    #[allow(clippy::suspicious_arithmetic_impl)]
    fn div(self, other: Self) -> Self {
        self * other.recip()
    }
}
impl Neg for Symbol {
    type Output = Self;
    fn neg(self) -> Self {
        match self.constant() {
            Some(value) => Symbol::lit(-value),
            None => Symbol(place(Node::Neg(self.0))),
        }
    }
}
impl AddAssign for Symbol {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
impl SubAssign for Symbol {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
impl MulAssign for Symbol {
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}
impl DivAssign for Symbol {
    fn div_assign(&mut self, other: Self) {
        *self = *self / other;
    }
}
impl Zero for Symbol {
    fn zero() -> Self {
        Symbol::lit(0.0)
    }
    fn is_zero(&self) -> bool {
        self.is(0.0)
    }
}
impl One for Symbol {
    fn one() -> Self {
        Symbol::lit(1.0)
    }
}

impl BitAnd for SymbolMask {
    type Output = Self;
    fn bitand(self, other: Self) -> Self {
        SymbolMask(place(Node::Join('&', self.0, other.0)))
    }
}
impl BitOr for SymbolMask {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        SymbolMask(place(Node::Join('|', self.0, other.0)))
    }
}
impl Not for SymbolMask {
    type Output = Self;
    fn not(self) -> Self {
        SymbolMask(place(Node::Not(self.0)))
    }
}
impl Mask for SymbolMask {
    fn splat(value: bool) -> Self {
        SymbolMask(place(Node::Always(value)))
    }
    /// It may be true and it may be false: no lane is like another.
    fn any(self) -> bool {
        true
    }
}

impl Real for Symbol {
    type Mask = SymbolMask;

    fn lit(value: f64) -> Self {
        Symbol(place(Node::Constant(value.to_bits())))
    }
    fn lt(self, other: Self) -> SymbolMask {
        SymbolMask(place(Node::Compare("lt", self.0, other.0)))
    }
    fn le(self, other: Self) -> SymbolMask {
        SymbolMask(place(Node::Compare("le", self.0, other.0)))
    }
    fn select(mask: SymbolMask, if_true: Self, if_false: Self) -> Self {
        if if_true == if_false {
            return if_true;
        }
        Symbol(place(Node::Select(mask.0, if_true.0, if_false.0)))
    }
    fn fma(self, factor: Self, term: Self) -> Self {
        Symbol(place(Node::Fma(self.0, factor.0, term.0)))
    }
    fn recip(self) -> Self {
        self.unary("recip")
    }
    fn sqrt(self) -> Self {
        self.unary("sqrt")
    }
    fn exp(self) -> Self {
        self.unary("exp")
    }
    fn ln(self) -> Self {
        self.unary("ln")
    }
    fn sin(self) -> Self {
        self.unary("sin")
    }
    fn cos(self) -> Self {
        self.unary("cos")
    }
    fn tanh(self) -> Self {
        self.unary("tanh")
    }
    fn atan2(self, x: Self) -> Self {
        Symbol(place(Node::Binary("atan2", self.0, x.0)))
    }
    fn powi(self, exponent: i32) -> Self {
        Symbol(place(Node::Powi(self.0, exponent)))
    }
    fn powf(self, exponent: Self) -> Self {
        Symbol(place(Node::Binary("powf", self.0, exponent.0)))
    }
    fn abs(self) -> Self {
        if self.known().sign != Sign::Unknown {
            self
        } else {
            self.unary("abs")
        }
    }
    fn detach(self) -> Self {
        self
    }
    fn straight_through(self, _soft: Self) -> Self {
        self
    }
    fn chain(partial: Self, cotangent: Self) -> Self {
        let node = GRAPH.with_borrow(|graph| graph.nodes[partial.0 as usize].0);
        match node {
            // Into the branches of a select: what passes nothing is then zero.
            Node::Select(mask, a, b) => {
                let (a, b) = (Symbol(a), Symbol(b));
                if a.constant().or(b.constant()).is_some() {
                    let pass = |partial| Symbol::chain(partial, cotangent);
                    return Symbol::select(SymbolMask(mask), pass(a), pass(b));
                }
                partial * cotangent
            }
            _ if cotangent.is(1.0) || partial.constant().is_some() => partial * cotangent,
            _ if partial.known().singular => Symbol(place(Node::Chain(partial.0, cotangent.0))),
            _ => partial * cotangent,
        }
    }
}

/// An `impl Adjoint` for the kernel type `name`, as Rust source.
///
/// `fields` are the kernel's constants as the printed code reads them (`self.dt`), and `build`
/// makes a kernel whose fields have the given values, in that order.
///
/// # Panics
/// If the kernel computes a literal from a field (`R::lit(2.0 * self.dt)`): the printed code
/// could not follow a change of the field. Such a number belongs into a field of its own.
pub fn adjoint<K, const I: usize, const O: usize>(
    name: &str,
    fields: &[&str],
    build: impl Fn(&[f64]) -> K,
) -> String
where
    K: Kernel<I, O>,
{
    // Numbers that no kernel has among its literals.
    let stand_ins = |seed: f64| (1..=fields.len()).map(move |k| (seed + k as f64).sqrt().fract());
    let [text, again] = [std::f64::consts::E, std::f64::consts::PI].map(|seed| {
        let values: Vec<f64> = stand_ins(seed).collect();
        let named: Vec<_> = fields.iter().copied().zip(values.iter().copied()).collect();
        body(&build(&values), &named)
    });
    assert_eq!(
        text, again,
        "a literal of the kernel {name} depends on a field"
    );
    let body = text
        .lines()
        .map(|line| format!("        {line}\n"))
        .collect::<String>();
    format!(
        "impl Adjoint<{I}, {O}> for {name} {{\n    #[inline(always)]\n    \
         fn vjp<R: Real>(&self, x: [R; {I}], y_bar: [R; {O}]) -> [R; {I}] {{\n{body}    }}\n}}\n"
    )
}

/// The statements of `vjp` for a kernel whose fields have the values named.
fn body<K, const I: usize, const O: usize>(kernel: &K, fields: &[(&str, f64)]) -> String
where
    K: Kernel<I, O>,
{
    GRAPH.take();
    let input = |k: usize| Symbol(place(Node::Input(k as u32)));
    let x: [Symbol; I] = std::array::from_fn(input);
    let y_bar: [Symbol; O] = std::array::from_fn(|k| input(I + k));
    let mut tape = Tape::new();
    let y = tape.record(&x, |x| {
        kernel.eval(std::array::from_fn::<_, I, _>(|k| x[k]))
    });
    let x_bar: Vec<u32> = tape.pullback(&y, &y_bar).iter().map(|s| s.0).collect();
    GRAPH.with_borrow(|graph| Printer::new(graph, (I, O), fields).print(&x_bar))
}

struct Printer<'a> {
    graph: &'a Graph,
    sizes: (usize, usize),
    fields: &'a [(&'a str, f64)],
    /// How often each node is read.
    reads: Vec<usize>,
}

impl<'a> Printer<'a> {
    fn new(graph: &'a Graph, sizes: (usize, usize), fields: &'a [(&'a str, f64)]) -> Self {
        Self {
            graph,
            sizes,
            fields,
            reads: vec![0; graph.nodes.len()],
        }
    }

    fn print(mut self, outputs: &[u32]) -> String {
        let mut pending = outputs.to_vec();
        while let Some(place) = pending.pop() {
            self.reads[place as usize] += 1;
            if self.reads[place as usize] == 1 {
                pending.extend(self.graph.nodes[place as usize].0.operands());
            }
        }
        let names = |letter: char, places: std::ops::Range<usize>| {
            let first = places.start;
            let name = |place: usize| match self.reads[place] > 0 {
                true => format!("{letter}{}", place - first),
                false => "_".to_owned(),
            };
            places.map(name).collect::<Vec<_>>().join(", ")
        };
        let (inputs, cotangents) = self.sizes;
        let mut text = String::new();
        let _ = writeln!(text, "let [{}] = x;", names('x', 0..inputs));
        let _ = writeln!(
            text,
            "let [{}] = y_bar;",
            names('y', inputs..inputs + cotangents)
        );
        for (place, (node, _)) in self.graph.nodes.iter().enumerate() {
            let leaf = matches!(node, Node::Input(_));
            if self.reads[place] > 0 && !leaf && !self.is_folded(place as u32) {
                let _ = writeln!(text, "let t{place} = {};", self.formula(*node));
            }
        }
        let outputs: Vec<String> = outputs.iter().map(|&place| self.name(place)).collect();
        let _ = writeln!(text, "[{}]", outputs.join(", "));
        text
    }

    /// A product that only one sum reads goes into it.
    fn is_folded(&self, place: u32) -> bool {
        let reader = |node: &Node| match *node {
            Node::Add(a, b) => self.fold(a, b).is_some_and(|(product, _)| product == place),
            Node::Sub(a, b) => a != place && b == place,
            _ => false,
        };
        self.is_lone_product(place)
            && self
                .graph
                .nodes
                .iter()
                .enumerate()
                .any(|(at, (node, _))| self.reads[at] > 0 && reader(node))
    }

    fn is_lone_product(&self, place: u32) -> bool {
        matches!(self.graph.nodes[place as usize].0, Node::Mul(..))
            && self.reads[place as usize] == 1
    }

    /// The product among two terms that becomes part of a fused one, and the other term.
    fn fold(&self, a: u32, b: u32) -> Option<(u32, u32)> {
        match (self.is_lone_product(a), self.is_lone_product(b)) {
            (_, true) if a != b => Some((b, a)),
            (true, _) if a != b => Some((a, b)),
            _ => None,
        }
    }

    fn name(&self, place: u32) -> String {
        match self.graph.nodes[place as usize].0 {
            Node::Input(k) if (k as usize) < self.sizes.0 => format!("x{k}"),
            Node::Input(k) => format!("y{}", k as usize - self.sizes.0),
            _ => format!("t{place}"),
        }
    }

    fn formula(&self, node: Node) -> String {
        let name = |place| self.name(place);
        let factors = |product: u32| match self.graph.nodes[product as usize].0 {
            Node::Mul(a, b) => (self.name(a), self.name(b)),
            other => unreachable!("{other:?} is no product"),
        };
        match node {
            Node::Input(_) => unreachable!("inputs have names"),
            Node::Constant(bits) => self.constant(f64::from_bits(bits)),
            Node::Unary(method, a) => format!("{}.{method}()", name(a)),
            Node::Binary(method, a, b) => format!("{}.{method}({})", name(a), name(b)),
            Node::Powi(a, exponent) => format!("{}.powi({exponent})", name(a)),
            Node::Add(a, b) => match self.fold(a, b) {
                Some((product, term)) => {
                    let (f, g) = factors(product);
                    format!("{f}.fma({g}, {})", name(term))
                }
                None => format!("{} + {}", name(a), name(b)),
            },
            Node::Sub(a, b) if self.is_lone_product(b) => {
                let (f, g) = factors(b);
                format!("(-{f}).fma({g}, {})", name(a))
            }
            Node::Sub(a, b) => format!("{} - {}", name(a), name(b)),
            Node::Mul(a, b) => format!("{} * {}", name(a), name(b)),
            Node::Neg(a) => format!("-{}", name(a)),
            Node::Fma(a, b, c) => format!("{}.fma({}, {})", name(a), name(b), name(c)),
            Node::Chain(a, b) => format!("R::chain({}, {})", name(a), name(b)),
            Node::Compare(method, a, b) => format!("{}.{method}({})", name(a), name(b)),
            Node::Join(operator, a, b) => format!("{} {operator} {}", name(a), name(b)),
            Node::Not(a) => format!("!{}", name(a)),
            Node::Always(value) => format!("<R::Mask as Mask>::splat({value})"),
            Node::Select(m, a, b) => format!("R::select({}, {}, {})", name(m), name(a), name(b)),
        }
    }

    fn constant(&self, value: f64) -> String {
        for (name, field) in self.fields {
            if value == *field {
                return format!("R::lit({name})");
            }
            if value == -field {
                return format!("R::lit(-{name})");
            }
        }
        format!("R::lit({value:?})")
    }
}
