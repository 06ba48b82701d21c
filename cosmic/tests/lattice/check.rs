use cosmic::geometry::{Dimension, Segment, Vector};
use cosmic::lattice::{EdgeRules, Payload, Truss};
use proptest::prelude::*;
use std::collections::BTreeSet;

/// Two triangles with a common edge, and one edge that ends freely.
const KITE: &str = r#"{
 "format": "cosmic-truss", "version": 1,
 "nodes": [[0, 0], [0.1, 0], [0.05, 0.1], [0.15, 0.1], [0.3, 0.1]],
 "edges": [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3], [3, 4]],
 "payload": [{"node": 2, "mass": 0.5}, {"node": 0}],
 "keep": [5], "forbid": [0], "tie": [[4, 2, 3]]
}"#;

/// Each change in `wrong_trusses.txt` is refused, and the message has the words that the file lists.
#[test]
fn invalid_trusses_are_refused_with_their_place() {
    let (_, rows) = include_str!("../wrong_trusses.txt")
        .split_once("\n\n")
        .unwrap();
    let mut count = 0;
    for row in rows.trim_end().split("\n\n") {
        let with = |mark: char| row.lines().filter_map(move |line| line.strip_prefix(mark));
        let [from, to] = ['-', '+'].map(|mark| with(mark).next().unwrap().trim());
        assert!(KITE.contains(from), "{from}");
        let refused = Truss::parse("kite.json", &KITE.replacen(from, to, 1));
        let found = refused.unwrap_err().to_string();
        let has = |words: &str| found.contains(words.trim());
        assert!(with('!').all(has) && has("kite.json:"), "{row}\n{found}");
        count += 1;
    }
    assert!(count > 25, "{count}");
    let none = "{\"format\": \"cosmic-truss\", \"version\": 1, \"nodes\": [], \"edges\": []}";
    let none = Truss::parse("none", none).unwrap_err().to_string();
    assert!(none.contains("expected at least one edge"), "{none}");
}

/// A truss is valid even if its edges cross, overlap or end freely, or if it consists of separate pieces.
#[test]
fn unusual_trusses_are_read() {
    let fine = r#"{"format": "cosmic-truss", "version": 1,
        "nodes": [[0, 0], [1, 1], [0, 1], [1, 0], [2, 0], [5, 5], [5, 6]],
        "edges": [[0, 1], [2, 3], [0, 3], [0, 4], [5, 6]], "payload": 3,
        "keep": [2, 2], "skeleton": [0], "actuator": [1]}"#;
    let fine = Truss::parse("fine", fine).unwrap();
    let mass = None;
    assert_eq!(fine.payload, [Payload { node: 0, mass }]);
    let ends = |edge: usize| fine.edges[edge].map(|node| fine.nodes[node]);
    assert_eq!(fine.nodes[0], [1.0, 0.0]);
    assert_eq!(ends(2), [[0.0, 0.0], [1.0, 0.0]]);
    assert_eq!(ends(4), [[5.0, 5.0], [5.0, 6.0]]);
}

/// The numbers of the nodes tell whether a truss is in the plane or in space.
#[test]
fn a_truss_with_three_coordinates_is_in_space() {
    let cube = r#"{"format": "cosmic-truss", "version": 1,
        "nodes": [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]],
        "edges": [[0, 1], [0, 2], [0, 3], [1, 2]]}"#;
    let truss = Truss::parse("cube.json", cube).unwrap();
    assert_eq!(truss.dimension, Dimension::Space);
    assert_eq!(truss.nodes[2], Vector::new([0.0, 0.1, 0.0]));
    let declared = cube.replacen("\"nodes\"", "\"dimension\": 3, \"nodes\"", 1);
    let refused = Truss::parse("cube.json", &declared)
        .unwrap_err()
        .to_string();
    assert!(refused.contains("unknown field `dimension`"), "{refused}");
}

proptest! {
    /// Every truss is either refused or renumbered. Renumbering changes nothing else.
    #[test]
    fn a_truss_is_refused_or_numbered_once(
        nodes in prop::collection::vec([0.0..1.0, 0.0..1.0], 7),
        more in prop::collection::vec((0..7usize, 0..7usize), 0..12),
        (first, other) in (0..7usize, prop::option::of(0..7usize)),
        keep in prop::collection::vec(0..12usize, 0..2),
        forbid in prop::collection::vec(0..12usize, 0..2),
        tie in prop::collection::vec(prop::collection::vec(0..12usize, 0..4), 0..2),
    ) {
        let payload = [first].into_iter().chain(other);
        let path = (0..6).map(|node| [node, node + 1]);
        let more: BTreeSet<_> = more.into_iter().filter(|(i, j)| i + 1 < *j).collect();
        let edges = path.chain(more.into_iter().map(|(i, j)| [j, i])).collect();
        let truss = Truss {
            payload: payload.map(|node| Payload { node, mass: None }).collect(),
            rules: EdgeRules { keep, forbid, tie, ..EdgeRules::default() },
            nodes: nodes.into_iter().map(Vector::from).collect(),
            edges,
            ..Truss::default()
        };
        let Ok(numbered) = truss.clone().checked() else { return Ok(()) };
        let ends = |truss: &Truss| -> Vec<Segment> {
            let edges = truss.edges.iter();
            edges.map(|&[i, j]| Segment::new(truss.nodes[i], truss.nodes[j])).collect()
        };
        prop_assert_eq!(ends(&numbered), ends(&truss));
        prop_assert_eq!(numbered.payload[0].node, 0);
        prop_assert_eq!(numbered.nodes[0], truss.nodes[first]);
        let given = |node: usize| truss.nodes[numbered.given_number(node)];
        prop_assert_eq!((0..7).map(given).collect::<Vec<_>>(), numbered.nodes.clone());
        let copy = Truss::parse("copy", &numbered.to_json()).unwrap();
        prop_assert_eq!(&copy.given_numbers, &numbered.given_numbers);
        prop_assert_eq!(copy, numbered);
    }
}

#[test]
#[should_panic(expected = "the lattice \"bad\": `edges[0]`")]
fn an_invalid_truss_cannot_be_added() {
    let edges = vec![[0, 0]];
    let bad = Truss {
        edges,
        ..Truss::default()
    };
    let _ = cosmic::Registry::default().with_lattice("bad", bad);
}
