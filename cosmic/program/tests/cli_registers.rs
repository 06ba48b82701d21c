//! The environment variable `COSMIC_SIMD`, which chooses the SIMD registers.

use crate::common::Bench;
use crate::program::{Told, command};
use autodiff::simd::levels;

/// A robot in space, in whose rollouts some kernels run in narrower registers than others.
const CUBE: &str = "base = \"cube\"\n[physics]\nsteps = 64\n";

fn with(bench: &Bench, registers: &str, line: &str) -> Told {
    let mut command = command(line);
    let command = command.env("COSMIC_SIMD", registers);
    Told::of(command.current_dir(bench.path("")).output().unwrap())
}

/// The narrowest kind, scalars, has no fused multiply-add, and so rounds in another way.
#[test]
fn all_registers_give_the_same_bytes() {
    let bench = Bench::with(CUBE);
    let line = |out: &str| format!("optimize tiny.toml --iterations 8 --threads 1 --out {out}");
    bench.ok(&line("widest"));
    for level in levels().iter().skip(1) {
        let name = level.name();
        with(&bench, name, &line(name)).ok();
        assert_eq!(bench.results(name), bench.results("widest"), "{name}");
    }
}

#[test]
fn registers_that_the_machine_lacks_are_refused() {
    let bench = Bench::default();
    let names: Vec<&str> = levels().iter().map(|level| level.name()).collect();
    let says = format!(
        "error: the environment variable COSMIC_SIMD is `avx1024`; this machine has: {}\n",
        names.join(", ")
    );
    let told = with(&bench, "avx1024", "optimize tiny.toml --out a");
    assert_eq!((told.code, told.error), (2, says));
    assert!(!bench.path("a").exists());
    with(&bench, "none", "scene check tiny.toml").ok();
}
