use cosmic::random::{Purpose, stream, symmetric};

#[test]
fn streams_repeat_and_differ() {
    let draw = |seed, purpose| {
        let mut stream = stream(seed, purpose);
        [(); 4].map(|()| symmetric(&mut stream, 1.0))
    };
    assert_eq!(draw(7, Purpose::Weights), draw(7, Purpose::Weights));
    assert_ne!(draw(7, Purpose::Weights), draw(8, Purpose::Weights));
    assert_ne!(draw(7, Purpose::Selection), draw(7, Purpose::Judgement));
}

#[test]
fn draws_fill_their_range() {
    let mut stream = stream(0, Purpose::Weights);
    let draws: Vec<f64> = (0..4000).map(|_| symmetric(&mut stream, 0.5)).collect();
    assert!(draws.iter().all(|x| x.abs() <= 0.5));
    // The standard deviation of the mean of 4000 draws is 0.5 / sqrt(3 * 4000) = 0.0046.
    assert!(draws.iter().sum::<f64>().abs() / 4000.0 < 0.02);
    assert!(draws.iter().any(|&x| x > 0.49) && draws.iter().any(|&x| x < -0.49));
}
