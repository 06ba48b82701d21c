//! Laws in a separate crate, as a user would write them. They agree with built-in laws and with formulas of mechanics,
//! and their gradients are right.

use autodiff::check::Verdict;
use autodiff::{Function, Parameters, Real, Var, gradient};
use cosmic::Registry;
use cosmic::case::Case;
use cosmic::design::{Design, Material};
use cosmic::geometry::{Ground, Vector};
use cosmic::inputs::ALL;
use cosmic::kernel;
use cosmic::lattice::{Lattice, State};
use cosmic::laws::{
    Bar, BarForce, Contact, Impact, Law, Node, NodeForce, contact, on_bars, on_nodes,
};
use cosmic::scene::{Integrator, PhysicsSettings, Scene, stable_step};
use cosmic::settings::within;
use cosmic::walk::IdleEnergy;
use cosmic::world::Span;
use cosmic::world::stability::Vibration;
use cosmic_lab::check::check_gradients;
use cosmic_tests::{Bare, farthest, few_directions, laws, relative_error, robot_of, states};

cosmic::settings! {
    /// A contact law: a node that hits the ground stops.
    struct Glue {}
}

impl Law for Glue {
    const NAME: &'static str = "glue";
}

#[kernel]
impl Contact for Glue {
    fn respond<R: Real, const D: usize>(_: &Self, _: Impact<R, D>) -> Vector<R, D> {
        Vector::zero()
    }
}

cosmic::settings! {
    /// A contact law: a node bounces back with a fraction of its speed. `restitution` is the fraction.
    struct Bounce<R> {
        /// The fraction of the speed that remains.
        restitution: R = 0.5, allowed within(0.0, 1.0), source "a test";
    }
}

impl Law for Bounce {
    const NAME: &'static str = "bounce";
}

#[kernel]
impl Contact for Bounce {
    fn respond<R: Real, const D: usize>(bounce: &Bounce<R>, impact: Impact<R, D>) -> Vector<R, D> {
        let velocity = impact.velocity;
        velocity.with_up(-bounce.restitution * velocity.up())
    }
}

cosmic::settings! {
    /// A contact law that reads a number of the scene's physics.
    struct Rubber<R> {} of physics {
        /// The coefficient of friction.
        friction: R = "physics.friction";
    }
}

impl Law for Rubber {
    const NAME: &'static str = "rubber";
}

#[kernel]
impl Contact for Rubber {
    fn respond<R: Real, const D: usize>(rubber: &Rubber<R>, impact: Impact<R, D>) -> Vector<R, D> {
        let velocity = impact.velocity;
        velocity
            .along()
            .shortened(rubber.friction * velocity.up().abs())
    }
}

cosmic::settings! {
    /// A force on nodes that reads a number of the scene's physics: it cancels a share of gravity.
    struct Lift<R> {
        /// The share.
        share: R = 1.0, allowed within(0.0, 1.0), source "a test";
    } of physics {
        /// The acceleration of free fall, m/s^2.
        gravity: R = "physics.gravity";
    }
}

impl Law for Lift {
    const NAME: &'static str = "lift";
}

#[kernel]
impl NodeForce for Lift {
    fn force<R: Real, const D: usize>(lift: &Lift<R>, node: Node<R, D>) -> Vector<R, D> {
        node.vertical * (lift.share * lift.gravity * node.mass)
    }
}

cosmic::settings! {
    /// A law of bars: Hooke's law a second time.
    struct Again {}
}

impl Law for Again {
    const NAME: &'static str = "again";
}

#[kernel]
impl BarForce for Again {
    fn tension<R: Real>(_: &Self, bar: Bar<R>) -> R {
        bar.stiffness * (bar.length - bar.target)
    }
}

cosmic::settings! {
    /// A force on nodes: a spring and a damper between every node and the ground's origin, and a pull that varies as a
    /// sine of the time.
    struct Tether<R> {
        /// Stiffness.
        stiffness: R = 2.0, allowed within(0.0, 1e6), unit "N/m", source "a test";
        /// Damping.
        damping: R = 0.0, allowed within(0.0, 1e6), unit "N s/m", source "a test";
        /// The largest pull along x; the force on a node is this times the node's index.
        pull: R = 0.0, allowed within(0.0, 1e6), unit "N", source "a test";
        /// The acceleration of gravity.
        gravity: R = 0.0, allowed within(0.0, 100.0), unit "m/s2", source "a test";
    }
}

