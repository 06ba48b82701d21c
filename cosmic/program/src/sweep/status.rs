//! `cosmic sweep status`, `merge` and `prune`: the commands that simulate nothing.

use crate::arguments::Output;
use crate::output::{answer, counted, in_json, lines, note, print, print_json};
use cosmic::error::Result;
use cosmic_lab::sweep::{self, RunState, SurveyedRun, SweepPlan, in_ranges, survey};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::Path;

pub(super) fn status(sweep: &Path, as_json: bool) -> Result<()> {
    let survey = survey(sweep, &SweepPlan::read(sweep)?);
    let left = in_ranges(&survey.left());
    if as_json {
        let count = |state: RunState| (state.name(), survey.count(state));
        let counts = BTreeMap::from(RunState::ALL.map(count));
        return print_json(&json!({ "runs": survey.runs, "counts": counts, "left": left }));
    }
    let widths = survey.runs.iter().map(|run| run.scene.chars().count());
    let width = widths.max().unwrap_or(0);
    let line = |run: &SurveyedRun| {
        let (index, scene, seed) = (run.index, &run.scene, run.seed);
        let (state, done) = (run.state.name(), counted(run.iterations, "iteration"));
        let swept: String = run
            .swept
            .iter()
            .map(|(k, v)| format!("  {k} = {v}"))
            .collect();
        format!("{index:5}  {scene:width$}  seed {seed:<5}  {state:8}  {done}{swept}\n")
    };
    let lines: String = survey.runs.iter().map(line).collect();
    let left = match &left[..] {
        "" => String::new(),
        numbers => format!("left: {numbers}\n"),
    };
    let counts = RunState::ALL.map(|state| format!("{} {}", survey.count(state), state.name()));
    print(&format!("{lines}{left}{}\n", counts.join(", ")))
}

pub(super) fn merge(sweep: &Path, output: &Output) -> Result<()> {
    let plan = SweepPlan::read(sweep)?;
    let merged = sweep::merge(sweep, &plan)?;
    let (written, missing) = ([merged.results, merged.table], merged.missing);
    if missing > 0 && !output.quiet {
        note(&format!("{missing} of {} runs are not done", plan.runs()));
    }
    let value = json!({ "written": in_json(&written), "missing": missing });
    answer(output, &value, &lines(&written))
}

pub(super) fn prune(sweep: &Path, output: &Output) -> Result<()> {
    let sweep::Pruned { runs, bytes } = sweep::prune(sweep, &SweepPlan::read(sweep)?)?;
    let text = format!("{}, {bytes} bytes\n", counted(runs, "run"));
    answer(output, &json!({ "runs": runs, "bytes": bytes }), &text)
}
