use crate::small::tiny;
use cosmic::keys::{Keyed, columns};
use cosmic::numbers::fixed;
use cosmic::outcome::Summary;
use cosmic::record::{RunPlan, optimise};

#[test]
fn a_summary_has_the_declared_keys_and_a_number_for_every_column() {
    let folder = tempfile::tempdir().unwrap();
    let plan = RunPlan::new("tiny", tiny(), 1);
    let summary = optimise(&folder.path().join("run"), &plan, &mut ()).unwrap();
    let keys = Summary::keys();
    let names: Vec<_> = keys.iter().map(|key| key.name).collect();
    let written = serde_json::to_value(&summary).unwrap();
    assert!(
        written
            .as_object()
            .unwrap()
            .keys()
            .all(|key| names.contains(&&key[..]))
    );
    let number = |name: &str| {
        let mut all = columns(&keys).into_iter().zip(summary.numbers());
        all.find(|(column, _)| column.name == name).unwrap().1
    };
    assert_eq!(summary.numbers().len(), columns(&keys).len());
    let declared = columns(&keys);
    let of = |name: &str| {
        let column = declared.iter().find(|column| column.name == name);
        column.map(|column| (column.unit, column.decimals, column.says))
    };
    let says = "Number of nodes in the lowest row with a bar";
    assert_eq!(of("feet"), Some(("", 0, says)));
    let says = "10 % quantile of the displacements of `displacement_p50`";
    assert_eq!(of("displacement_p10"), Some(("m", 3, says)));
    assert_eq!(number("displacement_y"), Some(summary.displacement[1]));
    assert_eq!(number("feet"), summary.structure.map(|s| s.feet as f64));
    assert_eq!(number("seconds"), Some(summary.seconds));
    let volume = format!("{:.4}", summary.volume);
    assert_eq!(summary.shown("V"), Some(volume));
    let along = format!("{} m", fixed(summary.displacement_along, 3));
    assert_eq!(summary.shown("displacement_along"), Some(along));
    let undecided = Summary {
        structure: None,
        loads: None,
        undecided: true,
        ..summary.clone()
    };
    assert_eq!(undecided.numbers().len(), summary.numbers().len());
    assert_eq!(undecided.numbers().last(), summary.numbers().last());
}