impl Law for Tether {
    const NAME: &'static str = "tether";
}

#[kernel]
impl NodeForce for Tether {
    const NEEDS_TIME: bool = true;

    fn weight(&self, node: usize, _: &Lattice) -> f64 {
        node as f64
    }

    fn force<R: Real, const D: usize>(tether: &Tether<R>, node: Node<R, D>) -> Vector<R, D> {
        let (k, c) = (tether.stiffness, tether.damping);
        let pull = tether.pull * node.weight * (R::lit(30.0) * node.time).sin();
        let fall = node.vertical * (tether.gravity * node.mass);
        Vector::upright(pull, R::zero()) - node.x * k - node.v * c - fall
    }

    fn energy<const D: usize>(&self, node: Node<f64, D>) -> Option<f64> {
        let height = node.x.dot(node.vertical);
        Some(0.5 * self.stiffness * node.x.dot(node.x) + self.gravity * node.mass * height)
    }
}

/// A registry with the laws of this file and of the example programs.
fn registry() -> Registry {
    laws::registry()
        .with_law(contact::<Glue>())
        .with_law(contact::<Bounce>())
        .with_law(contact::<Rubber>())
        .with_law(on_nodes::<Lift>())
        .with_law(on_bars::<Again>())
        .with_law(on_nodes::<Tether>())
}

/// The paper's scene, changed by settings.
fn scene(settings: &str) -> Scene {
    let scene = registry().load("stability").unwrap().with("own", settings);
    scene.unwrap_or_else(|error| panic!("{error}"))
}

fn physics(settings: &str) -> PhysicsSettings {
    scene(settings).physics
}

/// A falling robot. Its scene may name the laws of this file.
pub(super) fn robot(settings: &str) -> Case {
    robot_of(scene(settings))
}

fn last(case: &Case) -> State<f64> {
    states(case).pop().expect("a rollout has states")
}

#[test]
fn a_user_s_contact_law_gives_the_bits_of_the_same_built_in_law() {
    for incline in ["", "incline_deg = 15.0"] {
        let own = robot(&format!("[physics]\n{incline}\ncontact = \"glue\""));
        let built_in = robot(&format!("[physics]\n{incline}"));
        assert_eq!(last(&own), last(&built_in));
    }
}

/// A law that reads the friction of the scene is a law with friction, in rollouts, gradients and descriptions.
#[test]
fn a_law_reads_numbers_of_the_physics() {
    let sliding = |contact: &str| {
        robot(&format!(
            "physics = {{contact = '{contact}', friction = 0.3}}"
        ))
    };
    let [own, built_in] = ["rubber", "coulomb"].map(sliding);
    let off = farthest(&last(&own), &last(&built_in));
    // Coulomb's law adds the rest of a drift in another order, in each of 90 steps.
    assert!(off < 1e-11, "{off:e}");
    assert!(farthest(&last(&own), &last(&robot(""))) > 1e-3);
    let by_name = |case: &Case, name: &str| {
        let (world, robot) = (case.world(), case.robot());
        let end = |x: &[Var<f64>]| {
            let surroundings = world.surroundings().with(name, x[0]);
            let robot = robot.map(Var::constant).in_surroundings(surroundings);
            let walk = world
                .run(&[robot], &Span::of_steps(case.scene.physics.steps))
                .remove(0);
            walk.payload(0).x.forward()
        };
        gradient(end, &[robot.surroundings.value(name)])[0]
    };
    let [a, b] = [&own, &built_in].map(|case| by_name(case, "physics.friction"));
    // The same sums as above.
    assert!((a - b).abs() < 1e-9 * b.abs() && b != 0.0, "{a} {b}");
    let says = |case: &Case| case.scene.describe_world();
    assert!(says(&own).contains("feet slip at friction 0.3 (contact rubber)"));
    let glue = robot("physics.contact = 'glue'");
    assert!(says(&glue).contains("contact glue") && !says(&glue).contains("slip"));
    let names = glue.world().surroundings::<f64>();
    assert!(names.iter().all(|(name, _)| name != "physics.friction"));
}

