//! The history of an optimisation as charts over the iterations.

use super::data::horizon_diverged;
use super::files::RunFiles;
use super::plot::{Axes, Axis, Line, range};
use super::svg::{MUTED_LINE, MUTED_MIDDLE, Svg};
use cosmic::codesign::{Phase, Record};
use cosmic::geometry::{Range, Vector};

const WIDTH: f64 = 960.0;
const LEFT: f64 = 64.0;
const TOP: f64 = 66.0;
/// Height of a chart without its titles.
const HEIGHT: f64 = 130.0;
/// Height of a chart with its titles.
const PITCH: f64 = 182.0;

/// Displacement, volumes, binarisation measures and gradients, with the phases behind them.
pub(super) fn draw(run: &RunFiles) -> String {
    let history = &run.history;
    let mut svg = Svg::default();
    let first = history.first().map_or(0, |record| record.iteration - 1) as f64;
    let last = history.last().map_or(1, |record| record.iteration) as f64;
    for (k, chart) in charts(run).into_iter().enumerate() {
        let axes = Axes {
            origin: Vector::new([LEFT, TOP + k as f64 * PITCH]),
            size: Vector::new([WIDTH - LEFT - 24.0, HEIGHT]),
            x: Axis::linear(Range::new(first, last)),
            y: Axis {
                range: chart.range(),
                log: chart.log,
            },
        };
        draw_phases(&mut svg, &axes, history, k == 0);
        axes.draw(&mut svg, chart.title);
        for level in &chart.levels {
            let [from, to] = [first, last].map(|x| axes.place(Vector::new([x, *level])));
            let dashed = format!(r#"{MUTED_LINE} stroke-dasharray="4 4""#);
            svg.line(from, to, &dashed);
        }
        axes.draw_lines(&mut svg, &chart.lines);
        if k == 3 {
            axes.draw_along(&mut svg, "iteration");
        }
    }
    svg.finish(
        [WIDTH, TOP + 4.0 * PITCH + 14.0],
        "Displacement, volumes, binarisation measures and gradients over the iterations",
    )
}

/// The content of a chart.
struct Chart {
    title: &'static str,
    lines: Vec<Line>,
    /// Numbers with dashed lines.
    levels: Vec<f64>,
    log: bool,
}

impl Chart {
    /// The range up. A linear one begins at zero, or below its least number if that is negative. On a
    /// logarithmic one, an exactly zero number is drawn at the lower edge.
    fn range(&self) -> Range {
        let points = self.lines.iter().flat_map(|line| &line.points);
        let numbers = points.map(|point| point.up());
        if self.log {
            return range(numbers.filter(|v| *v > 0.0), Range::new(0.1, 10.0));
        }
        let range = range(numbers.chain(self.levels.iter().copied()), Range::default());
        let wide = range.widened(0.06 * range.size());
        let low = if range.low < 0.0 { wide.low } else { range.low };
        Range::new(low, wide.high)
    }
}

/// The four charts of a run, the first on top.
fn charts(run: &RunFiles) -> [Chart; 4] {
    type Number<'n> = &'n dyn Fn(&Record) -> Option<f64>;
    // A line in the k-th colour through the records that have a number. Numbers that are not finite make gaps.
    let line = |name: &str, k: usize, number: Number| {
        let point = |r: &Record| Some(Vector::new([r.iteration as f64, number(r)?]));
        let points = run.history.iter().filter_map(point);
        Line::new(name.to_owned(), k, "", points)
    };
    let displacement = vec![
        line("gradient's horizon", 1, &|r| {
            let gap = horizon_diverged(r).then_some(f64::NAN);
            gap.or(r.displacement_horizon)
        }),
        line("full rollout", 0, &|r| {
            let gap = r.diverged.then_some(f64::NAN);
            gap.or(r.displacement)
        }),
    ];
    let delivered = run.summary.displacement_p50.into_iter().collect();
    let volumes = vec![
        line("solid", 0, &|r| Some(r.volume)),
        line("actuators", 1, &|r| Some(r.actuator_volume)),
    ];
    let bounds = &run.robot.scene.volume;
    let mut bounds = [bounds.solid, bounds.actuator].concat();
    bounds.dedup();
    let names = [
        "norm",
        "void-skeleton",
        "void-actuator",
        "skeleton-actuator",
    ];
    let measures = [0, 1, 2, 3].map(|k| line(names[k], k, &|r| Some(r.measures[k])));
    let gradients = vec![
        line("design", 0, &|r| r.design_gradient[0]),
        line("design, stability", 2, &|r| r.design_gradient[1]),
        line("controller", 1, &|r| r.controller_gradient),
    ];
    let chart = |title, lines, levels, log| Chart {
        title,
        lines,
        levels,
        log,
    };
    let titles = [
        "Displacement along the ground, m (dashed: median of what is delivered)",
        "Share of edges (dashed: bounds before they widen)",
        "Binarisation measures, overlaps by pair",
        "Norm of the gradient before any bound",
    ];
    [
        chart(titles[0], displacement, delivered, false),
        chart(titles[1], volumes, bounds, false),
        chart(titles[2], measures.into(), Vec::new(), false),
        chart(titles[3], gradients, Vec::new(), true),
    ]
}

/// Draws the phases as bands behind a chart; the first chart has their names.
fn draw_phases(svg: &mut Svg, axes: &Axes, history: &[Record], named: bool) {
    for part in history.chunk_by(|a, b| a.phase == b.phase) {
        let (Some(first), Some(last)) = (part.first(), part.last()) else {
            continue;
        };
        let from = axes.across(first.iteration as f64 - 1.0);
        let to = axes.across(last.iteration as f64);
        let (name, colour) = match first.phase {
            Phase::CoDesign => ("co-design", "#f3f6fa"),
            Phase::Attraction => ("attraction", "#e6edf5"),
            Phase::Snap => ("snap", "#9fb3c8"),
            Phase::FineTuning => ("controller alone", "#f6f4ee"),
        };
        let top = axes.origin.up();
        let size = [(to - from).max(1.5), axes.size.up()];
        svg.rect([from, top], size, &format!(r#"fill="{colour}""#));
        if named {
            let place = [0.5 * (from + to), top - 34.0];
            svg.text(place, name, MUTED_MIDDLE);
        }
    }
}
