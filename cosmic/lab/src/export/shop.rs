//! What a workshop needs besides the table of bars: a list of parts, and set points for the actuators.

use super::member::DECIMALS;
use crate::report::RunFiles;
use crate::report::gait::Gait;
use crate::table::Table;
use cosmic::shop::{self, SetPoints};

/// Returns the table of parts: see [`shop::pieces`].
pub(super) fn parts(run: &RunFiles) -> Table {
    let robot = &run.robot;
    let pieces = shop::pieces(&robot.scene, &robot.lattice, &robot.design.materials);
    let names = |places: &[usize]| {
        let mut names: Vec<String> = places.iter().map(usize::to_string).collect();
        names.dedup();
        names.join(" ")
    };
    let length_says = "from joint to joint, m: a tube is sawn shorter by what its two joints add";
    let places_says = "the numbers of their edges; of nodes and payload, of the nodes";
    Table::of("", "", &pieces)
        .column("part", "what it is", |piece| piece.name)
        .column("number", "how many", |piece| piece.places.len())
        .column("length", length_says, |piece| piece.length)
        .column("mass", "mass of one, kg", |piece| piece.mass)
        .column("places", places_says, |piece| names(&piece.places))
        .rounded(DECIMALS)
        .done()
}

/// Returns the table of set points: see [`shop::set_points`].
pub(super) fn set_points(run: &RunFiles, gait: &Gait) -> Option<Table> {
    let SetPoints { every, lengths } = shop::set_points(&gait.case, &run.robot.design.materials)?;
    let rows: Vec<usize> = (0..lengths.first()?.1.len()).collect();
    let mut table = Table::of("", "", &rows).column("time", "s", |row| *row as f64 * every);
    for (edge, lengths) in &lengths {
        table = table.column(&format!("length_{edge}"), "m", |row| lengths[*row]);
    }
    Some(table.rounded(DECIMALS).done())
}
