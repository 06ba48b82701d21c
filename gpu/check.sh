#!/usr/bin/env bash
# Checks the package `cosmic-gpu` and the wheel `cosmic-codesign-gpu`: formatting, lints, and tests on the adapter that is
# taken first, or on the one that COSMIC_GPU names. Without any adapter the tests say that they were skipped.
set -euo pipefail
cd "$(dirname "$0")"

as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi; }

# Mesa's software driver stands in for a GPU. The installation may fail.
if command -v apt-get >/dev/null && ! dpkg -s mesa-vulkan-drivers >/dev/null 2>&1; then
  { as_root apt-get update -qq && as_root apt-get install -y -qq mesa-vulkan-drivers; } >/dev/null 2>&1 ||
    echo 'no mesa-vulkan-drivers: without a GPU the tests are skipped'
fi

printf '\n== gpu: formatting and lints\n'
cargo fmt --check
cargo clippy --all-targets --quiet -- -D warnings

printf '\n== gpu: tests\n'
cargo test --no-fail-fast -- --nocapture 2>&1 | grep -v XDG_RUNTIME_DIR

printf '\n== gpu: simulators of Python\n'
../python/check.sh --gpu 2>&1 | grep -v XDG_RUNTIME_DIR
