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

/// The paths of the mixtures of solid edges from the first iteration to the end, in the colours of their
/// materials; those of edges that end as void are left out. A ring marks where edges are delivered.
pub(super) fn draw_paths(run: &RunFiles) -> String {
    let robot = &run.robot;
    let mut svg = frame("Mixtures of the robot's edges on the way");
    let designs = run.designs.iter().map(|row| &row.z);
    let designs = designs.chain([&robot.design.z]);
    let designs: Vec<Vec<_>> = designs.map(|z| robot.mixtures(z)).collect();
    let materials = &robot.design.materials;
    for edge in robot.edges_of(Material::is_solid) {
        let path: Vec<[f64; 2]> = designs
            .iter()
            .map(|design| place(&design[edge].0))
            .collect();
        let colour = colour(materials[edge]);
        let style = format!(r#"stroke="{colour}" stroke-opacity="0.22" stroke-linejoin="round""#);
        svg.polyline(&path, &style);
    }
    for ([x, y], count, material) in ends(robot) {
        let colour = colour(material);
        let style = format!(r##"fill="#fff" stroke="{colour}" stroke-width="2""##);
        svg.circle([x, y], 9.0, &style);
        svg.text([x, y + 4.0], &count.to_string(), MIDDLE);
    }
    let iterations: Vec<usize> = run.designs.iter().map(|row| row.iteration).collect();
    let caption = match (iterations.first(), iterations.last()) {
        (Some(first), Some(last)) => {
            format!("iterations {first} to {last}; rings count the edges that end there")
        }
        _ => "the way was not recorded".to_owned(),
    };
    svg.text([230.0, 412.0], &caption, MUTED_MIDDLE);
    let title = "The way of the mixtures of the robot's edges between void, skeleton and actuator";
    svg.finish(SIZE, title)
}

/// Where solid edges end in the picture: the place, their number, their material.
fn ends(robot: &RobotFiles) -> Vec<([f64; 2], usize, Material)> {
    let mut spots = BTreeMap::new();
    let mixtures = robot.mixtures(&robot.design.z);
    for edge in robot.edges_of(Material::is_solid) {
        let [x, y] = place(&mixtures[edge].0);
        let spot = [x, y].map(|pixels| (pixels / 18.0).round() as i64);
        let material = robot.design.materials[edge];
        let (_, count, _) = spots.entry(spot).or_insert(([x, y], 0, material));
        *count += 1;
    }
    spots.into_values().collect()
}
