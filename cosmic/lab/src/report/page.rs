//! The page of a run: a single file of HTML that fetches nothing.

use serde_json::{Value, json};

use super::files::{RobotFiles, RunFiles};
use super::motion::{Motion, PAYLOAD, SKELETON, bounds, hex};
use super::numbers::with_numbers;
use super::{html, layout, loads, ternary};
use crate::table::{Cell, Column, Table, decimals, escape};
use cosmic::design::Material;
use cosmic::record::Summary;
use std::slice::from_ref;

/// The page of a run with its pictures of the robot and, if it has a history, of the convergence.
pub(super) fn of_run(
    run: &RunFiles,
    motion: &Motion,
    robot: &str,
    convergence: Option<&str>,
) -> String {
    let summary = &run.summary;
    let about = format!(
        "; {} iterations in {:.1} s; controller of iteration {}",
        summary.iterations, summary.seconds, summary.delivered_iteration,
    );
    let convergence = convergence.map_or("<p>No history was kept.</p>", |drawn| drawn);
    let body = [
        head(&run.robot, &run.title(), &about),
        figures(summary),
        player(motion),
        format!("<h2>Gait</h2>\n{robot}\n"),
        loads::section(run),
        design(&run.robot),
        format!("<h2>Convergence</h2>\n{convergence}\n"),
        numbers(summary, motion.deepest_cut()),
        scene(&run.robot),
        script(),
    ];
    html::page(&run.title(), &body.concat())
}

/// A page with the four most important numbers of a run and the robot in motion: what a notebook shows.
pub fn player_page(run: &RunFiles) -> String {
    let motion = Motion::new(&run.robot, &run.trajectory);
    let body = [figures(&run.summary), player(&motion), script()];
    html::page(&run.title(), &body.concat())
}

fn script() -> String {
    format!("<script>\n{}</script>\n", include_str!("page.js"))
}

/// The page of a design alone.
pub(super) fn of_design(robot: &RobotFiles, title: &str) -> String {
    let body = [head(robot, title, ""), design(robot), scene(robot)];
    html::page(title, &body.concat())
}

/// The heading, and a line with the size of the lattice and `about`.
fn head(robot: &RobotFiles, title: &str, about: &str) -> String {
    let (nodes, edges) = (robot.lattice.nodes(), robot.lattice.edges.len());
    let title = escape(title);
    format!("<h1>{title}</h1>\n<p class=\"muted\">{nodes} nodes, {edges} edges{about}</p>\n")
}

fn design(robot: &RobotFiles) -> String {
    let pair = [layout::draw_layout(robot), ternary::draw_mixtures(robot)].concat();
    format!("<h2>Design</h2>\n<div class=\"pair\">{pair}</div>\n")
}

fn scene(robot: &RobotFiles) -> String {
    format!(
        "<h2>Scene</h2>\n<details><summary>scene.toml, complete</summary><pre>{}</pre></details>\n",
        escape(&robot.scene.to_toml())
    )
}

/// The four most important numbers.
fn figures(summary: &Summary) -> String {
    let ends = summary.displacement_p10.zip(summary.displacement_p90);
    let spread = ends.map_or("some diverged".to_owned(), |(low, high)| {
        format!("{} \u{2013} {} m", decimals(low, 3), decimals(high, 3))
    });
    let far = summary.displacement_p50;
    let median = far.map_or("diverged".to_owned(), |x| decimals(x, 3) + " m");
    let kept = summary.clock_keeps();
    let kept = kept.map_or("\u{2013}".to_owned(), |kept| {
        format!("{:.0} %", 100.0 * kept)
    });
    let shares = [summary.volume, summary.actuator_volume];
    let [solid, actuators] = shares.map(|share| format!("{:.1} %", 100.0 * share));
    let cells = [
        (median, "displacement, median"),
        (spread, "10 % to 90 % of perturbed starts"),
        (kept, "of it by the clock alone, without feedback"),
        (
            format!("{solid} / {actuators}"),
            "of the edges are solid / are actuators",
        ),
    ];
    let cell = |(number, says)| format!("<div><b>{number}</b><span>{says}</span></div>");
    let cells = cells.map(cell).concat();
    format!("<div class=\"figures\">{cells}</div>\n")
}

