//! Tests of the functions that read files. For any bytes, such a function must return a value or a clear error. A value
//! is written, read again and compared.
//!
//! The fuzz targets call these tests. One test runs them over the corpus: the files that fuzzing has found.

use std::path::Path;

use cosmic::Result;
use cosmic::case::{Case, Frame};
use cosmic::error::Error;
use cosmic::outcome::DesignFile;
use cosmic::record::{RunPlan, snapshot};
use cosmic::scene::Scene;
use serde_json::Value;

/// The test of a function that reads files. It reads the bytes as a file, returns the error if there is one, and panics
/// if it finds a mistake in the function.
pub type Reader = fn(&[u8]) -> Result<()>;

/// The tests of all functions that read files. Each has a name, which is also the name of its corpus and its fuzz
/// target.
pub const READERS: [(&str, Reader); 4] = [
    ("scene", scene),
    ("case", case),
    ("design", design),
    ("snapshot", snapshot),
];

/// The largest number of steps, nodes and hidden units with which a case is run. Larger cases are only read, because a
/// fuzzer needs many short runs.
const FEW: usize = 16;

fn text(bytes: &[u8]) -> Result<&str> {
    std::str::from_utf8(bytes).map_err(|_| Error::Usage("not UTF-8".to_owned()))
}

/// Checks the reader of scenes: reads a scene, writes it as text, and asserts that this text gives the same scene.
///
/// # Errors
/// The errors of the reader.
///
/// # Panics
/// If the reader is wrong.
pub fn scene(bytes: &[u8]) -> Result<()> {
    let scene = Scene::parse("scene.toml", text(bytes)?)?;
    let again = Scene::parse("again.toml", &scene.to_toml());
    assert_eq!(again.expect("a scene's own text is a scene"), scene);
    Ok(())
}

/// Checks the reader of cases: reads a case, and runs it for a few steps if it is small.
///
/// # Errors
/// The errors of the reader.
///
/// # Panics
/// If the reader is wrong.
pub fn case(bytes: &[u8]) -> Result<()> {
    let mut case = Case::parse("case.json", text(bytes)?)?;
    case.recorded_steps(&[])?;
    // A case is written without its results, in the world's frame.
    case.listed_steps.clear();
    case.frame = Frame::default();
    let again = Case::parse("again.json", &case.to_json());
    assert_eq!(again.expect("a case's own text is a case"), case);
    if case.lattice.nodes() <= FEW && case.scene.controller.hidden <= FEW {
        case.scene.physics.steps = case.scene.physics.steps.min(FEW);
        case.evaluate(false, &[])?;
        case.step_check();
    }
    Ok(())
}

/// Checks the reader of designs: reads a design, and fits it to a lattice of 2x2 nodes.
///
/// # Errors
/// The errors of the reader.
///
/// # Panics
/// If the reader is wrong.
pub fn design(bytes: &[u8]) -> Result<()> {
    let design = DesignFile::parse(Path::new("design.json"), bytes)?;
    let mut scene = Scene::paper();
    (scene.lattice.columns, scene.lattice.rows) = (2, 2);
    (scene.controller.hidden, scene.controller.clocks) = (1, 1);
    let case = design.case(&scene, "design.json")?;
    assert_eq!(case.design, design.design());
    Ok(())
}

/// Replaces the scene of a snapshot by the paper's scene with its settings, because a snapshot has a whole scene, which
/// fuzzing would hardly keep whole. `None` for bytes without a scene.
fn with_whole_scene(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut json: Value = serde_json::from_slice(bytes).ok()?;
    let scene = json.pointer_mut("/plan/scene/text")?;
    let whole = Scene::paper().with("scene", scene.as_str()?).ok()?;
    *scene = whole.to_run_toml().into();
    Some(json.to_string().into_bytes())
}

/// Checks the reader of snapshots: reads a snapshot, and checks its progress against its own scene if the scene is
/// small.
///
/// # Errors
/// The errors of the reader.
///
/// # Panics
/// If the reader is wrong.
pub fn snapshot(bytes: &[u8]) -> Result<()> {
    let small = |plan: &RunPlan| {
        let (lattice, controller) = (&plan.scene.lattice, &plan.scene.controller);
        let sizes = [
            lattice.file.truss().map_or(0, |truss| truss.nodes.len()),
            lattice.columns,
            lattice.rows,
            controller.hidden,
            controller.clocks,
        ];
        if sizes.iter().any(|size| *size > FEW) {
            return Err(Error::Usage("too large for fuzzing".to_owned()));
        }
        Ok(())
    };
    let whole = with_whole_scene(bytes);
    let bytes = whole.as_deref().unwrap_or(bytes);
    snapshot::check(Path::new("snapshot.json"), bytes, small).map(drop)
}
