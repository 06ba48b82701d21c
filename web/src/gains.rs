//! What a change of each bar would bring, by the gradient of the distance.

use cosmic::design::Design;
use cosmic::error::{Error, Result};
use cosmic::search::{CoDesign, GradientPoint, Progress, Schedule, Variables};
use cosmic::world::Span;
use serde_json::{Value, json};

/// A bar with a smaller share of solid material counts as half skeleton, half actuator.
const LEAST: f64 = 0.02;

/// Returns the horizon of the next iteration in seconds, and the exact gradient within it: for every bar, how many metres
/// farther the robot gets for each share of solid material that the bar has more. The new material has the bar's own ratio of
/// skeleton to actuator. If `tried` is a bar and a share, a rollout with that share more tells how much farther the robot
/// really gets (m).
///
/// # Errors
/// [`Error::Usage`] for a loss that is not a distance, and for a bar that the lattice does not have.
pub(crate) fn gains(
    codesign: &CoDesign,
    progress: &Progress,
    tried: Option<(usize, f64)>,
) -> Result<Value> {
    let (evaluator, world) = (codesign.evaluator(), codesign.world());
    if !evaluator.is_far() {
        return Err(Error::Usage("only distances have gains".to_owned()));
    }
    let design = codesign.design(progress);
    let shares: Vec<[f64; 3]> = design.mixtures().iter().map(|mixture| mixture.0).collect();
    let steps = Schedule::at(codesign.scene(), progress.iteration + 1).horizon();
    let at = |shares: Vec<[f64; 3]>| {
        let mut inputs = codesign.inputs(progress);
        inputs.z = shares;
        GradientPoint {
            variations: Vec::new(),
            inputs,
            horizon: Span {
                memory: codesign.scene().gradient.budget(),
                ..Span::of_steps(steps)
            },
            sticks: false,
        }
    };
    let [slope] = evaluator.slopes([Variables::Shares], &at(shares.clone()));
    let more = shares.iter().map(|&mixture| more(mixture));
    let along = |(g, more): (&[f64; 3], [f64; 3])| {
        let rise: f64 = g.iter().zip(more).map(|(g, more)| g * more).sum();
        -world.lattice().scale * rise
    };
    let gains: Vec<f64> = slope
        .gradient
        .as_chunks()
        .0
        .iter()
        .zip(more.clone())
        .map(along)
        .collect();
    let mut farther = None;
    if let Some((bar, share)) = tried {
        let Some(change) = more.clone().nth(bar) else {
            let says = format!(
                "`tried` is bar {bar}; the lattice has {} bars",
                shares.len()
            );
            return Err(Error::Usage(says));
        };
        let mut other = shares.clone();
        for (own, change) in other[bar].iter_mut().zip(change) {
            *own += share * change;
        }
        let other = Design::of_shares(&other);
        let [there] = evaluator.slopes([Variables::Nothing(&other)], &at(shares));
        farther = Some(slope.loss - there.loss);
    }
    let seconds = steps as f64 * world.physics().dt;
    Ok(json!({ "gains": gains, "farther": farther, "seconds": seconds }))
}

/// The change of a mixture in which the share of solid material grows by 1.
fn more([_, skeleton, actuator]: [f64; 3]) -> [f64; 3] {
    let solid = skeleton + actuator;
    let [skeleton, actuator] = match solid < LEAST {
        true => [0.5, 0.5],
        false => [skeleton / solid, actuator / solid],
    };
    [-1.0, skeleton, actuator]
}
