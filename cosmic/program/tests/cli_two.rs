//! Two programs in one process. Each adds its own law, and both laws have the same name.

use crate::common::{Bench, scene};
use autodiff::Real;
use cosmic::Registry;
use cosmic::geometry::Vector;
use cosmic::kernel;
use cosmic::laws::{Choice, Law, Node, NodeForce, on_nodes};
use cosmic::record::{RunPlan, optimise};
use cosmic_program::Program;
use std::thread;

cosmic::settings! {
    /// Air that does not move.
    struct Calm {}
}

cosmic::settings! {
    /// Air that pushes every node.
    struct Gale {}
}

impl Law for Calm {
    const NAME: &'static str = "air";
}

impl Law for Gale {
    const NAME: &'static str = "air";
}

// A force on nodes compiles in a tenth of the time of a contact.
#[kernel]
impl NodeForce for Calm {
    fn force<R: Real, const D: usize>(_: &Self, _: Node<R, D>) -> Vector<R, D> {
        Vector::zero()
    }
}

#[kernel]
impl NodeForce for Gale {
    fn force<R: Real, const D: usize>(_: &Self, _: Node<R, D>) -> Vector<R, D> {
        Vector::upright(R::lit(-1e-3), R::zero())
    }
}

/// Both programs work at the same time on the same scene. Their walks differ, because each program uses its own law.
/// Each program can read its own run.
#[test]
fn two_programs_in_one_process_have_their_own_laws() {
    let bench = Bench::with(&scene(4, 64, "forces = [\"air\"]"));
    let work = |law: fn() -> Choice, name: &str| {
        let registry = Registry::default().with_law(law());
        let scene = registry.read(&bench.path("tiny.toml")).unwrap();
        optimise(&bench.path(name), &RunPlan::new(name, scene, 0), &mut ()).unwrap();
        let [run, out] = [name, &format!("{name}.json")].map(|name| bench.path(name));
        let [run, out] = [run, out].map(|path| path.display().to_string());
        let program = Program::new().with_law(law());
        let code = program.run_with(["cosmic", "evaluate", &run, "--out", &out]);
        assert_eq!(code, 0);
        bench.json(&format!("{name}.json"))["results"]["trajectory"].clone()
    };
    let [calm, gale] = thread::scope(|scope| {
        let works = [
            scope.spawn(|| work(on_nodes::<Calm>, "calm")),
            scope.spawn(|| work(on_nodes::<Gale>, "gale")),
        ];
        works.map(|work| work.join().unwrap())
    });
    assert_ne!(calm, gale);
    let says = "names an unknown law: \"air\"";
    bench.cosmic("evaluate calm").fails(2, &[says]);
}
