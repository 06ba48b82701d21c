#!/usr/bin/env bash
# Builds the wheel from source, installs it in a virtual environment, and runs the tests there, including the type
# checks. The environment is in the folder $1, or in target/venv. With `--gpu` the wheel is cosmic-codesign-gpu, and only
# the tests of GPU support run.
set -euo pipefail
cd "$(dirname "$0")"
here=$PWD
if [ "${1:-}" = --gpu ]; then
  name=cosmic_codesign_gpu folder=target/venv-gpu
  tests=(tests/test_gpu.py tests/test_page.py) needs=(numpy tqdm jax pytest)
  # What gpu/check.sh has compiled is compiled already.
  how=(--profile dev --features gpu --target-dir "$here/../gpu/target")
  build() { PATH=$venv/bin:$PATH ./gpu-wheel.sh "${how[@]}"; }
else
  name=cosmic_codesign folder=${1:-target/venv}
  tests=(tests) needs=() how=(--release)
  build() { "$python" -m maturin build --release --quiet --out target/wheels; }
fi
mkdir -p "$folder"
venv=$(cd "$folder" && pwd)
python=$venv/bin/python
most=$((10 * 1024 * 1024))

say() { printf '\n== python: %s\n' "$1"; }

log=$(mktemp)
elsewhere=$(mktemp -d)
trap 'rm -rf "$log" "$elsewhere"' EXIT

# Installs packages. Exits with success if the registry cannot be reached; any other error is a failure.
install() {
  if "$python" -m pip install --quiet --retries 2 --disable-pip-version-check "$@" >"$log" 2>&1; then
    return
  fi
  if grep -qE 'connection broken by|Max retries exceeded|Read timed out' "$log"; then
    echo 'SKIPPED: the Python package registry cannot be reached, so the package is not tested'
    exit 0
  fi
  cat "$log" >&2
  exit 1
}

if ! python3 -c 'import ensurepip, sys; sys.exit(sys.version_info < (3, 10))' 2>/dev/null; then
  echo 'SKIPPED: python3 3.10 or later with venv is missing, so the package is not tested'
  exit 0
fi

say "an environment in $venv"
python3 -m venv "$venv"
install 'maturin>=1.8,<2'

say 'formatting and lints'
cargo fmt --check
cargo clippy --quiet "${how[@]}" -- -D warnings

say 'the wheel from source'
rm -f target/wheels/"$name"-*.whl
build
wheel=$(echo "$here"/target/wheels/"$name"-*.whl)
size=$(wc -c <"$wheel")
echo "$(basename "$wheel"): $size bytes"
if [ "$size" -gt "$most" ]; then
  echo "the wheel has more than $most bytes" >&2
  exit 1
fi

say 'installation of the wheel and of the test dependencies'
install --force-reinstall --no-deps "$wheel"
[ "$name" = cosmic_codesign ] && needs=("$wheel[test]")
install "${needs[@]}"

# In another folder, so that Python does not import the sources instead of the installed package.
cd "$elsewhere"
export PYTHONDONTWRITEBYTECODE=1
say 'tests of the installed package'
"$python" -c "
import cosmic, sys
print(cosmic.__file__)
sys.exit(None if cosmic.__file__.startswith(sys.prefix) else 'this is not the installed package')"
"$python" -m pytest -p no:cacheprovider --tb=short -rs "${tests[@]/#/$here/}"
