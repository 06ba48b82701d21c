//! Checks of the readers of files. For any bytes, a reader must return a value or a clear error. A value is then
//! written, read again and compared.
//!
//! Fuzzing calls these functions, and a test runs them over the corpus that fuzzing found.

use std::path::Path;

use cosmic::Result;
use cosmic::case::Case;
use cosmic::error::Error;
use cosmic::record::{DesignFile, RunPlan, snapshot};
use cosmic::scene::Scene;

/// A check of one reader: reads bytes, and panics if the reader is wrong.
pub type Reader = fn(&[u8]) -> Result<()>;

/// Every reader with its name, which is also the name of its corpus and of its fuzz target.
pub const READERS: [(&str, Reader); 4] = [
    ("scene", scene),
    ("case", case),
    ("design", design),
    ("snapshot", snapshot),
];

/// Cases with more steps, nodes or hidden units are not run, because a fuzzer needs many short cases.
const FEW: usize = 16;

fn text(bytes: &[u8]) -> Result<&str> {
    std::str::from_utf8(bytes).map_err(|_| Error::Usage("not UTF-8".to_owned()))
}

/// Reads a scene. The text that the scene writes must read back to the same scene.
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

/// Reads a case, and runs it for a few steps if it is small.
///
/// # Errors
/// The errors of the reader.
///
/// # Panics
/// If the reader is wrong.
pub fn case(bytes: &[u8]) -> Result<()> {
    let mut case = Case::parse("case.json", text(bytes)?)?;
    case.recorded_steps(&[])?;
    case.listed_steps.clear();
    let again = Case::parse("again.json", &case.to_json());
    assert_eq!(again.expect("a case's own text is a case"), case);
    if case.lattice.nodes() <= FEW && case.observation.hidden <= FEW {
        case.physics.steps = case.physics.steps.min(FEW);
        case.evaluate(false, &[])?;
        case.step_check();
    }
    Ok(())
}

/// Reads a design, and fits it to a lattice of 2x2 nodes.
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

/// Reads a snapshot, and checks its progress against its own scene if the scene is small.
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
    snapshot::check(Path::new("snapshot.json"), bytes, small).map(drop)
}
