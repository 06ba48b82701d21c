#!/usr/bin/env bash
# Measures a GPU beside the processor: robot-steps per second, and a search over starts of `earth`.
#
# gpu/measure.sh [STARTS [STARTS_ON_THE_PROCESSOR [ITERATIONS]]]
#
# PROGRAM names the program; without it, the script builds it. Prints the mean of the starts' medians and its standard
# error for both, and the seconds that each search took.
set -euo pipefail
cd "$(dirname "$0")/.."
starts=${1:-256}
beside=${2:-16}
iterations=${3:-300}
if [ -z "${PROGRAM:-}" ]; then
  cargo build --release --manifest-path gpu/Cargo.toml
  PROGRAM=${CARGO_TARGET_DIR:-gpu/target}/release/cosmic-gpu
fi
out=$(mktemp -d)

"$PROGRAM" devices
"$PROGRAM" bench earth --robots 256,1024,4096 --steps 256

# search NAME ARGUMENTS…
search() {
  local name=$1 begun=$SECONDS
  shift
  "$PROGRAM" optimize earth --iterations "$iterations" --out "$out/$name" "$@" >"$out/$name.txt" || tail -n 3 "$out/$name.txt"
  echo "$name: $* --iterations $iterations took $((SECONDS - begun)) s"
  awk '$1 == "start" && ($4 == "m" || $4 == "m,") {
      n++; sum += $3; squares += $3 * $3
    } END {
      if (n > 1) { mean = sum / n; printf "  %d medians: %.4f +- %.4f m\n", n, mean, sqrt((squares / n - mean * mean) / (n - 1)) }
    }' "$out/$name.txt"
}

search gpu --starts "$starts" --device gpu
search processor --starts "$beside"
