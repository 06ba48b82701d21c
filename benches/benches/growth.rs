//! Measures how time, memory and the distances that robots cover change with the size of the lattice.
//!
//! `cargo bench -p benches --bench growth` prints a section of `RESULTS.md`: time and memory. With
//! `-- --designs` it also designs robots of all sizes, which takes a quarter of an hour on two cores.

use std::fmt::Write as _;
use std::time::Instant;

use autodiff::Memory;
use benches::machine::{row, seconds, section};
use benches::robot::{MEASURED_STEPS, Subject, memory_of};
use cosmic::case::Case;
use cosmic::codesign::{CoDesign, Quantiles};
use cosmic::inputs::{CONTROLLER, DESIGN};
use cosmic::parallel::{Crew, in_parallel};
use cosmic::scene::Scene;

/// The sizes of the lattice: the number of nodes in a row, which is also the number of rows.
const SIZES: [usize; 7] = [4, 6, 8, 10, 12, 16, 20];
/// The size with which other sizes are compared in ratios.
const UNIT: usize = 6;
/// The number of rounds of a measurement. Only the minimum is reported.
const ROUNDS: usize = 8;
/// The memory budgets for the gradient of the largest robot, in MB.
const BUDGETS: [usize; 4] = [400, 100, 20, 5];
/// The number of seeds with which each robot is designed.
const SEEDS: u64 = 8;
/// The scenes for which robots are designed.
const SCENES: [&str; 2] = ["stability", "large"];

fn main() {
    let cases = SIZES.map(|size| {
        let scene = sized("large", size);
        let case = Case::of_scene(&scene, 0).expect("the scene is complete");
        (scene, case)
    });
    let subjects = cases.each_ref();
    let subjects = subjects.map(|(scene, case)| Subject::new(case, &scene.loss));
    let edges = cases.each_ref().map(|(_, case)| case.lattice.edges.len());
    let times = times(&subjects, edges);
    let budgets = budgets(subjects.last().expect("there are sizes"));
    let mut tables = format!("{times}\n{budgets}");
    if std::env::args().any(|argument| argument == "--designs") {
        tables = format!("{tables}\n{}", distances());
    }
    let command = "cargo bench -p benches --bench growth -- --designs";
    println!("{}", section("Growth", command, &tables));
}

/// Returns a built-in scene with `size` rows and columns.
fn sized(scene: &str, size: usize) -> Scene {
    let mut scene = Scene::load(scene).expect("the scene is built in");
    (scene.lattice.columns, scene.lattice.rows) = (size, size);
    scene
}

/// Returns the table of the time for each edge and step, and of the memory of a gradient.
fn times(subjects: &[Subject; 7], edges: [usize; 7]) -> String {
    let mut least = [[f64::INFINITY; 3]; 7];
    for _ in 0..ROUNDS {
        for ((least, subject), edges) in least.iter_mut().zip(subjects).zip(edges) {
            let round = [
                seconds(|| subject.rollout::<f64>()),
                seconds(|| subject.gradient::<f64>(DESIGN)),
                seconds(|| subject.gradient::<f64>(CONTROLLER)),
            ];
            let pieces = (edges * MEASURED_STEPS) as f64;
            for (least, seconds) in least.iter_mut().zip(round) {
                *least = least.min(seconds * 1e9 / pieces);
            }
        }
    }
    let unit = SIZES.iter().position(|&size| size == UNIT);
    let unit = least[unit.expect("UNIT is one of SIZES")];
    let mut table = String::from(
        "| nodes | edges | rollout | | with the design gradient | | with the controller gradient | | MB |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for (k, times) in least.iter().enumerate() {
        let _ = write!(table, "| {0}x{0} | {1}", SIZES[k], edges[k]);
        for (time, unit) in times.iter().zip(unit) {
            let _ = write!(table, " | {time:.2} | {:.2}", time / unit);
        }
        let megabytes = megabytes(&subjects[k]);
        let _ = writeln!(table, " | {megabytes:.0} |");
    }
    table
}

/// Returns the table of the time and the memory of a gradient under several memory budgets.
fn budgets(subject: &Subject) -> String {
    let memories = BUDGETS.map(|budget| Memory::Bytes(budget * 1_000_000));
    let subjects: Vec<Subject> = std::iter::once(Memory::All)
        .chain(memories)
        .map(|memory| subject.with_memory(memory))
        .collect();
    // The runs of a budget are timed one after the other, so that each keeps its memory from gradient to gradient, as
    // in an optimisation.
    let least = |subject: &Subject| {
        let rounds = (0..ROUNDS).map(|_| seconds(|| subject.two_gradients()));
        rounds.fold(f64::INFINITY, f64::min)
    };
    let times: Vec<f64> = subjects.iter().map(least).collect();
    let mut table = String::from(
        "| budget, MB | MB held | time, relative to no budget |\n| --- | --- | --- |\n",
    );
    let names = std::iter::once("off".to_owned()).chain(BUDGETS.map(|budget| budget.to_string()));
    for ((name, subject), time) in names.zip(&subjects).zip(&times) {
        row(&mut table, &name, &[megabytes(subject), time / times[0]], 2);
    }
    table
}

/// Returns the peak memory for the gradients of a design optimisation, with both projections.
fn megabytes(subject: &Subject) -> f64 {
    let bytes = memory_of(|| subject.two_gradients());
    bytes.map_or(f64::NAN, |bytes| bytes as f64 * 1e-6)
}

/// Returns the table of how far robots of all sizes move.
fn distances() -> String {
    // The largest robots are designed first, because they take the longest.
    let jobs: Vec<(&str, usize, u64)> = (SIZES.iter().rev())
        .flat_map(|&size| SCENES.map(|scene| (scene, size)))
        .flat_map(|(scene, size)| (0..SEEDS).map(move |seed| (scene, size, seed)))
        .collect();
    let results = in_parallel(jobs.len(), Crew::of_one(None), |k, _| {
        let (scene, size, seed) = jobs[k];
        let start = Instant::now();
        let delivery = CoDesign::new(&sized(scene, size))?.optimise(seed, |_| ())?;
        let result = (delivery.spread.p50, start.elapsed().as_secs_f64());
        println!(
            "{scene} {size}, seed {seed}: {:.2} m, {:.0} s",
            result.0, result.1
        );
        Ok(result)
    });
    let results = results.expect("every scene can be optimised");
    let mut table = String::from(
        "| nodes | scene | seeds 0 to 7, m | median, m | s |\n| --- | --- | --- | --- | --- |\n",
    );
    for size in SIZES {
        for scene in SCENES {
            let these = jobs.iter().zip(&results);
            let these = these.filter(|((s, n, _), _)| (*s, *n) == (scene, size));
            let (far, seconds): (Vec<f64>, Vec<f64>) = these.map(|(_, result)| *result).unzip();
            let shown: Vec<String> = far.iter().map(|far| format!("{far:.2}")).collect();
            let [far, seconds] = [far, seconds].map(|sample| Quantiles::of(&sample).p50);
            let _ = writeln!(
                table,
                "| {size}x{size} | `{scene}` | {} | **{far:.2}** | {seconds:.1} |",
                shown.join(" ")
            );
        }
    }
    table
}
