//! Does one run, for `optimize` and `resume`: sets up threads, signals and progress, and prints a short summary.

use crate::arguments::{Output, Work};
use crate::interrupt;
use crate::output::{in_colour, in_place, metres, note, print, reached, see_again, unreliable};
use crate::progress::Progress;
use cosmic::Registry;
use cosmic::design::MOST_RANKED;
use cosmic::error::{Error, Result, command, in_shell};
use cosmic::judge::verdict::Verdict;
use cosmic::keys::Keyed;
use cosmic::numbers::{counted, fixed};
use cosmic::outcome::Summary;
use cosmic::parallel::pool;
use cosmic::record::run::read_scene;
use cosmic::record::snapshot::SNAPSHOT;
use cosmic::record::summary::SUMMARY;
use cosmic::record::{DIVERGED, Observer};
use cosmic::scene::{Scene, SkeletonPart};
use cosmic::walk::Energy;
use cosmic_lab::report::verdict_of;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// The built-in scene of robots that consist of parts.
const OF_PARTS: &str = "workshop";

/// Calls `work`, which does the run in `folder`, and prints the run's summary. The lines of `introduction` are printed
/// when the run begins.
///
/// # Errors
/// The errors of `work`; [`Error::NoFigure`] if the run is finished but its median displacement diverged.
pub(super) fn carry_out(
    folder: &Path,
    registry: &Registry,
    Work { threads, output }: &Work,
    introduction: Vec<String>,
    work: impl FnOnce(&mut dyn Observer) -> Result<Summary> + Send,
) -> Result<()> {
    let pool = pool(*threads)?;
    let mut progress = Progress::new(output, interrupt::listen(output.quiet)?, introduction);
    let done = pool.install(|| work(&mut progress));
    drop(progress);
    let diverged = folder.join(DIVERGED);
    if matches!(done, Err(Error::Diverged { .. })) && diverged.exists() {
        note(&see_again(&diverged));
    }
    if done.as_ref().is_err_and(is_full) && folder.join(SNAPSHOT).exists() {
        let again = command(format_args!("resume {}", in_shell(folder)));
        note(&format!(
            "the run is saved; free some space, then continue with: {again}"
        ));
    }
    let summary = done?;
    show(folder, &summary, registry, output)?;
    match summary.displacement_robust_p50 {
        Some(_) => Ok(()),
        None => Err(Error::NoFigure(format!(
            "{}: there is no median displacement: the final robot walks as designed, but robots that vary a little \
             diverge (displacement_robust_p50 is null in {SUMMARY})",
            folder.display()
        ))),
    }
}

/// True if a file could not be written because the disk is full.
fn is_full(error: &Error) -> bool {
    use ErrorKind::{QuotaExceeded, StorageFull};
    matches!(error, Error::Write { source, .. } if matches!(source.kind(), StorageFull | QuotaExceeded))
}

fn show(folder: &Path, summary: &Summary, registry: &Registry, output: &Output) -> Result<()> {
    if output.json {
        let path = folder.join(SUMMARY);
        let text = fs::read_to_string(&path).map_err(Error::reading(path))?;
        return print(&text);
    }
    // The run is done, so a scene that somebody has removed since is not an error.
    let verdict = verdict_of(folder, summary, registry).ok();
    let text = describe(folder, summary, verdict.as_ref(), !output.quiet);
    print(&text)?;
    if !output.quiet {
        note(&next(folder, registry));
    }
    Ok(())
}

/// The commands that a user probably runs next.
fn next(folder: &Path, registry: &Registry) -> String {
    let run = in_shell(folder);
    let [report, robustness] =
        ["report", "robustness"].map(|word| command(format_args!("{word} {run}")));
    let mut text = format!(
        "next: {report} writes a page on which the robot walks\n      {robustness} tells how far it walks with random \
         starts, friction, stiffness and masses"
    );
    // A robot of plain numbers shows what is possible; a robot of parts can be built.
    let has_parts = |scene: Scene| scene.materials.parts.skeleton != SkeletonPart::Numbers;
    let is_of_parts = read_scene(folder, registry).is_ok_and(has_parts);
    if !is_of_parts && registry.scene(OF_PARTS).is_some() {
        let parts = command(format_args!("optimize {OF_PARTS}"));
        text +=
            &format!("\n      {parts} designs a robot of tubes and cylinders that can be built");
    }
    text
}

