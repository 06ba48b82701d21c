#!/usr/bin/env bash
# All checks of the workspace. Stops at the first failure.
set -euo pipefail
cd "$(dirname "$0")"
# The most functions that may be compiled for wide registers, and the most instructions of a rollout with its gradient.
most_kernels=500
most_instructions=49500000

say() { printf '\n== %s, after %d s\n' "$1" "$SECONDS"; }

say 'formatting'
cargo fmt --all --check

say 'lints'
cargo clippy --workspace --all-targets -- -D warnings
cargo clippy --workspace --all-targets --features cosmic-python/gpu -- -D warnings

say 'documentation'
RUSTDOCFLAGS='-D warnings' cargo doc --workspace --no-deps
if ! docs/public.sh | diff docs/public.txt -; then
  echo 'public items changed: is it meant? Then docs/public.sh >docs/public.txt' >&2
  exit 1
fi

say 'the program, optimised, and the tests compiled'
# At the same time, because the optimised build often uses only one core. With the wheel's profile, and for third-party
# packages the wheel's features (`-p cosmic-python`), so that the program and python/check.sh share the compiled model.
cargo build --profile unwind -p cosmic-program -p cosmic-python --bin cosmic &
optimised=$!
cargo test --workspace --no-run
wait "$optimised"
program=${CARGO_TARGET_DIR:-target}/unwind/cosmic

say 'kernels and instructions'
if command -v nm >/dev/null; then
  # SIMD instructions are fast only if they are inlined; otherwise every step calls them thousands of times. `xgetbv`
  # belongs to the detection of the processor.
  if nm -C "$program" | grep core_arch | grep -v _xgetbv; then
    echo 'intrinsics were compiled as functions: a function around them is not #[inline(always)]' >&2
    exit 1
  fi
  kernels=$(nm -C "$program" | grep -c 'autodiff::simd::enter::' || true)
  echo "$kernels functions for wide registers, at most $most_kernels"
  [ "$kernels" -le "$most_kernels" ]
else
  echo 'SKIPPED: no nm: kernels are not counted'
fi
if command -v valgrind >/dev/null; then
  instructions=$(valgrind --tool=cachegrind --cache-sim=no --cachegrind-out-file=/dev/null \
    "$program" evaluate tests/data/reference/full_6x6_performance_512.json --gradient 2>&1 >/dev/null |
    sed -n 's/.*I *refs: *//p' | tr -d ,)
  echo "$instructions instructions of a rollout with its gradient, at most $most_instructions"
  [ "$instructions" -le "$most_instructions" ]
else
  echo 'SKIPPED: no valgrind: instructions are not counted'
fi

say 'tests'
cargo test --workspace --no-fail-fast --config "target.'cfg(unix)'.runner = '$PWD/tests/timed.sh'"
