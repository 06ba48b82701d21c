#!/usr/bin/env bash
# Installs Python packages into target/venv, the virtual environment of all tests, and prints the path of its Python. With VENV
# set, the environment has that name.
# If there is no Python, or the registry of packages cannot be reached, it says so on standard error and ends with 3.
#   python/environment.sh 'numpy>=2' pytest
set -euo pipefail
target=${CARGO_TARGET_DIR:-$(dirname "$0")/../target}
mkdir -p "$target"
venv=$(cd "$target" && pwd)/${VENV:-venv}

if ! python3 -c 'import ensurepip, sys; sys.exit(sys.version_info < (3, 10))' 2>/dev/null; then
  echo 'python3 3.10 or later with venv is missing' >&2
  exit 3
fi
# Tests that run at the same time wait for one another.
exec 9>"$venv.lock"
if command -v flock >/dev/null; then
  flock 9
fi
[ -x "$venv/bin/python" ] || python3 -m venv "$venv" >&2
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! "$venv/bin/python" -m pip install --quiet --retries 2 --disable-pip-version-check "$@" >"$log" 2>&1; then
  if grep -qE 'connection broken by|Max retries exceeded|Read timed out' "$log"; then
    echo 'the registry of Python packages cannot be reached' >&2
    exit 3
  fi
  cat "$log" >&2
  exit 1
fi
echo "$venv/bin/python"
