use crate::small::tiny;
use cosmic::record::files::read_json;
use cosmic::record::trajectory_file::{FORMAT, TRAJECTORY};
use cosmic::record::{DesignFile, RunPlan, check_one_run, optimise};

#[test]
fn files_of_two_seeds_do_not_agree() {
    let scene = tiny();
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = [1, 2].map(|seed| {
        let run = folder.path().join(seed.to_string());
        let plan = RunPlan::new("tiny", scene.clone(), seed);
        let summary = optimise(&run, &plan, &mut ()).unwrap();
        let design = DesignFile::read(&run.join("design.json")).unwrap();
        (
            design,
            summary,
            read_json(&run.join(TRAJECTORY), FORMAT).unwrap(),
        )
    });
    let check = |design, summary, trajectory| {
        let found = check_one_run(folder.path(), &scene, design, summary, trajectory);
        found.err().map(|error| error.to_string())
    };
    assert_eq!(check(&a.0, &a.1, &a.2), None);
    assert_eq!(check(&b.0, &b.1, &b.2), None);
    assert!(check(&a.0, &a.1, &b.2).is_some() && check(&b.0, &a.1, &a.2).is_some());
    // The displacement of the payload agrees, but the motion does not.
    let mut trajectory = a.2.clone();
    trajectory.states[1].x[3][1] += 1e-5;
    let text = check(&a.0, &a.1, &trajectory).expect("the motions differ");
    for words in ["trajectory.json: after 16 steps", "not all from one run"] {
        assert!(text.contains(words), "{text}");
    }
}
