#!/usr/bin/env bash
# Builds the wheel from source, installs it in target/venv, and runs the tests there, including the type checks.
#
# `python/check.sh --gpu` runs only the tests of GPU support, with the wheel cosmic-codesign-gpu. It is not installed, so that
# the other wheel stays. `python/check.sh --gpu LIBRARY` takes an extension module that is already built (an absolute path).
set -euo pipefail
cd "$(dirname "$0")"
here=$PWD
most=$((10 * 1024 * 1024))
if [ "${1:-}" = --gpu ]; then
  tests=(tests/test_gpu.py tests/test_page.py) needs=('maturin>=1.8,<2' numpy tqdm jax pytest)
else
  tests=(tests) needs=('maturin>=1.8,<2')
fi

say() { printf '\n== python: %s\n' "$1"; }

# Installs packages. If there is no Python or no registry, the script ends with success.
install() {
  local status=0
  python=$(./environment.sh "$@" 2>"$elsewhere/why") || status=$?
  if [ "$status" = 3 ]; then
    echo "SKIPPED: $(cat "$elsewhere/why"), so the package is not tested"
    exit 0
  elif [ "$status" != 0 ]; then
    cat "$elsewhere/why" >&2
    exit 1
  fi
}

elsewhere=$(mktemp -d)
trap 'rm -rf "$elsewhere"' EXIT

say 'the environment'
install "${needs[@]}"
wheels=$(dirname "$python")/../../wheels

say 'the package'
case "${1:-} ${2:-}" in
'--gpu ')
  rm -f "$wheels"/cosmic_codesign_gpu-*.whl
  PATH=$(dirname "$python"):$PATH ./gpu-wheel.sh --profile dev
  "$python" -m pip install --quiet --no-deps --target "$elsewhere" "$wheels"/cosmic_codesign_gpu-*.whl
  ;;
--gpu*)
  cp -r cosmic "$elsewhere"
  cp "$2" "$elsewhere/cosmic/_core.abi3.so"
  ;;
*)
  rm -f "$wheels"/cosmic_codesign-*.whl
  "$python" -m maturin build --out "$wheels"
  wheel=$(echo "$wheels"/cosmic_codesign-*.whl)
  size=$(wc -c <"$wheel")
  echo "$(basename "$wheel"): $size bytes"
  if [ "$size" -gt "$most" ]; then
    echo "the wheel has more than $most bytes" >&2
    exit 1
  fi
  install --force-reinstall --no-deps "$wheel"
  install "$wheel[test]"
  ;;
esac

# In another folder, so that Python does not import the sources.
cd "$elsewhere"
export PYTHONDONTWRITEBYTECODE=1
[ "${1:-}" = --gpu ] && export PYTHONPATH=$elsewhere
say 'tests of the installed package'
"$python" -c "
import cosmic
print(cosmic.__file__)
if cosmic.__file__.startswith('$here'):
    raise SystemExit('this is not the installed package')"
"$python" -m pytest -p no:cacheprovider --tb=short -rs --durations=20 --durations-min=1 "${tests[@]/#/$here/}"
