//! Draws the mixtures of edges as points of a triangle whose corners are void, skeleton and actuator.

use std::collections::BTreeMap;

use super::files::{RobotFiles, RunFiles};
use super::layout::colour;
use super::picture::{Font, INK, PAPER, Pen, Picture, Place, RULE};
use cosmic::design::Material;
use cosmic::geometry::Vector;
use cosmic::record::history::DesignRow;

const SIZE: Place = Vector::new([460.0, 420.0]);
/// The corners of the triangle that stand for void, skeleton and actuator.
const CORNERS: [Place; 3] = [
    Vector::new([62.0, 362.0]),
    Vector::new([398.0, 362.0]),
    Vector::new([230.0, 79.0]),
];

fn place(mixture: &[f64; 3]) -> Place {
    let corners = CORNERS.into_iter().zip(mixture);
    corners.map(|(corner, &share)| corner * share).sum()
}

/// Returns a picture of the triangle with its grid and the names of its corners.
fn frame(title: &str) -> Picture {
    let mut picture = Picture::default();
    picture.text([24.0, 26.0], title, Font::BOLD);
    for k in 1..5 {
        let (a, b) = (f64::from(k) / 5.0, 1.0 - f64::from(k) / 5.0);
        for ends in [
            [[a, b, 0.0], [a, 0.0, b]],
            [[b, a, 0.0], [0.0, a, b]],
            [[b, 0.0, a], [0.0, b, a]],
        ] {
            picture.line(ends.map(|end| place(&end)), Pen::new(RULE, 1.0));
        }
    }
    picture.line([0, 1, 2, 0].map(|k| CORNERS[k]), Pen::new(INK, 1.0));
    let names = [("void", 34.0), ("skeleton", 34.0), ("actuator", -20.0)];
    for (corner, (name, dy)) in CORNERS.into_iter().zip(names) {
        picture.text(corner + Vector::new([0.0, dy]), name, Font::MIDDLE);
    }
    picture
}

/// Draws, for every edge that is solid in the delivered design, the path of its mixture during the optimisation. A path
/// has the colour of the delivered material. Rings mark the ends of the paths.
pub(super) fn draw_paths(run: &RunFiles) -> String {
    let robot = &run.robot;
    let mut picture = frame("Mixtures of the robot's edges during the optimisation");
    let designs = run.designs.iter().map(|row| &row.z);
    let designs = designs.chain([&robot.design.z]);
    let designs: Vec<Vec<_>> = designs.map(|z| robot.mixtures(z)).collect();
    for edge in robot.edges_of(Material::is_solid) {
        let path = designs.iter().map(|design| place(&design[edge].0));
        let colour = colour(robot.design.materials[edge]);
        picture.line(path, Pen::new(colour.faint(0.22), 1.0));
    }
    for (end, count, material) in ends(robot) {
        picture.disc(end, 9.0, PAPER, Pen::new(colour(material), 2.0));
        picture.text(
            end + Vector::new([0.0, 4.0]),
            count.to_string(),
            Font::MIDDLE,
        );
    }
    let iteration = |row: &DesignRow| row.iteration;
    let ends = [run.designs.first(), run.designs.last()].map(|row| row.map(iteration));
    let caption = match ends {
        [Some(first), Some(last)] => {
            format!(
                "iterations {first} to {last}; the size of a ring shows how many edges end at its place"
            )
        }
        _ => "the designs of the iterations were not recorded".to_owned(),
    };
    picture.text([230.0, 412.0], caption, Font::CAPTION);
    let title =
        "The paths of the mixtures of the robot's edges between void, skeleton and actuator";
    picture.to_svg(SIZE, title)
}

/// Returns the places in the picture where the paths of solid edges end. For each place, also returns the number of
/// edges that end there and their material.
fn ends(robot: &RobotFiles) -> Vec<(Place, usize, Material)> {
    let mut spots = BTreeMap::new();
    let mixtures = robot.mixtures(&robot.design.z);
    for edge in robot.edges_of(Material::is_solid) {
        let end = place(&mixtures[edge].0);
        let spot = end.map(|pixels| (pixels / 18.0).round() as i64).array();
        let material = robot.design.materials[edge];
        let (_, count, _) = spots.entry(spot).or_insert((end, 0, material));
        *count += 1;
    }
    spots.into_values().collect()
}