/// Every number, with how deep bars cut into the ground if its corners can be cut, and the options that
/// depart from the paper.
fn numbers(summary: &Summary, deepest_cut: Option<f64>) -> String {
    let table = with_numbers(Table::of("", "", from_ref(summary)), |run| run).done();
    let cells = table.columns.iter().zip(&table.rows[0].cells);
    let row = |(column, cell): (&Column, &Cell)| {
        let number = column.shown_with_unit(cell);
        vec![Cell::from(&column.says[..]), number.into()]
    };
    let mut rows: Vec<_> = cells.map(row).collect();
    let [x, y] = summary.displacement.map(|x| decimals(x, 3));
    let says = "displacement of one unperturbed rollout, x and y of the world";
    rows.push(vec![says.into(), format!("{x} m, {y} m").into()]);
    rows.extend(deepest_cut.map(|depth| {
        let says = "deepest cut of a bar into the ground between its nodes";
        vec![says.into(), (decimals(depth, 4) + " m").into()]
    }));
    let departures = summary.departures.iter();
    let departures = departures.map(|d| vec![format!("`{}`", d.option).into(), d.says[..].into()]);
    let departures = if summary.departures.is_empty() {
        "<p>None.</p>\n".to_owned()
    } else {
        pairs(departures.collect())
    };
    let numbers = pairs(rows);
    format!("<h2>Summary</h2>\n{numbers}<h2>Departures from the paper</h2>\n{departures}")
}

/// A table of two columns without headings.
fn pairs(rows: Vec<Vec<Cell>>) -> String {
    Table::new(vec![Column::new("", ""), Column::new("", "")], rows).to_html()
}

/// The canvas, its controls, and the motion as data.
fn player(motion: &Motion) -> String {
    // Numbers and colours alone: nothing in it can end the script element early.
    format!(include_str!("player.html"), data = motion_data(motion))
}

/// The data of the player: 25 frames a second, fewer for a long rollout, in thousandths of a cell.
fn motion_data(motion: &Motion) -> Value {
    let robot = motion.robot;
    let (lattice, design) = (&robot.lattice, &robot.design);
    let (step, indices) = motion.every(0.04);
    let unit = 1e-3 * lattice.spacing;
    let whole = |v: &f64| (v / unit).round() as i64;
    let frame = |&i: &usize| -> Vec<i64> {
        let places = motion.states()[i].x.as_flattened();
        places.iter().map(whole).collect()
    };
    let camera = |&i: &usize| {
        let x = motion.camera(i)[0];
        [x, motion.floor(x)].map(|v| (v / unit).round() * unit)
    };
    // Skeleton edges have no rest length here: their colour does not depend on it.
    let edge = |(e, [i, j]): (usize, &[usize; 2])| match design.materials[e] {
        Material::Void => None,
        Material::Skeleton => Some(json!([i, j, 0])),
        Material::Actuator => Some(json!([i, j, lattice.rest_length[e]])),
    };
    let edges = design.edges.iter().enumerate().filter_map(edge);
    let ramp = (-16..=16).map(|k| hex(motion.colour(f64::from(k) / 16.0 * motion.limit)));
    let width = 4.0 * lattice.side();
    let cameras = indices.iter().map(|&i| motion.camera(i)[0]);
    let [low, high] = bounds(cameras.map(|x| [x, 0.0]));
    json!({
        "step": step,
        "unit": unit,
        "duration": motion.duration(),
        "width": width,
        "ground": motion.ground_line([low[0] - width, high[0] + width]),
        "cos": motion.ground().tangent()[0],
        "limit": motion.limit,
        "ramp": ramp.collect::<Vec<_>>(),
        "skeleton": hex(SKELETON),
        "payload": hex(PAYLOAD),
        "edges": edges.collect::<Vec<_>>(),
        "camera": indices.iter().map(camera).collect::<Vec<_>>(),
        "frames": indices.iter().map(frame).collect::<Vec<_>>(),
    })
}
