//! What topology, material and control are each worth, and what together.

use super::files::Results;
use super::markdown::{
    COLUMNS, Departures, cells, made_by, metres, motifs, percent, pictures, preamble, ratio, table,
};
use super::rows::Row;
use super::trials::{ABLATION, Entities};
use super::{Statistics, Study};
use crate::table::decimals;

/// An entity: its name, whether a trial designs it, the paper's gain as a ratio where it has one.
struct Entity {
    name: &'static str,
    is_in: fn(&Entities) -> bool,
    paper: Option<f64>,
}

const ENTITIES: [Entity; 3] = [
    Entity {
        name: "topology",
        is_in: |e| e.topology,
        paper: Some(2.16),
    },
    Entity {
        name: "material",
        is_in: |e| e.material,
        paper: Some(8.81),
    },
    Entity {
        name: "control",
        is_in: |e| e.control,
        paper: None,
    },
];

/// A number of a trial's sample.
type Figure = fn(&Statistics) -> Option<f64>;

/// What the trials that design an entity reach on average, and those that do not, m.
#[derive(Clone, Copy)]
struct Means {
    with: Option<f64>,
    without: Option<f64>,
}

impl Means {
    fn of(results: &Results, entity: &Entity, figure: Figure) -> Self {
        let mean = |wanted: bool| {
            let names = ABLATION
                .iter()
                .filter(|(.., e)| (entity.is_in)(e) == wanted);
            let numbers: Option<Vec<f64>> = names
                .map(|(name, ..)| figure(&results.row(name).displacement))
                .collect();
            numbers.map(|numbers| numbers.iter().sum::<f64>() / numbers.len() as f64)
        };
        Self {
            with: mean(true),
            without: mean(false),
        }
    }

    fn gain(&self) -> Option<f64> {
        Option::zip(self.with, self.without).map(|(with, without)| with - without)
    }
}

/// The bars of the paper's figure: for each entity its mean without and with, by the medians.
pub(super) fn means(results: &Results) -> Vec<(String, Option<f64>)> {
    let bars = |entity: &Entity| {
        let means = Means::of(results, entity, |s| s.median);
        let bar = |how: &str, mean| (format!("{how} {}", entity.name), mean);
        [bar("without", means.without), bar("with", means.with)]
    };
    ENTITIES.iter().flat_map(bars).collect()
}

/// The whole document.
pub(super) fn document(study: &Study, results: &Results) -> String {
    let rows: Vec<&Row> = results.rows.iter().collect();
    let names: Vec<&str> = rows.iter().map(|row| &row.name[..]).collect();
    let figures: String = rows
        .iter()
        .map(|row| pictures(study, row, &["robot"]))
        .collect();
    [
        "# Ablation: topology, material, control\n".to_owned(),
        preamble(study),
        ABOUT.to_owned(),
        format!(
            "## Trials\n\n{}\n![every seed](ablation/trials.svg)\n",
            trials(&rows)
        ),
        format!(
            "## By entity\n\n{}\n![means](ablation/entities.svg)\n",
            by_entity(results)
        ),
        format!("## Questions\n\n{}", questions(results)),
        format!("## Motifs\n\n{}", motifs(results, &names)),
        format!("## The best seed of each\n\n{figures}"),
        made_by(study),
    ]
    .join("\n")
}

const ABOUT: &str = "All trials begin with the stability heuristic where topology is designed, and \
    with a filled lattice where not. Without control the network keeps its first weights. Without \
    material the actuators are spread evenly over the vertical edges, and what an edge is not is \
    held down before every projection, in the stability projection after its centring. Without \
    topology the share of solid edges is held above 0.90, once materials are decided above 0.87 \
    (`volume.widening`). With neither, the filled layout, outside \
    the volume bounds, is taken as it is.\n";

fn trials(rows: &[&Row]) -> String {
    let departures = Departures::of(rows);
    let mut head = vec!["designed", "topology", "material", "control", "paper"];
    head.extend(COLUMNS);
    head.push("departures");
    let line = |(row, (.., entities)): (&&Row, &(&str, &str, Option<f64>, Entities))| {
        let mark = |entity: &Entity| match (entity.is_in)(entities) {
            true => "yes".to_owned(),
            false => "no".to_owned(),
        };
        let mut line = vec![row.title.clone()];
        line.extend(ENTITIES.iter().map(mark));
        line.push(metres(row.paper));
        line.extend(cells(row));
        line.push(departures.letters(row));
        line
    };
    let lines: Vec<Vec<String>> = rows.iter().zip(&ABLATION).map(line).collect();
    format!("{}\n{}", table(&head, &lines), departures.legend())
}

