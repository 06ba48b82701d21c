//! Warnings about trusses that can be simulated but are probably a mistake, each with trusses that must not be warned about.

use cosmic::Registry;
use cosmic::geometry::{Dimension, Vector};
use cosmic::lattice::{Payload, Truss};
use cosmic::random::{Purpose, stream, symmetric};
use cosmic::scene::{BUILTIN, Scene};
use std::fs;
use std::path::Path;

type Place = [f64; 3];

/// A truss in space that stands on the ground, and whose edges join all nodes up to a distance.
fn joined(mut nodes: Vec<Place>, within: f64) -> Truss {
    let lowest = nodes
        .iter()
        .fold(f64::INFINITY, |least, place| least.min(place[2]));
    nodes.iter_mut().for_each(|place| place[2] -= lowest);
    let nodes: Vec<Vector<f64>> = nodes.into_iter().map(Vector::from).collect();
    let pairs = (0..nodes.len()).flat_map(|j| (0..j).map(move |i| [i, j]));
    let near = |[i, j]: &[usize; 2]| nodes[*i].distance(nodes[*j]) < within;
    Truss {
        dimension: Dimension::Space,
        edges: pairs.filter(near).collect(),
        nodes,
        ..Truss::default()
    }
}

/// Places on a grid of cells of 0.1 m.
fn grid([columns, depth, rows]: [usize; 3]) -> Vec<Place> {
    let along = (0..columns).flat_map(move |i| (0..depth).map(move |j| (i, j)));
    let all = along.flat_map(move |(i, j)| (0..rows).map(move |k| [i, j, k]));
    all.map(|place| place.map(|x| 0.1 * x as f64)).collect()
}

/// Longer than the diagonal of a cell's face, shorter than two cells.
const FACE: f64 = 0.16;

fn cube() -> Truss {
    joined(grid([2, 2, 2]), FACE)
}

/// The warnings about the truss of a scene.
fn warnings(truss: Truss) -> Vec<String> {
    let scene = Registry::default()
        .with_lattice("own", truss)
        .parse("own.toml", "base = 'stability'\n[lattice]\nfile = 'own'\n")
        .unwrap();
    let of_truss = |text: &String| text.contains("lattice.file");
    let all = scene.warnings().into_iter().map(|found| found.to_string());
    all.filter(of_truss).collect()
}

/// Asserts that there is one warning, with these words.
#[track_caller]
fn warns(truss: Truss, words: &[&str]) {
    let found = warnings(truss);
    assert_eq!(found.len(), 1, "{found:?}");
    for word in words {
        assert!(found[0].contains(word), "{word}: {found:?}");
    }
}

/// Turns the places about the axis across, then about the vertical one.
fn turned(places: Vec<Place>, [by, then]: [f64; 2]) -> Vec<Place> {
    let about = |[x, y, z]: Place| {
        let [x, z] = [x * by.cos() + z * by.sin(), z * by.cos() - x * by.sin()];
        [
            x * then.cos() - y * then.sin(),
            y * then.cos() + x * then.sin(),
            z,
        ]
    };
    places.into_iter().map(about).collect()
}

