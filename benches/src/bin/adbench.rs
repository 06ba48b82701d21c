use benches::adbench::*;
use std::time::Duration;
fn main() {
    let dir = std::path::PathBuf::from("tests/data/adbench/data");
    let mut problem: Box<dyn Problem> = Box::new(ba::Ba::read(&dir.join("ba/ba1_n49_m7776_p31843.txt")).unwrap());
    let e = measure::Effort { least: Duration::from_millis(50), limit: Duration::from_secs(1) };
    let o = measure::seconds(e, || problem.objective());
    let d = measure::seconds(e, || problem.derivative());
    println!("ba {:.3} ms {:.3} ms ratio {:.2}", o*1e3, d*1e3, d/o);
}
