#!/usr/bin/env bash
# Builds the page and tests it in the installed browsers: every control, the files that it saves, the saved robot in the
# native program, the page of a run, and Lighthouse's score. If a tool is missing, its tests are skipped, and the output says so. If $1 is
# given, screenshots of the page are written into that folder.
set -euo pipefail
cd "$(dirname "$0")"

say() { printf '\n== web: %s\n' "$1"; }

say 'formatting, lints, build'
./build.sh --check
./build.sh
if ! ls dist/*/cosmic.wasm >/dev/null 2>&1; then
  exit 0
fi

say 'installing what the tests need'
if ! command -v node >/dev/null || ! command -v npm >/dev/null; then
  echo 'SKIPPED: no node with npm: the page is not tested'
  exit 0
fi
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! npm ci --prefix test --no-audit --no-fund >"$log" 2>&1; then
  if grep -qE 'EAI_AGAIN|ENOTFOUND|ECONNREFUSED|ECONNRESET|ETIMEDOUT|E40[134]' "$log"; then
    echo 'SKIPPED: the registry of npm cannot be reached: the page is not tested'
    exit 0
  fi
  cat "$log" >&2
  exit 1
fi

say 'the page in browsers'
program=${CARGO_TARGET_DIR:-../target}/release/cosmic
# If one check fails, the other still runs.
status=0
node cast.mjs --check || status=1
node test/page.mjs --program "$program" ${1:+--shots "$1"} || status=1

say 'the page of a run'
if [ -x "$program" ] && [ -x /usr/bin/chromium ]; then
  run=$(mktemp -d)
  "$program" optimize earth --quiet --out "$run/run" --set lattice.columns=4 --set lattice.rows=3 --set physics.steps=2048 \
    --set schedule.iterations=60 --set schedule.attraction_from=24 --set schedule.snap_at=36 \
    --set 'schedule.horizon=[256, 1024]' --set loss.window=256
  "$program" report "$run/run" --quiet
  node test/report.mjs "$run/run/report.html" ${1:+"$1"} || status=1
  rm -r "$run"
else
  echo "SKIPPED: no program $program, or no Chromium: the page of a run is not tested"
fi

say 'accessibility'
node test/lighthouse.mjs || status=1
exit "$status"
