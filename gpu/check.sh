#!/usr/bin/env bash
# Tests the package `cosmic-gpu` and the wheel `cosmic-codesign-gpu` on the adapter that is taken first, or on the one that
# COSMIC_GPU names. Without any adapter the tests say that they were skipped. On a machine without a GPU, Mesa's software
# driver (the package mesa-vulkan-drivers) stands in for it.
set -euo pipefail
cd "$(dirname "$0")"

printf '\n== gpu: tests\n'
cargo test -p cosmic-gpu --no-fail-fast -- --nocapture 2>&1 | grep -v XDG_RUNTIME_DIR

printf '\n== gpu: simulators of Python\n'
../python/check.sh --gpu 2>&1 | grep -v XDG_RUNTIME_DIR