/// A frame in a plane has no stiffness across it, whatever the plane, also if the nodes are a little off the plane.
#[test]
fn a_flat_truss_in_space_is_noticed() {
    let mut draws = stream(1, Purpose::Judgement);
    for turn in [[0.0, 0.0], [0.0, 0.7], [0.6, 0.0], [1.1, 2.0]] {
        for off in [0.0, 1e-3] {
            let mut places = turned(grid([4, 1, 3]), turn);
            for x in places.iter_mut().flatten() {
                *x += symmetric(&mut draws, off);
            }
            warns(
                joined(places, FACE),
                &["the truss is flat", "no stiffness", "; "],
            );
        }
    }
    let standing = joined(grid([4, 1, 3]), FACE);
    warns(
        standing,
        &["direction [0, 1, 0]", "give it depth", "[along, above]"],
    );
    let upright = turned(grid([4, 1, 3]), [0.0, 0.25 * std::f64::consts::PI]);
    warns(joined(upright, FACE), &["0.71, 0]"]);
    // A drawing in a plane whose second number is the height lies on the ground.
    let lying = joined(grid([4, 3, 1]), FACE);
    warns(lying, &["direction [0, 0, 1]", "write [along, height]"]);
    // A truss of two layers, upright or turned, and the same frame in the plane.
    for turn in [[0.0, 0.0], [1.1, 2.0]] {
        assert_eq!(
            warnings(joined(turned(grid([4, 2, 3]), turn), FACE)),
            [""; 0]
        );
    }
    let mut plane = joined(grid([4, 1, 3]), FACE);
    plane.dimension = Dimension::Plane;
    assert_eq!(warnings(plane), [""; 0]);
    // Without diagonals its 17 bars leave 24 - 3 - 17 = 4 motions.
    let mut hinged = joined(grid([4, 1, 3]), 0.12);
    hinged.dimension = Dimension::Plane;
    warns(hinged, &["stretch no bar", "4 such motions"]);
}

/// A node whose edges lie in a plane, and parts that turn about a hinge, have no stiffness either.
#[test]
fn loose_nodes_and_hinges_are_noticed() {
    let mut tail = cube();
    tail.nodes.push([0.3, 0.05, 0.1].into());
    let of = |place: Place| tail.nodes.iter().position(|x| x.array() == place).unwrap();
    let (left, right) = (of([0.1, 0.0, 0.1]), of([0.1, 0.1, 0.1]));
    tail.edges.extend([[left, 8], [right, 8]]);
    let held = [[left, 8], [right, 8], [of([0.1, 0.0, 0.0]), 8]];
    warns(
        tail.clone(),
        &[
            "node 8 has no stiffness in the direction [0, 0, 1]",
            "add an edge",
        ],
    );
    tail.edges.truncate(tail.edges.len() - 2);
    tail.edges.extend(held);
    assert_eq!(warnings(tail), [""; 0]);
    // Two tetrahedra with a common edge.
    let places = [
        [0.0, 0.0, 0.0],
        [0.0, 0.1, 0.0],
        [0.1, 0.0, 0.0],
        [0.1, 0.05, 0.1],
        [-0.1, 0.0, 0.0],
        [-0.1, 0.05, 0.1],
    ];
    let mut hinge = joined(places.to_vec(), 0.17);
    assert_eq!(hinge.edges.len(), 11, "{:?}", hinge.edges);
    warns(
        hinge.clone(),
        &["stretch no bar", "1 such motion", "add at least 1 edge"],
    );
    // An edge between nodes 2 and 4 would pass through the axis of the hinge.
    hinge.edges.push([3, 5]);
    assert_eq!(warnings(hinge), [""; 0]);
}

/// A table: four legs under a plate of two layers.
fn table() -> Vec<Place> {
    let mut places = grid([4, 3, 2]);
    places.iter_mut().for_each(|place| place[2] += 0.1);
    let legs = [[0.0, 0.0], [0.3, 0.0], [0.0, 0.2], [0.3, 0.2]];
    places.extend(legs.map(|[x, y]| [x, y, 0.0]));
    places
}

