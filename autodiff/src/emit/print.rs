//! The formula as Rust.

use std::fmt::Write;

use super::graph::{Graph, Node};

pub(super) struct Printer<'a> {
    graph: &'a Graph,
    sizes: (usize, usize),
    fields: &'a [(&'a str, f64)],
    /// How often each node is read.
    reads: Vec<usize>,
}

impl<'a> Printer<'a> {
    pub(super) fn new(
        graph: &'a Graph,
        sizes: (usize, usize),
        fields: &'a [(&'a str, f64)],
    ) -> Self {
        Self {
            graph,
            sizes,
            fields,
            reads: vec![0; graph.nodes.len()],
        }
    }

    /// The statements that compute some rows of the formula, and each row as an array.
    pub(super) fn print(mut self, rows: &[Vec<u32>]) -> (String, Vec<String>) {
        let mut pending = rows.concat();
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
        if cotangents > 0 {
            let names = names('y', inputs..inputs + cotangents);
            let _ = writeln!(text, "let [{names}] = y_bar;");
        }
        for (place, (node, _)) in self.graph.nodes.iter().enumerate() {
            let leaf = matches!(node, Node::Input(_));
            if self.reads[place] > 0 && !leaf && !self.is_folded(place as u32) {
                let _ = writeln!(text, "let t{place} = {};", self.formula(*node));
            }
        }
        let row = |row: &Vec<u32>| {
            let names: Vec<String> = row.iter().map(|&place| self.name(place)).collect();
            format!("[{}]", names.join(", "))
        };
        (text, rows.iter().map(row).collect())
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
