//! The tiles at the top of a run's page: its most important numbers.

use super::files::RunFiles;
use super::motion::DrawnMotion;
use crate::table::escape;
use cosmic::design::Material;
use cosmic::keys::Keyed;
use cosmic::numbers::{brief, fixed, mass};
use cosmic::outcome::Summary;
use cosmic::scene::Named;
use cosmic::walk::Energy;

/// The text for a number that an undecided design does not have.
const NOT_KNOWN: &str = "not known";
/// The text for a displacement that a diverged rollout would determine.
const DIVERGED: &str = "diverged";
/// The column of the displacement to quote.
const QUOTED: &str = "displacement_robust_p50";

/// Returns tiles of a number and its meaning, as HTML.
fn draw(tiles: &[[String; 2]]) -> String {
    let tile = |[number, says]: &[String; 2]| {
        format!("<div><b>{number}</b><span>{}</span></div>", escape(says))
    };
    let tiles: String = tiles.iter().map(tile).collect();
    format!("<div class=\"figures\">{tiles}</div>\n")
}

/// Returns the tiles of a run: world, size, mass, speed, objective, energy, and the bars that pass through each other.
pub(super) fn of_run(run: &RunFiles, motion: &DrawnMotion) -> String {
    let world = escape(&run.robot.scene.describe_world());
    let mut tiles = vec![
        speed(run),
        objective(run),
        size(run, motion),
        weight(run),
        energy(run),
        stores(run),
        crossings(run),
        sensitivity(run),
    ];
    // A robot that is told where to go has no distance of which a share could be left.
    if run.summary.ways.is_empty() {
        tiles.push(open_loop(run));
    }
    let tiles = tiles.into_iter();
    let tiles: Vec<[String; 2]> = tiles
        .map(|[number, says]| [escape(&number), says])
        .collect();
    format!("<p class=\"muted\">World: {world}</p>\n{}", draw(&tiles))
}

/// A displacement of the summary.
fn metres(summary: &Summary, column: &str) -> String {
    let shown = summary.shown(column);
    shown.unwrap_or_else(|| DIVERGED.to_owned())
}

fn speed(run: &RunFiles) -> [String; 2] {
    let (physics, summary) = (&run.robot.scene.physics, &run.summary);
    let whole = physics.steps as f64 * physics.dt;
    let seconds = summary.seconds_of_walk(whole);
    let Some(far) = summary.displacement_robust_p50 else {
        return [DIVERGED.to_owned(), String::new()];
    };
    let then = if seconds < whole {
        "; then it stands still"
    } else {
        ""
    };
    let time = fixed(seconds, 1);
    [
        fixed(far / seconds, 2) + " m/s",
        format!("speed, over {time} s{then}"),
    ]
}

fn objective(run: &RunFiles) -> [String; 2] {
    let summary = &run.summary;
    if let Some(says) = summary.ways_in_words() {
        let left = summary.way_left();
        let left = left.map(|left| fixed(100.0 * left, 0) + " %");
        return [
            left.unwrap_or(DIVERGED.to_owned()),
            format!("objective: {says}"),
        ];
    }
    if let Some(loss) = summary.loss_p50 {
        let task = run.robot.scene.objective.task.name();
        let says = format!("objective: loss of the task {task}, median");
        let loss = loss.map_or(DIVERGED.to_owned(), |loss| fixed(loss, 4));
        return [loss, says];
    }
    let low = metres(summary, "displacement_robust_p10");
    [
        metres(summary, QUOTED),
        format!("objective: distance, median of robots that vary a little; 10 % quantile: {low}"),
    ]
}

/// The size of the robot at the start, and its bars.
fn size(run: &RunFiles, motion: &DrawnMotion) -> [String; 2] {
    let size = motion.bounds(&motion.states()[0]).size();
    let count = |material| {
        let materials = run.robot.design.materials.iter();
        materials.filter(|m| **m == material).count()
    };
    let bars = match run.summary.undecided {
        true => format!(
            "size; {} edges, all undecided",
            run.robot.lattice.edges.len()
        ),
        false => format!(
            "size; {} skeleton bars, {} muscles",
            count(Material::Skeleton),
            count(Material::Actuator)
        ),
    };
    let sides = run.robot.lattice.dimension.components(size);
    let sides: Vec<String> = sides.map(|side| fixed(side, 2)).collect();
    [sides.join(" \u{d7} ") + " m", bars]
}

