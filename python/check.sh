#!/usr/bin/env bash
# Builds the wheel, installs it in a fresh virtual environment, and runs the tests of the package there:
# python/check.sh [FOLDER OF THE ENVIRONMENT]. Torch's tests run where torch is installed; they are run by
# command: python/check.sh FOLDER torch.
set -euo pipefail
cd "$(dirname "$0")"
environment=${1:-target/venv}
extras=test${2:+,$2}
most=$((10 * 1000 * 1000))

say() { printf '\n== %s\n' "$1"; }
log=$(mktemp)
trap 'rm -f "$log"' EXIT

# Runs pip. Where the registry of packages cannot be reached there is nothing to test.
install() {
  if "$environment/bin/python" -m pip install --quiet --retries 2 "$@" >"$log" 2>&1; then
    return
  fi
  cat "$log" >&2
  if grep -qE 'connection broken by|Max retries exceeded|Read timed out' "$log"; then
    echo 'SKIPPED: the registry of Python packages cannot be reached: the package for Python is not tested'
    exit 0
  fi
  exit 1
}

say 'environment'
python3 -m venv --clear "$environment"
install 'maturin>=1.8,<2'

say 'formatting and lints'
cargo fmt --check
cargo clippy --release --quiet -- -D warnings

say 'wheel'
rm -rf target/wheels
"$environment/bin/maturin" build --release --quiet --interpreter "$environment/bin/python" --out target/wheels
wheel=$(ls target/wheels/*.whl)
size=$(wc -c <"$wheel")
echo "$(basename "$wheel"): $size bytes"
if [ "$size" -gt "$most" ]; then
  echo "expected at most $most bytes" >&2
  exit 1
fi
install "$wheel[$extras]"

say 'tests'
# From a folder of their own: the sources beside them have no compiled module.
"$environment/bin/python" -m pytest --quiet --import-mode=importlib -p no:cacheprovider --rootdir tests tests
