//! HTML pages. Each is a single file that loads nothing from elsewhere.

use serde_json::Value;

use super::files::{RobotFiles, RunFiles};
use super::gait::Gait;
use super::motion::DrawnMotion;
use super::{data, robot, tiles, verdict};
use crate::table::{Table, escape};
use crate::walk::{self, Walk};
use cosmic::design::Material;
use cosmic::outcome::Summary;
use cosmic::record::TrajectoryFile;
use cosmic::scene::{Departure, Scene};
use std::slice::from_ref;

/// The text that a page shows instead of actuators if the design is undecided.
const UNDECIDED: &str = "The design is undecided: the run ended before every edge had one material. \
    There are no bars and no actuators yet.";

/// Returns a complete HTML page.
pub(super) fn html(title: &str, body: &str) -> String {
    let title = escape(title);
    let style = [
        include_str!("page/theme.css"),
        include_str!("page/page.css"),
    ]
    .concat();
    format!(
        include_str!("page/frame.html"),
        style = style,
        title = title,
        body = body
    )
}

/// Returns the page of a run: the verdict, the robot in motion and in several poses, its design, gait and energies.
/// Folded at the end are the parts for authors: the convergence if the run has a history, all numbers, and the scene.
pub(super) fn of_run(run: &RunFiles, motion: &DrawnMotion, gait: &Gait) -> String {
    let summary = &run.summary;
    let about = format!(
        "; {} iterations in {:.1} s; controller of iteration {}",
        summary.iterations, summary.seconds, summary.delivered_iteration,
    );
    let actuators = run.robot.edges_of(|m| m == Material::Actuator);
    let walks = format!(
        include_str!("page/run.html"),
        peaks = match summary.undecided {
            true => UNDECIDED.to_owned(),
            false => gait.peaks(&actuators, motion.limit),
        },
        states = gait.loads_over(),
        table = gait.table(&actuators),
    );
    let convergence = if run.history.is_empty() {
        "<p>No history was kept.</p>\n"
    } else {
        include_str!("page/convergence.html")
    };
    let verdict = run.verdict();
    let body = [
        &head(&run.robot, &run.title(), &about),
        &verdict::to_html(&verdict),
        include_str!("page/player.html"),
        WHICH,
        "<div class=\"strip\" tabindex=\"0\" role=\"region\" aria-label=\"The robot at several moments\">\n",
        &robot::draw(motion),
        "</div>\n",
        &tiles::of_run(run, motion),
        &warning(summary),
        "<div>\n",
        include_str!("page/design.html"),
        &walks,
        "</div>\n",
        "<h2>For authors</h2>\n",
        &fold("Convergence", convergence),
        &fold("Mixtures of the edges", include_str!("page/ternary.html")),
        &numbers(summary),
        &departures(&run.robot.scene),
        &scene(&run.robot),
        &script(&data::of_run(run, motion, gait), ONE_ROBOT),
    ];
    html(&run.title(), &body.concat())
}

/// Returns the page of a robot's walk to goals. `motion` is the motion of the walk.
pub(super) fn of_walk(walk: &Walk, motion: &DrawnMotion, title: &str) -> String {
    let table = walk::table(&walk.legs).to_html();
    let body = [
        &head(motion.robot, title, ""),
        include_str!("page/player.html"),
        &format!(include_str!("page/walk.html"), table = table),
        &scene(motion.robot),
        &script(&data::of_motion(motion), ONE_ROBOT),
    ];
    html(title, &body.concat())
}

/// Returns the page that a notebook shows: the verdict, the most important numbers of a run and the robot in motion.
pub fn player_page(run: &RunFiles) -> String {
    let motion = DrawnMotion::new(&run.robot, &run.trajectory);
    let body = [
        &verdict::to_html(&run.verdict()),
        &tiles::of_run(run, &motion),
        &warning(&run.summary),
        include_str!("page/player.html"),
        WHICH,
        &script(&data::of_motion(&motion), ONE_ROBOT),
    ];
    html(&run.title(), &body.concat())
}

