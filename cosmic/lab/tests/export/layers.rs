use super::member::sample;
use cosmic_lab::export::layers::Stack;
use cosmic_lab::export::member::Member;

fn stack(members: &[Member]) -> Stack {
    Stack::new(members, 2.0, |a, b| a.distance(b) < 1.0)
}

/// Returns bars between nodes that are in a row, 10 mm apart.
fn in_a_row(edges: &[[usize; 2]]) -> Vec<Member> {
    let place = |node: usize| [10.0 * node as f64, 0.0];
    let bars = edges.iter().enumerate();
    bars.map(|(k, nodes)| sample(k, *nodes, nodes.map(place)))
        .collect()
}

#[test]
fn bars_that_touch_are_in_different_layers_and_few_are_used() {
    let corners = [[0.0, 0.0], [10.0, 0.0], [0.0, 10.0], [10.0, 10.0]];
    let edges = [[0, 1], [0, 2], [1, 3], [2, 3], [0, 3], [1, 2]];
    let bars: Vec<Member> = (edges.iter().enumerate())
        .map(|(k, nodes)| sample(k, *nodes, nodes.map(|n| corners[n])))
        .collect();
    let stack = stack(&bars);
    for (k, a) in bars.iter().enumerate() {
        for (l, b) in bars.iter().enumerate().skip(k + 1) {
            assert!(a.distance(b) >= 1.0 || stack.of_member[k] != stack.of_member[l]);
        }
    }
    // Opposite sides of the square share a layer; each diagonal touches all other bars.
    assert_eq!((stack.height(), stack.blocked), (4, None));
    assert!(stack.at_node.values().all(|span| span.end() > span.start()));
}

#[test]
fn a_bar_across_a_node_is_on_top_and_two_that_block_each_other_are_reported() {
    let stack_of = |edges: &[[usize; 2]]| stack(&in_a_row(edges));
    let one = stack_of(&[[0, 2], [0, 1], [1, 2], [2, 3]]);
    assert_eq!((one.of_member[0], one.blocked), (2, None));
    // Whichever of the first two bars is on top, the pin at its end goes through the other one.
    let two = stack_of(&[[0, 2], [1, 3], [0, 1], [1, 2], [2, 3]]);
    assert!(two.blocked.is_some());
}
