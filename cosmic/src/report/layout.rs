//! Pictures of the design: the layout at rest, and where its edges stand between the materials.

use std::collections::BTreeMap;

use super::motion::{SKELETON, hex};
use super::results::Results;
use super::svg::{INK, MUTED, RULE, Svg};
use crate::design::Material;
use crate::projection::softmax;

/// Colour of actuators where no strain is shown.
const ACTUATOR: &str = "#d9541e";

fn colour(material: Material) -> String {
    match material {
        Material::Void => "#c4cad1".to_owned(),
        Material::Skeleton => hex(SKELETON),
        Material::Actuator => ACTUATOR.to_owned(),
    }
}

/// The layout on the lattice at rest, in the ground's frame.
pub(super) fn draw_layout(run: &Results) -> String {
    let (columns, rows) = (run.lattice.columns, run.lattice.rows);
    let cell = 320.0 / (columns.max(rows) - 1).max(1) as f64;
    let size = [460.0, 420.0];
    let left = 0.5 * (size[0] - cell * (columns - 1) as f64);
    let place = |node: usize| {
        let (row, column) = ((node / columns) as f64, (node % columns) as f64);
        [left + cell * column, 370.0 - cell * row]
    };
    let mut svg = Svg::new(size);
    svg.text([24.0, 26.0], "Layout at rest", r#"font-weight="600""#);
    for material in [Material::Skeleton, Material::Actuator] {
        let made_of = run.design.materials.iter().zip(&run.design.edges);
        let edges = made_of.filter(|(m, _)| **m == material);
        let width = if material == Material::Actuator {
            5.0
        } else {
            3.5
        };
        let colour = colour(material);
        let style = format!(r#"stroke="{colour}" stroke-width="{width}" stroke-linecap="round""#);
        for (_, &[i, j]) in edges {
            svg.line(place(i), place(j), &style);
        }
    }
    for node in 0..run.lattice.nodes() {
        svg.circle(
            place(node),
            2.6,
            &format!(r##"fill="#fff" stroke="{MUTED}""##),
        );
    }
    svg.circle(
        place(0),
        7.0,
        r##"fill="#e68a00" stroke="#fff" stroke-width="1.5""##,
    );
    let counted = Material::ALL.map(|m| run.design.materials.iter().filter(|e| **e == m).count());
    let [void, skeleton, actuator] = counted;
    let caption = format!("{skeleton} skeleton, {actuator} actuator, {void} void (not drawn)");
    svg.text(
        [0.5 * size[0], 402.0],
        &caption,
        &format!(r#"text-anchor="middle" fill="{MUTED}""#),
    );
    svg.finish("Materials of the edges on the lattice at rest")
}

/// The mixtures of the final design vectors in a triangle whose corners are the materials.
pub(super) fn draw_ternary(run: &Results) -> String {
    let corners = [[62.0, 362.0], [398.0, 362.0], [230.0, 79.0]];
    let place = |mixture: &[f64; 3]| {
        [0, 1].map(|axis| (0..3).map(|k| mixture[k] * corners[k][axis]).sum::<f64>())
    };
    let mut svg = Svg::new([460.0, 420.0]);
    svg.text(
        [24.0, 26.0],
        "Mixture of every edge at the end",
        r#"font-weight="600""#,
    );
    for k in 1..5 {
        let (a, b) = (f64::from(k) / 5.0, 1.0 - f64::from(k) / 5.0);
        for [from, to] in [
            [[a, b, 0.0], [a, 0.0, b]],
            [[b, a, 0.0], [0.0, a, b]],
            [[b, 0.0, a], [0.0, b, a]],
        ] {
            svg.line(place(&from), place(&to), &format!(r#"stroke="{RULE}""#));
        }
    }
    for [k, l] in [[0, 1], [1, 2], [2, 0]] {
        svg.line(corners[k], corners[l], &format!(r#"stroke="{INK}""#));
    }
    for (place, count, material) in clusters(run, place) {
        let radius = 3.0 + 1.6 * (count as f64).sqrt();
        let style = format!(
            r##"fill="{}" fill-opacity="0.85" stroke="#fff""##,
            colour(material)
        );
        svg.circle(place, radius, &style);
        if count > 4 {
            let text = r##"text-anchor="middle" fill="#fff" font-weight="600""##;
            svg.text([place[0], place[1] + 4.0], &count.to_string(), text);
        }
    }
    for (corner, (name, dy)) in
        corners
            .iter()
            .zip([("void", 34.0), ("skeleton", 34.0), ("actuator", -20.0)])
    {
        svg.text([corner[0], corner[1] + dy], name, r#"text-anchor="middle""#);
    }
    svg.finish("Mixtures of the final design between void, skeleton and actuator")
}

/// Mixtures that fall on one spot of the picture: where, how many, of which material.
fn clusters(
    run: &Results,
    place: impl Fn(&[f64; 3]) -> [f64; 2],
) -> Vec<([f64; 2], usize, Material)> {
    let design = &run.design;
    let snapped = design.is_snapped();
    let mut spots = BTreeMap::new();
    for (z, &material) in design.z.iter().zip(&design.materials) {
        // A layout has exactly one material per edge (D7).
        let mixture = if snapped {
            *z
        } else {
            softmax(*z, run.scene.projection.beta)
        };
        let [x, y] = place(&mixture);
        let spot = [x, y].map(|pixels| (pixels / 2.0).round() as i64);
        let (_, count, _) = spots.entry(spot).or_insert(([x, y], 0, material));
        *count += 1;
    }
    spots.into_values().collect()
}