/// A force and the scene read the same number: with a lift of all of the gravity nothing falls, whatever the gravity is.
#[test]
fn a_number_that_two_laws_read_is_one_number() {
    let case = robot("physics = {contact = 'none', forces = ['lift']}");
    let (world, robot) = (case.world(), case.robot());
    let height = |gravity: f64| {
        let surroundings = world.surroundings().with("physics.gravity", gravity);
        let robot = robot.clone().in_surroundings(surroundings);
        let walk = world.run(&[robot], &Span::of_steps(90)).remove(0);
        walk.payload(0).x.up()
    };
    // The weights of nodes differ by nothing, and rounding of their impulses is far below this in 90 steps.
    assert!(
        (height(1.0) - height(30.0)).abs() < 1e-9,
        "{} {}",
        height(1.0),
        height(30.0)
    );
}

#[test]
fn the_tensions_of_all_laws_add_up() {
    let twice = robot("[physics]\nforces = [\"again\"]");
    let mut stiffer = robot("[materials]\nstiffness = [2e-7, 8e2, 6e1]");
    stiffer.design = twice.design.clone();
    // Sums have another order in each of 90 steps, and positions near 1 m have 15 decimals.
    let off = farthest(&last(&twice), &last(&stiffer));
    assert!(off < 1e-11, "{off:e}");
    // Without the second law, the robot ends at a different place.
    assert!(farthest(&last(&twice), &last(&robot(""))) > 1e-3);
}

/// A user's law for gravity along the vertical has the same effect as the scene's gravity, also on inclines.
#[test]
fn a_force_on_nodes_knows_the_vertical() {
    for incline in [
        "",
        "incline_deg = 15.0",
        "incline_deg = -15.0\nintegrator = \"leapfrog\"",
    ] {
        let physics = format!("[physics]\n{incline}\n");
        let own = format!(
            "{physics}gravity = 0.0\nforces = [\"tether\"]\n[tether]\nstiffness = 0.0\ngravity = 4.8"
        );
        let off = farthest(&last(&robot(&own)), &last(&robot(&physics)));
        // The impulses of a force are divided by the mass, and those of gravity are not. This causes a few rounding
        // errors in each step.
        assert!(off < 1e-11, "{incline}: {off:e}");
    }
}

/// A law gets the data of the right node, and the time at the beginning of the step. The test makes two steps with
/// nodes that start at rest, under a pull that oscillates at 30 rad/s.
#[test]
fn a_force_knows_the_time_and_the_node() {
    let physics = physics(
        "[physics]\ngravity = 0.0\ndamping = 0.0\ncontact = \"none\"\nforces = [\"tether\"]\n\
         [tether]\nstiffness = 0.0\npull = 3.0",
    );
    let (dt, bare) = (physics.dt, Bare::free_node(physics));
    let start = State::new(vec![[0.0; 2]; 2], vec![[0.0; 2]; 2]);
    let end = bare.run_to_end(&start, 2);
    let expected = 3.0 * (30.0 * dt).sin() * dt / 0.01;
    // Only the second step changes the velocity: the first step is at time 0, where the sine is 0. Node 0 does not
    // move, because its weight is 0. The tolerance is for rounded products.
    assert!(
        (end.v[1].forward() - expected).abs() < 1e-15 && end.v[0] == [0.0; 2],
        "{end:?}"
    );
}

/// A node that is dropped from one metre and bounces with half of its speed rises to a quarter of a metre.
#[test]
fn a_bouncing_node_rises_again() {
    let settings = "[physics]\ngravity = 9.81\ndamping = 0.0\n\
                    contact = \"bounce\"\ndt = 1e-5";
    let bare = Bare::free_node(physics(settings));
    let start = State::new(vec![[0.0, 1.0]; 2], vec![[0.0; 2]; 2]);
    // The node falls for 0.4515 s and rises for half as long.
    let apex = (1.5 * (2.0 / 9.81_f64).sqrt() / 1e-5) as usize;
    let height = bare.run_to_end(&start, apex).x[0].up();
    // The tolerance is for the length of a step of 1e-5 s at a speed of 4.4 m/s.
    assert!((height - 0.25).abs() < 1e-4, "{height}");
}

