//! The picture of the layout at rest.

use super::files::RobotFiles;
use super::motion::{SKELETON, hex};
use super::svg::{BOLD, MUTED_LINE, MUTED_MIDDLE, Svg};
use cosmic::design::Material;

/// Colour of actuators without strain colours.
const ACTUATOR: &str = "#d9541e";

/// The colour of a material without strain colours.
pub(super) fn colour(material: Material) -> String {
    match material {
        Material::Void => "#c4cad1".to_owned(),
        Material::Skeleton => hex(SKELETON),
        Material::Actuator => ACTUATOR.to_owned(),
    }
}

/// The layout on the lattice at rest, in the ground's frame.
pub(super) fn draw_layout(robot: &RobotFiles) -> String {
    let (lattice, design) = (&robot.lattice, &robot.design);
    let [width, height] = lattice.extent();
    let cell = 320.0 / width.max(height).max(1.0);
    let size = [460.0, 420.0];
    let left = 0.5 * (size[0] - cell * width);
    let place = |node: usize| {
        let [along, above] = lattice.places[node];
        [left + cell * along, 370.0 - cell * above]
    };
    let mut svg = Svg::default();
    svg.text([24.0, 26.0], "Layout at rest", BOLD);
    for material in [Material::Skeleton, Material::Actuator] {
        let made_of = design.materials.iter().zip(&design.edges);
        let edges = made_of.filter(|(m, _)| **m == material);
        let width = material.of(&[0.0, 3.5, 5.0]);
        let colour = colour(material);
        let style =
            format!(r#"stroke="{colour}" stroke-width="{width:.1}" stroke-linecap="round""#);
        for (_, &[i, j]) in edges {
            svg.line(place(i), place(j), &style);
        }
    }
    let node_style = format!(r##"fill="#fff" {MUTED_LINE}"##);
    for node in 0..lattice.nodes() {
        svg.circle(place(node), 2.6, &node_style);
    }
    let payload_style = r##"fill="#e68a00" stroke="#fff" stroke-width="1.5""##;
    for payload in &lattice.payload {
        svg.circle(place(payload.node), 7.0, payload_style);
    }
    let count = |m| design.materials.iter().filter(|e| **e == m).count();
    let [void, skeleton, actuator] = Material::ALL.map(count);
    let caption = format!("{skeleton} skeleton, {actuator} actuator, {void} void (not drawn)");
    svg.text([0.5 * size[0], 402.0], &caption, MUTED_MIDDLE);
    svg.finish(size, "Materials of the edges on the lattice at rest")
}
