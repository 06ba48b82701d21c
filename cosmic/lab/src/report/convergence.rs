//! Charts of an optimisation's history over the iterations.

use super::files::RunFiles;
use super::gait::brief;
use super::picture::{Colour, Font, MUTED, Pen, Picture};
use super::plot::{Axes, Axis, Line, range};
use crate::table::Cell;
use cosmic::codesign::{Phase, Record};
use cosmic::geometry::{Range, Vector};
use serde::Serialize;

const WIDTH: f64 = 960.0;
const LEFT: f64 = 64.0;
const TOP: f64 = 66.0;
/// The height of a chart without its titles, in pixels.
const HEIGHT: f64 = 130.0;
/// The height of a chart with its titles, in pixels.
const PITCH: f64 = 182.0;

/// A chart of numbers over the iterations. It is drawn as a part of a picture, or its data are written into a page.
#[derive(Serialize)]
pub(super) struct Chart {
    /// The id of the HTML canvas on which a page draws the chart.
    id: &'static str,
    title: &'static str,
    /// A text that explains the dashed lines.
    #[serde(skip)]
    note: &'static str,
    series: Vec<Series>,
    /// The numbers at which dashed lines are drawn.
    levels: Vec<f64>,
    /// True for a logarithmic axis.
    log: bool,
}

/// A line of a chart.
#[derive(Serialize)]
struct Series {
    name: &'static str,
    /// The index of the line's colour.
    colour: usize,
    /// A cell for each iteration. The line continues over a missing number; a text interrupts the line.
    numbers: Vec<Cell>,
}

/// Creates a line of a chart. `number` returns the number of an iteration, if there is one.
fn series(
    run: &RunFiles,
    name: &'static str,
    colour: usize,
    number: impl Fn(&Record) -> Option<f64>,
) -> Series {
    let cell = |record: &Record| match number(record) {
        Some(x) if !x.is_finite() => Cell::from("diverged"),
        number => number.map(brief).into(),
    };
    Series {
        name,
        colour,
        numbers: run.history.iter().map(cell).collect(),
    }
}

/// Creates two lines of the displacement over the iterations: in full rollouts, and in the rollouts from which
/// gradients were computed.
fn displacements(run: &RunFiles) -> Vec<Series> {
    let full = |r: &Record| match r.diverged {
        true => Some(f64::NAN),
        false => r.displacement,
    };
    // If the robot diverged in the rollout of the gradient, the history has no displacement.
    let horizon = |r: &Record| match r.pass {
        Some(_) => Some(r.displacement_horizon.unwrap_or(f64::NAN)),
        None => r.displacement_horizon,
    };
    vec![
        series(run, "full rollout", 0, full),
        series(run, "gradient's horizon", 1, horizon),
    ]
}

/// Creates the charts of a run, from top to bottom.
pub(super) fn charts(run: &RunFiles) -> Vec<Chart> {
    let bounds = &run.robot.scene.volume;
    let mut bounds = [bounds.solid, bounds.actuator].concat();
    bounds.dedup();
    let pairs = [
        "norm",
        "void\u{2013}skeleton",
        "void\u{2013}actuator",
        "skeleton\u{2013}actuator",
    ];
    let measures = [0, 1, 2, 3].map(|k| series(run, pairs[k], k, |r| Some(r.measures[k])));
    let objective = objective(run);
    let title = match &objective {
        Some(_) => "Displacement along the ground, m",
        None => "Objective: displacement along the ground, m",
    };
    let others = [
        Chart {
            id: "displacement",
            title,
            note: " (dashed: median of the final robot)",
            series: displacements(run),
            levels: run.summary.displacement_robust_p50.into_iter().collect(),
            log: false,
        },
        Chart {
            id: "volumes",
            title: "Share of edges",
            note: " (dashed: bounds before they widen)",
            series: vec![
                series(run, "solid", 0, |r| Some(r.volume)),
                series(run, "actuators", 1, |r| Some(r.actuator_volume)),
            ],
            levels: bounds,
            log: false,
        },
        Chart {
            id: "measures",
            title: "Binarisation measures, overlaps by pair",
            note: "",
            series: measures.into(),
            levels: Vec::new(),
            log: false,
        },
        Chart {
            id: "gradients",
            title: "Norm of the gradient before any bound",
            note: "",
            series: vec![
                series(run, "design", 0, |r| r.design_gradient[0]),
                series(run, "design, stability", 2, |r| r.design_gradient[1]),
                series(run, "controller", 1, |r| r.controller_gradient),
            ],
            levels: Vec::new(),
            log: true,
        },
    ];
    objective.into_iter().chain(others).collect()
}

/// Creates the chart of the loss; `None` if the objective is the displacement.
fn objective(run: &RunFiles) -> Option<Chart> {
    run.summary.loss_p50?;
    let loss = |r: &Record| r.pass.map(|_| r.loss_horizon.unwrap_or(f64::NAN));
    Some(Chart {
        id: "objective",
        title: "Objective: loss, less is better",
        note: " (dashed: median of the final robot)",
        series: vec![series(run, "gradient's horizon", 1, loss)],
        levels: run.summary.loss_p50.into_iter().collect(),
        log: false,
    })
}

