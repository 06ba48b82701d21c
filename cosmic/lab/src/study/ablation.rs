//! The gains of topology, material and control, each alone and together.

use super::Study;
use super::document::{document, metres, motifs, percent, pictures, table, trial_table};
use super::results::StudyResults;
use super::rows::TrialRow;
use super::statistics::Statistics;
use super::trials::{ABLATION, CONTROL, MATERIAL, TOPOLOGY, lines};
use crate::report::Bar;
use crate::table::decimals;
use cosmic::record::summary::ratio;

/// Something that a trial may design: its name, its bit in [`ABLATION`], the paper's gain as a ratio.
type Entity = (&'static str, u8, Option<f64>);

const ENTITIES: [Entity; 3] = [
    ("topology", TOPOLOGY, Some(2.16)),
    ("material", MATERIAL, Some(8.81)),
    ("control", CONTROL, None),
];

/// A statistic of a trial's sample.
type Number = fn(&Statistics) -> Option<f64>;

/// Mean displacements of the trials that do not design an entity, and of those that do, m.
fn means(results: &StudyResults, bit: u8, number: Number) -> [Option<f64>; 2] {
    [false, true].map(|wanted| {
        let designs = |designs: u8| designs & bit > 0;
        let trials = ABLATION.iter().filter(|trial| designs(trial.3) == wanted);
        let numbers = trials.map(|(name, ..)| number(&results.row(name).displacement));
        let numbers = numbers.collect::<Option<Vec<f64>>>()?;
        Some(numbers.iter().sum::<f64>() / numbers.len() as f64)
    })
}

/// The bars of the paper's figure: for each entity its mean without and with, by the medians.
pub(super) fn bars(results: &StudyResults) -> Vec<Bar> {
    let bars = |(name, bit, _): &Entity| {
        let [without, with] = means(results, *bit, |s| s.median);
        [("without", without), ("with", with)].map(|(how, value)| Bar {
            name: format!("{how} {name}"),
            value,
            ..Bar::default()
        })
    };
    ENTITIES.iter().flat_map(bars).collect()
}

/// The whole document.
pub(super) fn document_of(study: &Study, results: &StudyResults) -> String {
    let rows: Vec<&TrialRow> = results.rows.iter().collect();
    let trials = format!("{}\n![every seed](ablation/trials.svg)\n", trials(&rows));
    let entities = format!("{}\n![means](ablation/entities.svg)\n", by_entity(results));
    document(
        study,
        "Ablation: topology, material, control",
        ABOUT,
        &[
            ["Trials", &trials],
            ["By entity", &entities],
            ["Questions", &questions(results)],
            ["Motifs", &motifs(results, "ablation")],
            ["The best seed of each", &pictures(study, &rows, &["robot"])],
        ],
    )
}

const ABOUT: &str = "\nAll trials begin with the stability heuristic where topology is designed, and \
    with a filled lattice where not. Without control the network keeps its first weights. Without \
    material the actuators are spread evenly over the vertical edges, and what an edge is not is \
    held down before every projection, in the stability projection after its centring. Without \
    topology the share of solid edges is held above 0.90, once materials are decided above 0.87 \
    (`volume.widening`). With neither, the filled layout, outside \
    the volume bounds, is taken as it is.\n";

fn trials(rows: &[&TrialRow]) -> String {
    let designs = |row: &TrialRow, bit: u8| {
        let mut trials = ABLATION.iter().filter(|(name, ..)| *name == row.trial.name);
        trials.any(|(.., designs)| designs & bit > 0)
    };
    trial_table(rows, |table| {
        table
            .column("designed", "", |row| row.trial.title)
            .columns(ENTITIES.map(|(name, ..)| name), "", |row, k| {
                let (_, bit, _) = ENTITIES[k];
                if designs(row, bit) { "yes" } else { "no" }
            })
            .column("paper", "", |row| row.trial.paper)
    })
}

fn by_entity(results: &StudyResults) -> String {
    let row = |(name, bit, paper): &Entity| {
        let mut cells = vec![(*name).into()];
        for number in [(|s| s.median) as Number, |s| s.best] {
            let [without, with] = means(results, *bit, number);
            let gain = percent(ratio(with, without));
            cells.extend([without.into(), with.into(), gain.into()]);
        }
        cells.push(percent(*paper).into());
        cells
    };
    let names = "entity | without, median | with, median | gain | without, best | with, best | gain \
                 | the paper's gain";
    let names: Vec<&str> = names.split(" | ").collect();
    format!(
        "Means over the four trials that design the entity and the four that do not: of the medians \
         over the seeds, and of the best seeds.\n\n{}",
        table(&names, ENTITIES.iter().map(row))
    )
}

/// Questions that two trials answer: the trial without an entity, the trial with it, the question,
/// the paper's answer.
const STEPS: &str = "
topology-material | all               | Does control help on top of topology and material | 1.02 to 1.91, +87 %
topology          | topology-control  | Does control help with topology alone | it does not
material          | topology-material | Does topology help with material alone | it does
material-control  | all               | Does topology help with material and control | it does
";

/// The paper's findings beside these numbers.
fn questions(results: &StudyResults) -> String {
    let steps: String = lines(STEPS).map(|line| step(results, line)).collect();
    ranking(results) + &together(results) + &steps
}

const NO_VERDICT: &str = "not to be said: some median diverged";

fn ranking(results: &StudyResults) -> String {
    let gain = |(name, bit, _): Entity| {
        let [without, with] = means(results, bit, |s| s.median);
        let gain = Option::zip(without, with).map(|(without, with)| with - without);
        (name, gain)
    };
    let mut gains = ENTITIES.map(gain);
    gains.sort_by(|a, b| b.1.partial_cmp(&a.1).unwrap_or(std::cmp::Ordering::Equal));
    let list = gains.map(|(name, gain)| format!("{name} {} m", metres(gain)));
    let verdict = match (gains[0].0, gains[2].0) {
        _ if gains.iter().any(|(_, gain)| gain.is_none()) => NO_VERDICT,
        ("material", "control") => "as in the paper",
        _ => "unlike in the paper",
    };
    format!(
        "- **Which entity is worth most, which least?** By the gain of the means: {}; {verdict} (the \
         paper: the actuation layout is worth most, control least).\n",
        list.join(", ")
    )
}

fn together(results: &StudyResults) -> String {
    let median = |name: &str| results.row(name).displacement.median;
    let gain = |name: &str| Some(median(name)? - median("none")?);
    let singles = ["topology", "material", "control"].map(gain);
    let sum = singles.iter().copied().sum::<Option<f64>>();
    let joint = gain("all");
    let verdict = match Option::zip(joint, sum) {
        Some((joint, sum)) if joint > sum => "more than the sum, as in the paper",
        Some(_) => "not more than the sum, unlike in the paper",
        None => NO_VERDICT,
    };
    format!(
        "- **Is the joint gain more than the sum of the single ones?** All three {} m over none; one \
         by one {} m, together {} m: {verdict}.\n",
        metres(joint),
        singles.map(metres).join(" + "),
        metres(sum),
    )
}

/// The change from one trial to another that designs one entity more.
fn step(results: &StudyResults, [from, to, question, paper]: [&str; 4]) -> String {
    let [from, to] = [from, to].map(|name| results.row(name).displacement);
    let errors = Option::zip(from.standard_error, to.standard_error);
    let error = errors.map(|(a, b)| format!(" ± {}", decimals(a.hypot(b), 2)));
    let change = Option::zip(from.median, to.median).map(|(a, b)| b - a);
    format!(
        "- **{question}?** {} to {} m, a change of {}{} m (the paper: {paper}).\n",
        metres(from.median),
        metres(to.median),
        metres(change),
        error.unwrap_or_default(),
    )
}
