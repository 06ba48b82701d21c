#!/usr/bin/env bash
# Prints the public items of the crates: what rustdoc lists, without methods and fields. Run `cargo doc --workspace --no-deps`
# before. `check.sh` compares them with docs/public.txt, so that no change of an interface goes unseen.
set -euo pipefail
cd "$(dirname "$0")/.."
for crate in autodiff autodiff_programs cosmic_optimiser cosmic cosmic_lab cosmic_program; do
  sed 's/<li>/\n/g' "${CARGO_TARGET_DIR:-target}/doc/$crate/all.html" |
    sed -nE "s#^<a href=\"([^\"]*/)?([a-z]+)\.([^\"]*)\.html\">.*#$crate/\1\3: \2#p" | sed 's#/#::#g' | LC_ALL=C sort
done
