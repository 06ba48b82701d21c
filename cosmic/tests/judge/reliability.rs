use cosmic::judge::{Medians, Merit, OtherSteps, Quantiles, Reliability, Standstill};
use cosmic::scene::Integrator;
use std::f64::consts::TAU;

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

/// The reasons not to trust a robot with these medians: its own, with half the time step, and with leapfrog.
fn unsteady(merit: Merit, [own, half, leapfrog]: [f64; 3]) -> Vec<String> {
    let medians = |merit: f64| Medians {
        displacement: merit,
        merit,
    };
    let other = OtherSteps {
        half: medians(half),
        integrator: Some((Integrator::Leapfrog, medians(leapfrog))),
    };
    merit.unsteady(own, &other, Integrator::SymplecticEuler)
}

#[test]
fn a_median_that_changes_by_a_fifth_with_other_steps_is_a_reason() {
    assert_eq!(
        unsteady(FAR, [4.66, 2.34, 2.2]),
        [
            "it walks 2.34 m at half the time step, but 4.66 m at the scene's time step",
            "it walks 2.20 m with leapfrog, but 4.66 m with the scene's symplectic Euler"
        ]
    );
    // Both directions count, and a fifth is allowed.
    let [inside, outside] = [0.199, 0.201];
    for sign in [-1.0, 1.0] {
        assert!(unsteady(FAR, [2.0, 2.0 * (1.0 + sign * inside), 2.0]).is_empty());
        assert_eq!(
            unsteady(FAR, [2.0, 2.0, 2.0 * (1.0 + sign * outside)]).len(),
            1
        );
    }
    // A robot that stays in place does not depend on the time step: 5 cm is the shortest distance that counts.
    assert!(unsteady(FAR, [0.001, -0.008, 0.009]).is_empty());
    let diverged = unsteady(FAR, [2.0, f64::NEG_INFINITY, 2.0]);
    assert_eq!(diverged, ["it diverges at half the time step"]);
    let loss = unsteady(Merit::MinusLoss, [-0.3, -0.43, -0.3]);
    assert_eq!(
        loss,
        ["its loss is 0.4300 at half the time step, but 0.3000 at the scene's time step"]
    );
}

/// A robot that moves by less than a twentieth of its length is unreliable for this reason first. The limit is 25 mm here.
#[test]
fn a_robot_that_stays_in_place_is_unreliable() {
    let of = |reliability: Reliability, displacement: f64| reliability.of_walk(displacement, 0.025);
    for moves in [0.025, -0.025, 3.0, f64::NEG_INFINITY] {
        assert_eq!(of(Reliability::Reliable, moves), Reliability::Reliable);
    }
    let stays = of(Reliability::Reliable, 0.0249);
    assert_eq!(
        stays.reason(),
        Some("it stays in place: it moves by 0.0249 m, and 0.025 m are a twentieth of its length")
    );
    assert_eq!(
        (stays.stays_in_place(), stays.word()),
        (true, "stays in place")
    );
    let low = FAR.reliability(&spread(-0.006, 0.0), 0.0);
    assert_eq!((low.stays_in_place(), low.word()), (false, "unreliable"));
    let both = of(low.clone(), 0.0);
    let reasons = ["it stays in place: ", "; ", low.reason().unwrap()];
    let says = both.reason().unwrap();
    assert!(
        says.starts_with(reasons[0]) && says.ends_with(&reasons[1..].concat()),
        "{says}"
    );
    // Files keep the verdict in one word, and say that the robot stays.
    let text = |reliability: &Reliability| serde_json::to_value(reliability).unwrap();
    let json = text(&both);
    assert_eq!(
        (&json["verdict"], &json["stays_in_place"]),
        (&"unreliable".into(), &true.into())
    );
    assert!(text(&low).get("stays_in_place").is_none());
    for reliability in [both, low] {
        assert_eq!(
            serde_json::from_value::<Reliability>(text(&reliability)).unwrap(),
            reliability
        );
    }
}

/// A robot that stays at its place for the last quarter stands still. The sway of its gait, 3 cm here, does not count.
#[test]
fn a_standstill_has_a_place_and_a_time() {
    let times: Vec<f64> = (0..=512).map(|k| 0.032 * f64::from(k)).collect();
    let walk = |stops: f64| -> Vec<f64> {
        let place = |time: &f64| 0.25 * time.min(stops) + 0.03 * (10.0 * time).sin();
        times.iter().map(place).collect()
    };
    let found = |stops: f64| Standstill::of(&times, &walk(stops), TAU / 10.0, 1.0);
    assert_eq!(found(99.0), None);
    assert_eq!(found(13.0), None);
    let still = found(8.0).unwrap();
    // A place within 5 % of the way is the last place, and a mean over samples leaves some of the sway.
    assert!((still.at - 2.0).abs() < 0.01, "{still:?}");
    assert!(
        still.since < 8.1 && still.since > 8.0 * 0.95 - 0.2,
        "{still:?}"
    );
    // It never moves: it stays in place, and does not stop.
    assert_eq!(found(0.0), None);
}
