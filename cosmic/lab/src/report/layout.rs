//! The picture of the layout at rest.

use super::files::RobotFiles;
use super::motion::SKELETON;
use super::picture::{Colour, Font, MUTED, PAPER, Pen, Picture};
use super::view::draw_payload;
use cosmic::design::Material;

/// Returns the colour of a material in a picture that does not show strains.
pub(super) fn colour(material: Material) -> Colour {
    match material {
        Material::Void => Colour::hex(0xc4cad1),
        Material::Skeleton => SKELETON,
        Material::Actuator => Colour::hex(0xd9541e),
    }
}

/// Draws the layout on the lattice at rest, in the frame of the ground.
pub(super) fn draw_layout(robot: &RobotFiles) -> String {
    let (lattice, design) = (&robot.lattice, &robot.design);
    let [width, height] = lattice.extent().array();
    let cell = 320.0 / width.max(height).max(1.0);
    let size = [460.0, 420.0];
    let left = 0.5 * (size[0] - cell * width);
    let place = |node: usize| {
        let [along, above] = (lattice.places[node] * cell).array();
        [left + along, 370.0 - above]
    };
    let mut picture = Picture::default();
    picture.text([24.0, 26.0], "Layout at rest", Font::BOLD);
    for (material, width) in [(Material::Skeleton, 3.5), (Material::Actuator, 5.0)] {
        let edges = design.materials.iter().zip(&design.edges);
        for (_, edge) in edges.filter(|(m, _)| **m == material) {
            picture.line(edge.map(place), Pen::new(colour(material), width));
        }
    }
    for node in 0..lattice.nodes() {
        picture.disc(place(node), 2.6, PAPER, Pen::new(MUTED, 1.0));
    }
    for payload in &lattice.payload {
        draw_payload(&mut picture, place(payload.node), 7.0);
    }
    let count = |m| design.materials.iter().filter(|e| **e == m).count();
    let [void, skeleton, actuator] = Material::ALL.map(count);
    let caption = format!("{skeleton} skeleton, {actuator} actuator, {void} void (not drawn)");
    picture.text([0.5 * size[0], 402.0], caption, Font::CAPTION);
    picture.to_svg(size, "Materials of the edges on the lattice at rest")
}
