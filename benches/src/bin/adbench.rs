use benches::adbench::*;
use std::time::Duration;
fn compare(a: &serde_json::Value, b: &serde_json::Value) -> f64 {
    fn nums(v: &serde_json::Value, o: &mut Vec<f64>) { match v { serde_json::Value::Array(l) => l.iter().for_each(|x| nums(x, o)), x => o.push(x.as_f64().unwrap()) } }
    let (mut x, mut y) = (vec![], vec![]); nums(a, &mut x); nums(b, &mut y);
    assert_eq!(x.len(), y.len());
    let m = y.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    x.iter().zip(&y).fold(0.0f64, |e, (a, b)| e.max((a-b).abs())) / m
}
fn main() {
    let dir = std::path::PathBuf::from("tests/data/adbench/data");
    let pick = std::env::args().nth(1).unwrap_or_default();
    let mut go = |name: &str, mut problem: Box<dyn Problem>| {
        if !name.contains(&pick) { return; }
        let e = measure::Effort { least: Duration::from_millis(20), limit: Duration::from_secs(1) };
        problem.derivative();
        problem.objective();
        let r: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(format!("tests/data/adbench/reference/{name}.json")).unwrap()).unwrap();
        let a = problem.answer();
        for k in ["objective", "gradient", "jacobian", "reproj_err"] { if !r[k].is_null() && !r[k].is_object() { print!("{k} {:e} ", compare(&a[k], &r[k])); } }
        let o = measure::seconds(e, || problem.objective());
        let d = measure::seconds(e, || problem.derivative());
        println!("{name} {:.4} ms {:.4} ms ratio {:.2}", o*1e3, d*1e3, d/o);
    };
    go("ba1_n49_m7776_p31843", Box::new(ba::Ba::read(&dir.join("ba/ba1_n49_m7776_p31843.txt")).unwrap()));
    for n in ["gmm_test", "gmm_d2_K5", "gmm_d2_K200", "gmm_d10_K5", "gmm_d10_K25", "gmm_d20_K25"] {
        go(n, Box::new(gmm::Gmm::read(&dir.join(format!("gmm/{n}.txt"))).unwrap()));
    }
    for n in ["lstm_l2_c1024", "lstm_l4_c1024"] {
        go(n, Box::new(lstm::Lstm::read(&dir.join(format!("lstm/{n}.txt"))).unwrap()));
    }
    for n in ["hand_test", "hand1_t26_c100", "hand_complicated_test", "hand_complicated1_t26_c100"] {
        go(n, Box::new(hand::Hand::read(&dir.join(format!("hand/{n}.txt")), &dir.join("hand/model")).unwrap()));
    }
}
