//! The formula as a graph: every subexpression once, and what is known of it.

use std::cell::RefCell;
use std::collections::HashMap;

use super::known::{Known, Range};
use crate::elementary::Elementary;

/// How a node was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Node {
    Input(u32),
    /// The bits of an f64.
    Constant(u64),
    /// A method of [`Real`](crate::Real) on one or two numbers.
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

    /// The operands that are sure to be finite where the value is.
    fn shows(self) -> Vec<u32> {
        match self {
            Node::Add(..) | Node::Sub(..) | Node::Mul(..) | Node::Fma(..) | Node::Neg(_) => {
                self.operands()
            }
            Node::Unary("abs" | "sqrt" | "ln" | "sin" | "cos" | "detach", _) => self.operands(),
            Node::Binary("straight_through", hard, _) => vec![hard],
            _ => vec![],
        }
    }
}

/// More nodes than anyone would check in.
const MOST: usize = 1 << 20;

/// All nodes, each subexpression once (hash-consing).
#[derive(Default)]
pub(super) struct Graph {
    pub(super) nodes: Vec<(Node, Known)>,
    /// Constants that stand for fields: nothing but finiteness is known of those.
    fields: Vec<f64>,
    places: HashMap<Node, u32>,
}

thread_local! {
    pub(super) static GRAPH: RefCell<Graph> = RefCell::default();
}

impl Graph {
    pub(super) fn new(fields: &[f64]) -> Self {
        Self {
            fields: fields.to_vec(),
            ..Self::default()
        }
    }

    fn place(&mut self, node: Node) -> u32 {
        if let Some(&place) = self.places.get(&node) {
            return place;
        }
        assert!(
            self.nodes.len() < MOST,
            "a kernel of more than {MOST} operations cannot be emitted: does it loop until \
             `Mask::any` is false? For symbols it never is"
        );
        let place = self.nodes.len() as u32;
        self.nodes.push((node, self.known(node)));
        self.places.insert(node, place);
        place
    }

    /// What is known of a node by its operands.
    fn known(&self, node: Node) -> Known {
        let of = |place: u32| self.nodes[place as usize].1;
        let product = |a, b| {
            if a == b {
                of(a).squared()
            } else {
                of(a).times(of(b))
            }
        };
        match node {
            Node::Input(_) => Known::within(Range::Finite),
            Node::Constant(bits) => match f64::from_bits(bits) {
                value if self.fields.contains(&value.abs()) => Known::within(Range::Bounded),
                value => Known::constant(value),
            },
            Node::Add(a, b) => of(a).plus(of(b)),
            Node::Sub(a, b) => of(a).plus(of(b).negated()),
            Node::Mul(a, b) | Node::Chain(a, b) => product(a, b),
            Node::Neg(a) => of(a).negated(),
            // Unlike a product by itself, one inside is not rounded to a zero first: a small negative
            // product may round to a negative zero in the end.
            Node::Fma(a, b, c) => Known {
                unsigned: a == b && of(c).unsigned && of(c).least >= 0.0,
                ..product(a, b).plus(of(c))
            },
            Node::Select(_, a, b) => of(a).or(of(b)),
            Node::Unary(method, a) => of(a).through(method),
            Node::Binary("straight_through", hard, soft) => Known {
                least: of(hard).least,
                ..of(hard).or(of(soft))
            },
            Node::Binary(..) | Node::Powi(..) | Node::Elementary(..) => {
                Known::within(Range::Singular)
            }
            Node::Compare(..) | Node::Join(..) | Node::Not(_) | Node::Always(_) => {
                Known::within(Range::Bounded)
            }
        }
    }

    /// Notes that these results are finite, and with them every number whose infinity would show there.
    pub(super) fn assume_finite(&mut self, results: &[u32]) {
        let mut shown = vec![false; self.nodes.len()];
        let mut pending = results.to_vec();
        while let Some(place) = pending.pop() {
            if !std::mem::replace(&mut shown[place as usize], true) {
                pending.extend(self.nodes[place as usize].0.shows());
            }
        }
        for (place, shown) in shown.into_iter().enumerate() {
            let node = self.nodes[place].0;
            let known = self.known(node);
            self.nodes[place].1 = match node {
                Node::Unary(method, _) if shown => known.shown(method),
                _ if shown => known.shown(""),
                _ => known,
            };
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
