#!/usr/bin/env bash
# Builds the page into web/dist, which any file server can host. If the target wasm32-unknown-unknown cannot be
# installed, the script says so and ends with 0. `web/build.sh --check` only checks formatting and lints.
set -euo pipefail
cd "$(dirname "$0")"
target=wasm32-unknown-unknown

if ! rustup target add "$target" >/dev/null 2>&1 &&
  ! [ -d "$(rustc --print sysroot)/lib/rustlib/$target" ]; then
  echo "SKIPPED: no target $target, and it cannot be installed: the page is not built"
  exit 0
fi

# Rollouts need more stack than the default of one megabyte.
CARGO_ENCODED_RUSTFLAGS=$(../.ci/paths.sh flags -Ctarget-feature=+simd128 -Clink-arg=-zstack-size=8388608)
export CARGO_ENCODED_RUSTFLAGS
if [ "${1:-}" = --check ]; then
  cargo fmt --check
  cargo clippy --quiet --locked --target "$target" -- -D warnings
  exit 0
fi
cargo build --release --quiet --locked --target "$target"

rm -rf dist
mkdir -p dist/new
cp page/* ../cosmic/lab/src/report/page/{theme.css,drawing.js,painter.js,robot.js,charts.js} dist/new
folder=$(cargo metadata --no-deps --format-version 1 | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
cp "$folder/$target/release/cosmic_web.wasm" dist/new/cosmic.wasm
mv dist/new/{index.html,sw.js,preview.png} dist

bytes=$(wc -c < dist/new/cosmic.wasm)
sed -i "s#BYTES = 0;#BYTES = $bytes;#" dist/new/worker.js

# The name of the folder is a hash of its files, so that servers may let browsers keep them forever.
version=v-$(cat dist/new/* | sha256sum | cut -c1-12)
mv dist/new "dist/$version"
sed -i -E "s#(href|src)=\"([a-z]+\.[a-z]+)\"#\1=\"$version/\2\"#" dist/index.html
# Previews need a full address: SITE=https://example.org/robot ./build.sh
sed -i "s#SITE/#${SITE:+$SITE/}#" dist/index.html
# The address of the source, once the repository has one.
source=$(sed -n 's/^repository-code: "\(.*\)"/\1/p' ../CITATION.cff)
case $source in
*OWNER*) sed -i 's#<a href="SOURCE">.*</a>#Its source is not published yet#' dist/index.html ;;
*) sed -i "s#SOURCE#$source#" dist/index.html ;;
esac
../.ci/paths.sh check dist/*.* dist/"$version"/*
modules=$(cd dist && printf '<link rel="modulepreload" href="%s">' "$version"/{main,client,design,player,scene,strip,cast}.js)
sed -i "s#</head>#$modules\n</head>#" dist/index.html
files=$(cd dist && printf '"%s", ' "$version"/*)
sed -i "s#VERSION\"#$version\"#; s#/\* FILES \*/#$files#" dist/sw.js
chmod -R u=rwX,go=rX dist

kilobytes() { echo $(($(wc -c) / 1000)); }
all=$(cat dist/*.* dist/v-*/* | kilobytes)
packed=$(for file in dist/*.* dist/v-*/*; do gzip -9 -c "$file"; done | kilobytes)
echo "web/dist: $all kB, $packed kB compressed by gzip"
if [ "$packed" -gt 3000 ]; then
  echo "the page has $packed kB compressed; at most 3000 are allowed" >&2
  exit 1
fi
# Servers can send these instead of compressing the files themselves.
for file in dist/*.{html,js} dist/v-*/*; do
  gzip -9 -k -n "$file"
done
if command -v node >/dev/null; then
  node compress.mjs dist
else
  echo "SKIPPED: no node: no files compressed by brotli"
fi
