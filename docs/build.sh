#!/usr/bin/env bash
# Builds the site for any file server: the live page as its front, these documents with a search as `book`, and the
# documentation of the crates as `api`.
#   docs/build.sh FOLDER
# Needs Rust with the target wasm32-unknown-unknown, and mdBook. Prints broken links, and fails if there are any.
set -euo pipefail
out=$(realpath -m "${1:?usage: docs/build.sh FOLDER}")
cd "$(dirname "$0")/.."
if ! command -v mdbook >/dev/null; then
  echo 'docs/build.sh needs mdBook: cargo install mdbook --locked' >&2
  exit 1
fi
book=$(mktemp -d)
trap 'rm -rf "$book"' EXIT

packages=(autodiff autodiff-derive autodiff-programs codesign optimiser lab program)
target=${CARGO_TARGET_DIR:-target}/site
cargo doc --quiet --locked --no-deps --all-features --target-dir "$target" "${packages[@]/#/-pcosmic-}"
web/build.sh

# The book has the folders of the repository, so that links between documents work in both.
mkdir -p "$book/src" "$book/theme"
cp docs/book.toml "$book"
git ls-files -z -- '*.md' '*.svg' '*.png' '*.gif' '*.csv' '*.toml' '*.py' '*.ipynb' '*.yml' 'cosmic/*.rs' '*/pages/*' \
  'LICENSE-*' ':!web' ':!gpu' ':!fuzz' | xargs -0 cp --parents -t "$book/src"
cp -rL scenes "$book/src"
sed -E 's#\]\(\.\./#](#; t; s#\]\(([a-z])#](docs/\1#' docs/SUMMARY.md >"$book/src/SUMMARY.md"
# listing FOLDER TITLE: a chapter for a folder that a document links to.
listing() {
  local file
  printf -- '- [%s](%s/README.md)\n' "$2" "$1" >>"$book/src/SUMMARY.md"
  printf '# %s\n\n' "$2" >"$book/src/$1/README.md"
  for file in $(git ls-files -- "$1"); do
    file=$(basename "$file")
    printf -- '- [%s](%s)\n' "$file" "$file" >>"$book/src/$1/README.md"
    case $file in *.md) printf -- '  - [%s](%s/%s)\n' "${file%.md}" "$1" "$file" >>"$book/src/SUMMARY.md" ;; esac
  done
}
printf '\n# Reference\n\n- [Crates](crates.md)\n' >>"$book/src/SUMMARY.md"
listing cosmic/program/tests/pages 'Commands with their output'
listing cosmic/program/examples 'Examples in Rust'
listing python/examples 'Examples in Python'
{
  printf '# Crates\n\n'
  for name in autodiff autodiff_derive autodiff_programs cosmic cosmic_optimiser cosmic_lab cosmic_program; do
    printf -- '- [`%s`](../api/%s/index.html)\n' "$name" "$name"
  done
} >"$book/src/crates.md"
# mdBook makes an index of every README, but does not change the links to it.
find "$book/src" -name '*.md' ! -name SUMMARY.md -exec sed -E -i 's#(\]\([^):]*)README\.md#\1index.html#g' {} +
# Rustdoc resolves the links of this table.
sed -i 's#\.\./autodiff/src/kinks\.md#../../api/autodiff/real/index.html#' "$book"/src/docs/*.md
# Tables have up to seven columns, so they get more room than paragraphs. On a phone they scroll, with readable cells.
cat >"$book/theme/head.hbs" <<'END'
<style>
html:root { --content-max-width: 1100px }
.content main > :is(p, ul, ol) { max-width: 800px }
.table-wrapper :is(td, th) { padding: 3px 8px; vertical-align: top }
@media (max-width: 700px) {
  .table-wrapper table { width: max-content }
  .table-wrapper :is(td, th) { max-width: 17em }
}
</style>
END
# Every page leads to the other parts of the site. mdBook moves its pages up by the height of the menu.
cat >"$book/theme/header.hbs" <<'END'
<p style="margin: 0 0 calc(8px - var(--menu-bar-height)); padding: calc(var(--menu-bar-height) + 8px) 16px 0">
<a href="{{ path_to_root }}../index.html">A robot in your browser</a> · <a href="{{ path_to_root }}crates.html">The crates</a></p>
END

rm -rf "$out"
mkdir -p "$out"
if [ -e web/dist/index.html ]; then
  cp -r web/dist/. "$out"
  sed -i 's#</header>#  <p><a href="book/index.html">How it works, and how to use it</a></p>\n</header>#' "$out/index.html"
  gzip -9 -k -n -f "$out/index.html"
  rm -f "$out/index.html.br"
else
  echo '<meta http-equiv="refresh" content="0; url=book/index.html">' >"$out/index.html"
fi
cp -r "$target/doc" "$out/api"
mdbook build "$book" --dest-dir "$out/book"
python3 docs/links.py "$out"
