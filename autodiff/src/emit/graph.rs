//! The formula: every node once, and what is known of it.

use std::cell::RefCell;
use std::collections::HashMap;

use crate::element::Elementary;

/// How a node was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Node {
    Input(u32),
    /// The bits of an f64.
    Constant(u64),
    /// A method of [`Real`] on one or two numbers.
    Unary(&'static str, u32),
    Binary(&'static str, u32, u32),
    Powi(u32, i32),
    Elementary(Elementary, u32),
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
    pub(super) fn operands(self) -> Vec<u32> {
        match self {
            Node::Input(_) | Node::Constant(_) | Node::Always(_) => vec![],
            Node::Unary(_, a)
            | Node::Powi(a, _)
            | Node::Elementary(_, a)
            | Node::Neg(a)
            | Node::Not(a) => vec![a],
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
pub(super) struct Known {
    pub(super) sign: Sign,
    /// May be infinite or NaN.
    pub(super) singular: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Sign {
    Unknown,
    NonNegative,
    Positive,
}

/// All nodes, each formula once.
#[derive(Default)]
pub(super) struct Graph {
    pub(super) nodes: Vec<(Node, Known)>,
    places: HashMap<Node, u32>,
}

thread_local! {
    pub(super) static GRAPH: RefCell<Graph> = RefCell::default();
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
            Node::Unary("detach", a) | Node::Binary("straight_through", a, _) => (sign(a), true),
            Node::Binary(..) | Node::Powi(..) | Node::Elementary(..) => (Unknown, false),
            _ => (Unknown, true),
        };
        let singular = !domain_is_safe || node.operands().into_iter().any(|a| of(a).singular);
        Known {
            sign: result,
            singular,
        }
    }

    pub(super) fn constant(&self, place: u32) -> Option<f64> {
        match self.nodes[place as usize].0 {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }
}

pub(super) fn place(node: Node) -> u32 {
    GRAPH.with_borrow_mut(|graph| graph.place(node))
}
