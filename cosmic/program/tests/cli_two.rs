//! Two programs in one process. Each adds its own law, and both laws have the same name.

use crate::common::{Bench, scene};
use autodiff::Real;
use cosmic::Registry;
use cosmic::geometry::Vector;
use cosmic::kernel;
use cosmic::laws::{Choice, Contact, Impact, Law, contact};
use cosmic::record::{RunPlan, optimise};
use cosmic_program::Program;
use std::process::ExitCode;
use std::thread;

cosmic::settings! {
    /// A node stops, as on the built-in ground of infinite friction.
    struct Glue {}
}

cosmic::settings! {
    /// A node slides without friction.
    struct Ice {}
}

impl Law for Glue {
    const NAME: &'static str = "floor";
}

impl Law for Ice {
    const NAME: &'static str = "floor";
}

#[kernel]
impl Contact for Glue {
    fn respond<R: Real, const D: usize>(_: &Self, _: Impact<R, D>) -> Vector<R, D> {
        Vector::zero()
    }
}

#[kernel]
impl Contact for Ice {
    fn respond<R: Real, const D: usize>(_: &Self, impact: Impact<R, D>) -> Vector<R, D> {
        impact.velocity.along()
    }
}

/// Both programs work at the same time on the same scene. Their walks differ, because each program uses its own law.
/// Each program can read its own run.
#[test]
fn two_programs_in_one_process_have_their_own_laws() {
    let bench = Bench::with(&scene(4, 64, "contact = \"floor\""));
    let work = |law: fn() -> Choice, name: &str| {
        let registry = Registry::default().with_law(law());
        let scene = registry.read(&bench.path("tiny.toml")).unwrap();
        optimise(&bench.path(name), &RunPlan::new(name, scene, 0), &mut ()).unwrap();
        let [run, out] = [name, &format!("{name}.json")].map(|name| bench.path(name));
        let [run, out] = [run, out].map(|path| path.display().to_string());
        let program = Program::new().with(law());
        let code = program.run_with(["cosmic", "evaluate", &run, "--out", &out]);
        assert_eq!(format!("{code:?}"), format!("{:?}", ExitCode::SUCCESS));
        bench.json(&format!("{name}.json"))["results"]["trajectory"].clone()
    };
    let [glue, ice] = thread::scope(|scope| {
        let works = [
            scope.spawn(|| work(contact::<Glue>, "glue")),
            scope.spawn(|| work(contact::<Ice>, "ice")),
        ];
        works.map(|work| work.join().unwrap())
    });
    assert_ne!(glue, ice);
    // The law `Glue` has the same effect as the built-in ground `infinite`.
    let scene = bench.read("glue/scene.toml");
    bench.write(
        "glue/scene.toml",
        scene.replace("\"floor\"", "\"infinite\""),
    );
    bench.remove("glue/snapshot.json");
    assert_eq!(
        bench.cosmic("evaluate glue").json()["results"]["trajectory"],
        glue
    );
    let says = "names an unknown law: \"floor\"";
    bench.cosmic("evaluate ice").fails(2, &[says]);
}
