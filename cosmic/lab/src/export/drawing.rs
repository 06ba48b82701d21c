//! A drawing of the robot at rest as SVG, to scale: one unit of the drawing is a millimetre.

use super::member::{Member, nodes_of, place};
use crate::report::RobotFiles;
use cosmic::design::Material;
use cosmic::geometry::{Bounds, Vector};
use cosmic::scene::SkeletonPart;
use std::fmt::Write;

/// Millimetres in a metre.
const MM: f64 = 1e3;

/// Returns the drawing. Bars are lines between their nodes. A part of the skeleton is as wide as its section; other bars
/// have a thirtieth of the lattice's spacing.
pub(super) fn draw(robot: &RobotFiles, members: &[Member]) -> String {
    let parts = &robot.scene.materials.parts;
    let thin = MM * robot.lattice.spacing / 30.0;
    let outer = match parts.skeleton {
        SkeletonPart::Numbers => thin,
        SkeletonPart::Tube | SkeletonPart::Rod | SkeletonPart::Strut => MM * parts.outer,
    };
    let nodes = nodes_of(members);
    let bounds = Bounds::of(nodes.iter().map(|&node| place(robot, node) * MM));
    let bounds = bounds.widened(3.0 * thin + outer);
    let [width, height] = bounds.size().in_plane();
    // The second axis of SVG points down.
    let down = |point: Vector<f64>| {
        [
            point.forward() - bounds.low.forward(),
            bounds.high.up() - point.up(),
        ]
    };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.6}mm\" height=\"{height:.6}mm\" \
         viewBox=\"0 0 {width:.6} {height:.6}\" font-family=\"sans-serif\" text-anchor=\"middle\" \
         dominant-baseline=\"central\">\n<title>The robot at rest, to scale, in millimetres</title>\n"
    );
    // Writing to a string cannot fail.
    for (class, colour, material, wide) in [
        ("skeleton", "#262b33", Material::Skeleton, outer),
        ("actuator", "#d9541e", Material::Actuator, thin),
    ] {
        let _ = writeln!(
            svg,
            "<g class=\"{class}\" stroke=\"{colour}\" stroke-width=\"{wide:.6}\">"
        );
        for member in members.iter().filter(|member| member.material == material) {
            let [[x1, y1], [x2, y2]] = [member.axis.from, member.axis.to].map(|end| down(end * MM));
            let _ = writeln!(
                svg,
                "<line id=\"bar-{}\" x1=\"{x1:.6}\" y1=\"{y1:.6}\" x2=\"{x2:.6}\" y2=\"{y2:.6}\"/>",
                member.edge
            );
        }
        svg += "</g>\n";
    }
    let _ = writeln!(svg, "<g class=\"labels\" font-size=\"{:.6}\">", 1.5 * thin);
    for member in members {
        let [x, y] = down(member.axis.middle() * MM);
        label(&mut svg, [x, y], 0.9 * thin, member.edge);
    }
    for &node in &nodes {
        let [x, y] = down(place(robot, node) * MM);
        label(&mut svg, [x, y], 1.3 * thin, node);
    }
    svg + "</g>\n</svg>\n"
}

/// Writes a number into a white disc.
fn label(svg: &mut String, [x, y]: [f64; 2], radius: f64, number: usize) {
    let _ = writeln!(
        svg,
        "<circle cx=\"{x:.6}\" cy=\"{y:.6}\" r=\"{radius:.6}\" fill=\"#fff\"/>\
         <text x=\"{x:.6}\" y=\"{y:.6}\">{number}</text>"
    );
}
