//! The paper's evaluation repeated: many seeds of every experiment beside the paper's numbers; and designs
//! in another simulator.
//!
//! A [`Study`] is a sweep with a document. [`prepare`](Study::prepare) freezes its plan,
//! [`simulate`](Study::simulate) completes the runs and takes each one's [`Measurement`],
//! [`write`](Study::write) reads the records and writes Markdown, CSV, JSON and figures. All numbers except wall times follow from the plan.

mod trials;
mod settings;
mod check;
mod statistics;
mod python;
mod in_mujoco;
mod rows;
mod motifs;
mod results;
mod document;
mod paper;
mod ablation;
mod findings;
mod transfer;
mod figures;
mod measurement;
mod work;

pub use measurement::Measurement;
pub use settings::Study;
pub use trials::{Base, StudyKind};
