#!/usr/bin/env bash
# What autodiff costs a user. Prints two tables in Markdown, in processor seconds of release builds with the default profile.
#
# 1. A program of ten lines from nothing, with its dependencies: by this crate, by the crate of an earlier commit, and by other
#    crates. Needs a network once, for their packages.
# 2. The seconds to compile the program alone, after its dependencies have been compiled, and the size of the stripped
#    program, for a few small programs.
#
#   benches/compile.sh [COMMIT]    # the earlier commit; without it, the one before the crate was divided
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
earlier=${1:-c253c9ca}
crate=$(mktemp -d)
before=$(mktemp -d)
trap 'rm -rf "$crate" "$before"' EXIT
mkdir "$crate/src"

# manifest DEPENDENCIES: writes the crate's manifest.
manifest() {
  cat > "$crate/Cargo.toml" <<END
[package]
name = "user"
edition = "2024"
[dependencies]
$1
[profile.release]
strip = true
[workspace]
END
}

# seconds: builds the crate, and prints the processor seconds.
seconds() {
  { TIMEFORMAT='%U %S'; time cargo build --quiet --release --manifest-path "$crate/Cargo.toml"; } 2>&1 |
    awk '{ printf "%.2f", $1 + $2 }'
}

# whole NAME LOCK DEPENDENCIES: compiles a program, whose source is standard input, from nothing, and prints its row.
whole() {
  cat > "$crate/src/main.rs"
  manifest "$3"
  cp "$2" "$crate/Cargo.lock"
  cargo fetch --quiet --manifest-path "$crate/Cargo.toml"
  local least=
  for _ in 1 2; do
    rm -rf "$crate/target"
    local now
    now=$(seconds)
    [ -n "$least" ] && [ "$(echo "$now >= $least" | bc)" = 1 ] || least=$now
  done
  "$crate/target/release/user" > /dev/null
  local packages
  packages=$(cargo tree --quiet --manifest-path "$crate/Cargo.toml" --prefix none -e normal,build | sort -u | wc -l)
  echo "| $1 | $least | $((packages - 1)) |"
}

ours='
use autodiff::{Real, gradient, hessian};

fn well<R: Real>(x: &[R]) -> R {
    x[0] * x[0] + R::lit(3.0) * x[1].sin()
}

fn main() {
    let x = [std::env::args().count() as f64, 2.0];
    println!("{:?} {:?}", gradient(well, &x), hessian(well, &x));
}'
git -C "$root" archive "$earlier" | tar x -C "$before"

echo '| ten lines from nothing | compiled in, s | packages |'
echo '| --- | --: | --: |'
whole 'this crate' "$root/Cargo.lock" 'autodiff = { package = "cosmic-autodiff", path = "'"$root"'/autodiff" }' <<<"$ours"
whole "commit $earlier" "$before/Cargo.lock" \
  'autodiff = { package = "cosmic-autodiff", path = "'"$before"'/autodiff" }' <<<"$ours"
whole 'num-dual 0.15' "$root/Cargo.lock" 'num-dual = "0.15"
nalgebra = { version = "0.35", default-features = false, features = ["alloc", "libm"] }' <<'END'
use nalgebra::SVector;
use num_dual::{DualNum, gradient, hessian};

fn well<D: DualNum<Primitive = f64> + Copy>(x: SVector<D, 2>) -> D {
    x[0] * x[0] + x[1].sin() * 3.0
}

fn main() {
    let x = SVector::from([std::env::args().count() as f64, 2.0]);
    println!("{:?} {:?}", gradient(well, &x), hessian(well, &x));
}
END
whole 'echidna 0.15, a tape' "$root/Cargo.lock" 'echidna = { version = "0.15", features = ["bytecode"] }
num-traits = "0.2"' <<'END'
use echidna::BReverse64;
use num_traits::Float;

fn well(x: &[BReverse64]) -> BReverse64 {
    x[0] * x[0] + x[1].sin() * BReverse64::constant(3.0)
}

fn main() {
    let x = [std::env::args().count() as f64, 2.0];
    let (mut tape, _) = echidna::record(well, &x);
    println!("{:?} {:?}", tape.gradient(&x), tape.hessian_vec::<2>(&x).2);
}
END

echo
cp "$root/Cargo.lock" "$crate"
manifest 'autodiff = { package = "cosmic-autodiff", path = "'"$root"'/autodiff" }
autodiff_programs = { package = "cosmic-autodiff-programs", path = "'"$root"'/autodiff/programs" }'
empty=
# Compiles a program, whose source is standard input, and prints its row of the table.
program() {
  cat > "$crate/src/main.rs"
  cargo build --quiet --release --manifest-path "$crate/Cargo.toml"
  local least=
  for _ in 1 2 3; do
    touch "$crate/src/main.rs"
    local now
    now=$(seconds)
    [ -n "$least" ] && [ "$(echo "$now >= $least" | bc)" = 1 ] || least=$now
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
use autodiff::{Real, gradient};
use autodiff_programs::data::{Sum, Summand};
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
use autodiff::{Real, gradient};
use autodiff_programs::{Kernel, Model, Program, Rollout, kernel};
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
