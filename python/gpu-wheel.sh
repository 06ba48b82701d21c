#!/usr/bin/env bash
# Builds the wheel `cosmic-codesign-gpu` into target/wheels: the same package with GPU support. It is installed in place of
# `cosmic-codesign`. Arguments go to maturin.
#   python/gpu-wheel.sh && pip install target/wheels/cosmic_codesign_gpu-*.whl
set -euo pipefail
cd "$(dirname "$0")"
sources=$(mktemp -d)
trap 'rm -rf "$sources"' EXIT
cp -rL cosmic README.md LICENSE-* "$sources"
sed 's|^name = "cosmic-codesign"|name = "cosmic-codesign-gpu"|; s|^\[tool.maturin\]|&\nmanifest-path = "'"$PWD"'/Cargo.toml"\nfeatures = ["gpu"]|' \
  pyproject.toml >"$sources/pyproject.toml"
out=${CARGO_TARGET_DIR:-$PWD/../target}/wheels
paths=$PWD/../.ci/paths.sh
CARGO_ENCODED_RUSTFLAGS=$("$paths" flags)
export CARGO_ENCODED_RUSTFLAGS
cd "$sources"
maturin build --quiet --out "$out" "$@"
"$paths" check "$out"/cosmic_codesign_gpu-*.whl