fn weight(run: &RunFiles) -> [String; 2] {
    let RunFiles { robot, summary, .. } = run;
    let payload = summary.measured(&robot.scene, &robot.lattice).payload;
    [
        summary
            .quoted_energy()
            .map_or(NOT_KNOWN.to_owned(), |energy| mass(energy.mass)),
        format!("mass, of which {} payload", mass(payload)),
    ]
}

fn energy(run: &RunFiles) -> [String; 2] {
    let Some(Energy {
        power,
        net_power,
        air_power,
        per_metre,
        cost_of_transport,
        ..
    }) = run.summary.quoted_energy()
    else {
        return [NOT_KNOWN.to_owned(), "mean power".to_owned()];
    };
    let net = brief(net_power);
    let mut says = format!("mean power at this speed, without losses; net {net} W");
    if let Some(joule) = per_metre {
        says += &format!("; {} J/m", brief(joule));
    }
    if let Some(cost) = cost_of_transport {
        says += &format!("; cost of transport {}", brief(cost));
    }
    if let Some(pressing) = air_power {
        says += &format!("; pressing its air needs at least {} W", brief(pressing));
    }
    [brief(power) + " W", says]
}

/// What ten minutes take from a battery and from a supply of air.
fn stores(run: &RunFiles) -> [String; 2] {
    let says = "for ten minutes, without losses";
    let Some(energy) = run.summary.quoted_energy() else {
        return [NOT_KNOWN.to_owned(), format!("energy {says}")];
    };
    let air = energy.air.map_or(String::new(), |air| {
        let litres = brief(1e3 * 600.0 * air);
        format!("; its cylinders take {litres} litres of air, at 1 bar")
    });
    let hours = 600.0 * energy.needed() / 3600.0;
    [brief(hours) + " Wh", format!("energy {says}{air}")]
}

fn crossings(run: &RunFiles) -> [String; 2] {
    let says = "of bars pass through each other in motion";
    let Some(loads) = run.summary.loads.as_ref() else {
        return [NOT_KNOWN.to_owned(), format!("how many pairs {says}")];
    };
    let number = match loads.most_tangles {
        1 => "1 pair".to_owned(),
        pairs => format!("{pairs} pairs"),
    };
    let share = fixed(100.0 * loads.tangled, 0);
    [number, format!("at most {says}, in {share} % of the time")]
}

/// The strongest effects of other physics on the distance, of those that are larger than twice their standard error.
fn sensitivity(run: &RunFiles) -> [String; 2] {
    let effects = run.summary.sensitivities.iter().flat_map(|of| {
        let both = [("smaller", of.smaller), ("larger", of.larger)];
        let least = 2.0 * of.error.unwrap_or(f64::INFINITY);
        both.map(|(way, metres)| (&*of.name, way, metres.filter(|x| x.abs() > least)))
    });
    let mut effects: Vec<_> = effects
        .filter_map(|(name, way, x)| Some((name, way, x?)))
        .collect();
    effects.sort_by(|a, b| b.2.abs().total_cmp(&a.2.abs()));
    let says = |&(name, way, _): &(&str, &str, f64)| format!("if {name} is 10 % {way}");
    let metres = |x: f64| format!("{}{} m", if x > 0.0 { "+" } else { "" }, fixed(x, 2));
    let Some((first, others)) = effects.split_first() else {
        return [
            NOT_KNOWN.to_owned(),
            match run
                .summary
                .sensitivities
                .iter()
                .any(|of| of.error.is_some())
            {
                true => {
                    "no number of the physics, 10 % larger or smaller, has an effect beyond chance"
                        .to_owned()
                }
                false => "how other physics change the distance".to_owned(),
            },
        ];
    };
    let others = others.iter().take(2);
    let others = others.map(|effect| format!("; {} {}", metres(effect.2), says(effect)));
    [
        metres(first.2),
        format!(
            "{}: the strongest effect of other physics{}",
            says(first),
            others.collect::<String>()
        ),
    ]
}

fn open_loop(run: &RunFiles) -> [String; 2] {
    let summary = &run.summary;
    let kept = summary.clock_keeps();
    let kept = kept.map(|kept| fixed(100.0 * kept, 0) + " %");
    [
        kept.unwrap_or("\u{2013}".to_owned()),
        "of the distance in open loop, without feedback".to_owned(),
    ]
}