/// A truss whose second number is the height lies on its side.
#[test]
fn a_truss_with_y_up_is_noticed() {
    let on_its_side = |places: Vec<Place>| -> Vec<Place> {
        places.into_iter().map(|[x, y, z]| [x, z, y]).collect()
    };
    let words = [
        "lie on its side",
        "exchange the second and the third number",
    ];
    assert_eq!(warnings(joined(table(), 0.23)), [""; 0]);
    warns(joined(on_its_side(table()), 0.23), &words);
    // A robot whose left is unlike its right stands on its feet, and not on its outrigger.
    let mut places = grid([2, 2, 2]);
    places.push([0.03, -0.08, 0.04]);
    assert_eq!(warnings(joined(places.clone(), FACE)), [""; 0]);
    warns(joined(on_its_side(places), FACE), &words);
    // A box is alike on all sides; its payload is on top.
    let with_payload = |places: Vec<Place>, at: Place| {
        let mut truss = joined(places, FACE);
        let near = |x: &Vector<f64>| x.distance(Vector::from(at)) < 1e-9;
        truss.payload = Payload::at(truss.nodes.iter().position(near).unwrap());
        truss
    };
    let places = grid([4, 3, 3]);
    assert_eq!(
        warnings(with_payload(places.clone(), [0.1, 0.1, 0.2])),
        [""; 0]
    );
    assert_eq!(
        warnings(with_payload(places.clone(), [0.0, 0.0, 0.0])),
        [""; 0]
    );
    warns(with_payload(places, [0.1, 0.2, 0.1]), &words);
}

/// Lengths in millimetres are noticed at every size that a robot may have; lengths in metres are not.
#[test]
fn lengths_in_millimetres_are_noticed_at_every_size() {
    let of_size = |size: f64| {
        let mut truss = cube();
        for node in &mut truss.nodes {
            *node = *node * (size / 0.1);
        }
        truss
    };
    for size in [0.006, 0.015, 0.05, 0.3, 0.9, 2.0, 4.9] {
        assert_eq!(warnings(of_size(size)), [""; 0], "{size} m");
        let text = serde_json::to_string(&of_size(1e3 * size)).unwrap();
        let says = match Truss::parse("own.json", &text) {
            Ok(truss) => warnings(truss).concat(),
            Err(refused) => refused.to_string(),
        };
        assert!(
            says.contains("lengths in millimetres by 1000"),
            "{size} m: {says}"
        );
    }
    warns(
        of_size(0.004),
        &["the robot measures 0.004 m", "lengths are in metres"],
    );
}

/// Edges that count nodes from 1 are refused, and the message says where counting begins.
#[test]
fn nodes_counted_from_1_are_noticed() {
    let says = |change: &dyn Fn(&mut Truss)| {
        let mut truss = cube();
        change(&mut truss);
        let text = serde_json::to_string(&truss).unwrap();
        Truss::parse("own.json", &text).unwrap_err().to_string()
    };
    let from_1 = says(&|truss| {
        truss
            .edges
            .as_flattened_mut()
            .iter_mut()
            .for_each(|node| *node += 1)
    });
    let hint = "nodes are counted from 0, but these edges count from 1: subtract 1 from every number of a node";
    assert!(from_1.contains(hint), "{from_1}");
    let beyond = says(&|truss| truss.edges[3][1] = 9);
    assert!(
        beyond.contains("nodes are counted from 0") && !beyond.contains("subtract"),
        "{beyond}"
    );
    let payload = says(&|truss| truss.payload = Payload::at(8));
    assert!(
        payload.contains("found 8; nodes are counted from 0"),
        "{payload}"
    );
    let kept = says(&|truss| truss.rules.keep = vec![truss.edges.len()]);
    assert!(kept.contains("edges are counted from 0"), "{kept}");
    // A list of nodes that has an entry for node 0, which nothing uses.
    let unused = says(&|truss| {
        truss.nodes.insert(0, [0.5, 0.5, 0.5].into());
        truss
            .edges
            .as_flattened_mut()
            .iter_mut()
            .for_each(|node| *node += 1);
    });
    assert!(
        unused.contains("no edge has node 0; nodes are counted from 0"),
        "{unused}"
    );
}

/// Built-in scenes and the trusses of the studies are not warned about.
#[test]
fn good_trusses_are_not_doubted() {
    for builtin in BUILTIN {
        assert_eq!(Scene::load(builtin.name).unwrap().warnings(), []);
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../studies/worlds");
    let mut count = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|name| name != "json") {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let truss = Truss::parse("world.json", &text).unwrap();
        assert_eq!(warnings(truss), [""; 0], "{}", path.display());
        count += 1;
    }
    assert!(count > 3, "{count}");
}
