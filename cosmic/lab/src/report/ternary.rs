//! The mixtures of edges in a triangle whose corners are void, skeleton and actuator.

use std::collections::BTreeMap;

use super::files::{RobotFiles, RunFiles};
use super::layout::colour;
use super::svg::{BOLD, INK_LINE, MIDDLE, MUTED_MIDDLE, RULE_LINE, Svg};
use cosmic::design::Material;

/// Width and height, pixels.
const SIZE: [f64; 2] = [460.0, 420.0];
/// The corners of the materials, pixels.
const CORNERS: [[f64; 2]; 3] = [[62.0, 362.0], [398.0, 362.0], [230.0, 79.0]];

fn place(mixture: &[f64; 3]) -> [f64; 2] {
    [0, 1].map(|axis| (0..3).map(|k| mixture[k] * CORNERS[k][axis]).sum::<f64>())
}

/// The triangle with its rulings and names.
fn frame(title: &str) -> Svg {
    let mut svg = Svg::default();
    svg.text([24.0, 26.0], title, BOLD);
    for k in 1..5 {
        let (a, b) = (f64::from(k) / 5.0, 1.0 - f64::from(k) / 5.0);
        for [from, to] in [
            [[a, b, 0.0], [a, 0.0, b]],
            [[b, a, 0.0], [0.0, a, b]],
            [[b, 0.0, a], [0.0, b, a]],
        ] {
            svg.line(place(&from), place(&to), RULE_LINE);
        }
    }
    for [k, l] in [[0, 1], [1, 2], [2, 0]] {
        svg.line(CORNERS[k], CORNERS[l], INK_LINE);
    }
    let names = [("void", 34.0), ("skeleton", 34.0), ("actuator", -20.0)];
    for ([x, y], (name, dy)) in CORNERS.into_iter().zip(names) {
        svg.text([x, y + dy], name, MIDDLE);
    }
    svg
}

/// The mixtures of the final design vectors.
pub(super) fn draw_mixtures(robot: &RobotFiles) -> String {
    let mut svg = frame("Mixture of every edge at the end");
    for (place, count, material) in clusters(robot) {
        let radius = 3.0 + 1.6 * (count as f64).sqrt();
        let colour = colour(material);
        let style = format!(r##"fill="{colour}" fill-opacity="0.85" stroke="#fff""##);
        svg.circle(place, radius, &style);
        if count > 4 {
            let text = r##"text-anchor="middle" fill="#fff" font-weight="600""##;
            svg.text([place[0], place[1] + 4.0], &count.to_string(), text);
        }
    }
    let title = "Mixtures of the final design between void, skeleton and actuator";
    svg.finish(SIZE, title)
}

/// The path of every edge's mixture from the first iteration to the end, in the colour of its final
/// material.
pub(super) fn draw_paths(run: &RunFiles) -> String {
    let mut svg = frame("Mixture of every edge on the way");
    let designs = run.designs.iter().map(|row| &row.z);
    let designs = designs.chain([&run.robot.design.z]);
    let designs: Vec<Vec<[f64; 3]>> = designs.map(|z| run.robot.mixtures(z)).collect();
    for (edge, &material) in run.robot.design.materials.iter().enumerate() {
        let path: Vec<[f64; 2]> = designs.iter().map(|design| place(&design[edge])).collect();
        let colour = colour(material);
        let style = format!(r#"stroke="{colour}" stroke-opacity="0.55" stroke-linejoin="round""#);
        svg.polyline(&path, &style);
        svg.circle(path[0], 2.2, &format!(r#"fill="{colour}""#));
    }
    let iterations: Vec<usize> = run.designs.iter().map(|row| row.iteration).collect();
    let caption = match (iterations.first(), iterations.last()) {
        (Some(first), Some(last)) => format!("iterations {first} to {last}; dots where they began"),
        _ => "the way was not recorded".to_owned(),
    };
    svg.text([230.0, 412.0], &caption, MUTED_MIDDLE);
    let title = "The way of every edge's mixture between void, skeleton and actuator";
    svg.finish(SIZE, title)
}

/// Mixtures at one spot of the picture: the place, their number, their material.
fn clusters(robot: &RobotFiles) -> Vec<([f64; 2], usize, Material)> {
    let mut spots = BTreeMap::new();
    let mixtures = robot.mixtures(&robot.design.z);
    for (mixture, &material) in mixtures.iter().zip(&robot.design.materials) {
        let [x, y] = place(mixture);
        let spot = [x, y].map(|pixels| (pixels / 2.0).round() as i64);
        let (_, count, _) = spots.entry(spot).or_insert(([x, y], 0, material));
        *count += 1;
    }
    spots.into_values().collect()
}