/// A formula gives the rollouts and the gradients of the same law in code: with explicit and implicit steps, in double and
/// in single precision. It has the same stiffness and damping, which determine the stable time step.
#[test]
fn a_formula_acts_like_the_same_law_in_code() {
    let wind = "0.01 * (-z * (0.5 + 0.5 * sin(6.283185307179586 * (time / 2 - x / 3))) - vx)";
    for [force, code, own, formula] in [
        [
            "stiffening",
            "stiffening.cubic = 150",
            "bar_formula",
            "{tension = 'a * stiffness * (length - target)^3', a = 150}",
        ],
        [
            "damper",
            "damper.time = 1e-3",
            "bar_formula",
            "{tension = 'stiffness * 1e-3 * rate'}",
        ],
        [
            "rope",
            "rope = {actuator = 0.7, skeleton = 0.2}",
            "bar_formula",
            "{tension = '(0.5 * actuator + 0.2) * stiffness * max(target - length, 0)'}",
        ],
        // So slow that bars move faster from the start on, and many of them more than twice as fast.
        [
            "actuator",
            "actuator = {force = 0.01, speed = 0.008}",
            "bar_formula",
            "{tension = 'actuator * (max(a * (rate / b - 1), min(a * (1 + rate / b), max(-a, min(a, stiffness * \
             (length - target))))) - stiffness * (length - target))', a = 0.01, b = 0.008}",
        ],
        [
            "wind",
            "wind.speed = -1",
            "node_formula",
            &format!("{{force_x = '{wind}', force_z = '-0.01 * vz'}}"),
        ],
    ] {
        for integrator in ["symplectic_euler", "implicit"] {
            let physics = |force: &str, settings: &str| {
                cosmic_tests::robot(&format!(
                    "physics = {{integrator = '{integrator}', forces = ['{force}']}}\n{settings}"
                ))
            };
            let cases = [
                physics(force, code),
                physics(own, &format!("{own} = {formula}")),
            ];
            let name = format!("{force}, {integrator}");
            // Formulas multiply in another order, in each of 90 steps.
            let off = farthest(&last(&cases[0]), &last(&cases[1]));
            assert!(off < 1e-11, "{name}: {off:e}");
            let bare = cosmic_tests::robot(&format!("physics.integrator = '{integrator}'"));
            assert!(farthest(&last(&cases[0]), &last(&bare)) > 1e-5, "{name}");
            let [code, own] = [0, 1].map(|k| gradient_in(&cases[k], |x| x));
            let off = relative_error(&own, &code);
            assert!(off < 1e-9, "{name}: {off:e}");
            // Rounding of 90 steps at 6e-8.
            let off = relative_error(&gradient_in(&cases[1], |x| x as f32), &code);
            assert!(off > 0.0 && off < 1e-2, "{name}: {off:e}");
            let [code, own] = cases.map(|case| {
                let (body, physics) = (case.body(), &case.scene.physics);
                let vibration = Vibration::new(&case.lattice, &body, physics, &case.start.x);
                [vibration.fastest().0, vibration.damping()]
            });
            let off = relative_error(&own, &code);
            assert!(off < 1e-9, "{name}: {own:?} {code:?}");
        }
    }
}

/// The gradient of the displacement of a robot with respect to all its inputs, computed in the number type of `as_number`.
fn gradient_in<R: Real + Into<f64>>(case: &Case, as_number: fn(f64) -> R) -> Vec<f64> {
    let (world, inputs) = (case.world(), case.inputs().map(as_number));
    let (_, gradient) = inputs.differentiate(ALL, |inputs| case.displacement_loss(&world, inputs));
    gradient.into_iter().map(R::into).collect()
}

