//! The history of an optimisation as charts over the iterations.

use super::plot::{Axes, Series, range};
use super::results::Results;
use super::svg::{MUTED, Svg};
use cosmic::codesign::{Phase, Record};

const WIDTH: f64 = 960.0;
const LEFT: f64 = 64.0;
const TOP: f64 = 66.0;
/// Height of a chart, and of a chart with what is above it.
const HEIGHT: [f64; 2] = [130.0, 182.0];

/// Colours that stay apart for colour-blind eyes.
const COLOURS: [&str; 4] = ["#0b62b8", "#d9541e", "#2a8f5b", "#8a4fb0"];

/// Displacement, volumes, binarisation measures and gradients, with the phases behind them.
pub(super) fn draw(run: &Results) -> String {
    let history = &run.history;
    let charts = [
        displacement(run),
        volumes(run),
        measures(history),
        gradients(history),
    ];
    let mut svg = Svg::new([WIDTH, TOP + 4.0 * HEIGHT[1] + 14.0]);
    let first = history.first().map_or(0, |record| record.iteration - 1) as f64;
    let last = history.last().map_or(1, |record| record.iteration) as f64;
    for (k, chart) in charts.into_iter().enumerate() {
        let axes = Axes {
            origin: [LEFT, TOP + k as f64 * HEIGHT[1]],
            size: [WIDTH - LEFT - 24.0, HEIGHT[0]],
            x: [first, last],
            y: chart.range,
            log: [false, chart.log],
        };
        draw_phases(&mut svg, &axes, (history, k == 0));
        axes.draw(&mut svg, chart.title);
        for level in &chart.levels {
            let ends = [first, last].map(|x| axes.place([x, *level]));
            svg.line(
                ends[0],
                ends[1],
                &format!(r#"stroke="{MUTED}" stroke-dasharray="4 4""#),
            );
        }
        axes.draw_series(&mut svg, &chart.series);
        if k == 3 {
            axes.draw_along(&mut svg, "iteration");
        }
    }
    svg.finish("Displacement, volumes, binarisation measures and gradients over the iterations")
}

/// What one chart shows.
struct Chart {
    title: &'static str,
    series: Vec<Series>,
    /// Numbers that are marked by dashed lines.
    levels: Vec<f64>,
    range: [f64; 2],
    log: bool,
}

impl Chart {
    /// A chart from zero, or from its least number if that is below.
    fn linear(title: &'static str, series: Vec<Series>, levels: Vec<f64>) -> Self {
        let numbers = series.iter().flat_map(|s| s.points.iter().map(|p| p[1]));
        let [low, high] = range(numbers.chain(levels.iter().copied()), [0.0, 0.0]);
        let head = 0.06 * (high - low);
        let range = [if low < 0.0 { low - head } else { low }, high + head];
        Self {
            title,
            series,
            levels,
            range,
            log: false,
        }
    }
}

/// The records that have a number, as points of a line.
fn series(
    (name, colour): (&'static str, &'static str),
    history: &[Record],
    number: impl Fn(&Record) -> Option<f64>,
) -> Series {
    let point = |r: &Record| Some([r.iteration as f64, number(r).filter(|v| v.is_finite())?]);
    let points = history.iter().filter_map(point).collect();
    Series {
        name,
        colour,
        points,
    }
}

fn displacement(run: &Results) -> Chart {
    let whole = series(("full rollout", COLOURS[0]), &run.history, |r| {
        r.displacement
    });
    let horizon = series(("gradient's horizon", COLOURS[1]), &run.history, |r| {
        r.displacement_horizon
    });
    let delivered = run.summary.displacement_p50.into_iter().collect();
    Chart::linear(
        "Displacement along the ground, m (dashed: median of what is delivered)",
        vec![horizon, whole],
        delivered,
    )
}

fn volumes(run: &Results) -> Chart {
    let bounds = &run.scene.volume;
    let mut levels = [bounds.solid, bounds.actuator].concat();
    levels.dedup();
    let solid = series(("solid", COLOURS[0]), &run.history, |r| Some(r.volume));
    let actuator = series(("actuators", COLOURS[1]), &run.history, |r| {
        Some(r.actuator_volume)
    });
    Chart::linear(
        "Share of edges (dashed: bounds before they widen)",
        vec![solid, actuator],
        levels,
    )
}

fn measures(history: &[Record]) -> Chart {
    const NAMES: [&str; 4] = [
        "norm",
        "void-skeleton",
        "void-actuator",
        "skeleton-actuator",
    ];
    let line = |k: usize| series((NAMES[k], COLOURS[k]), history, |r| Some(r.measures[k]));
    Chart::linear(
        "Binarisation measures, overlaps by pair",
        [0, 1, 2, 3].map(line).into(),
        Vec::new(),
    )
}

fn gradients(history: &[Record]) -> Chart {
    let series = vec![
        series(("design", COLOURS[0]), history, |r| r.design_gradient[0]),
        series(("design, stability", COLOURS[2]), history, |r| {
            r.design_gradient[1]
        }),
        series(("controller", COLOURS[1]), history, |r| {
            r.controller_gradient
        }),
    ];
    let numbers = series.iter().flat_map(|s| s.points.iter().map(|p| p[1]));
    let positive: Vec<f64> = numbers.filter(|v| *v > 0.0).collect();
    let least = positive.iter().copied().fold(0.1, f64::min);
    // An exactly zero gradient is drawn at the lower edge.
    let range = range(positive.into_iter(), [least.max(1e-9), 10.0]);
    Chart {
        title: "Norm of the gradient before any bound",
        series,
        levels: Vec::new(),
        range,
        log: true,
    }
}

/// The phases as bands behind a chart, named above the first.
fn draw_phases(svg: &mut Svg, axes: &Axes, (history, named): (&[Record], bool)) {
    for part in history.chunk_by(|a, b| a.phase == b.phase) {
        let (Some(first), Some(last)) = (part.first(), part.last()) else {
            continue;
        };
        let from = axes.place([first.iteration as f64 - 1.0, 0.0])[0];
        let to = axes.place([last.iteration as f64, 0.0])[0];
        let (name, colour) = match first.phase {
            Phase::CoDesign => ("co-design", "#f3f6fa"),
            Phase::Attraction => ("attraction", "#e6edf5"),
            Phase::Snap => ("snap", "#9fb3c8"),
            Phase::FineTuning => ("controller alone", "#f6f4ee"),
        };
        let size = [(to - from).max(1.5), axes.size[1]];
        svg.rect([from, axes.origin[1]], size, &format!(r#"fill="{colour}""#));
        if named {
            let style = format!(r#"text-anchor="middle" fill="{MUTED}""#);
            svg.text([0.5 * (from + to), axes.origin[1] - 34.0], name, &style);
        }
    }
}
