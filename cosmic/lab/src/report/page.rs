//! The page of a run: one file of HTML that fetches nothing.

use std::fmt::Write;

use serde_json::{Value, json};

use super::layout;
use super::motion::{Motion, PAYLOAD, SKELETON, hex};
use super::results::Results;
use super::svg::{decimals, escape};
use super::ternary;
use cosmic::design::Material;
use cosmic::record::Summary;

/// A number of a summary as tables show it.
pub(super) struct Figure {
    /// Heading of a column.
    pub(super) short: &'static str,
    /// What it is.
    pub(super) says: &'static str,
    /// The number itself.
    pub(super) of: fn(&Summary) -> String,
}

const fn figure(short: &'static str, says: &'static str, of: fn(&Summary) -> String) -> Figure {
    Figure { short, says, of }
}

/// The numbers that are worth comparing.
const FIGURES: [Figure; 9] = [
    figure(
        "p50, m",
        "displacement: median over perturbed starts",
        |s| metres(s.displacement_p50),
    ),
    figure(
        "p10, m",
        "displacement: 10 % quantile over perturbed starts",
        |s| metres(s.displacement_p10),
    ),
    figure(
        "p90, m",
        "displacement: 90 % quantile over perturbed starts",
        |s| metres(s.displacement_p90),
    ),
    figure(
        "last p50, m",
        "displacement of the last iterate: median over perturbed starts",
        |s| metres(s.displacement_last_p50),
    ),
    figure(
        "single, m",
        "displacement of one unperturbed rollout",
        |s| metres(s.displacement_along),
    ),
    figure("V", "share of solid edges", |s| format!("{:.3}", s.volume)),
    figure("V_act", "share of actuators", |s| {
        format!("{:.3}", s.actuator_volume)
    }),
    figure("seed", "seed of the random generator", |s| {
        s.seed.to_string()
    }),
    figure("time, s", "duration of the optimisation", |s| {
        format!("{:.1}", s.seconds)
    }),
];

/// What runs of another task than to get far, and of an own loss, are ranked by.
const LOSS: Figure = figure(
    "loss p50",
    "loss: median over the same perturbed starts",
    |s| s.loss_p50.map_or("–".to_owned(), |loss| decimals(loss, 4)),
);

/// What is shown of runs, with the loss where one of them is ranked by it.
pub(super) fn figures_of<'a>(runs: impl IntoIterator<Item = &'a Summary>) -> Vec<Figure> {
    let with_loss = runs.into_iter().any(|run| run.loss_p50.is_some());
    let loss = with_loss.then_some(LOSS);
    FIGURES.into_iter().chain(loss).collect()
}

/// A displacement; none where the rollouts that it stands for diverged.
fn metres(value: impl Into<Option<f64>>) -> String {
    value
        .into()
        .map_or("diverged".to_owned(), |v| decimals(v, 3))
}

/// A number with its unit; what is none, a word, has none.
fn with_unit(number: String, unit: &str) -> String {
    match number.ends_with(|last: char| last.is_ascii_digit()) {
        true => number + unit,
        false => number,
    }
}

/// A whole page of HTML.
pub(super) fn wrap(title: &str, body: &str) -> String {
    let (title, style) = (escape(title), include_str!("page.css"));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>\n{style}</style>\n</head>\n<body>\n{body}\n</body>\n</html>\n"
    )
}

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
    wrap(&run.title(), &body)
}

/// The four numbers to see first.
fn figures(summary: &Summary) -> String {
    let ends = summary.displacement_p10.zip(summary.displacement_p90);
    let spread = ends.map_or("some diverged".to_owned(), |(low, high)| {
        format!("{} \u{2013} {} m", decimals(low, 3), decimals(high, 3))
    });
    let median = with_unit(metres(summary.displacement_p50), " m");
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
    let mut html = String::from("<h2>Summary</h2>\n<table><tbody>");
    let [x, y] = run.summary.displacement.map(metres);
    let world = (
        "displacement of one unperturbed rollout, x and y of the world",
        format!("{}, {}", with_unit(x, " m"), with_unit(y, " m")),
    );
    let unit = |f: &Figure| {
        if f.short.ends_with(", m") {
            " m"
        } else if f.short.ends_with(", s") {
            " s"
        } else {
            ""
        }
    };
    let figures = figures_of([&run.summary]);
    let rows = figures
        .iter()
        .map(|f| (f.says, with_unit((f.of)(&run.summary), unit(f))));
    for (says, number) in rows.chain([world]) {
        let _ = write!(
            html,
            "<tr><td>{says}</td><td class=\"number\">{number}</td></tr>"
        );
    }
    html += "</tbody></table>\n<h2>Departures from the paper</h2>\n";
    let departures = &run.summary.departures;
    if departures.is_empty() {
        return html + "<p>None.</p>\n";
    }
    html += "<table><tbody>";
    for departure in departures {
        let _ = write!(
            html,
            "<tr><td><code>{}</code></td><td>{}</td></tr>",
            escape(&departure.option),
            escape(&departure.says)
        );
    }
    html + "</tbody></table>\n"
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