/// Draws the charts of displacement, volumes, binarisation measures and gradients. Behind them, bands show the phases.
pub(super) fn draw(run: &RunFiles) -> String {
    let history = &run.history;
    let mut picture = Picture::default();
    let before = history.first().map_or(0, |record| record.iteration - 1);
    let along = Range::new(before as f64, (before + history.len().max(1)) as f64);
    let charts = charts(run);
    let last = charts.len() - 1;
    for (k, chart) in charts.iter().enumerate() {
        let lines = chart.lines(before);
        let axes = Axes {
            origin: Vector::new([LEFT, TOP + k as f64 * PITCH]),
            size: Vector::new([WIDTH - LEFT - 24.0, HEIGHT]),
            x: Axis::linear(along),
            y: Axis {
                range: chart.range(&lines),
                log: chart.log,
            },
        };
        draw_phases(&mut picture, &axes, history, k == 0);
        axes.draw(&mut picture, &[chart.title, chart.note].concat());
        for level in &chart.levels {
            let ends = [along.low, along.high].map(|x| axes.place(Vector::new([x, *level])));
            picture.line(ends, Pen::dashed(MUTED, 1.0, "4 4"));
        }
        axes.draw_lines(&mut picture, &lines);
        if k == last {
            axes.draw_along(&mut picture, "iteration");
        }
    }
    picture.to_svg(
        [WIDTH, TOP + charts.len() as f64 * PITCH + 14.0],
        "Displacement, volumes, binarisation measures and gradients over the iterations",
    )
}

impl Chart {
    /// Returns the lines of the chart. The history begins after `before` iterations, so its first number is drawn at
    /// iteration `before + 1`.
    fn lines(&self, before: usize) -> Vec<Line> {
        let number = |cell: &Cell| match cell {
            Cell::Missing => None,
            Cell::Number(y) => Some(*y),
            _ => Some(f64::NAN),
        };
        let line = |series: &Series| {
            let numbers = series.numbers.iter().enumerate();
            let points = numbers.filter_map(|(k, y)| Some([(before + k + 1) as f64, number(y)?]));
            Line::new(series.name.to_owned(), series.colour, "", points)
        };
        self.series.iter().map(line).collect()
    }

    /// Returns the range of the vertical axis. A linear axis begins at zero, or at the least number if that is
    /// negative. On a logarithmic axis, zeros are drawn at the lower edge. A few extreme numbers do not widen a linear
    /// axis: they are drawn at its ends.
    fn range(&self, lines: &[Line]) -> Range {
        let numbers = lines.iter().flat_map(|line| &line.points).map(|p| p.up());
        if self.log {
            return range(numbers.filter(|v| *v > 0.0), Range::new(0.1, 10.0));
        }
        let numbers: Vec<f64> = numbers.chain(self.levels.iter().copied()).collect();
        let most = robust(&numbers);
        let numbers = numbers.into_iter().filter(|x| most.contains(*x));
        let range = range(numbers, Range::default());
        let wide = range.widened(0.06 * range.size());
        let low = if range.low < 0.0 { wide.low } else { range.low };
        Range::new(low, wide.high)
    }
}

/// Returns a range that contains most of the numbers: from the 2 % quantile to the 98 % quantile, widened on either side by
/// its size. Infinite if these quantiles are equal. `page/charts.js` computes the same range.
fn robust(numbers: &[f64]) -> Range {
    let finite = numbers.iter().copied().filter(|x| x.is_finite());
    let mut sorted: Vec<f64> = finite.collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let last = sorted.len().saturating_sub(1) as f64;
    let at = |share: f64| sorted.get((share * last).round() as usize).copied();
    let ends = at(0.02).zip(at(0.98)).filter(|(low, high)| low < high);
    let ends = ends.map(|(low, high)| Range::new(low, high));
    match ends {
        Some(middle) => middle.widened(middle.size()),
        None => Range::new(f64::NEG_INFINITY, f64::INFINITY),
    }
}

/// Draws the phases of the run as bands behind a chart. If `named` is true, writes the names of the phases above the
/// bands.
fn draw_phases(picture: &mut Picture, axes: &Axes, history: &[Record], named: bool) {
    for part in history.chunk_by(|a, b| a.phase == b.phase) {
        let [first, last] = [&part[0], &part[part.len() - 1]];
        let from = axes.across(first.iteration as f64 - 1.0);
        let to = axes.across(last.iteration as f64);
        let (name, colour) = match first.phase {
            Phase::CoDesign => ("co-design", 0xf3f6fa),
            Phase::Attraction => ("attraction", 0xe6edf5),
            Phase::Snap => ("snap", 0x9fb3c8),
            Phase::FineTuning => ("controller alone", 0xf6f4ee),
        };
        let top = axes.origin[1];
        let size = [(to - from).max(1.5), axes.size[1]];
        picture.rectangle([from, top], size, Colour::hex(colour));
        if named {
            picture.text([0.5 * (from + to), top - 34.0], name, Font::CAPTION);
        }
    }
}
