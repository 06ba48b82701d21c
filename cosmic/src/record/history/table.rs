//! The rows of `history.csv`.

use super::rows::HistoryRow;
use crate::optimiser::MmaDiagnostics;
use crate::scene::Pass;

/// The names of the table's columns.
pub(super) const HEADER: &str = "\
    iteration,phase,pass,displacement,displacement_horizon,horizon,V,V_act,\
    g_bin,g_01,g_02,g_12,\
    violation_g_bin,violation_g_01,violation_g_02,violation_g_12,\
    multiplier_g_bin,multiplier_g_01,multiplier_g_02,multiplier_g_12,\
    penalty_g_bin,penalty_g_01,penalty_g_02,penalty_g_12,\
    design_gradient_performance,design_gradient_stability,controller_gradient,\
    mma_performance_newton_steps,mma_performance_residual,\
    mma_performance_elastic_V_most,mma_performance_elastic_V_least,\
    mma_performance_elastic_V_act_most,mma_performance_elastic_V_act_least,\
    mma_stability_newton_steps,mma_stability_residual,\
    mma_stability_elastic_V_most,mma_stability_elastic_V_least,\
    mma_stability_elastic_V_act_most,mma_stability_elastic_V_act_least,\
    skipped,dt_over_bound,dt_over_limit,seconds\n";

/// A row of the table, in the header's order. Missing values are empty cells; numbers that are not finite are
/// `NaN`, `inf` or `-inf`.
pub(super) fn line(row: &HistoryRow) -> String {
    let r = &row.record;
    let pass = r.pass.map_or("", |pass| match pass {
        Pass::Design => "design",
        Pass::Controller => "controller",
    });
    let mut cells = vec![r.iteration.to_string(), r.phase.name().into(), pass.into()];
    cells.extend([r.displacement, r.displacement_horizon].map(perhaps));
    cells.push(r.horizon.to_string());
    cells.extend([r.volume, r.actuator_volume].map(number));
    let lists = [r.measures, r.violations, r.multipliers, r.penalties];
    cells.extend(lists.as_flattened().iter().map(|&x| number(x)));
    cells.extend(r.design_gradient.map(perhaps));
    cells.push(perhaps(r.controller_gradient));
    cells.extend(r.mma.iter().flat_map(|mma| solved(mma.as_ref())));
    cells.push(r.skipped.to_string());
    let bound = r.time_step.map(|check| check.bound.share(check.dt));
    let limit = r
        .time_step
        .and_then(|check| Some(check.exact?.share(check.dt)));
    cells.extend([bound, limit].map(perhaps));
    cells.push(number(row.seconds));
    cells.join(",") + "\n"
}

/// The six cells on a subproblem.
fn solved(mma: Option<&MmaDiagnostics>) -> Vec<String> {
    let Some(mma) = mma else {
        return vec![String::new(); 6];
    };
    let mut cells = vec![mma.newton_steps.to_string(), number(mma.residual)];
    // Where the measures are constraints too, theirs follow: the lines have them, the table not.
    cells.extend(mma.elastic.iter().take(4).map(|&x| number(x)));
    cells
}

/// The shortest decimal that reads back to the same bits.
fn number(x: f64) -> String {
    format!("{x:?}")
}

fn perhaps(x: Option<f64>) -> String {
    x.map_or(String::new(), number)
}