fn by_entity(results: &Results) -> String {
    let line = |entity: &Entity| {
        let mut line = vec![entity.name.to_owned()];
        for figure in [(|s| s.median) as Figure, |s| s.best] {
            let means = Means::of(results, entity, figure);
            line.extend([metres(means.without), metres(means.with)]);
            line.push(percent(ratio(means.with, means.without)));
        }
        line.push(percent(entity.paper));
        line
    };
    let head = [
        "entity",
        "without, median",
        "with, median",
        "gain",
        "without, best",
        "with, best",
        "gain",
        "the paper's gain",
    ];
    let lines = ENTITIES.each_ref().map(line);
    format!(
        "Means over the four trials that design the entity and the four that do not: of the medians \
         over the seeds, and of the best seeds.\n\n{}",
        table(&head, &lines)
    )
}

/// What the paper says it found, held against these numbers.
fn questions(results: &Results) -> String {
    let mut text = ranking(results);
    text += &together(results);
    text += &step(
        results,
        (
            "Does control help on top of topology and material",
            ["topology-material", "all"],
        ),
        "the paper: 1.02 to 1.91, +87 %",
    );
    text += &step(
        results,
        (
            "Does control help with topology alone",
            ["topology", "topology-control"],
        ),
        "the paper: it does not",
    );
    for (question, pair) in [
        (
            "Does topology help with material alone",
            ["material", "topology-material"],
        ),
        (
            "Does topology help with material and control",
            ["material-control", "all"],
        ),
    ] {
        text += &step(results, (question, pair), "the paper: it does");
    }
    text
}

fn ranking(results: &Results) -> String {
    let gain = |entity: &Entity| Means::of(results, entity, |s| s.median).gain();
    let mut gains: Vec<_> = ENTITIES.iter().map(|e| (e.name, gain(e))).collect();
    gains.sort_by(|a, b| b.1.partial_cmp(&a.1).unwrap_or(std::cmp::Ordering::Equal));
    let list: Vec<String> = gains
        .iter()
        .map(|(name, gain)| format!("{name} {} m", metres(*gain)))
        .collect();
    let verdict = match (gains[0].0, gains[2].0) {
        _ if gains.iter().any(|(_, gain)| gain.is_none()) => "not to be said: some median diverged",
        ("material", "control") => "as in the paper",
        _ => "unlike in the paper",
    };
    format!(
        "- **Which entity is worth most, which least?** By the gain of the means: {}; {verdict} (the \
         paper: the actuation layout is worth most, control least).\n",
        list.join(", ")
    )
}

fn together(results: &Results) -> String {
    let median = |name: &str| results.row(name).displacement.median;
    let none = median("none");
    let gain = |name: &str| Option::zip(median(name), none).map(|(x, none)| x - none);
    let singles = ["topology", "material", "control"].map(gain);
    let sum = singles.iter().copied().sum::<Option<f64>>();
    let joint = gain("all");
    let verdict = match Option::zip(joint, sum) {
        Some((joint, sum)) if joint > sum => "more than the sum, as in the paper",
        Some(_) => "not more than the sum, unlike in the paper",
        None => "not to be said: some median diverged",
    };
    format!(
        "- **Is the joint gain more than the sum of the single ones?** All three {} m over none; one \
         by one {} m, together {} m: {verdict}.\n",
        metres(joint),
        singles.map(metres).join(" + "),
        metres(sum),
    )
}

/// From one trial to another that designs one entity more.
fn step(results: &Results, (question, pair): (&str, [&str; 2]), paper: &str) -> String {
    let [from, to] = pair.map(|name| results.row(name).displacement);
    let errors = Option::zip(from.standard_error, to.standard_error);
    let error = errors.map_or(String::new(), |(a, b)| {
        format!(" ± {}", decimals(a.hypot(b), 2))
    });
    let change = Option::zip(from.median, to.median).map(|(a, b)| b - a);
    format!(
        "- **{question}?** {} to {} m, a change of {}{error} m ({paper}).\n",
        metres(from.median),
        metres(to.median),
        metres(change),
    )
}
