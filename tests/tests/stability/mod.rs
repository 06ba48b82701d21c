//! Checks all cases in the files of the folder `stability`. Each kind of case has its own check, and one test runs all
//! cases.

mod lattices;
mod nodes;
mod springs;

use cosmic::case::Frame;
use cosmic::design::{Design, Material};
use cosmic::geometry::{Dimension, Vector};
use cosmic::lattice::{Body, Lattice};
use cosmic::laws::ContactLaw;
use cosmic::scene::{MaterialSettings, PhysicsSettings};
use cosmic_tests::{
    Reference, assert_near, number, numbers, own_reference_folder, reference_subfolder, references,
    relative_error,
};
use serde_json::{Value, from_value};

type Check = fn(&StabilityCase);

/// The kinds of cases. Each kind has a key that only its cases have, and a check.
static KINDS: [(&str, Check); 14] = [
    ("terminal_velocity_discrete", nodes::flies),
    ("first_touches_step_tau", nodes::lands),
    ("slid_down", nodes::slides),
    ("stops_at_step", nodes::brakes),
    ("exact_dx_dH_infinite", nodes::bounces),
    ("dtanh", springs::saturates),
    ("jacobian_dp_dz", springs::projects),
    ("tangent_dF_dd", springs::pulls),
    ("eigenvalues", springs::oscillates),
    ("invariant", springs::keeps_its_invariant),
    ("rest", springs::vibrates),
    ("omega_bound_edge", lattices::has_stable_steps),
    ("window_means_over_E0", lattices::keeps_its_energy),
    ("x_100000", lattices::comes_to_rest),
];

/// A case, with the file that contains it.
#[derive(Clone, Debug)]
struct StabilityCase {
    file: Value,
    case: Value,
}

/// All cases of a file.
fn cases(file: &Reference) -> Vec<StabilityCase> {
    let lists = ["cases", "linear", "braking"].into_iter();
    let cases = lists.filter_map(|list| file.json[list].as_array());
    let of_file = |case: &Value| StabilityCase {
        file: file.json.clone(),
        case: case.clone(),
    };
    let found: Vec<_> = cases.flatten().map(of_file).collect();
    assert!(!found.is_empty(), "{}: no cases", file.name());
    found
}

/// Every case of the reference folder passes its check. If the folder has no cases of a kind, the cases of this project
/// are checked.
#[test]
fn every_case_of_every_kind_holds() {
    let own = own_reference_folder().join("stability");
    let [given, own] = [reference_subfolder("stability"), own].map(|folder| {
        let files = references(&folder);
        files.iter().flat_map(cases).collect::<Vec<_>>()
    });
    let has = |case: &StabilityCase, key: &str| case.case.get(key).is_some();
    for case in &given {
        let known = KINDS.iter().any(|(key, _)| has(case, key));
        assert!(known, "no key of this case is in KINDS: {case:?}");
    }
    std::thread::scope(|scope| {
        for (key, check) in &KINDS {
            let of_kind = |cases: &[StabilityCase]| -> Vec<StabilityCase> {
                let found = cases.iter().filter(|case| has(case, key));
                found.cloned().collect()
            };
            let given = Some(of_kind(&given)).filter(|found| !found.is_empty());
            let found = given.unwrap_or_else(|| of_kind(&own));
            assert!(!found.is_empty(), "no case has `{key}`");
            scope.spawn(move || found.iter().for_each(check));
        }
    });
}

impl StabilityCase {
    /// A number of the case.
    fn number(&self, key: &str) -> f64 {
        number(&self.case, key)
    }

    /// All numbers in a value of the case, which may be a nested list.
    fn numbers(&self, key: &str) -> Vec<f64> {
        numbers(&self.case[key])
    }

    /// A vector of the case.
    fn vector(&self, key: &str) -> [f64; 2] {
        self.numbers(key).try_into().expect("two numbers")
    }

    /// The frame in which the case gives positions.
    fn frame(&self) -> Frame {
        Frame {
            ground_height: self.case["ground_height"].as_f64().unwrap_or(0.0),
        }
    }

    /// A list of points of the case, in the world's frame.
    fn points(&self, key: &str) -> Vec<Vector<f64>> {
        let points = Dimension::Plane.from_flat(&self.numbers(key)).into_iter();
        points.map(|point| self.frame().read(point)).collect()
    }

    /// A number of the file, such as a tolerance.
    fn of_file(&self, key: &str) -> f64 {
        number(&self.file, key)
    }

    /// Asserts that `got` differs by at most `bound` from the number that the case has under `key`.
    #[track_caller]
    fn near(&self, key: &str, got: f64, bound: f64) {
        let of = format!("{key} of {}", self.case);
        assert_near(got, self.number(key), bound, &of);
    }

    /// Asserts that `got` equals the number that the case has under `key`, within the absolute tolerance of the file.
    #[track_caller]
    fn absolute(&self, key: &str, got: f64) {
        self.near(key, got, self.of_file("tolerance_abs"));
    }

    /// Asserts that `got` equals the number that the case has under `key`, within the relative tolerance of the file.
    #[track_caller]
    fn relative(&self, key: &str, got: f64) {
        let bound = self.of_file("tolerance_rel") * self.number(key).abs();
        self.near(key, got, bound);
    }

    /// The regular lattice of the case, with `edges` instead of its own edges.
    fn lattice(&self, edges: Vec<[usize; 2]>) -> Lattice {
        let [columns, rows] = ["columns", "rows"].map(|key| self.number(key) as usize);
        let spacing = self.number("spacing");
        let place = |node: usize| [node % columns, node / columns].map(|n| n as f64 * spacing);
        let places = (0..columns * rows).map(place).map(Vector::from);
        // The reference answers add 1e-12 m^2 to squares of lengths on every lattice.
        Lattice {
            scale: 1.0,
            ..Lattice::between(places.collect(), edges)
        }
    }

    /// The edges of the case as pairs of nodes.
    fn edges(&self) -> Vec<[usize; 2]> {
        from_value(self.case["edges"].clone()).expect("pairs")
    }

    /// The stiffnesses and masses of a lattice whose edges have the case's materials.
    fn body(&self, lattice: &Lattice) -> Body<f64> {
        let materials: Vec<Material> =
            from_value(self.case["state"].clone()).expect("a material for each edge");
        let usual = MaterialSettings::default();
        let body = Body::new(&Design::Layout(materials), lattice, &usual, &self.world());
        // The tolerance is for about a dozen rounding errors.
        assert!(relative_error(&body.mass, &self.numbers("node_mass")) < 1e-14);
        body
    }

    /// The physics of the case. By default, the ground is flat, and there is no friction, no damping and no gravity. If
    /// the case does not give the height of the ground, there is no ground.
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
            incline_deg: or("alpha_deg", 0.0),
            contact: match (case["ground_height"].as_f64(), case["contact"].as_str()) {
                (None, _) => ContactLaw::none(),
                (_, Some("coulomb")) => ContactLaw::coulomb(),
                (_, Some("infinite") | None) => ContactLaw::infinite(),
                (_, Some(other)) => panic!("unknown contact {other:?}: {case}"),
            },
            friction: or("mu", 0.0),
            ..usual
        }
    }
}
