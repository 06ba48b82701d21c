//! Differentiates a function of nested structs of parameters. The gradient has the same structs, and a gradient check
//! reports the parameters by name.
use autodiff::check::{Claim, Options, Verdict, check_directions};
use autodiff::{Parameters, Real, parameters};

#[derive(Debug, Parameters)]
struct Lens<R> {
    power: R,
    gap: R,
}
#[derive(Debug, Parameters)]
struct Telescope<R> {
    lenses: [Lens<R>; 3],
    tilt: R,
}

fn height_at_exit<R: Real>(telescope: &Telescope<R>) -> R {
    let (mut height, mut slope) = (R::one(), telescope.tilt);
    for lens in &telescope.lenses {
        slope -= height * lens.power;
        height += slope * lens.gap;
    }
    height
}

fn main() {
    let lenses = [0.1, 0.2, 0.3].map(|power| Lens { power, gap: 3.0 });
    let at = Telescope { lenses, tilt: 0.1 };
    let mut gradient = parameters::gradient(height_at_exit, &at);
    println!("{gradient:?}");
    gradient.lenses[1].gap *= 1.01; // a mistake
    let (x, claimed) = (at.flatten(), gradient.flatten());
    let (claim, options) = (Claim::new(&x, &claimed), Options::named(at.names()));
    let report = check_directions(|x| height_at_exit(&at.with(x)), &claim, &options);
    assert_eq!(report.verdict, Verdict::Wrong, "{report}");
    assert_eq!(report.worst.unwrap().name.unwrap(), "lenses[1].gap");
}
