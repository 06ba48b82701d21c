#!/usr/bin/env bash
# Everything that continuous integration runs. Stops at the first thing that is wrong.
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
# Much of the former is one crate on one core.
cargo build --release --quiet -p cosmic-program &
release=$!
cargo test --workspace --no-run
wait "$release"
# SIMD instructions are fast only inlined: one that is left as a function of its own is called
# thousands of times a step. `xgetbv` is part of asking the processor what it has.
if command -v nm >/dev/null; then
  if nm -C target/release/cosmic | grep core_arch | grep -v _xgetbv; then
    echo 'intrinsics were left as functions; something around them is not #[inline(always)]' >&2
    exit 1
  fi
fi

say 'tests'
cargo test --workspace --no-fail-fast
