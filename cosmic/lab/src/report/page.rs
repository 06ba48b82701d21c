//! The page of a run: one file of HTML that fetches nothing.

use std::fmt::Write;

use serde_json::{Value, json};

use super::motion::{Motion, PAYLOAD, SKELETON, hex};
use super::numbers::{SummaryColumn, summary_columns};
use super::results::Results;
use super::{html, layout, ternary};
use crate::table::{Cell, Column, Table, decimals, escape};
use cosmic::design::Material;
use cosmic::record::Summary;

/// The page of a run with its pictures of the robot and of the convergence.
pub(super) fn render(motion: &Motion, [robot, convergence]: [&str; 2]) -> String {
    let run = motion.run;
    let title = escape(&run.title());
    let mut body = format!("<h1>{title}</h1>\n");
    let _ = writeln!(
        body,
        "<p class=\"muted\">{} nodes, {} edges; {} iterations in {:.1} s; controller of iteration {}</p>",
        run.lattice.nodes(),
        run.lattice.edges.len(),
        run.summary.iterations,
        run.summary.seconds,
        run.summary.delivered_iteration,
    );
    body += &figures(&run.summary);
    body += &player(motion);
    let _ = writeln!(body, "<h2>Gait</h2>\n{robot}");
    let pair = [layout::draw_layout(run), ternary::draw_mixtures(run)].concat();
    let _ = writeln!(body, "<h2>Design</h2>\n<div class=\"pair\">{pair}</div>");
    let _ = writeln!(body, "<h2>Convergence</h2>\n{convergence}");
    body += &summary(run);
    let _ = writeln!(
        body,
        "<h2>Scene</h2>\n<details><summary>scene.toml, complete</summary><pre>{}</pre></details>",
        escape(&run.scene.to_toml())
    );
    let _ = writeln!(body, "<script>\n{}</script>", include_str!("page.js"));
    html::page(&run.title(), &body)
}

/// The four numbers to see first.
fn figures(summary: &Summary) -> String {
    let ends = summary.displacement_p10.zip(summary.displacement_p90);
    let spread = ends.map_or("some diverged".to_owned(), |(low, high)| {
        format!("{} \u{2013} {} m", decimals(low, 3), decimals(high, 3))
    });
    let median = summary.displacement_p50;
    let median = median.map_or("diverged".to_owned(), |x| decimals(x, 3) + " m");
    let cells = [
        (median, "displacement, median"),
        (spread, "10 % to 90 % of perturbed starts"),
        (
            format!("{:.1} %", 100.0 * summary.volume),
            "of the edges are solid",
        ),
        (
            format!("{:.1} %", 100.0 * summary.actuator_volume),
            "are actuators",
        ),
    ];
    let cell = |(number, says)| format!("<div><b>{number}</b><span>{says}</span></div>");
    let cells = cells.map(cell).concat();
    format!("<div class=\"figures\">{cells}</div>\n")
}

/// Every number, and the options that depart from the paper.
fn summary(run: &Results) -> String {
    let mut rows: Vec<Vec<Cell>> = summary_columns(&[&run.summary])
        .iter()
        .map(|SummaryColumn { column, of }| {
            let number = column.shown_with_unit(&of(&run.summary));
            vec![column.says[..].into(), number.into()]
        })
        .collect();
    let [x, y] = run.summary.displacement.map(|x| decimals(x, 3));
    let says = "displacement of one unperturbed rollout, x and y of the world";
    rows.push(vec![says.into(), format!("{x} m, {y} m").into()]);
    let departures = run.summary.departures.iter();
    let departures: Vec<Vec<Cell>> = departures
        .map(|d| vec![format!("`{}`", d.option).into(), d.says[..].into()])
        .collect();
    let departures = match departures.is_empty() {
        true => "<p>None.</p>\n".to_owned(),
        false => pairs(departures),
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
    // Nothing in it can end the script element early: numbers and colours alone.
    let data = motion_data(motion);
    format!(
        "<h2>Motion</h2>\n<div class=\"player\"><canvas id=\"stage\" width=\"1920\" height=\"800\"></canvas>\n\
         <div class=\"controls\"><button id=\"play\">Pause</button>\n\
         <input id=\"time\" type=\"range\" min=\"0\" step=\"any\" value=\"0\" aria-label=\"time\">\n\
         <output id=\"clock\">0.0 s</output>\n\
         <label>speed <select id=\"speed\"><option value=\"0.25\">\u{bc}</option>\
         <option value=\"0.5\">\u{bd}</option><option value=\"1\" selected>1</option>\
         <option value=\"2\">2</option><option value=\"4\">4</option></select></label></div></div>\n\
         <script type=\"application/json\" id=\"motion\">{data}</script>\n"
    )
}

/// What the player draws: 25 frames a second, of a long rollout less, in thousandths of a cell.
fn motion_data(motion: &Motion) -> Value {
    let run = motion.run;
    let (step, indices) = motion.every(0.04);
    let unit = 1e-3 * run.scene.lattice.spacing;
    let whole = |v: &f64| (v / unit).round() as i64;
    let frame = |&i: &usize| -> Vec<i64> {
        motion.states()[i]
            .x
            .as_flattened()
            .iter()
            .map(whole)
            .collect()
    };
    let camera = |&i: &usize| {
        let x = motion.camera(i)[0];
        [x, motion.ground_height(x)].map(|v| (v / unit).round() * unit)
    };
    // Skeleton edges have no rest length here: their colour does not depend on it.
    let edges = run
        .design
        .edges
        .iter()
        .enumerate()
        .filter_map(|(e, [i, j])| match run.design.materials[e] {
            Material::Void => None,
            Material::Skeleton => Some(json!([i, j, 0])),
            Material::Actuator => Some(json!([i, j, run.lattice.rest_length[e]])),
        });
    let ramp = (-16..=16).map(|k| hex(motion.colour(f64::from(k) / 16.0 * motion.limit())));
    let side = run.lattice.columns.max(run.lattice.rows) as f64 * run.scene.lattice.spacing;
    let floor = motion.ground_height(0.0);
    json!({
        "step": step,
        "unit": unit,
        "duration": motion.duration(),
        "width": 4.0 * side,
        "ground": [floor, motion.ground_height(1.0) - floor],
        "limit": motion.limit(),
        "ramp": ramp.collect::<Vec<_>>(),
        "skeleton": hex(SKELETON),
        "payload": hex(PAYLOAD),
        "edges": edges.collect::<Vec<_>>(),
        "camera": indices.iter().map(camera).collect::<Vec<_>>(),
        "frames": indices.iter().map(frame).collect::<Vec<_>>(),
    })
}
