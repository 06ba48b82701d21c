//! Graphs that leave out some of their edges.

use autodiff_programs::Graph;

const NODES: usize = 40;

/// Springs join each node of a chain to the next one and to the third one after it.
fn edges() -> Vec<[usize; 2]> {
    let springs = |reach: usize| (0..NODES - reach).map(move |i| [i, i + reach]);
    springs(1).chain(springs(3)).collect()
}

/// Returns which edges to leave out: the first edges, and then every third one.
fn marked(count: usize) -> Vec<bool> {
    (0..count)
        .map(|e| e < 17 || (e > 30 && e % 3 == 0))
        .collect()
}

#[test]
fn what_is_left_out_is_a_ghost() {
    let (full, marked) = (Graph::new(NODES, &edges()), marked(edges().len()));
    let less = full.without(&marked);
    assert_eq!(full.slots(), less.slots());
    assert_eq!(full.slot_of_edge().len(), marked.len());
    assert_eq!(full.slot_of_edge(), less.slot_of_edge());
    let of_slot = less.edge_of_slot();
    for (edge, &slot) in full.slot_of_edge().iter().enumerate() {
        let is_left = !marked[edge];
        assert_eq!(of_slot[slot], is_left.then_some(edge));
        assert_eq!(less.nodes_of_slot()[slot], is_left.then_some(edges()[edge]));
    }
    let ones = less.to_slots(&vec![1.0; marked.len()]);
    let left = marked.iter().filter(|marked| !**marked).count();
    assert_eq!(ones.iter().sum::<f64>(), left as f64);
}
