//! A reader of files must read any bytes at all, or say cleanly what is wrong with them. A value that was
//! read is written out, read again and compared.
//!
//! Fuzzing drives these functions, and a test runs them over the corpus that fuzzing left.

use std::path::Path;

use cosmic::Result;
use cosmic::case::Case;
use cosmic::error::Error;
use cosmic::record::{DesignFile, RunPlan, snapshot};
use cosmic::scene::Scene;

/// A reader by its name, which is that of its corpus and of its fuzz target.
pub type Reader = fn(&[u8]) -> Result<()>;

/// Every reader.
pub const READERS: [(&str, Reader); 4] = [
    ("scene", scene),
    ("case", case),
    ("design", design),
    ("snapshot", snapshot),
];

/// Steps for which a case is run that was read, and the nodes and hidden units that it may have
/// for that: a fuzzer wants many cases, not long ones.
const FEW: usize = 16;

fn text(bytes: &[u8]) -> Result<&str> {
    std::str::from_utf8(bytes).map_err(|_| Error::Usage("no text".to_owned()))
}

/// Reads a scene; what is read back from its own text must be the same.
///
/// # Errors
/// The reader's.
///
/// # Panics
/// Where the reader is wrong.
pub fn scene(bytes: &[u8]) -> Result<()> {
    let scene = Scene::parse("scene.toml", text(bytes)?)?;
    let again = Scene::parse("again.toml", &scene.to_toml());
    assert_eq!(again.expect("a scene's own text is a scene"), scene);
    Ok(())
}

/// Reads a case, and runs a small one for a few steps.
///
/// # Errors
/// As [`scene`].
///
/// # Panics
/// As [`scene`].
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
/// As [`scene`].
///
/// # Panics
/// As [`scene`].
pub fn design(bytes: &[u8]) -> Result<()> {
    let design = DesignFile::parse(Path::new("design.json"), bytes)?;
    let mut scene = Scene::paper();
    (scene.lattice.columns, scene.lattice.rows) = (2, 2);
    (scene.controller.hidden, scene.controller.clocks) = (1, 1);
    let case = design.case(&scene, "design.json")?;
    assert_eq!(case.design, design.design());
    Ok(())
}

/// Reads a snapshot, and fits what it has reached to its own scene where that is small.
///
/// # Errors
/// As [`scene`].
///
/// # Panics
/// As [`scene`].
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
            return Err(Error::Usage("too large to be tried often".to_owned()));
        }
        Ok(())
    };
    snapshot::check(Path::new("snapshot.json"), bytes, small).map(drop)
}
