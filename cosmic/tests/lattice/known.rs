//! Truss files of robots that exist: materials, rest lengths and stiffnesses that the file decides.

use std::fs;

use cosmic::Registry;
use cosmic::case::Case;
use cosmic::design::{Material, filled};
use cosmic::lattice::{Lattice, Truss};
use cosmic::scene::{AnyDesign, Scene};
use cosmic::world::Span;

/// Two struts across a square, held together by four ropes that are 5 % shorter than its sides.
const TENSEGRITY: &str = r#"{"format": "cosmic-truss", "version": 1,
 "nodes": [[0.0, 0.0], [0.3, 0.0], [0.3, 0.3], [0.0, 0.3]],
 "edges": [[0, 2], [1, 3], [0, 1], [1, 2], [2, 3], [3, 0]],
 "skeleton": [0, 1], "actuator": [2, 3, 4, 5],
 "rest": [0.42426406871192857, 0.42426406871192857, 0.285, 0.285, 0.285, 0.285],
 "stiffness": [5000, 5000, 500, 500, 500, 500]}"#;

/// A world without gravity and ground in which the tensegrity comes to rest, with the default materials.
const SPACE: &str = "base = 'stability'\nlattice.file = 'tensegrity'\nvolume = {solid = [1.0, 1.0], actuator = [0.6, \
                     0.7]}\nphysics = {gravity = 0.0, damping = 20.0, contact = 'none', dt = 0.001, steps = 4000, \
                     node_mass = 0.1, payload_mass = 0.0, forces = []}\nmaterials.max_strain = [0.0, 0.0, 0.0]";

fn tensegrity() -> Scene {
    let truss = Truss::parse("tensegrity.json", TENSEGRITY).unwrap();
    let registry = Registry::default().with_lattice("tensegrity", truss);
    let scene = registry.parse("space", SPACE);
    scene.unwrap_or_else(|error| panic!("{error}"))
}

/// The tension of an edge after the rollout of a case, N.
fn tension(case: &Case, edge: usize) -> f64 {
    let robot = case.robot();
    let seen = (case.world()).run_one(&robot, &Span::of_steps(case.scene.physics.steps));
    let [i, j] = case.lattice.edges[edge];
    let x = &seen.states[0].x;
    robot.body.stiffness[edge] * (x[i].distance(x[j]) - case.lattice.rest_length[edge])
}

/// The prestress follows from the rest lengths and stiffnesses of the file. The right values are those of the balance of
/// one rope and one strut at a corner.
#[test]
fn a_tensegrity_has_its_prestress() {
    let case = Case::of_scene(&tensegrity(), 1).unwrap();
    for edge in 0..6 {
        let right = if edge < 2 { -9.642365 } else { 6.818182 };
        // The values are given to six decimals. What is left of the motion is damped by exp(-40).
        assert!(
            (tension(&case, edge) - right).abs() < 1e-5,
            "{edge}: {}",
            tension(&case, edge)
        );
    }
}

/// The edges have the materials of the file from the start: in the mixtures, in the filled layout and in the body.
#[test]
fn edges_have_their_materials() {
    let scene = tensegrity();
    let case = Case::of_scene(&scene, 1).unwrap();
    let filled = filled(&case.lattice);
    for (edge, mixture) in case.own_design().mixtures().iter().enumerate() {
        let right = if edge < 2 {
            Material::Skeleton
        } else {
            Material::Actuator
        };
        assert_eq!((mixture.dominant(), filled[edge]), (right, right));
        // Other shares are less than half of the last bit of 1.
        assert_eq!(mixture[right], 1.0);
    }
    assert_eq!(
        case.body().stiffness,
        [5000.0, 5000.0, 500.0, 500.0, 500.0, 500.0]
    );
    // The bound on frequencies holds for the stiffnesses of the file: with the struts it is at least
    // sqrt(2 * 5000 / 0.1), and the stiffest material has 400 N/m.
    let any_design = AnyDesign::new(&case.lattice, &scene.materials, &scene.physics);
    let stiffest = any_design.frequency();
    assert!(stiffest > 316.0, "{stiffest}");
}

/// A case has all of it, and moves alike.
#[test]
fn a_case_keeps_the_bars_of_a_truss() {
    let mut scene = tensegrity();
    scene.physics.steps = 200;
    let case = Case::of_scene(&scene, 1).unwrap();
    let read = Case::parse("case.json", &case.to_json()).unwrap();
    assert_eq!(read.lattice.rules, case.lattice.rules);
    assert_eq!(read.lattice.stiffness, case.lattice.stiffness);
    assert_eq!(read.lattice.rest_length, case.lattice.rest_length);
    assert_eq!(tension(&read, 2), tension(&case, 2));
}

/// Text in UTF-16, with and without a byte order mark, is named in every file that people write.
#[test]
fn utf_16_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("my.json");
    let utf_16 =
        |text: &str| -> Vec<u8> { text.encode_utf16().flat_map(u16::to_le_bytes).collect() };
    for mark in ["\u{feff}", ""] {
        fs::write(&path, utf_16(&format!("{mark}{TENSEGRITY}"))).unwrap();
        let errors = [
            Truss::read(&path).unwrap_err(),
            cosmic::outcome::DesignFile::read(&path).unwrap_err(),
            Case::read(&path).unwrap_err(),
            Registry::default().read(&path).unwrap_err(),
        ];
        for error in errors {
            let says = error.to_string();
            assert!(
                says.contains("UTF-16 or UTF-32 text; save it as UTF-8"),
                "{says}"
            );
        }
    }
    fs::write(&path, b"{\"format\": \"caf\xe9\"}").unwrap();
    let says = Truss::read(&path).unwrap_err().to_string();
    assert!(says.contains("the byte 0xe9 is not UTF-8 text"), "{says}");
}

/// A lattice whose mirror image has other bars is not its own mirror image.
#[test]
fn a_mirror_image_has_the_same_bars() {
    let truss = Truss::parse("tensegrity.json", TENSEGRITY).unwrap();
    let own = Lattice::between(truss.nodes.clone(), truss.edges.clone());
    let mut lattice = Lattice {
        payload: Vec::new(),
        ..own
    };
    assert!(lattice.image().is_some());
    lattice.stiffness = vec![5000.0, 4000.0, 500.0, 500.0, 500.0, 500.0];
    assert!(lattice.image().is_none());
}
