use cosmic::codesign::{Merit, Quantiles, Reliability};

const FAR: Merit = Merit::Distance { scale: 1.0 };

fn spread(p10: f64, p50: f64) -> Quantiles {
    let p90 = p50 + 1.0;
    Quantiles { p10, p50, p90 }
}

/// The reason why a robot with these quantiles is unreliable; empty if it is reliable.
fn reason(merit: Merit, [p10, p50, unperturbed]: [f64; 3]) -> String {
    let found = merit.reliability(&spread(p10, p50), unperturbed);
    found.reason().unwrap_or_default().to_owned()
}

#[test]
fn an_unreliable_robot_has_a_reason() {
    let far = |numbers| reason(FAR, numbers);
    assert_eq!(far([1.6, 3.0, 4.4]), "");
    assert_eq!(
        far([-1.537, 3.093, 3.0]),
        "the 10 % quantile of varied robots is -1.537 m, more than 1.546 m below their median of 3.093 m"
    );
    assert!(far([3.0, 3.093, -4.2]).starts_with("the unperturbed rollout reaches -4.200 m, "));
    assert!(far([3.0, 3.0, 4.6]).contains("1.500 m away"));
    let diverged = [f64::NEG_INFINITY, 3.0, 3.0];
    assert_eq!(far(diverged), "rollouts diverge");
    assert_eq!(far([3.0, 3.0, f64::NAN]), "rollouts diverge");
}

/// A robot that walks backwards is as reliable as one that walks forwards.
#[test]
fn negative_medians_are_compared_by_their_absolute_value() {
    let far = |numbers| reason(FAR, numbers);
    assert_eq!(far([-2.9, -2.0, -1.1]), "");
    assert!(far([-3.1, -2.0, -2.0]).contains("-3.100 m"));
    // For a robot that barely moves, the numbers may differ by at most 5 mm.
    assert_eq!(far([-0.004, 0.0, 0.004]), "");
    assert!(far([-0.006, 0.0, 0.0]).contains("0.005 m below"));
    // With losses, the merit is minus the loss.
    let loss = |numbers| reason(Merit::MinusLoss, numbers);
    assert_eq!(loss([-0.5, -0.4, -0.3]), "");
    let worse = loss([-0.9, -0.4, -0.4]);
    for words in ["loss of varied robots is 0.9000", "median of 0.4000"] {
        assert!(worse.contains(words), "{worse}");
    }
    assert_eq!(loss([0.0, 0.0, 0.0]), "");
}

#[test]
fn the_score_of_an_unreliable_robot_is_its_lower_quantile() {
    let score = |numbers: [f64; 3]| FAR.score(&spread(numbers[0], numbers[1]), numbers[2]);
    let reliable = score([1.9, 2.0, 2.0]);
    assert_eq!(reliable, 2.0);
    // Two unreliable robots: the first because of its quantile, the second because of its unperturbed rollout.
    assert_eq!(score([1.4, 3.0, 3.0]), 1.4);
    assert_eq!(score([1.6, 3.0, -4.0]), 1.6);
    // An unreliable robot may still have the higher score.
    assert!(score([2.4, 5.0, 5.0]) > reliable);
}

#[test]
fn files_have_the_verdict_and_the_reason() {
    let json = |found: &Reliability| serde_json::to_string(found).unwrap();
    assert_eq!(json(&Reliability::Reliable), r#"{"verdict":"reliable"}"#);
    let found = FAR.reliability(&spread(0.0, 3.0), 3.0);
    let text = json(&found);
    assert!(
        text.starts_with(r#"{"verdict":"unreliable","reason":"the 10 %"#),
        "{text}"
    );
    assert_eq!(serde_json::from_str::<Reliability>(&text).unwrap(), found);
}