#[test]
fn gradients_of_own_laws_are_right_in_every_mode() {
    for settings in [
        "physics.contact = 'glue'",
        "physics = {contact = 'bounce', incline_deg = 10}",
        "physics = {forces = ['again'], contact = 'coulomb'}",
        "physics = {forces = ['tether', 'damper'], substeps = 2}\n\
         tether = {stiffness = 0.3, damping = 0.01, pull = 0.01}",
        "physics = {forces = ['damper', 'tether'], integrator = 'leapfrog'}\n\
         damper.time = 1e-3",
        // These stops are so close that most actuators reach them.
        "physics = {forces = ['stops'], contact = 'none'}\nstops = {at = 0.003, stiffness = 3}",
        // Bars move faster than these actuators, which brake them.
        "physics = {forces = ['actuator'], contact = 'none'}\nactuator = {force = 0.01, speed = 0.008}",
        "physics = {forces = ['actuator'], contact = 'none', integrator = 'implicit'}\n\
         actuator = {force = 0.01, speed = 0.008}",
    ] {
        let check = check_gradients(&robot(settings), None, 90, &few_directions());
        assert!(check.failures().is_empty(), "{settings}:\n{check}");
        let smooth = |group: &&cosmic_lab::check::Group| group.verdict == Verdict::Smooth;
        let smooth = check.groups.iter().filter(smooth).count();
        assert!(
            smooth >= 5 && check.control.is_some(),
            "{settings}:\n{check}"
        );
    }
}

/// The stable time step takes forces on nodes and damping forces into account. A free node with a spring and a damper
/// to the origin stays bounded with a step below the limit, and flies away with a step above it.
#[test]
fn the_stable_step_includes_forces_on_nodes_and_damping() {
    for (integrator, damping, own) in [
        (Integrator::SymplecticEuler, 0.0, 0.0),
        (Integrator::SymplecticEuler, 20.0, 0.3),
        (Integrator::Leapfrog, 0.0, 0.3),
        (Integrator::Leapfrog, 20.0, 0.0),
        (Integrator::Leapfrog, 5.0, 2.0),
    ] {
        let settings = format!(
            "[physics]\ngravity = 0.0\ndamping = {damping:?}\ncontact = \"none\"\n\
             forces = [\"tether\"]\n[tether]\nstiffness = 40.0\ndamping = {own:?}"
        );
        let mut bare = Bare::free_node(physics(&settings));
        bare.physics.integrator = integrator;
        let place = vec![Vector::from([0.3, 0.2]); 2];
        let vibration = Vibration::new(&bare.lattice, &bare.body, &bare.physics, &place);
        let (frequency, eta) = (vibration.fastest().0, vibration.damping());
        // The expected numbers are sqrt(40 / 0.01) and own / 0.01. The tolerance is for the rounding errors of an
        // iteration.
        assert!(
            (frequency / (4000f64).sqrt() - 1.0).abs() < 1e-9,
            "{frequency}"
        );
        assert!((eta - own / 0.01).abs() < 1e-9 * (1.0 + eta), "{eta}");
        assert!(vibration.edge_bound().0 >= frequency * (1.0 - 1e-12));
        let limit = stable_step(&bare.physics, frequency, eta);
        let start = State::new(place, vec![[0.0; 2]; 2]);
        let size = |share: f64| {
            let mut bare = bare.clone();
            bare.physics.dt = share * limit;
            bare.run_to_end(&start, 4000).x[0].forward().abs()
        };
        let [below, above] = [0.99, 1.01].map(size);
        assert!(below < 30.0, "{integrator:?}, {damping}, {own}: {below}");
        // With a step far above the limit, positions become infinite or NaN.
        assert!(
            above.is_nan() || above > 30.0,
            "{integrator:?}, {damping}, {own}: {above}"
        );
    }
}

