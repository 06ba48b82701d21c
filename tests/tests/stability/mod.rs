//! The files of stability cases: each kind of case has one check, and one walk runs them all.

mod lattices;
mod nodes;
mod springs;

use cosmic::design::{Design, Material};
use cosmic::lattice::{Body, Lattice};
use cosmic::laws::ContactLaw;
use cosmic::scene::{MaterialSettings, PhysicsSettings};
use cosmic_tests::{
    Reference, assert_near, number, numbers, own_reference_folder, reference_subfolder, references,
    relative_error,
};
use serde_json::{Value, from_value};
use std::path::Path;

/// A kind of case: the list of a file that holds it, a key that no other kind has, and what must hold.
struct Kind {
    list: &'static str,
    key: &'static str,
    check: fn(&StabilityCase),
}

const fn kind(list: &'static str, key: &'static str, check: fn(&StabilityCase)) -> Kind {
    Kind { list, key, check }
}

static KINDS: [Kind; 14] = [
    kind("cases", "terminal_velocity_discrete", nodes::flies),
    kind("cases", "first_touches_step_tau", nodes::lands),
    kind("cases", "slid_down", nodes::slides),
    kind("braking", "stops_at_step", nodes::brakes),
    kind("cases", "exact_dx_dH_infinite", nodes::bounces),
    kind("cases", "dtanh", springs::saturates),
    kind("cases", "jacobian_dp_dz", springs::projects),
    kind("cases", "tangent_dF_dd", springs::pulls),
    kind("cases", "eigenvalues", springs::oscillates),
    kind("linear", "invariant", springs::keeps_its_invariant),
    kind("cases", "rest", springs::vibrates),
    kind("cases", "omega_bound_edge", lattices::has_stable_steps),
    kind("cases", "window_means_over_E0", lattices::keeps_its_energy),
    kind("cases", "x_100000", lattices::comes_to_rest),
];

/// A case, and the file that it is from.
#[derive(Clone, Debug)]
struct StabilityCase {
    file: Value,
    case: Value,
}

/// All cases of a file, with the lists that hold them.
fn cases(file: &Reference) -> Vec<(&'static str, StabilityCase)> {
    let name = file.name();
    assert!(file.json["cases"].is_array(), "{name}: no `cases`");
    let mut found = Vec::new();
    for list in ["cases", "linear", "braking"] {
        for case in file.json[list].as_array().into_iter().flatten() {
            let (file, case) = (file.json.clone(), case.clone());
            found.push((list, StabilityCase { file, case }));
        }
    }
    found
}

/// The cases of the reference folder, and the project's own of a kind that is missing there.
#[test]
fn every_case_of_every_kind_holds() {
    let all = |folder: &Path| {
        references(folder)
            .iter()
            .flat_map(cases)
            .collect::<Vec<_>>()
    };
    let given = all(&reference_subfolder("stability"));
    let own = all(&own_reference_folder().join("stability"));
    let is_of = |kind: &Kind, (list, case): &(&str, StabilityCase)| {
        kind.list == *list && case.case.get(kind.key).is_some()
    };
    for case in &given {
        let known = KINDS.iter().any(|kind| is_of(kind, case));
        assert!(known, "no kind has this case: {case:?}");
    }
    std::thread::scope(|scope| {
        for kind in &KINDS {
            let of_kind = |cases: &[(&str, StabilityCase)]| -> Vec<StabilityCase> {
                let found = cases.iter().filter(|case| is_of(kind, case));
                found.map(|(_, case)| case.clone()).collect()
            };
            let mut found = of_kind(&given);
            if found.is_empty() {
                found = of_kind(&own);
            }
            assert!(!found.is_empty(), "no case has `{}`", kind.key);
            scope.spawn(move || found.iter().for_each(kind.check));
        }
    });
}

impl StabilityCase {
    /// A number of the case.
    fn number(&self, key: &str) -> f64 {
        number(&self.case, key)
    }

    /// Numbers of the case, nested lists from first to last.
    fn numbers(&self, key: &str) -> Vec<f64> {
        numbers(&self.case[key])
    }

    /// A vector of the case.
    fn vector(&self, key: &str) -> [f64; 2] {
        self.numbers(key).try_into().expect("two numbers")
    }

    /// A list of points of the case.
    fn points(&self, key: &str) -> Vec<[f64; 2]> {
        self.numbers(key).as_chunks().0.to_vec()
    }

    /// A number of the file, such as a tolerance.
    fn of_file(&self, key: &str) -> f64 {
        number(&self.file, key)
    }

    /// Asserts that a number is within a bound of the case's number of this key.
    #[track_caller]
    fn near(&self, key: &str, got: f64, bound: f64) {
        let of = format!("{key} of {}", self.case);
        assert_near(got, self.number(key), bound, &of);
    }

    /// Asserts that a number is the case's number of this key, within the file's absolute tolerance.
    #[track_caller]
    fn absolute(&self, key: &str, got: f64) {
        self.near(key, got, self.of_file("tolerance_abs"));
    }

    /// Asserts the same within the file's relative tolerance.
    #[track_caller]
    fn relative(&self, key: &str, got: f64) {
        let bound = self.of_file("tolerance_rel") * self.number(key).abs();
        self.near(key, got, bound);
    }

    /// The case's lattice of regular places, with these edges.
    fn lattice(&self, edges: Vec<[usize; 2]>) -> Lattice {
        let [columns, rows] = ["columns", "rows"].map(|key| self.number(key) as usize);
        let spacing = self.number("spacing");
        let place = |node: usize| [node % columns, node / columns].map(|n| n as f64 * spacing);
        Lattice::between((0..columns * rows).map(place).collect(), edges)
    }

    /// The case's edges: pairs of nodes.
    fn edges(&self) -> Vec<[usize; 2]> {
        from_value(self.case["edges"].clone()).expect("pairs")
    }

    /// The stiffnesses and masses of a lattice whose edges have the case's materials.
    fn body(&self, lattice: &Lattice) -> Body<f64> {
        let materials: Vec<Material> =
            from_value(self.case["state"].clone()).expect("a material for each edge");
        let usual = MaterialSettings::default();
        let body = Body::new(&Design::Layout(materials), lattice, &usual, &self.world());
        // A dozen roundings of sums.
        assert!(relative_error(&body.mass, &self.numbers("node_mass")) < 1e-14);
        body
    }

    /// The world of the case. Without a height of the ground there is no ground, and by default the world
    /// is flat, frictionless, undamped and without gravity.
    fn world(&self) -> PhysicsSettings {
        let case = &self.case;
        let or = |key: &str, otherwise: f64| case[key].as_f64().unwrap_or(otherwise);
        let usual = PhysicsSettings::default();
        PhysicsSettings {
            dt: or("dt", usual.dt),
            gravity: or("gravity", 0.0),
            damping: or("gamma", 0.0),
            node_mass: or("m_eps", usual.node_mass),
            payload_mass: or("payload_mass", usual.payload_mass),
            ground_height: or("ground_height", 0.0),
            incline_deg: or("alpha_deg", 0.0),
            contact: match (case["ground_height"].as_f64(), case["contact"].as_str()) {
                (None, _) => ContactLaw::none(),
                (_, Some("coulomb")) => ContactLaw::coulomb(),
                (_, Some("infinite") | None) => ContactLaw::infinite(),
                (_, Some(other)) => panic!("no contact is called {other:?}: {case}"),
            },
            friction: or("mu", 0.0),
            ..usual
        }
    }
}
