use crate::small::lattice;
use cosmic::design::{Design, Material, filled, layout_materials, solid_and_actuators, start};
use cosmic::error::Result;
use cosmic::lattice::Lattice;
use cosmic::scene::{Layout, StartKind, StartSettings};

/// The initial design of the given kind on a lattice.
fn design(kind: StartKind, lattice: &Lattice) -> Result<Design<[f64; 3]>> {
    let settings = StartSettings {
        kind,
        void: 0.05,
        ..StartSettings::default()
    };
    start(&settings, lattice, 20.0, 0)
}

#[test]
fn starts_have_their_shares_of_void() {
    let (lattice, one_row) = (lattice(6, 6, 0.0), lattice(4, 1, 0.0));
    let third = 1.0 / 3.0;
    let upwards = lattice.midpoints().map(|m| third + 0.12 * m.up() / 5.0);
    let legs = layout_materials(Layout::Short, &lattice).unwrap();
    let beside = legs.iter().map(|m| if m.is_solid() { third } else { 0.05 });
    for (kind, lattice, void) in [
        (StartKind::Uniform, &lattice, vec![third; 110]),
        (StartKind::Filled, &lattice, vec![0.05; 110]),
        (StartKind::Stability, &lattice, upwards.collect()),
        (StartKind::Stability, &one_row, vec![third; 3]),
        (StartKind::ThreeLegged, &lattice, beside.collect()),
    ] {
        let Design::Undecided(z) = design(kind, lattice).unwrap() else {
            panic!("the initial design is a layout")
        };
        assert_eq!(z.len(), void.len());
        for (z, void) in z.into_iter().zip(void) {
            // For equal shares, the entries are exactly a third.
            assert!(z[1] == z[2] && (void != third || z == [third; 3]), "{z:?}");
            let e = z.map(|z| (20.0 * z).exp());
            // The rounding errors of z are multiplied by 20 in exp(20 z).
            assert!((e[0] / (e[0] + e[1] + e[2]) - void).abs() < 1e-14, "{z:?}");
        }
    }
}

#[test]
fn the_filled_layout_does_not_depend_on_the_direction_of_edges() {
    let mut lattice = lattice(6, 6, 0.0);
    let materials = filled(&lattice);
    for edge in &mut lattice.edges {
        edge.reverse();
    }
    assert_eq!(filled(&lattice), materials);
    assert!(materials.contains(&Material::Actuator));
}

#[test]
fn the_layouts_keep_the_volume_budget() {
    let lattice = lattice(6, 6, 0.0);
    for layout in [Layout::Tall, Layout::Short] {
        let materials = layout_materials(layout, &lattice).unwrap();
        assert_eq!(solid_and_actuators(&materials), [55, 22]);
        let settings = StartSettings {
            layout,
            kind: StartKind::Layout,
            ..StartSettings::default()
        };
        let begun = start(&settings, &lattice, 20.0, 0).unwrap();
        assert_eq!(begun, Design::Layout(materials));
    }
}

#[test]
fn the_filled_layout_spreads_its_actuators_over_the_vertical_edges() {
    let lattice = lattice(6, 6, 0.0);
    let materials = layout_materials(Layout::Filled, &lattice).unwrap();
    assert!(materials.iter().all(|material| material.is_solid()));
    let made_of = lattice.edges.iter().zip(&materials);
    let actuators = made_of.filter(|(_, m)| **m == Material::Actuator);
    let edges: Vec<[usize; 2]> = actuators.map(|(&edge, _)| edge).collect();
    assert_eq!(edges.len(), 24);
    assert!(edges.iter().all(|[i, j]| j - i == 6) && edges.contains(&[0, 6]));
    let in_column = |c: usize| edges.iter().filter(|[i, _]| i % 6 == c).count();
    assert_eq!([0, 1, 2, 3, 4, 5].map(in_column), [4; 6]);
}

#[test]
fn a_layout_for_another_lattice_is_refused() {
    let error = design(StartKind::Layout, &lattice(5, 5, 0.0)).unwrap_err();
    assert!(error.to_string().contains("has 25 nodes and 72 edges"));
}