#[test]
fn the_energy_includes_forces_that_have_one() {
    let with = |forces: &[&str]| physics(&format!("physics.forces = {forces:?}"));
    let case = robot("");
    let body = case.body();
    let energy = |physics: &PhysicsSettings, state: &State<f64>| {
        IdleEnergy::new(&case.lattice, physics, &body).energy(state)
    };
    let plain = energy(&with(&[]), &case.start).expect("springs have one");
    let tethered = energy(&with(&["tether"]), &case.start).expect("the tether has one");
    let ground = Ground::from(&case.scene.physics);
    let of_tether = case.start.to_ground(&ground).x;
    let of_tether: f64 = of_tether.iter().map(|x| x.dot(*x)).sum();
    // The tolerance is for sums of a dozen terms.
    assert!(
        (tethered - plain - of_tether).abs() < 1e-12,
        "{tethered} {plain}"
    );
    assert_eq!(energy(&with(&["damper"]), &case.start), None);
}

#[test]
fn a_law_is_chosen_by_name_and_has_its_settings_in_a_section() {
    let own = scene("[bounce]\nrestitution = 0.25\n[physics]\ncontact = \"bounce\"");
    assert_eq!(own.physics.contact.name(), "bounce");
    let text = own.to_toml();
    assert!(
        text.contains("\n[bounce]\n") && text.contains("\nrestitution = 0.25\n"),
        "{text}"
    );
    assert_eq!(registry().parse("own", &text).unwrap(), own);
    let set = own.set(&["bounce.restitution=0.75"]).unwrap();
    assert_ne!(set, own);
    // If the law is named again, it keeps its settings.
    assert_eq!(set.set(&["physics.contact=bounce"]).unwrap(), set);
    // A case has the settings of the law too.
    let case = Case::of_scene(&set, 0).unwrap();
    let again = Case::parse_with(&registry(), "case", &case.to_json()).unwrap();
    assert_eq!(again.scene.physics.contact, case.scene.physics.contact);
    let says = Case::parse("case", &case.to_json())
        .unwrap_err()
        .to_string();
    assert!(
        says.contains("`scene.physics.contact` names an unknown law: \"bounce\""),
        "{says}"
    );
}

#[test]
fn wrong_choices_are_refused_with_what_is_known() {
    let refused = |text: &str| registry().parse("own.toml", text).unwrap_err().to_string();
    for (text, words) in [
        ("physics.contact = 'clay'", "\"bounce\""),
        ("physics.forces = ['gale']", "\"tether\""),
        ("tether.stiffness = 1.0", "does not choose the law `tether`"),
        ("tether.stiffness = 1.0", "physics.forces = [\"tether\"]"),
        ("bounce.restitution = 1.0", "physics.contact = \"bounce\""),
        (
            "physics.contact = 'bounce'\nbounce.restitution = 2.0",
            "`bounce.restitution` is out of range: 2.0",
        ),
        (
            "physics.contact = 'bounce'\nbounce.restitutoin = 0.5",
            "unknown key `restitutoin`",
        ),
        (
            "physics.contact = 'bounce'\nbounce.restitutoin = 0.5",
            "did you mean `restitution`?",
        ),
    ] {
        let said = refused(text);
        assert!(said.contains(words), "{text}\n{said}\nlacks {words}");
    }
}

cosmic::settings! {
    /// A law that may not be registered, because its name is the name of a section of physicss.
    struct Section {}
}

impl Law for Section {
    const NAME: &'static str = "ground";
}

#[kernel]
impl Contact for Section {
    fn respond<R: Real, const D: usize>(_: &Self, _: Impact<R, D>) -> Vector<R, D> {
        Vector::zero()
    }
}

#[test]
#[should_panic(expected = "a law cannot be named \"ground\"")]
fn a_law_cannot_have_the_name_of_a_section() {
    let _ = registry().with_law(contact::<Section>());
}

#[test]
#[should_panic(expected = "a law named \"glue\" exists already")]
fn a_name_is_taken_once() {
    let _ = registry().with_law(contact::<Glue>());
}

/// Stops that are far stiffer than the bars determine the stable time step, even while no actuator touches a stop.
#[test]
fn the_stable_step_includes_stops() {
    let bound = |stops: &str| {
        let mut case = robot(&format!(
            "[physics]\nforces = [\"stops\"]\n[stops]\n{stops}"
        ));
        case.design = Design::Layout(vec![Material::Actuator; case.lattice.edges.len()]);
        let body = case.body();
        Vibration::new(&case.lattice, &body, &case.scene.physics, &case.start.x)
            .fastest()
            .0
    };
    let [none, soft, hard] =
        ["stiffness = 0.0", "stiffness = 40.0", "stiffness = 40000.0"].map(bound);
    assert!(none < soft && soft < 0.2 * hard, "{none} {soft} {hard}");
}

