#!/usr/bin/env bash
# Builds the wheel from source, installs it in target/venv, and runs the tests there, including the type checks.
#
# `python/check.sh --gpu` runs only the tests of GPU support, with the wheel cosmic-codesign-gpu. It is not installed, so that
# the other wheel stays. `python/check.sh --gpu LIBRARY` takes an extension module that is already built (an absolute path).
#
# `python/check.sh --frameworks` tests the newest wheel in target/wheels, or builds it, with the oldest versions of torch, JAX
# and stable-baselines3 that pyproject.toml promises, and with the newest, and checks types with the newest. The packages take
# about 12 GB.
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

# The packages that pyproject.toml names as `NAME>=VERSION`, with exactly these versions.
promised() { grep -oE '"(gymnasium|jax|optax|stable-baselines3|torch)>=[0-9.]+"' pyproject.toml | tr -d '"' | sed 's/>=/==/' | sort -u; }

if [ "${1:-}" = --frameworks ]; then
  wheels=${CARGO_TARGET_DIR:-$here/../target}/wheels
  for age in oldest newest; do
    say "the $age frameworks"
    export VENV=frameworks-$age
    install pip
    if ! ls "$wheels"/cosmic_codesign-*.whl >/dev/null 2>&1; then
      install 'maturin>=1.8,<2'
      PATH=$(dirname "$python"):$PATH "$python" -m maturin build --out "$wheels"
    fi
    [ "$age" = newest ] && versions=(gymnasium jax optax stable-baselines3 torch) || mapfile -t versions < <(promised)
    install --upgrade pytest pygame-ce "${versions[@]}"
    install --upgrade --force-reinstall --no-deps "$wheels"/cosmic_codesign-*.whl
    install "$(echo "$wheels"/cosmic_codesign-*.whl)[jax,torch,sb3]" "${versions[@]}"
    "$python" -m pip list 2>/dev/null | grep -E '^(gymnasium|jax|numpy|optax|stable_baselines3|torch) '
    (cd "$elsewhere" && "$python" -m pytest -p no:cacheprovider --tb=short -rs "$here"/tests/test_{derivatives,gym,jax,sb3,torch}.py)
  done
  # The tests of the usual check do not know the types of all frameworks, and mypy skips them there.
  say 'types, with those of the newest frameworks'
  install ezdxf mypy pyright trimesh
  (cd "$elsewhere" && "$python" -m pytest -p no:cacheprovider --tb=short -rs "$here/tests/test_examples.py" -k pyright)
  cp -r cosmic examples/*.py "$elsewhere"
  cd "$elsewhere"
  "$python" -m mypy --config-file= --strict --ignore-missing-imports --allow-untyped-calls --allow-untyped-decorators cosmic ./*.py
  exit
fi

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