/// Returns the page of a design that has no run. It shows the robot at rest.
pub(super) fn of_design(robot: &RobotFiles, title: &str) -> String {
    let at_rest = TrajectoryFile {
        dt: robot.scene.physics.dt,
        steps: vec![0],
        states: vec![robot.lattice.state_at_rest()],
        bars: Vec::new(),
    };
    let motion = DrawnMotion::new(robot, &at_rest);
    let body = [
        &head(robot, title, ""),
        include_str!("page/design.html"),
        include_str!("page/ternary.html"),
        &scene(robot),
        &script(&data::of_motion(&motion), ONE_ROBOT),
    ];
    html(title, &body.concat())
}

/// Returns the script elements of a page: the page's data, the script that all pages share, and the page's own script
/// `of_page`.
pub(super) fn script(data: &Value, of_page: &str) -> String {
    // A `</script>` in a text would end the script element, so `<` is escaped.
    let data = data.to_string().replace('<', "\\u003c");
    let drawing = concat!(
        include_str!("page/drawing.js"),
        include_str!("page/painter.js"),
        include_str!("page/robot.js"),
        include_str!("page/charts.js")
    );
    format!(
        "<script type=\"application/json\" id=\"data\">{data}</script>\n\
         <script>\n{drawing}{of_page}</script>\n"
    )
}

/// The script of a page that shows one robot.
const ONE_ROBOT: &str = concat!(include_str!("page/gait.js"), include_str!("page/page.js"));

/// Returns the heading of a page and a line below it. The line states the size of the lattice, followed by the text
/// `about`.
fn head(robot: &RobotFiles, title: &str, about: &str) -> String {
    let (nodes, edges) = (robot.lattice.nodes(), robot.lattice.edges.len());
    let title = escape(title);
    format!("<h1>{title}</h1>\n<p class=\"muted\">{nodes} nodes, {edges} edges{about}</p>\n")
}

fn scene(robot: &RobotFiles) -> String {
    format!(
        "<details><summary>Scene: scene.toml, complete</summary><pre tabindex=\"0\">{}</pre></details>\n",
        escape(&robot.scene.to_toml())
    )
}

/// A paragraph that says which of many walks the page plays. It has no number, so that the page begins with one distance.
const WHICH: &str = "<p class=\"muted\">The robot exactly as designed walks here. The numbers below are medians of robots \
    that vary a little, so its own distance differs.</p>\n";

/// Returns a paragraph that says why the robot is unreliable; empty for other robots.
fn warning(summary: &Summary) -> String {
    summary.unreliable().map_or(String::new(), |reason| {
        let reason = escape(reason);
        format!("<p><b class=\"bad\">Unreliable robot:</b> {reason}.</p>\n")
    })
}

/// Returns a section that is folded until the reader opens it by a click on `title`.
fn fold(title: &str, body: &str) -> String {
    format!("<details><summary>{title}</summary>\n{body}</details>\n")
}

/// Returns a folded section with all numbers.
fn numbers(summary: &Summary) -> String {
    let table = Table::of("", "", from_ref(summary));
    let table = table.keyed(Some).done().without_empty();
    let cells = table.columns.iter().zip(&table.rows[0].cells);
    let rows: Vec<[String; 2]> = cells
        .map(|(column, cell)| {
            let says = format!("`{}`: {}", column.name, column.says);
            [says, column.shown_with_unit(cell)]
        })
        .collect();
    let table = Table::of("", "", &rows).columns(["", ""], "", |row, k| &row[k][..]);
    fold("All numbers", &table.done().to_html())
}

/// Returns a folded section with the keys of the scene whose values differ from those of the paper's scene.
fn departures(scene: &Scene) -> String {
    let departures = scene.departures();
    let there = |d: &Departure| d.there.clone().unwrap_or_default();
    let table = Table::of("", "", &departures)
        .column("key", "", |d| &d.key[..])
        .column("here", "", |d| &d.here[..])
        .column("in stability", "", there);
    fold(
        "Keys that differ from the scene stability",
        &table.done().to_html(),
    )
}