/// The force of an actuator falls with its speed, which dampens like a damper of `force / speed`, if it works at its limit.
#[test]
fn the_stable_step_includes_the_speed_of_actuators() {
    let damping = |speed: &str| {
        let mut case = robot(&format!(
            "physics.forces = ['actuator']\nactuator = {{force = 0.5, speed = {speed}}}"
        ));
        case.design = Design::Layout(vec![Material::Actuator; case.lattice.edges.len()]);
        let body = case.body();
        Vibration::new(&case.lattice, &body, &case.scene.physics, &case.start.x).damping()
    };
    let [slow, fast] = ["0.2", "2.0"].map(damping);
    assert!(
        fast > 0.0 && (slow / fast - 10.0).abs() < 1e-6,
        "{slow} {fast}"
    );
}

/// The energy `c (1 - cos a)` of two bars with the angle `a` between them and the angular stiffness `c` = 0.02 N m, as a
/// function of the coordinates of their three nodes.
struct BendingEnergy;

impl Function for BendingEnergy {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let [ax, ay] = [x[2] - x[0], x[3] - x[1]];
        let [bx, by] = [x[4] - x[2], x[5] - x[3]];
        let lengths = (ax * ax + ay * ay).sqrt() * (bx * bx + by * by).sqrt();
        R::lit(0.02) * (R::one() - (ax * bx + ay * by) / lengths)
    }
}

/// Bars in line resist bending with the slope of their energy. Their stiffnesses of 100 and 400 N/m and the radius of
/// gyration give the angular stiffness `2 r^2 k_1 k_2 / (k_1 + k_2)`.
#[test]
fn bars_resist_bending_as_their_energy_says() {
    let x = [[0.0, 0.0], [0.1, 0.01], [0.19, 0.05]].map(Vector::<f64>::from);
    let springs = [([0, 1], 100.0), ([1, 2], 400.0)];
    let relaxed = springs.map(|([i, j], k)| ([i, j], x[i].distance(x[j]), k));
    let mut bare = Bare::new(&relaxed, &[1.0; 3]);
    bare.lattice.positions = [0.0, 0.1, 0.2].map(|x| Vector::from([x, 0.0])).to_vec();
    let radius = (0.02_f64 / 160.0).sqrt();
    let bending = format!("physics.forces = ['bending']\nbending.radius = {radius:?}");
    bare.physics.forces = laws::forces(&bending);
    let start = State::new(x, [Vector::zero(); 3]);
    let end = bare.run_to_end(&start, 1);
    let slope = gradient(|x| BendingEnergy.eval(x), &start.to_flat()[0]);
    for (node, v) in end.v.iter().enumerate() {
        let v = v.in_plane();
        for k in 0..2 {
            // The softening lengthens bars by a fraction of 1e-10, and the forces are below 1 N.
            let expected = -bare.physics.dt * slope[2 * node + k];
            assert!((v[k] - expected).abs() < 1e-10, "{end:?} {slope:?}");
        }
    }
}

/// A compressed bar of 30 N/m buckles under `pi^2 E I / l^2`, and below that it is a spring.
#[test]
fn a_buckled_bar_pushes_with_its_euler_load() {
    let load = std::f64::consts::PI.powi(2) * 1e-3 / 0.01;
    for (length, push) in [(0.05, load), (0.08, 0.6), (0.12, -0.6)] {
        let mut bare = Bare::new(&[([0, 1], 0.1, 30.0)], &[1.0; 2]);
        bare.physics.forces = laws::forces("physics.forces = ['buckle']\nbuckle.bending = 1e-3");
        let start = State::new(vec![[0.0, 0.0], [length, 0.0]], vec![[0.0; 2]; 2]);
        let speed = bare.run_to_end(&start, 1).v[1].forward();
        // As above.
        assert!((speed - bare.physics.dt * push).abs() < 1e-10, "{speed}");
    }
}
