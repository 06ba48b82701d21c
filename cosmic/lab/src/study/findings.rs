//! The paper's findings, each as a change of the default and a number.

use super::Study;
use super::document::{document, metres, percent, trial_table};
use super::results::StudyResults;
use super::rows::{RunRow, TrialRow};
use super::statistics::mean;
use super::trials::{REFERENCE, lines};
use crate::table::decimals;
use cosmic::record::summary::ratio;

/// The trial that answers, the trial it is compared with, the question, and the paper's answer, if
/// any.
const QUESTIONS: &str = "
simp                | stability | Does penalised stiffness (SIMP) harm? \
    | it can induce significant instability
constraints         | stability | Are strict binarisation constraints worse than the augmented Lagrangian? \
    | the augmented Lagrangian yields better performance
no-stability-pass   | stability | Is the stability pass worth something? \
    | it probes the robot that the snap will leave
c-no-stability-pass | c         | The same from the three-legged start? \
    | it probes the robot that the snap will leave
clocks-20           | stability | Do more than 10 clocks harm? \
    | they desynchronise the robot and harm its stability
clocks-40           | stability | And many more? \
    | they desynchronise the robot and harm its stability
final-loss          | stability | What does the mean loss bring? |
exact-gradient      | stability | What does the cotangent bound bring? |
last-iterate        | stability | What does the choice of the delivered controller bring? |
single-precision    | stability | Do rollouts in f32 cost distance? |
c-tall              | c         | What does the short layout bring to the three-legged start? \
    | one layout for the baseline and the start
d-no-memory         | d | What does the mean of design gradients bring without a heuristic? |
d-no-trials         | d | What do the snap's alternatives bring there? |
d-no-polish         | d | What do other materials after the snap bring there? |
d-no-settling       | d | What does settling bring there? |
stability           | loose     | What does it bring that all bars hang together? |
no-free-ends        | stability | And that none has a free end? |
no-crossings        | stability | And that none cross? |
feet                | stability | And that there are at least four feet? |
stops               | stability | What do end stops cost, where actuators overshoot without? |
";

/// The whole document.
pub(super) fn document_of(study: &Study, results: &StudyResults) -> String {
    let answers: String = lines(QUESTIONS).map(|line| answer(results, line)).collect();
    let questions = answers + &steering(results);
    let trials = format!(
        "Each is the default with one change.\n\n{}\n![every seed](findings/trials.svg)\n",
        trials(results)
    );
    let sections = [["Trials", &trials], ["Questions", &questions]];
    document(study, "Findings of the paper as questions", "", &sections)
}

fn trials(results: &StudyResults) -> String {
    let rows: Vec<&TrialRow> = results.rows.iter().collect();
    let reference = results.row(REFERENCE).displacement.median;
    let over = |row: &&TrialRow| ratio(row.displacement.median, reference);
    trial_table(&rows, |table| {
        table
            .column("trial", "", |row| row.trial.title)
            .column("median / default", "", over)
            .column("goal behind", "", |row| row.goal_behind)
    })
}

/// A question with its numbers. Runs of one seed begin alike, so the verdict is on the mean change from
/// seed to seed. A mean within twice its error decides nothing.
fn answer(results: &StudyResults, [changed, reference, question, paper]: [&str; 4]) -> String {
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
    let change = change.map_or(String::new(), |both| {
        let [change, error] = both.map(|x| decimals(x, 2));
        format!(", seed by seed a change of {change} ± {error} m")
    });
    let paper = match paper {
        "" => String::new(),
        paper => format!(" The paper: {paper}."),
    };
    format!(
        "- **{question}** {} m becomes {} m ({}){change}: {verdict}.{paper}\n",
        metres(from),
        metres(to),
        percent(ratio(to, from)),
    )
}

/// One controller and two goals.
fn steering(results: &StudyResults) -> String {
    let [one, two] = [REFERENCE, "two-goals"].map(|name| {
        let row = results.row(name);
        let steered = row.runs.iter().filter(|run| {
            run.displacement() > Some(0.0) && run.goal_behind().is_some_and(|behind| behind < 0.0)
        });
        format!(
            "{} m with the goal ahead and {} m with it behind, {} of {} seeds in the goals' \
             directions",
            metres(row.displacement.median),
            metres(row.goal_behind),
            steered.count(),
            row.runs.len(),
        )
    });
    format!(
        "- **Does the goal steer?** Trained for one goal: {one}. Trained for two: {two}. The paper: \
         the goal vector enables steering towards different targets.\n"
    )
}
