#!/usr/bin/env bash
# What autodiff costs in a user's crate: the seconds to compile the crate, and the size of its program, for a few small
# programs. Release builds with the default profile, stripped; seconds are processor time of the crate alone, after its
# dependencies have been compiled. Prints a table in Markdown.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
crate=$(mktemp -d)
trap 'rm -rf "$crate"' EXIT
mkdir "$crate/src"
cp "$root/Cargo.lock" "$crate"
cat > "$crate/Cargo.toml" <<END
[package]
name = "user"
edition = "2024"
[dependencies]
autodiff = { package = "cosmic-autodiff", path = "$root/autodiff" }
[profile.release]
strip = true
[workspace]
END

empty=
# Compiles a program, whose source is standard input, and prints its row of the table.
program() {
  cat > "$crate/src/main.rs"
  cargo build --quiet --release --manifest-path "$crate/Cargo.toml"
  local least=
  for _ in 1 2 3; do
    touch "$crate/src/main.rs"
    local seconds
    seconds=$( { TIMEFORMAT='%U %S'; time cargo build --quiet --release --manifest-path "$crate/Cargo.toml"; } 2>&1 |
      awk '{ printf "%.2f", $1 + $2 }')
    [ -n "$least" ] && [ "$(echo "$seconds >= $least" | bc)" = 1 ] || least=$seconds
  done
  "$crate/target/release/user" > /dev/null
  local size
  size=$(stat -c %s "$crate/target/release/user")
  : "${empty:=$size}"
  echo "| $1 | $least | $(((size - empty) / 1000)) |"
}

echo '| program | compiled in, s | larger than the empty one by, kB |'
echo '| --- | --: | --: |'
program 'empty' <<'END'
fn main() {
    println!("{}", std::env::args().count());
}
END
program '`gradient` of a closure' <<'END'
use autodiff::{Real, gradient};
fn main() {
    let x = std::env::args().count() as f64;
    println!("{:?}", gradient(|x| x[0] * x[0] + x[1].sin(), &[x, 2.0]));
}
END
program '`gradient` and `hessian` of a generic function' <<'END'
use autodiff::{Real, gradient, hessian};
fn bowl<R: Real>(x: &[R]) -> R {
    x[0] * x[0] + R::lit(3.0) * x[1].sin()
}
fn main() {
    let x = [std::env::args().count() as f64, 2.0];
    println!("{:?} {:?}", gradient(bowl, &x), hessian(bowl, &x));
}
END
program 'a `Sum` over data and its gradient' <<'END'
use autodiff::data::{Sum, Summand};
use autodiff::{Real, gradient};
struct Misfit;
impl Summand for Misfit {
    fn eval<R: Real>(&self, line: &[R], point: &[R]) -> R {
        let gap = line[0] + line[1] * point[0] - point[1];
        gap * gap
    }
}
fn main() {
    let x = std::env::args().count() as f64;
    let points = Sum::new(Misfit, &[[0.0, 1.0], [1.0, 3.0], [2.0, 2.0]]);
    println!("{:?}", gradient(|line| points.run(line), &[x, 1.0]));
}
END
program 'a `Rollout` with one kernel and its gradient' <<'END'
use autodiff::{Kernel, Model, Program, Real, Rollout, gradient, kernel};
#[derive(Clone)]
struct Spring;
#[kernel]
impl Kernel<3, 2> for Spring {
    fn eval<R: Real>(&self, [x, v, stiffness]: [R; 3], _: &[R]) -> [R; 2] {
        let v = v - R::lit(0.1) * stiffness * x;
        [x + R::lit(0.1) * v, v]
    }
}
impl Model for Spring {
    fn record(&self, program: &mut Program) {
        let stiffness = program.parameter(1);
        let (x, v) = (program.state(1), program.state(1));
        let [x_next, v_next] = program.map(Spring, [x, v, stiffness], &[]);
        program.advance(x, x_next);
        program.advance(v, v_next);
    }
}
fn main() {
    let x = std::env::args().count() as f64;
    let rollout = Rollout::new(Spring, 100);
    println!("{:?}", gradient(|k| rollout.run(&k[..2], &[&k[2..]])[0], &[x, 0.0, 1.0]));
}
END
