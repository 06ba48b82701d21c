#!/usr/bin/env bash
# All checks of the workspace. Stops at the first failure.
set -euo pipefail
cd "$(dirname "$0")"

say() { printf '\n== %s\n' "$1"; }

say 'formatting'
cargo fmt --all --check

say 'lints'
cargo clippy --workspace --all-targets -- -D warnings

say 'documentation'
RUSTDOCFLAGS='-D warnings' cargo doc --workspace --no-deps

say 'release binary, and the tests compiled'
# At the same time, because the release build often uses only one core.
cargo build --release --quiet -p cosmic-program &
release=$!
cargo test --workspace --no-run
wait "$release"
# SIMD instructions are fast only if they are inlined; otherwise every step calls them thousands of times. `xgetbv`
# belongs to the detection of the processor.
if command -v nm >/dev/null; then
  if nm -C target/release/cosmic | grep core_arch | grep -v _xgetbv; then
    echo 'intrinsics were compiled as functions: a function around them is not #[inline(always)]' >&2
    exit 1
  fi
fi

say 'tests'
cargo test --workspace --no-fail-fast
