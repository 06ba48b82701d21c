#!/usr/bin/env bash
# What ./check.sh leaves out because it takes long. Run it before a release, and after a change of
# SIMD lanes, of unsafe code, of emitted adjoints or of a feature: ./check.sh runs the tests with
# little optimisation and every feature. Tools that are missing are named and skipped.
set -euo pipefail
cd "$(dirname "$0")"

say() { printf '\n== %s\n' "$1"; }

say 'every test, fully optimised'
# Without debug assertions: they are in ./check.sh. Several units, for nothing is timed here.
CARGO_PROFILE_RELEASE_CODEGEN_UNITS=16 CARGO_PROFILE_RELEASE_DEBUG=0 \
  cargo test --release --workspace --no-fail-fast --target-dir target/heavy

say 'features'
cargo check -p cosmic-autodiff --no-default-features
cargo check -p cosmic-autodiff --features nalgebra
cargo check -p cosmic-autodiff --features rayon
cargo check -p cosmic-codesign --no-default-features

say 'licences, sources and versions of dependencies'
if cargo deny --version >/dev/null 2>&1; then
  cargo deny check licenses bans sources
else
  echo 'no cargo-deny: skipped'
fi

say 'instructions of gradients'
if command -v valgrind >/dev/null; then
  cargo bench -p benches --bench instructions
else
  echo 'no valgrind: skipped'
fi
