//! Gradients of whole rollouts with respect to every block of their inputs. Reverse mode agrees with forward mode and
//! finite differences, for every contact law, integrator, force, ground and projection.

use autodiff::check::{Verdict, check_gradient};
use autodiff::{Function, Real};
use cosmic::case::Case;
use cosmic::geometry::Ground;
use cosmic::inputs::DESIGN;
use cosmic::objective::{Displacement, loss_of};
use cosmic::projection::Projection;
use cosmic::scene::{LossKind, LossSettings};
use cosmic::world::{Span, World};
use cosmic_tests::{assert_smooth, few_directions, least_height, robot, states};

/// The worlds to test, each as settings in TOML.
const WORLDS: [&str; 27] = [
    "",
    "physics = {contact = 'coulomb', friction = 0.4}",
    "physics.incline_deg = 15",
    "physics = {contact = 'coulomb', incline_deg = 15, friction = 0.4}",
    "physics = {contact = 'coulomb', integrator = 'leapfrog', friction = 0.3}",
    "physics = {integrator = 'leapfrog', substeps = 2}",
    "physics = {contact = 'coulomb', substeps = 3, friction = 0.3}",
    "physics.forces = ['bending']\nbending.radius = 0.02",
    "physics.forces = ['stiffening']",
    "physics.forces = ['stiffening', 'bending']\nbending.radius = 0.02",
    "physics.friction = 0.4\nlattice.drop = 0.008\nground = {profile = 'points', points = [[0.08, 0.0], \
     [0.15, 0.01], [0.18, 0.003], [0.22, 0.01], [0.31, -0.01], [0.34, 0.008]]}",
    "physics = {contact = 'coulomb', friction = 0.4}\nlattice.drop = 0.008\nground = {profile = \
     'points', points = [[0.08, 0.0], [0.15, 0.01], [0.18, 0.003], [0.22, 0.01], [0.31, -0.01]]}",
    "physics.integrator = 'implicit'",
    "physics = {integrator = 'implicit', contact = 'coulomb', friction = 0.4, incline_deg = 15}",
    "physics = {integrator = 'implicit', contact = 'coulomb', friction = 0.3, substeps = 2, \
     forces = ['damper', 'stops', 'stiffening']}\nstops.at = 0.05",
    "physics = {integrator = 'implicit', contact = 'coulomb', friction = 0.4, dt = 0.003}\nmaterials.stiffness = \
     [1e-7, 1e5, 30.0]\nlattice.drop = 0.008\nground = {profile = 'points', points = [[0.08, 0.0], [0.15, 0.01], \
     [0.18, 0.003], [0.22, 0.01], [0.31, -0.01]]}",
    "physics = {contact = 'coulomb', friction = 0.4, forces = ['actuator', 'buckle']}\n\
     actuator = {force = 0.1, speed = 4.0}\nbuckle.bending = 2e-4",
    "physics = {integrator = 'implicit', contact = 'coulomb', friction = 0.4, forces = ['actuator', 'rope']}\n\
     actuator = {force = 0.1, speed = 4.0}\nrope = {actuator = 0.0, skeleton = 0.5}",
    "physics = {contact = 'coulomb', friction = 0.4, substeps = 2}\nparts = {skeleton = 'strut', material = 'pla', \
     outer = 0.003, joint = 1e3, end_mass = 0.001, actuator = 'device', actuator_mass = 0.01, stroke = 0.1}",
    "physics = {integrator = 'implicit', contact = 'coulomb', friction = 0.4}\nparts = {skeleton = 'tube', material = \
     'aluminium', joint = 2e5, actuator = 'device', actuator_mass = 0.02, stroke = 0.1}",
    "physics = {contact = 'coulomb', friction = 0.4, forces = ['damper', 'bumpers']}\nbumpers.distance = 0.9",
    "physics = {integrator = 'implicit', contact = 'coulomb', friction = 0.4, forces = ['bumpers']}\n\
     bumpers = {distance = 0.9, reach = 1}",
    "physics = {integrator = 'implicit', contact = 'coulomb', friction = 0.4, forces = ['bending']}\nbending.radius = 0.02",
    "physics = {contact = 'coulomb', friction = 0.4}\nlattice.drop = 0.008\nground = {profile = 'points', points = \
     [[0.07, -0.01], [0.07, 0.0], [0.22, 0.0], [0.22, -0.01], [0.32, -0.01], [0.32, 0.03]]}",
    "physics = {integrator = 'implicit', contact = 'coulomb', friction = 0.4}\nlattice.drop = 0.008\nground = {profile = \
     'points', points = [[0.07, -0.01], [0.07, 0.0], [0.22, 0.0], [0.22, -0.01], [0.32, -0.01], [0.32, 0.03]]}",
    "physics = {forces = ['bar_formula', 'node_formula'], substeps = 2}\nbar_formula.tension = '9 * stiffness * \
     max(length - rest_length, 0) + 0.01 * actuator * rate'\nnode_formula = {force_x = '-0.02 * vx * abs(vx)', force_z = \
     '0.002 * sin(9 * x + 40 * time) - mass * tanh(z)'}",
    "physics = {integrator = 'implicit', contact = 'coulomb', friction = 0.4, forces = ['bar_formula', 'node_formula']}\n\
     bar_formula.tension = 'stiffness * where(rate < 0, 0.002, 0.001) * rate * (length / target)^2'\n\
     node_formula.force_z = '1e-3 / (0.2 + z)^2'",
];

#[test]
fn every_block_in_every_world_and_projection() {
    let mut touched = 0;
    for (k, world) in WORLDS.iter().enumerate() {
        for projection in [Projection::Performance, Projection::Stability] {
            // Near shares of almost zero, the slope of bending changes completely if a share changes by a millionth.
            // Differences cannot resolve that.
            if projection == Projection::Stability && k >= 4 {
                continue;
            }
            let mut case = robot(world);
            // The robot lands in the first third of this time.
            case.scene.physics.steps = 60;
            case.projection = projection;
            // Some implicit steps solve their equations three times.
            case.scene.physics.passes = 2 + k % 2;
            let lowest = least_height(&case.scene.physics, &states(&case));
            // In the frame of an incline, the height of a node on the ground is zero except for rounding.
            touched += usize::from(lowest.abs() < 1e-12);
            assert_smooth(&format!("{world}, {projection:?}"), &case);
        }
    }
    // Most robots reach the ground.
    assert!(touched > 10, "{touched}");
}

/// The optimiser's loss as a function of the design vectors: a mean over the last part of the rollout.
struct OfDesign<'a> {
    case: &'a Case,
    world: World,
}

impl Function for OfDesign<'_> {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let mut inputs = self.case.inputs().lift();
        inputs.set(DESIGN, x);
        let design = self.case.projected(self.case.projection, &inputs.z);
        let loss = Displacement {
            ground: Ground::from(&self.case.scene.physics),
            settings: LossSettings {
                kind: LossKind::Mean,
                window: 64,
                every: 8,
            },
        };
        let span = Span::of_steps(self.case.scene.physics.steps);
        loss_of(
            &self.world,
            &inputs.robot(&self.world, &design),
            &loss,
            &span,
        )
    }
}

#[test]
fn the_mean_loss_of_a_rollout() {
    let case = robot("");
    let (world, z) = (case.world(), case.design.vectors());
    let function = OfDesign { case: &case, world };
    let report = check_gradient(&function, z.as_flattened(), &few_directions());
    assert_eq!(report.verdict, Verdict::Smooth, "{report}");
    assert_eq!(report.control, Some(Verdict::Wrong), "{report}");
}
