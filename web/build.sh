#!/usr/bin/env bash
# Builds the page into web/dist, which any file server can host. If the target wasm32-unknown-unknown cannot be
# installed, the script says so and ends with 0.
set -euo pipefail
cd "$(dirname "$0")"
target=wasm32-unknown-unknown

if ! rustup target add "$target" >/dev/null 2>&1 &&
  ! [ -d "$(rustc --print sysroot)/lib/rustlib/$target" ]; then
  echo "SKIPPED: no target $target, and it cannot be installed: the page is not built"
  exit 0
fi

# Rollouts need more stack than the default of one megabyte.
flags='-C target-feature=+simd128 -C link-arg=-zstack-size=8388608'
RUSTFLAGS="$flags" cargo build --release --quiet --locked --target "$target"

rm -rf dist
mkdir dist
cp page/* ../cosmic/lab/src/report/page/{theme.css,drawing.js} dist
folder=$(cargo metadata --no-deps --format-version 1 | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
cp "$folder/$target/release/cosmic_web.wasm" dist/cosmic.wasm
chmod 644 dist/*

kilobytes() { echo $(($(wc -c) / 1000)); }
all=$(cat dist/* | kilobytes)
packed=$(for file in dist/*; do gzip -9 -c "$file"; done | kilobytes)
echo "web/dist: $all kB, $packed kB compressed by gzip"
if [ "$packed" -gt 3000 ]; then
  echo "the page has $packed kB compressed; at most 3000 are allowed" >&2
  exit 1
fi
