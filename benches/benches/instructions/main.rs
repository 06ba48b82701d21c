//! Counts the instructions of a robot's rollout and of its gradients with valgrind's callgrind. Other load on the machine
//! does not change the counts. The program runs itself under valgrind, with one repetition and with two. The difference of
//! the two counts contains only the work itself, without the start of the program, the setup and the first use of memory.
//!
//! `cargo bench -p benches --bench instructions` prints a table of `RESULTS.md`. Without valgrind it prints that it is
//! skipped.

mod robot;

use std::hint::black_box;
use std::process::{Command, ExitCode};

use autodiff::Real;
use cosmic::case::Case;
use cosmic::inputs::{CONTROLLER, DESIGN};
use cosmic::scene::Scene;
use robot::{MEASURED_STEPS, Subject, TwoMatvecs};

/// A row of the table: its name, the scene, the number of columns with counts, and the work of a column.
type Row = (&'static str, &'static str, usize, fn(&Subject<'_>, usize));

const ROWS: [Row; 5] = [
    ("only two mat-vecs, f64", "stability", 1, matvecs),
    ("mixture, f64", "stability", 3, in_type::<f64>),
    ("mixture, f32", "stability", 3, in_type::<f32>),
    ("one-hot, f64", "baseline_tall", 3, in_type::<f64>),
    ("one-hot, f32", "baseline_tall", 3, in_type::<f32>),
];

fn matvecs(subject: &Subject<'_>, _: usize) {
    black_box(TwoMatvecs::new(subject.case).run(MEASURED_STEPS));
}

fn in_type<R: Real>(subject: &Subject<'_>, column: usize) {
    match column {
        0 => _ = black_box(subject.rollout::<R>()),
        1 => _ = black_box(subject.gradient::<R>(DESIGN)),
        _ => _ = black_box(subject.gradient::<R>(CONTROLLER)),
    }
}

fn main() -> ExitCode {
    // `ROW COLUMN REPETITIONS` does one piece of work: so the program calls itself under valgrind.
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let numbers: Result<Vec<usize>, _> = arguments.iter().map(|text| text.parse()).collect();
    if let Ok([row, column, repeats]) = numbers.as_deref() {
        let (_, scene, _, work) = ROWS[*row];
        let scene = Scene::load(scene).expect("the scene is built in");
        let case = Case::of_scene(&scene, 0).expect("a built-in scene is complete");
        let subject = Subject::new(&case, &scene.loss);
        (0..*repeats).for_each(|_| work(&subject, *column));
        return ExitCode::SUCCESS;
    }
    let Ok(version) = Command::new("valgrind").arg("--version").output() else {
        println!("SKIPPED: valgrind, which counts instructions, is not on the path");
        return ExitCode::SUCCESS;
    };
    println!(
        "Counted by callgrind ({}) on AVX2 lanes: instructions per step, over a rollout of {MEASURED_STEPS} steps with its \
         beginning and end, for 6x6 nodes, 110 edges and 32 hidden units. In brackets: the ratio to the two matrix-vector \
         products of the controller in f64.\n\n\
         | design | rollout | value and design gradient | value and controller gradient |\n| --- | --- | --- | --- |",
        String::from_utf8_lossy(&version.stdout).trim()
    );
    match print_rows() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn print_rows() -> Result<(), String> {
    let mut base = None;
    for (row, (name, _, columns, _)) in ROWS.into_iter().enumerate() {
        let mut text = format!("| {name} |");
        for column in 0..columns {
            let count = (total(row, column, 2)? - total(row, column, 1)?) / MEASURED_STEPS as f64;
            text += &format!(" {count:.0} ({:.2}) |", count / *base.get_or_insert(count));
        }
        println!("{text}{}", " |".repeat(3 - columns));
    }
    Ok(())
}

/// Returns the number of instructions of a process that repeats a piece of work.
///
/// # Errors
/// If valgrind or the program fails, or valgrind prints no count.
fn total(row: usize, column: usize, repeats: usize) -> Result<f64, String> {
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(program)
        .args([row, column, repeats].map(|number| number.to_string()))
        .output()
        .map_err(|error| format!("cannot run valgrind: {error}"))?;
    let messages = String::from_utf8_lossy(&output.stderr);
    // The summary is `==PID== Collected : 123`.
    let count = messages.rsplit_once("Collected : ").map(|(_, rest)| rest);
    let count = count.and_then(|rest| rest.lines().next()?.trim().parse().ok());
    let failed = || {
        format!(
            "valgrind printed no count of instructions ({}): {messages}",
            output.status
        )
    };
    count.filter(|_| output.status.success()).ok_or_else(failed)
}
