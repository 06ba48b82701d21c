#!/usr/bin/env bash
# Slow checks that are not in ./check.sh, which runs the tests with little optimisation and all features. Run this
# before a release, and after changes to SIMD lanes, unsafe code, emitted adjoints or features. Checks whose tools are
# missing are skipped.
set -euo pipefail
cd "$(dirname "$0")"

say() { printf '\n== %s\n' "$1"; }

say 'every test, fully optimised, also those that take longer than 20 s'
# ./check.sh already runs the others with debug assertions. Many codegen units compile faster. Tests always unwind; in
# release, which aborts, the program would be compiled a second time.
CARGO_PROFILE_UNWIND_CODEGEN_UNITS=16 \
  cargo test --profile unwind --workspace --no-fail-fast --target-dir target/heavy -- --include-ignored

say 'features'
cargo check -p cosmic-autodiff --no-default-features
cargo check -p cosmic-autodiff --features derive
cargo check -p cosmic-autodiff --features nalgebra
cargo check -p cosmic-autodiff --features rayon
cargo check -p cosmic-autodiff-programs --no-default-features
cargo check -p cosmic-codesign --no-default-features
cargo check -p cosmic-optimiser
if rustup target add wasm32-unknown-unknown >/dev/null 2>&1; then
  cargo check -p cosmic-codesign --no-default-features --target wasm32-unknown-unknown
else
  echo 'no target wasm32-unknown-unknown: skipped'
fi

oldest=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
say "the oldest Rust, $oldest"
if rustup toolchain install "$oldest" --profile minimal >/dev/null 2>&1; then
  cargo +"$oldest" check --target-dir target/oldest --all-features \
    -p cosmic-autodiff -p cosmic-autodiff-programs -p cosmic-codesign -p cosmic-optimiser -p cosmic-lab \
    -p cosmic-program
else
  echo "no toolchain $oldest: skipped"
fi

say 'lanes of other processors: NEON and WebAssembly'
if command -v qemu-aarch64 >/dev/null && command -v aarch64-linux-gnu-gcc >/dev/null &&
  rustup target add aarch64-unknown-linux-gnu >/dev/null 2>&1; then
  CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc \
  CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER='qemu-aarch64 -L /usr/aarch64-linux-gnu' \
    cargo test -p cosmic-autodiff -p cosmic-autodiff-programs --no-fail-fast \
    --target aarch64-unknown-linux-gnu
else
  echo 'no qemu-user, gcc-aarch64-linux-gnu or target aarch64-unknown-linux-gnu: skipped'
fi
if command -v node >/dev/null && rustup target add wasm32-wasip1 >/dev/null 2>&1; then
  # With little optimisation, sums over data need more than the default megabyte of stack.
  wasm='-C target-feature=+simd128 -C link-arg=-zstack-size=8388608'
  CARGO_TARGET_WASM32_WASIP1_RUNNER="node --no-warnings $PWD/autodiff/tests/wasi.mjs" \
  RUSTFLAGS=$wasm RUSTDOCFLAGS=$wasm \
    cargo test -p cosmic-autodiff -p cosmic-autodiff-programs --no-fail-fast --target wasm32-wasip1
else
  echo 'no node or target wasm32-wasip1: skipped'
fi

say 'undefined behaviour'
if cargo +nightly miri --version >/dev/null 2>&1; then
  # `pointers` has a small case of each group that is skipped for its time. Miri has no AVX, so it checks the portable
  # lanes.
  MIRIFLAGS='-Zmiri-disable-isolation -Zmiri-deterministic-floats' \
    cargo +nightly miri test -p cosmic-autodiff -p cosmic-autodiff-programs --target-dir target/miri --test all -- \
    --skip nan_is_passed_on --skip misuse:: --skip nesting:: --skip memory:: --skip rules:: --skip kinks:: \
    --skip fused:: --skip trace --skip foreign:: --skip program:: --skip drawn::drawn --skip graph:: \
    --skip rollout:: --skip emitted:: --skip numbers:: --skip callers:: --skip check:: --skip operations::
else
  echo 'no nightly toolchain with miri and rust-src: skipped'
fi

say 'the wheel with GPU support'
python/check.sh --gpu

say 'packages, unpacked, built and tested outside the repository'
packages=$(mktemp -d)
trap 'rm -rf "$packages"' EXIT
# The loop below builds them.
cargo publish --quiet --workspace --dry-run --no-verify --allow-dirty --target-dir "$packages/publish"
cargo package --quiet --no-verify --allow-dirty --target-dir "$packages/target" \
  -p cosmic-autodiff -p cosmic-autodiff-derive -p cosmic-autodiff-programs -p cosmic-codesign -p cosmic-optimiser \
  -p cosmic-lab -p cosmic-program
patches=()
for archive in "$packages"/target/package/*.crate; do
  tar xzf "$archive" -C "$packages"
  package=$(basename "$archive" .crate)
  name=${package%-[0-9]*}
  patches+=(--config "patch.crates-io.$name.path=\"$packages/$package\"")
done
for archive in "$packages"/target/package/*.crate; do
  package=$(basename "$archive" .crate)
  # The archive lacks the features that a package's tests request from the package itself.
  (cd "$packages/$package" && cargo test --quiet --all-features "${patches[@]}" --config profile.dev.opt-level=1 \
    --config profile.dev.debug=false --target-dir "$packages/tests")
done

say 'licences, sources and versions of dependencies'
if cargo deny --version >/dev/null 2>&1; then
  cargo deny check licenses bans sources
else
  echo 'no cargo-deny: skipped'
fi

say 'sweeps on schedulers'
tests/cluster.sh

say 'instructions of gradients'
if command -v valgrind >/dev/null; then
  cargo bench -p benches --bench instructions
else
  echo 'no valgrind: skipped'
fi
