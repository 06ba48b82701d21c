use crate::small::{begun, tiny};
use cosmic::keys::{Keyed, columns};
use cosmic::numbers::fixed;
use cosmic::outcome::Summary;
use cosmic::record::{RunPlan, optimise};
use cosmic::scene::TaskKind;

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

/// A robot of another task is not judged as a walker if too many of its rollouts diverged to know its loss, also after its
/// summary went through a file.
#[test]
fn a_robot_of_another_task_keeps_its_task_if_its_loss_is_not_known() {
    for (task, is_far) in [(TaskKind::Far, true), (TaskKind::Climb, false)] {
        let mut scene = tiny();
        scene.objective.task = task;
        let (codesign, progress) = begun(&scene);
        let mut delivery = codesign.deliver(&progress);
        let known = Summary::new(&scene, &progress, &delivery);
        if let Some(merit) = &mut delivery.merit {
            merit.p50 = f64::NEG_INFINITY; // more than half of the rollouts diverged
        }
        let lost = Summary::new(&scene, &progress, &delivery);
        assert_eq!(lost.loss_p50.flatten(), None);
        assert_eq!(known.loss_p50.flatten().is_none(), is_far);
        for summary in [known, lost] {
            let text = serde_json::to_string(&summary).unwrap();
            let read: Summary = serde_json::from_str(&text).unwrap();
            assert_eq!(read, summary);
            let measured = read.measured(&scene, codesign.world().lattice());
            assert_eq!(measured.is_far, is_far);
        }
    }
}
