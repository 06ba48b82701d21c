//! The formula as Rust.

use std::fmt::Write;

use super::graph::{Graph, Node};

/// What a function is to compute.
pub(super) struct Formula {
    /// How many inputs come first among the nodes, and how many cotangents after them.
    pub(super) sizes: (usize, usize),
    /// The results of the kernel, where they are given.
    pub(super) results: Vec<u32>,
    /// The nodes wanted.
    pub(super) rows: Vec<Vec<u32>>,
}

pub(super) struct Printer<'a> {
    graph: &'a Graph,
    formula: &'a Formula,
    fields: &'a [(&'a str, f64)],
    /// How often each node is read.
    reads: Vec<usize>,
}

impl<'a> Printer<'a> {
    pub(super) fn new(
        graph: &'a Graph,
        formula: &'a Formula,
        fields: &'a [(&'a str, f64)],
    ) -> Self {
        Self {
            graph,
            formula,
            fields,
            reads: vec![0; graph.nodes.len()],
        }
    }

    /// The statements that compute the rows, and each row as an array.
    pub(super) fn print(mut self) -> (String, Vec<String>) {
        let Formula {
            sizes: (inputs, cotangents),
            results,
            rows,
        } = self.formula;
        let mut pending = rows.concat();
        while let Some(place) = pending.pop() {
            self.reads[place as usize] += 1;
            if self.reads[place as usize] == 1 && self.given(place).is_none() {
                pending.extend(self.graph.nodes[place as usize].0.operands());
            }
        }
        let mut text = String::new();
        let all: Vec<u32> = (0..(inputs + cotangents) as u32).collect();
        let (x, y_bar) = all.split_at(*inputs);
        for (letter, places, array) in [('x', x, "x"), ('r', results, "y"), ('y', y_bar, "y_bar")] {
            if !places.is_empty() {
                let _ = writeln!(text, "let [{}] = {array};", self.names(letter, places));
            }
        }
        for (place, (node, _)) in self.graph.nodes.iter().enumerate() {
            let place = place as u32;
            let leaf = matches!(node, Node::Input(_)) || self.given(place).is_some();
            if self.reads[place as usize] > 0 && !leaf && !self.is_folded(place) {
                let _ = writeln!(text, "let t{place} = {};", self.formula(*node));
            }
        }
        let row = |row: &Vec<u32>| {
            let names: Vec<String> = row.iter().map(|&place| self.name(place)).collect();
            format!("[{}]", names.join(", "))
        };
        (text, rows.iter().map(row).collect())
    }

    /// The pattern by which an argument is destructured; `_` for what is not read, or has another name.
    fn names(&self, letter: char, places: &[u32]) -> String {
        let name = |(k, &place): (usize, &u32)| {
            let own = format!("{letter}{k}");
            let used = self.reads[place as usize] > 0 && self.name(place) == own;
            if used { own } else { "_".to_owned() }
        };
        let names: Vec<String> = places.iter().enumerate().map(name).collect();
        names.join(", ")
    }

    /// Which result a node is, if the results are given.
    fn given(&self, place: u32) -> Option<usize> {
        let results = &self.formula.results;
        results.iter().position(|&result| result == place)
    }

    /// Whether this product is printed as part of the sum that alone reads it, as a fused multiply-add.
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
            && self.given(place).is_none()
    }

    /// Which of two terms is a product to be fused into their sum, and the other term.
    fn fold(&self, a: u32, b: u32) -> Option<(u32, u32)> {
        match (self.is_lone_product(a), self.is_lone_product(b)) {
            (_, true) if a != b => Some((b, a)),
            (true, _) if a != b => Some((a, b)),
            _ => None,
        }
    }

    fn name(&self, place: u32) -> String {
        let inputs = self.formula.sizes.0;
        match (self.graph.nodes[place as usize].0, self.given(place)) {
            (Node::Input(k), _) if (k as usize) < inputs => format!("x{k}"),
            (Node::Input(k), _) => format!("y{}", k as usize - inputs),
            (_, Some(result)) => format!("r{result}"),
            (_, None) => format!("t{place}"),
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
            Node::Elementary(f, a) => {
                let path = "autodiff::Elementary";
                format!("{}.elementary({path}::{f:?})", name(a))
            }
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
        match value {
            f64::INFINITY => "R::lit(f64::INFINITY)".into(),
            f64::NEG_INFINITY => "R::lit(f64::NEG_INFINITY)".into(),
            _ if value.is_nan() => "R::lit(f64::NAN)".into(),
            _ => format!("R::lit({value:?})"),
        }
    }
}
