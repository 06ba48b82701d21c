//! Stiff bars: which time step reaches which error in which time, and how the implicit step behaves in extreme cases.

mod contest;
mod extremes;

use rayon::prelude::*;

use crate::report::sheet::Section;
use crate::table::Table;
use crate::verify::subject::DIRECTIONS;
use contest::{Contest, Entry};
use cosmic::case::Case;
use cosmic::design::{Design, Material};
use cosmic::lattice::Lattice;
use cosmic::laws::ContactLaw;
use cosmic::scene::PartsSettings;
pub use extremes::{Extreme, extremes};

/// The stiffness of the skeleton in each contest, N/m, and its name in names of files.
const STIFFNESS: [(f64, &str); 5] = [
    (4e2, "4e2"),
    (1e4, "1e4"),
    (1e5, "1e5"),
    (1e6, "1e6"),
    (1e7, "1e7"),
];

/// The surroundings of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum World {
    Air,
    Ground,
}

impl World {
    fn name(self) -> &'static str {
        match self {
            Self::Air => "air",
            Self::Ground => "ground",
        }
    }

    /// The case in this world, with a skeleton of another stiffness and without undecided bars: in a mixture of skeleton
    /// and actuator, the stiffness of the one would pull with the stroke of the other.
    fn of(self, case: &Case, stiffness: f64) -> Case {
        let mut case = case.clone();
        if case.design.layout().is_none() {
            case.design = Design::Layout(materials(&case.lattice));
        }
        let materials = &mut case.materials;
        materials.parts = PartsSettings::default();
        let [_, skeleton, _] = &mut materials.stiffness;
        *skeleton = stiffness;
        let physics = &mut case.physics;
        // The damping of a damper is proportional to the stiffness. With stiff bars, no explicit step could follow it.
        physics.forces = physics.forces.without("damper");
        if self == Self::Air {
            physics.contact = ContactLaw::none();
        }
        case
    }
}

/// A design for a lattice: horizontal and vertical bars are skeleton, and all others are actuators.
fn materials(lattice: &Lattice) -> Vec<Material> {
    let material = |&[i, j]: &[usize; 2]| {
        let along = lattice.positions[j] - lattice.positions[i];
        match along.forward() * along.up() {
            0.0 => Material::Skeleton,
            _ => Material::Actuator,
        }
    };
    lattice.edges.iter().map(material).collect()
}

/// Measures explicit and implicit steps of a case with skeletons of any stiffness, in the air and on the ground, and tries
/// the implicit step on extreme robots.
pub fn stiff(case: &Case) -> Section {
    let worlds = [World::Air, World::Ground];
    let kinds = worlds
        .into_iter()
        .flat_map(|world| STIFFNESS.map(|stiffness| (world, stiffness)));
    let cases: Vec<_> = kinds
        .map(|(world, (stiffness, name))| (world, name, world.of(case, stiffness)))
        .collect();
    let mut contests: Vec<Contest> = (cases.par_iter())
        .map(|(world, name, case)| Contest::new(world.name(), name, case))
        .collect();
    // Times are measured while nothing else runs.
    contests.iter_mut().for_each(Contest::run);
    let extremes = extremes();
    let mut section = Section {
        title: "Stiff bars".to_owned(),
        notes: notes(case, &contests),
        tables: vec![table(&contests), extremes::table(&extremes)],
        figures: contests.iter().map(Contest::figure).collect(),
        ..Section::default()
    };
    for contest in &contests {
        let about = format!("skeleton of {} N/m, {}", contest.stiffness, contest.world);
        section.check(
            contest.is_known(),
            format!("{about}: the reference diverged"),
        );
        let failure = format!("{about}: a run by a stable step diverged");
        section.check(contest.is_finite(), failure);
    }
    for extreme in &extremes {
        section.check(
            extreme.is_bounded(),
            format!("{}: the speed grows", extreme.name()),
        );
        section.check(
            extreme.keeps_momentum(),
            format!("{}: momentum is lost", extreme.name()),
        );
    }
    section
}

fn notes(case: &Case, contests: &[Contest]) -> Vec<String> {
    let mut notes = vec![
        format!(
            "The robot moves for {} s, in the air and on the ground, with skeletons of several stiffnesses. `position` \
             is the largest distance of a node from the reference, in spacings of the lattice. `energy` is the relative \
             error of the kinetic and elastic energy with idle actuators. `gradient` is the relative error of the slopes \
             of the payload's displacement along {DIRECTIONS} random directions. The reference is explicit leapfrog with \
             steps {} times shorter than the longest stable one. Cells of errors below three times the uncertainty of \
             the reference are empty.",
            contest::time(case),
            contest::FINER,
        ),
        "Explicit steps begin with the longest stable step among the scene's step halved several times. `x` and a number \
         are the mechanical steps in each step of the controller. All numbers are f64. Dampers are left out, since their \
         damping grows with the stiffness. So actuators vibrate freely, and most of the error of implicit steps comes \
         from vibrations that they damp."
            .to_owned(),
        extremes::NOTE.to_owned(),
    ];
    if case.design.layout().is_none() {
        notes.push(
            "The design is undecided. Here, horizontal and vertical bars are skeleton, and all others are actuators.".to_owned(),
        );
    }
    notes.extend(contests.iter().filter_map(Contest::doubt));
    notes
}

/// All runs of all contests.
fn table(contests: &[Contest]) -> Table {
    let rows: Vec<(&Contest, &Entry)> = contests
        .iter()
        .flat_map(|contest| contest.entries.iter().map(move |entry| (contest, entry)))
        .collect();
    Table::of(
        "stiff",
        "Errors of explicit and implicit steps with stiff bars",
        &rows,
    )
    .column("world", "where the robot moves", |(of, _)| of.world)
    .column("stiffness", "stiffness of the skeleton, N/m", |(of, _)| {
        of.stiffness
    })
    .column("method", "how a step is integrated", |(_, entry)| {
        entry.method.name()
    })
    .column("dt_s", "time step of the controller, s", |(of, entry)| {
        of.dt(entry)
    })
    .column("time_s", "processor time of a run, s", |(_, entry)| {
        entry.time
    })
    .column(
        "gradient_s",
        "processor time of a gradient, s",
        |(_, entry)| entry.gradient_time,
    )
    .column("position", "error of positions, spacings", |(_, entry)| {
        entry.position
    })
    .column("energy", "relative error of the energy", |(_, entry)| {
        entry.energy
    })
    .column(
        "gradient",
        "relative error of the gradient",
        |(_, entry)| entry.gradient,
    )
    .done()
}
