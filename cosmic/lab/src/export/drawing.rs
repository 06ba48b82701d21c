//! A drawing of the robot at rest as SVG, to scale: one unit of the drawing is a millimetre.

use super::member::{Member, nodes_of, place};
use crate::report::RobotFiles;
use cosmic::design::Material;
use cosmic::geometry::{Bounds, Dimension, Vector};
use cosmic::scene::SkeletonPart;
use std::fmt::Write;

/// Millimetres in a metre.
const MM: f64 = 1e3;

/// A view of the robot: the beginning of the ids of its lines, and the place in the drawing of a point in millimetres.
type View<'v> = (&'static str, Box<dyn Fn(Vector<f64>) -> [f64; 2] + 'v>);

/// Returns the views of a robot in this box, and the width and height of all of them. A robot in space is seen from the side,
/// from above (over the first view), and from the front (to its right).
fn views(dimension: Dimension, bounds: &Bounds) -> (Vec<View<'_>>, [f64; 2]) {
    let Bounds { low, high } = *bounds;
    let ([width, height], depth) = (bounds.size().in_plane(), bounds.size().sideways());
    let (under, size) = match dimension {
        Dimension::Plane => (0.0, [width, height]),
        Dimension::Space => (depth, [width + depth, depth + height]),
    };
    // The second axis of SVG points down.
    let down = move |point: Vector<f64>| under + (high.up() - point.up());
    let along = move |point: Vector<f64>| point.forward() - low.forward();
    let mut views: Vec<View<'_>> = vec![("bar", Box::new(move |p| [along(p), down(p)]))];
    if dimension == Dimension::Space {
        let above = move |p: Vector<f64>| [along(p), high.sideways() - p.sideways()];
        let front = move |p: Vector<f64>| [width + (p.sideways() - low.sideways()), down(p)];
        views.push(("above", Box::new(above)));
        views.push(("front", Box::new(front)));
    }
    (views, size)
}

/// Returns the drawing. Bars are lines between their nodes. A part of the skeleton is as wide as its section; other bars
/// have a thirtieth of the lattice's spacing. A robot in space has three views.
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
    let (views, [width, height]) = views(robot.lattice.dimension, &bounds);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.6}mm\" height=\"{height:.6}mm\" \
         viewBox=\"0 0 {width:.6} {height:.6}\" font-family=\"sans-serif\" text-anchor=\"middle\" \
         dominant-baseline=\"central\">\n<title>The robot at rest, to scale, in millimetres</title>\n"
    );
    let kinds = [
        ("skeleton", "#262b33", Material::Skeleton, outer),
        ("actuator", "#d9541e", Material::Actuator, thin),
    ];
    for view in &views {
        lines(&mut svg, view, members, kinds);
        let _ = writeln!(svg, "<g class=\"labels\" font-size=\"{:.6}\">", 1.5 * thin);
        for member in members {
            let [x, y] = view.1(member.axis.middle() * MM);
            label(&mut svg, [x, y], 0.9 * thin, member.edge);
        }
        for &node in &nodes {
            let [x, y] = view.1(place(robot, node) * MM);
            label(&mut svg, [x, y], 1.3 * thin, node);
        }
        svg += "</g>\n";
    }
    svg + "</svg>\n"
}

/// The class, the colour, the material and the width of lines.
type Kind = (&'static str, &'static str, Material, f64);

/// Writes the lines of all bars in a view.
fn lines(svg: &mut String, (ids, at): &View<'_>, members: &[Member], kinds: [Kind; 2]) {
    // Writing to a string cannot fail.
    for (class, colour, material, wide) in kinds {
        let _ = writeln!(
            svg,
            "<g class=\"{class}\" stroke=\"{colour}\" stroke-width=\"{wide:.6}\">"
        );
        for member in members.iter().filter(|member| member.material == material) {
            let [[x1, y1], [x2, y2]] = [member.axis.from, member.axis.to].map(|end| at(end * MM));
            let _ = writeln!(
                svg,
                "<line id=\"{ids}-{}\" x1=\"{x1:.6}\" y1=\"{y1:.6}\" x2=\"{x2:.6}\" y2=\"{y2:.6}\"/>",
                member.edge
            );
        }
        svg.push_str("</g>\n");
    }
}

/// Writes a number into a white disc.
fn label(svg: &mut String, [x, y]: [f64; 2], radius: f64, number: usize) {
    let _ = writeln!(
        svg,
        "<circle cx=\"{x:.6}\" cy=\"{y:.6}\" r=\"{radius:.6}\" fill=\"#fff\"/>\
         <text x=\"{x:.6}\" y=\"{y:.6}\">{number}</text>"
    );
}
