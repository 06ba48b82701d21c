//! What the paper says it found, each as a change of the default and a number.

use super::Study;
use super::files::Results;
use super::markdown::{
    COLUMNS, Departures, cells, made_by, metres, percent, preamble, ratio, table,
};
use super::rows::{Row, RunRow};
use super::statistics::mean;
use super::trials::REFERENCE;
use crate::table::decimals;

/// What is asked, the trial that answers, the one it is held against, and what the paper says
/// where it does.
const QUESTIONS: [(&str, &str, &str, Option<&str>); 15] = [
    (
        "Does penalised stiffness (SIMP) harm?",
        "simp",
        REFERENCE,
        Some("it can induce significant instability"),
    ),
    (
        "Are strict binarisation constraints worse than the augmented Lagrangian?",
        "constraints",
        REFERENCE,
        Some("the augmented Lagrangian yields better performance"),
    ),
    (
        "Is the stability pass worth something?",
        "no-stability-pass",
        REFERENCE,
        Some("it probes the robot that the snap will leave"),
    ),
    (
        "The same from the three-legged start?",
        "c-no-stability-pass",
        "c",
        Some("it probes the robot that the snap will leave"),
    ),
    (
        "Do more than 10 clocks harm?",
        "clocks-20",
        REFERENCE,
        Some("they desynchronise the robot and harm its stability"),
    ),
    (
        "And many more?",
        "clocks-40",
        REFERENCE,
        Some("they desynchronise the robot and harm its stability"),
    ),
    (
        "What does the mean loss bring?",
        "final-loss",
        REFERENCE,
        None,
    ),
    (
        "What does the cotangent bound bring?",
        "exact-gradient",
        REFERENCE,
        None,
    ),
    (
        "What does the choice of the delivered controller bring?",
        "last-iterate",
        REFERENCE,
        None,
    ),
    (
        "Do rollouts in f32 cost distance?",
        "single-precision",
        REFERENCE,
        None,
    ),
    (
        "What does the short layout bring to the three-legged start?",
        "c-tall",
        "c",
        Some("one layout for the baseline and the start"),
    ),
    (
        "What does the mean of design gradients bring without a heuristic?",
        "d-no-memory",
        "d",
        None,
    ),
    (
        "What do the snap's alternatives bring there?",
        "d-no-trials",
        "d",
        None,
    ),
    (
        "What do other materials after the snap bring there?",
        "d-no-polish",
        "d",
        None,
    ),
    (
        "What does settling bring there?",
        "d-no-settling",
        "d",
        None,
    ),
];

/// The whole document.
pub(super) fn document(study: &Study, results: &Results) -> String {
    let rows: Vec<&Row> = results.rows.iter().collect();
    let answers: String = QUESTIONS.map(|question| answer(results, question)).concat();
    [
        "# Findings of the paper as questions\n".to_owned(),
        preamble(study),
        format!(
            "## Trials\n\nEach is the default with one change.\n\n{}\n![every \
             seed](findings/trials.svg)\n",
            trials(results, &rows)
        ),
        format!("## Questions\n\n{answers}{}", steering(results)),
        made_by(study),
    ]
    .join("\n")
}

fn trials(results: &Results, rows: &[&Row]) -> String {
    let departures = Departures::of(rows);
    let mut head = vec!["trial", "median / default", "goal behind"];
    head.extend(COLUMNS);
    head.push("departures");
    let reference = results.row(REFERENCE).displacement.median;
    let line = |row: &&Row| {
        let share = ratio(row.displacement.median, reference);
        let share = share.map_or(metres(None), |x| decimals(x, 2));
        let mut line = vec![row.title.clone(), share, metres(row.goal_behind)];
        line.extend(cells(row));
        line.push(departures.letters(row));
        line
    };
    let lines: Vec<Vec<String>> = rows.iter().map(line).collect();
    format!("{}\n{}", table(&head, &lines), departures.legend())
}

/// A question with its numbers. Runs of one seed begin alike, so the verdict is on the mean of the
/// seeds' own changes; one within twice its error is no answer.
fn answer(
    results: &Results,
    (question, changed, reference, paper): (&str, &str, &str, Option<&str>),
) -> String {
    let rows = [reference, changed].map(|name| results.row(name));
    let [from, to] = rows.map(|row| row.displacement.median);
    let [before, after] = rows.map(|row| row.runs.iter().map(RunRow::displacement));
    let pairs = before.zip(after).map(|(a, b)| Some(b? - a?));
    let pairs = pairs.collect::<Option<Vec<f64>>>();
    let change = pairs.as_deref().and_then(mean);
    let verdict = match change {
        None if pairs.is_some() => "undecided: one seed's change has no error",
        None => "no number: runs diverged",
        Some([change, error]) if change.abs() <= 2.0 * error => "within twice its error: undecided",
        Some([change, _]) if change < 0.0 => "worse",
        Some(_) => "better",
    };
    let change = change.map(|both| both.map(|x| decimals(x, 2)));
    let change = change.map_or(String::new(), |[change, error]| {
        format!(", seed by seed a change of {change} ± {error} m")
    });
    let paper = paper.map_or(String::new(), |paper| format!(" The paper: {paper}."));
    format!(
        "- **{question}** {} m becomes {} m ({}){change}: {verdict}.{paper}\n",
        metres(from),
        metres(to),
        percent(ratio(to, from)),
    )
}

/// One controller and two goals.
fn steering(results: &Results) -> String {
    let [one, two] = [REFERENCE, "two-goals"].map(|name| results.row(name));
    let goals = |row: &Row| {
        let steered = row.runs.iter().filter(|run| {
            let behind = run.check.as_ref().and_then(|check| check.goal_behind);
            run.displacement() > Some(0.0) && behind.is_some_and(|behind| behind < 0.0)
        });
        format!(
            "{} m with the goal ahead and {} m with it behind, {} of {} seeds in the goals' \
             directions",
            metres(row.displacement.median),
            metres(row.goal_behind),
            steered.count(),
            row.runs.len(),
        )
    };
    format!(
        "- **Does the goal steer?** Trained for one goal: {}. Trained for two: {}. The paper: the \
         goal vector enables steering towards different targets.\n",
        goals(one),
        goals(two)
    )
}
