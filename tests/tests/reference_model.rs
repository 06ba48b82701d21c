//! What of a reference case needs no simulation: the folded controller's first output, the loss of
//! the states listed, and which are. The rest of its figures are compared where it is simulated.

use cosmic::case::Case;
use cosmic::generator::edges;
use cosmic::ground::Ground;
use cosmic::lattice::State;
use cosmic::objective::{Displacement, Loss};
use cosmic::policy::{Layer, Network, clock};
use cosmic::scene::{LossKind, LossSettings};
use cosmic::simulator::Trajectory;
use cosmic_tests::{Reference, numbers, own_reference_folder, reference_folder, references};
use serde_json::Value;

fn cases() -> impl Iterator<Item = (Reference, Case)> {
    let references = references(&reference_folder()).into_iter();
    references.map(|reference| {
        let case = reference.case();
        (reference, case)
    })
}

/// Compares a field with the results of the file, within one of the tolerances of the file.
fn check(reference: &Reference, field: &str, tolerance: &str, got: &[f64]) {
    let expected = numbers(&reference.json["results"][field]);
    reference.check(field, tolerance, [got, &expected]);
}

/// A rollout feeds the raw state of the ground's frame into the folded first layer.
#[test]
fn the_first_activation_of_the_folded_controller() {
    for (reference, case) in cases() {
        let ground = Ground::from(&case.physics);
        let network = Network::of(&case.controller).expect("a network");
        let folded = network.folded(&case.observation, case.lattice.nodes(), &[], &ground);
        let state = case.start.to_ground(&ground);
        let column = |points: &[[f64; 2]], k: usize| points.iter().map(|p| p[k]).collect();
        let columns: [Vec<f64>; 5] = [
            column(&state.x, 0),
            column(&state.x, 1),
            column(&state.v, 0),
            column(&state.v, 1),
            clock(&case.observation, 0.0).to_vec(),
        ];
        let hidden = layer(&folded.first, &columns.concat());
        let first = layer(&folded.second, &hidden);
        check(&reference, "u0", "algebraic", &first);
    }
}

fn layer(Layer { weights, biases }: &Layer<f64>, input: &[f64]) -> Vec<f64> {
    let rows = weights.chunks_exact(input.len());
    let row = |(row, bias): (&[f64], &f64)| {
        (row.iter().zip(input).map(|(w, x)| w * x).sum::<f64>() + bias).tanh()
    };
    rows.zip(biases).map(row).collect()
}

/// The listed states, as if a rollout had left them.
fn listed(json: &Value) -> Trajectory<f64> {
    let states = json["results"]["trajectory"]
        .as_object()
        .expect("a case lists states");
    let mut states: Vec<(usize, &Value)> = states
        .iter()
        .map(|(step, state)| (step.parse().expect("states go by step"), state))
        .collect();
    states.sort_by_key(|&(step, _)| step);
    let points = |value: &Value| numbers(value).as_chunks().0.to_vec();
    Trajectory {
        steps: states.iter().map(|&(step, _)| step).collect(),
        states: states
            .iter()
            .map(|(_, state)| State {
                x: points(&state["x"]),
                v: points(&state["v"]),
            })
            .collect(),
    }
}

#[test]
fn the_loss_of_the_listed_states() {
    for (reference, case) in cases() {
        let displacement = Displacement {
            ground: Ground::from(&case.physics),
            settings: LossSettings {
                kind: LossKind::Final,
                ..LossSettings::default()
            },
        };
        let loss = displacement.loss(&listed(&reference.json));
        check(&reference, "l_disp", "forward", &[loss]);
    }
}

#[test]
fn the_steps_that_a_case_lists_are_recorded() {
    for (reference, case) in cases() {
        let steps = listed(&reference.json).steps;
        assert_eq!(
            case.recorded_steps(&[]).ok(),
            Some(steps),
            "{}",
            reference.name()
        );
        assert_eq!(case.recorded_steps(&[2, 0, 2]).ok(), Some(vec![0, 2]));
        assert!(case.recorded_steps(&[case.physics.steps + 1]).is_err());
    }
}

/// The project's own cases are all on regular lattices, so that their edges, which the reader
/// takes from the file, show the order of those that the program lays out itself.
#[test]
fn edges_are_laid_out_in_the_order_of_the_files() {
    for reference in references(&own_reference_folder()) {
        let case = reference.case();
        let expected = edges(case.layout.columns, case.layout.rows);
        assert_eq!(case.lattice.edges, expected, "{}", reference.name());
    }
}
