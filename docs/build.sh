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

packages=(autodiff autodiff-derive codesign optimiser lab program)
target=${CARGO_TARGET_DIR:-target}/site
cargo doc --quiet --locked --no-deps --all-features --target-dir "$target" "${packages[@]/#/-pcosmic-}"
web/build.sh

# The book has the folders of the repository, so that links between documents work in both.
mkdir -p "$book/src" "$book/theme"
cp docs/book.toml "$book"
git ls-files -z -- '*.md' '*.svg' '*.png' '*.gif' '*.csv' '*.toml' '*.py' '*.ipynb' '*.yml' 'cosmic/*.rs' 'LICENSE-*' \
  ':!web' ':!gpu' ':!fuzz' | xargs -0 cp --parents -t "$book/src"
sed -E 's#\]\(\.\./#](#; t; s#\]\(([a-z])#](docs/\1#' docs/SUMMARY.md >"$book/src/SUMMARY.md"
# listing FOLDER PATTERN TITLE: a chapter for a folder that a document links to.
listing() {
  local file
  printf -- '- [%s](%s/README.md)\n' "$3" "$1" >>"$book/src/SUMMARY.md"
  printf '# %s\n\n' "$3" >"$book/src/$1/README.md"
  for file in $(git ls-files -- "$1/$2"); do
    file=$(basename "$file")
    printf -- '- [%s](%s)\n' "$file" "$file" >>"$book/src/$1/README.md"
    case $file in *.md) printf -- '  - [%s](%s/%s)\n' "${file%.md}" "$1" "$file" >>"$book/src/SUMMARY.md" ;; esac
  done
}
printf '\n# Reference\n\n- [Crates](crates.md)\n' >>"$book/src/SUMMARY.md"
listing cosmic/program/tests/pages '*' 'Commands with their output'
listing python/examples '*' 'Examples in Python'
{
  printf '# Crates\n\n'
  for name in autodiff autodiff_derive cosmic cosmic_optimiser cosmic_lab cosmic_program; do
    printf -- '- [`%s`](../api/%s/index.html)\n' "$name" "$name"
  done
} >"$book/src/crates.md"
# Rustdoc resolves the links of this table.
sed -i 's#\.\./autodiff/src/kinks\.md#../../api/autodiff/real/index.html#' "$book"/src/docs/*.md
# Every page leads to the other parts of the site.
printf '<p><a href="{{ path_to_root }}../index.html">A robot in your browser</a> · <a href="{{ path_to_root }}crates.html">%s</a></p>\n' \
  'The crates' >"$book/theme/header.hbs"

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