/// Describes the robot in a few lines: how its bars are connected, how they are loaded, and how far it walks without
/// feedback.
fn robot(summary: &Summary) -> String {
    let mut text = String::new();
    if summary.undecided {
        text += "bars and actuators: undecided, because the run ended before every edge had one material\n";
    }
    if let Some(s) = summary.structure {
        let floppy = match s.floppy_modes {
            Some(modes) => counted(modes, "floppy mode"),
            None => format!("floppy modes not counted (more than {MOST_RANKED} bars)"),
        };
        text += &format!(
            "bars: {}, {}, {}, {}, {}, {}\n",
            counted(s.pieces, "piece"),
            counted(s.nodes, "node"),
            counted(s.free_ends, "free end"),
            counted(s.crossings, "crossing"),
            counted(s.feet, "lowest node"),
            floppy,
        );
    }
    if let Some(loads) = &summary.loads {
        let shown = |column| loads.shown(column).unwrap_or_default();
        let [low, high] = [loads.strains.low, loads.strains.high].map(|strain| fixed(strain, 3));
        text += &format!(
            "actuators: strain {low} to {high} (99 %: {}), {} and {} at most, {} W (99 %); bars pass through each other \
             {:.0} % of the time{}\n",
            shown("strain_p99"),
            shown("force_peak"),
            shown("speed_peak"),
            fixed(loads.power.p99, 3),
            100.0 * loads.tangled,
            match loads.most_tangles {
                0 => String::new(),
                pairs => format!(", up to {}", counted(pairs, "pair")),
            },
        );
        if let Some(safety) = loads.shown("euler_safety") {
            text += &format!("skeleton: Euler safety {safety} at least\n");
        }
    }
    text += &summary
        .quoted_energy()
        .as_ref()
        .map_or(String::new(), energy);
    match summary.ways.is_empty() {
        true => text + &open_loop(summary).unwrap_or_default(),
        false => text,
    }
}

/// Describes how far the robot walks without feedback; `None` if it diverges.
fn open_loop(summary: &Summary) -> Option<String> {
    let clock = summary.shown("displacement_clock_p50")?;
    let keeps = summary.clock_keeps().zip(summary.shown("displacement_p50"));
    let keeps = keeps.map_or(String::new(), |(kept, whole)| {
        let share = fixed(100.0 * kept, 0);
        format!(", {share} % of {whole} with feedback from the same starts")
    });
    Some(format!("open loop, without feedback: {clock}{keeps}\n"))
}

/// Describes the energy that the robot needs, and what ten minutes take from a battery and from a supply of air.
fn energy(energy: &Energy) -> String {
    let shown = |column| energy.shown(column);
    let per_distance = match (shown("per_metre"), shown("cost_of_transport")) {
        (Some(joule), Some(cost)) => format!(", {joule}, cost of transport {cost}"),
        (Some(joule), None) => format!(", {joule}"),
        (None, _) => String::new(),
    };
    let air = energy.air.map_or(String::new(), |air| {
        let purpose = match energy.needed() > energy.power {
            true => "to press",
            false => "and",
        };
        format!(
            ", {purpose} {:.0} litres of air (at 1 bar)",
            1e3 * 600.0 * air
        )
    });
    format!(
        "energy: {}, {} on average (net {} W){per_distance}; ten minutes take {} Wh, without losses{air}\n",
        shown("mass").unwrap_or_default(),
        shown("power").unwrap_or_default(),
        fixed(energy.net_power, 3),
        fixed(600.0 * energy.needed() / 3600.0, 3),
    )
}

/// Formats the summary of a run. The first line names its folder; the last two lines have the verdict, and displacement,
/// volumes and time. A robot that does not get far gets advice if `advises` is true.
fn describe(folder: &Path, summary: &Summary, verdict: Option<&Verdict>, advises: bool) -> String {
    let mut text = format!("run: {}\n", folder.display());
    for start in &summary.starts {
        let end = reached(start.displacement_robust_p50, start.reliability.as_ref());
        text += &format!("start {}: {end}\n", start.seed);
    }
    text += &format!(
        "{}, seed {}: {}, controller of iteration {}, {}, {} skipped\n",
        summary.scene,
        summary.seed,
        counted(summary.iterations, "iteration"),
        summary.delivered_iteration,
        match summary.undecided {
            true => "not snapped".to_owned(),
            false => counted(summary.flips, "flip"),
        },
        counted(summary.skipped_gradients, "gradient"),
    );
    text += &robot(summary);
    if let Some(entered) = summary.entered {
        text += &format!("started after iteration {entered} with the robot in start.json\n");
    }
    if let Some(ways) = summary.ways_in_words() {
        text += &format!("{ways} (medians)\n");
    } else if let Some(loss) = summary.loss_p50 {
        text += &match loss {
            Some(loss) => format!("loss {} (median)\n", fixed(loss, 4)),
            None => "loss not known: too many rollouts diverged\n".to_owned(),
        };
    }
    if let Some(reason) = summary.unreliable() {
        text += &format!("unreliable: {reason}\n");
    }
    if let Some(verdict) = verdict {
        text += &format!("verdict: {}\n", verdict.line(in_colour));
        if advises && !verdict.hints.is_empty() {
            text += &format!("what to try: {}\n", verdict.hints.join("; "));
        }
    }
    let together = match summary.starts[..] {
        [] => "",
        _ => ", all starts together",
    };
    let shown = |column| summary.shown(column).unwrap_or_default();
    text + &format!(
        "{}displacement {} (median of robots that vary a little; 10 % quantile {}){}, V {}, V_act {}, time {}{together}\n",
        in_place(Some(&summary.reliability)),
        metres(summary.displacement_robust_p50),
        metres(summary.displacement_robust_p10),
        unreliable(Some(&summary.reliability)),
        shown("V"),
        shown("V_act"),
        shown("seconds"),
    )
}
