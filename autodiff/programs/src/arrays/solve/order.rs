//! The order in which the nodes of a graph are eliminated.

use std::collections::{BTreeSet, VecDeque};

/// For each node, the nodes that an edge connects with it.
type Neighbours = Vec<Vec<usize>>;

/// Returns for each node its place in an order in which connected nodes are close to each other. It is the order with the
/// smallest [`bandwidth`] of these: the given order; for each offset `d` between the nodes of an edge, the order by `node mod
/// d`, which goes through a lattice column by column if it is given row by row; and an order [from end to
/// end](from_end_to_end).
pub(super) fn places(nodes: usize, edges: &[[usize; 2]]) -> Vec<usize> {
    let mut neighbours: Neighbours = vec![Vec::new(); nodes];
    for &[tail, head] in edges {
        neighbours[tail].push(head);
        neighbours[head].push(tail);
    }
    let offsets: BTreeSet<usize> = edges.iter().map(|[tail, head]| head - tail).collect();
    let by_offset = offsets.into_iter().map(|offset| {
        let mut order: Vec<usize> = (0..nodes).collect();
        order.sort_by_key(|node| node % offset);
        order
    });
    let orders = [(0..nodes).collect()].into_iter().chain(by_offset);
    let orders = orders.chain([from_end_to_end(&neighbours)]);
    let places = orders.map(|order: Vec<usize>| {
        let mut places = vec![0; nodes];
        (order.iter().enumerate()).for_each(|(place, &node)| places[node] = place);
        places
    });
    let best = places.min_by_key(|places| bandwidth(places, edges));
    best.expect("there is the given order")
}

/// The largest distance between the places of two connected nodes.
pub(super) fn bandwidth(places: &[usize], edges: &[[usize; 2]]) -> usize {
    let distance = |&[tail, head]: &[usize; 2]| places[tail].abs_diff(places[head]);
    edges.iter().map(distance).max().unwrap_or(0)
}

/// The nodes of each connected part of the graph, from one end of the part to the other: sorted by the distance to one
/// end minus the distance to the other. In a lattice such an order goes along the longer side.
fn from_end_to_end(neighbours: &Neighbours) -> Vec<usize> {
    let mut order = Vec::new();
    let mut is_known = vec![false; neighbours.len()];
    for node in 0..neighbours.len() {
        if is_known[node] {
            continue;
        }
        // The last node that a search reaches is at an end. Two more searches find ends that are far apart.
        let end = |from: usize| {
            *by_distance(neighbours, from)
                .0
                .last()
                .expect("the node itself")
        };
        let first = end(end(node));
        let (mut part, of_first) = by_distance(neighbours, first);
        let last = *part.last().expect("the node itself");
        let (_, of_last) = by_distance(neighbours, last);
        part.iter().for_each(|&node| is_known[node] = true);
        // The sort is stable, so nodes at the same distances stay in the order of the search.
        part.sort_by_key(|&node| of_first[node].cast_signed() - of_last[node].cast_signed());
        order.extend(part);
    }
    order
}

/// The nodes that can be reached from a node, nearest first, and the number of edges to each node.
fn by_distance(neighbours: &Neighbours, from: usize) -> (Vec<usize>, Vec<usize>) {
    let mut distance = vec![usize::MAX; neighbours.len()];
    let (mut order, mut waiting) = (Vec::new(), VecDeque::from([from]));
    distance[from] = 0;
    while let Some(node) = waiting.pop_front() {
        order.push(node);
        for &next in &neighbours[node] {
            if distance[next] == usize::MAX {
                distance[next] = distance[node] + 1;
                waiting.push_back(next);
            }
        }
    }
    (order, distance)
}
