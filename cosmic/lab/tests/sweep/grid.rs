use cosmic_lab::sweep::{Axis, combinations};

/// The greatest length of a suffix, in bytes.
const LONGEST: usize = 160;

fn suffixes(axes: &[&str]) -> Vec<String> {
    let axes: Vec<_> = axes.iter().map(|a| Axis::parse(a).unwrap()).collect();
    let all = combinations(&axes).unwrap();
    all.into_iter().map(|one| one.suffix).collect()
}

#[test]
fn every_combination_occurs_once_with_a_name_that_shows_it() {
    let two = ["physics.friction=0.6,1", "physics.gravity=3.7,9.81"];
    let expected = [
        "+friction=0.6+gravity=3.7",
        "+friction=0.6+gravity=9.81",
        "+friction=1+gravity=3.7",
        "+friction=1+gravity=9.81",
    ];
    assert_eq!(suffixes(&two), expected);
    assert_eq!(suffixes(&[]), [""]);
    let axes = two.map(|axis| Axis::parse(axis).unwrap());
    let third = &combinations(&axes).unwrap()[2];
    assert_eq!(
        third.settings,
        ["physics.friction=1", "physics.gravity=3.7"]
    );
    // A key with one value is a setting of all runs, which no name needs.
    assert_eq!(suffixes(&["physics.friction=0.6"]), [""]);
}

#[test]
fn commas_within_brackets_and_quotes_do_not_separate() {
    let lists = suffixes(&["schedule.horizon=[32,32], [64, 64]"]);
    assert_eq!(lists, ["+horizon=32,32", "+horizon=64,_64"]);
    assert_eq!(suffixes(&["a.b={c=1,d=2},'e,f'"]), ["+b=c_1,d_2", "+b=e,f"]);
}

#[test]
fn names_differ_and_fit() {
    // If two keys have the same last part, the suffix shows the whole keys.
    let keys = suffixes(&["volume.kind=1,2", "loss.kind=3,4"]);
    assert_eq!(keys[1], "+volume.kind=1+loss.kind=4");
    assert_eq!(suffixes(&["a.b='x/y',x:y"]), ["+b=x_y", "+b=x_y~2"]);
    let long = format!("a.b={0}1,{0}2", "é".repeat(LONGEST));
    let long = suffixes(&[&long]);
    assert!(
        long[0] != long[1] && long[1].len() <= LONGEST + 2,
        "{long:?}"
    );
}

#[test]
fn malformed_grids_are_refused() {
    for (text, says) in [
        ("physics.friction", "`=` is missing"),
        ("=1", "the key is missing"),
        ("a.b=1,,2", "a value is missing"),
        ("a.b=1, 1", "a value is repeated"),
    ] {
        let error = Axis::parse(text).unwrap_err().to_string();
        assert!(error.contains(says) && error.contains(text), "{error}");
    }
    let axis = Axis::parse("a.b=1").unwrap();
    let error = combinations(&[axis.clone(), axis]).unwrap_err().to_string();
    assert!(error.contains("`a.b` is set twice"), "{error}");
}
