//! The loads of a run's bars: the strains of actuators against their limit, and a table.

use super::files::RunFiles;
use super::plot::{Axes, range};
use super::svg::{MUTED_END, MUTED_LINE, Svg};
use crate::table::{Column, Table};
use cosmic::Result;
use cosmic::design::Material;
use cosmic::record::run::DESIGN;
use cosmic::simulator::{BarLoad, Trajectory};

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 220.0;
const LEFT: f64 = 64.0;
const TOP: f64 = 40.0;

/// The loads of every edge in the states of a run's trajectory; nothing is simulated again.
///
/// # Errors
/// If the design does not fit its scene.
pub(crate) fn loads(run: &RunFiles) -> Result<Vec<BarLoad>> {
    let file = run.folder.join(DESIGN).display().to_string();
    let case = run.robot.design.case(&run.robot.scene, &file)?;
    let trajectory = Trajectory {
        steps: run.trajectory.steps.clone(),
        states: run.trajectory.states.clone(),
    };
    let (task, mixture) = (case.task(), case.own_mixture());
    Ok(task.loads(&mixture, &case.controller, &trajectory))
}

/// The heading, the drawing and the table of a page.
pub(super) fn section(run: &RunFiles) -> String {
    let Ok(loads) = loads(run) else {
        return String::new();
    };
    let materials = &run.robot.design.materials;
    let is = |material: Material| move |edge: &usize| materials[*edge] == material;
    let actuators: Vec<usize> = (0..loads.len()).filter(is(Material::Actuator)).collect();
    let limit = run.robot.scene.materials.max_strain[Material::Actuator as usize];
    let (drawing, table) = (draw(&loads, &actuators, limit), table(&loads, &actuators));
    format!(
        "<h2>Actuators</h2>\n{drawing}\n<details><summary>strain, force, speed and power of each</summary>\
         {table}</details>\n"
    )
}

/// The strains of actuators side by side: from the least to the greatest, and where they are for 99 % of
/// the time.
fn draw(loads: &[BarLoad], actuators: &[usize], limit: f64) -> String {
    let strains = actuators.iter().flat_map(|&edge| loads[edge].strains);
    let axes = Axes {
        origin: [LEFT, TOP],
        size: [WIDTH - LEFT - 24.0, HEIGHT - TOP - 20.0],
        x: [-0.5, actuators.len() as f64 - 0.5],
        y: range(strains, [-1.1 * limit, 1.1 * limit]),
        log: [false; 2],
    };
    let mut svg = Svg::default();
    axes.draw(
        &mut svg,
        "strain of every actuator, least to greatest, thick up to the 99 % quantile",
    );
    for level in [-limit, limit] {
        let [from, to] = axes.x.map(|x| axes.place([x, level]));
        svg.line(from, to, &format!(r#"{MUTED_LINE} stroke-dasharray="4 4""#));
    }
    svg.text(
        [WIDTH - 24.0, TOP - 10.0],
        "dashed: the limit of what is asked for",
        MUTED_END,
    );
    for (k, &edge) in actuators.iter().enumerate() {
        let [low, high] = loads[edge].strains;
        let most = loads[edge].strain.p99;
        for (ends, width) in [([low, high], 1.5), ([low.max(-most), high.min(most)], 6.0)] {
            let [from, to] = ends.map(|strain| axes.place([k as f64, strain]));
            svg.line(
                from,
                to,
                &format!(r##"stroke="#0b62b8" stroke-width="{width}""##),
            );
        }
    }
    svg.finish([WIDTH, HEIGHT], "Strains of the actuators")
}

fn table(loads: &[BarLoad], actuators: &[usize]) -> String {
    let number = |name, unit, decimals| Column::new(name, "").unit(unit).decimals(decimals, "-");
    let table = Table::of("", "", actuators)
        .column("edge", "its number in design.json", |edge| *edge)
        .add(number("shortest", "", 3), |edge| loads[*edge].strains[0])
        .add(number("longest", "", 3), |edge| loads[*edge].strains[1])
        .add(number("strain, 99 %", "", 3), |edge| {
            loads[*edge].strain.p99
        })
        .add(number("force", "N", 2), |edge| loads[*edge].force.peak)
        .add(number("force, 99 %", "N", 2), |edge| loads[*edge].force.p99)
        .add(number("speed", "m/s", 2), |edge| loads[*edge].speed.peak)
        .add(number("speed, 99 %", "m/s", 2), |edge| {
            loads[*edge].speed.p99
        })
        .add(number("power", "W", 3), |edge| loads[*edge].power.peak)
        .add(number("power, 99 %", "W", 3), |edge| loads[*edge].power.p99);
    table.done().to_html()
}
