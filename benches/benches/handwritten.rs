//! Generic code against code written by hand for one robot: rollouts and gradients in turns.
//!
//! - `cargo bench -p benches --bench handwritten`
//! - the same with `-- --table` writes `docs/handwritten.md`.

use autodiff::Real;
use benches::handwritten::{Buffer, Handwritten};
use benches::machine::{built_in, machine, row, seconds, write_page};
use cosmic::inputs::{CONTROLLER, DESIGN};
use cosmic_lab::verify::{MEASURED_STEPS, Subject, TwoMatvecs};

/// Times that each measurement is taken, in turns; the least counts.
const ROUNDS: usize = 60;
/// A mixture of all materials on every edge, and a layout.
const SCENES: [(&str, &str); 2] = [("mixture", "stability"), ("one-hot", "baseline_tall")];

/// The least times of generic code and of code by hand, s: rollout, value and design gradient,
/// value and controller gradient.
struct LeastTimes([[f64; 3]; 2]);

fn main() {
    let page = page();
    println!("{page}");
    write_page("handwritten.md", || page);
}

fn page() -> String {
    let mut table = String::from(
        "| | rollout | value and design gradient | value and controller gradient |\n\
         | --- | --- | --- | --- |\n",
    );
    let mut matvecs = f64::INFINITY;
    for (name, scene) in SCENES {
        let (scene, mut case) = built_in(scene);
        // By hand every node counts alike.
        case.rules.one_piece = false;
        let subject = Subject::new(&case, &scene.loss);
        let two = TwoMatvecs::new(&case);
        let by_hand = Handwritten::new(&case, &scene.loss, MEASURED_STEPS);
        let mut yardstick = || matvecs = seconds(|| two.run(MEASURED_STEPS)).min(matvecs);
        let double = times::<f64>((&subject, &by_hand), &mut yardstick);
        let single = times::<f32>((&subject, &by_hand), &mut yardstick);
        for (kind, times) in [("f64", double), ("f32", single)] {
            rows(&mut table, &format!("{name}, {kind}"), &times);
        }
    }
    format!(
        "# Against code written by hand\n\n\
         Measured on {}; times are the least of {ROUNDS} rounds taken in turns, on one thread. This \
         page is written by\n\n```sh\ncargo bench -p benches --bench handwritten -- --table\n```\n\n\
         The robot's rollout over {MEASURED_STEPS} steps and its gradients, once by the generic source of \
         `cosmic` on `autodiff`, in which nothing is differentiated by hand, and once by \
         `benches/src/handwritten`: the same robot with all sizes constants and its adjoint worked \
         out by hand, on the same SIMD lanes and tanh. Their answers agree (a test). Microseconds a \
         step; the controller's two matrices times vectors alone, in f64, take {:.3}.\n\n{table}\n\
         By hand as here is no bound: whoever spends longer on it may get it faster, and on other \
         processors other choices pay.\n",
        machine(),
        per_step(matvecs),
    )
}

/// Three rows of the table: both times and their ratio.
fn rows(table: &mut String, name: &str, LeastTimes([generic, by_hand]): &LeastTimes) {
    let ratio = std::array::from_fn(|k| generic[k] / by_hand[k]);
    for (what, figures, digits) in [
        ("generic", generic.map(per_step), 3),
        ("by hand", by_hand.map(per_step), 3),
        ("generic over by hand", ratio, 2),
    ] {
        row(table, &format!("{name}: {what}"), &figures, digits);
    }
}

fn times<R: Real>(
    (subject, by_hand): (&Subject, &Handwritten),
    yardstick: &mut dyn FnMut(),
) -> LeastTimes {
    let mut least = [[f64::INFINITY; 3]; 2];
    let mut rows = Buffer::default();
    for _ in 0..ROUNDS {
        yardstick();
        let round = [
            [
                seconds(|| subject.rollout::<R>()),
                seconds(|| subject.gradient::<R>(DESIGN)),
                seconds(|| subject.gradient::<R>(CONTROLLER)),
            ],
            [
                seconds(|| by_hand.rollout::<R>(&mut rows)),
                seconds(|| by_hand.design_gradient(&mut rows)),
                seconds(|| by_hand.controller_gradient(&mut rows)),
            ],
        ];
        for (least, time) in least
            .as_flattened_mut()
            .iter_mut()
            .zip(round.as_flattened())
        {
            *least = time.min(*least);
        }
    }
    LeastTimes(least)
}

/// Microseconds a step, of the seconds of a rollout.
fn per_step(time: f64) -> f64 {
    time * 1e6 / MEASURED_STEPS as f64
}
