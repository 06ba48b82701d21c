use cosmic_optimiser::mma::Bracket;

/// A function that is constant at 1e-6 up to a kink at 7 and then falls steeply. Because of the elastic cost, the
/// slope along a line search can be such a function.
fn kinked(at: f64) -> f64 {
    1e-6 - 1e3 * (at - 7.0).max(0.0)
}

fn trials(mut kinks: Vec<f64>) -> usize {
    let mut bracket = Bracket::starting_with(kinked(0.0));
    let mut at = 1.0;
    for trials in 1..=100 {
        let value = kinked(at);
        if value.abs() < 1e-7 {
            return trials;
        }
        bracket.narrow(at, value);
        at = bracket.next_trial(&mut kinks);
    }
    panic!("no zero found: stopped at {at}");
}

#[test]
fn a_known_kink_shortens_the_search() {
    let (blind, told) = (trials(vec![]), trials(vec![3.0, 7.0, 50.0]));
    // The trials are 1, 4, 16, the kink at 7, and the zero of the chord beyond the kink, which is exact up to
    // rounding.
    assert!(
        told <= 6 && blind > 2 * told,
        "{told} trials, {blind} without kinks"
    );
}
