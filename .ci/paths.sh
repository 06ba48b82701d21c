#!/usr/bin/env bash
# Keeps the folders of the machine that builds out of what is handed out.
#   .ci/paths.sh flags [FLAG…]    prints CARGO_ENCODED_RUSTFLAGS: the flags, and those that shorten paths in messages
#   .ci/paths.sh check FILE…      fails if a file, or a file in an archive, names the folder of the checkout, of the home or of cargo
set -euo pipefail
# On Windows rustc knows paths in another form than bash.
native() { if command -v cygpath >/dev/null; then cygpath -w "$1"; else echo "$1"; fi; }
checkout=$(native "$(cd "$(dirname "$0")/.." && pwd)")
home=$(native "$HOME")
cargo=$(native "${CARGO_HOME:-$HOME/.cargo}")

case $1 in
flags)
  # The last prefix that fits counts. Wheels for Linux are built in a container, whose home is /root.
  flags=("${@:2}")
  for pair in /root=home "$home=home" /root/.cargo=cargo "$cargo=cargo" "$checkout=."; do
    flags+=("--remap-path-prefix=$pair")
  done
  (IFS=$'\x1f' && printf %s "${flags[*]}")
  ;;
check)
  found=0
  for file in "${@:2}"; do
    case $file in
    *.whl) show=(unzip -p "$file") ;;
    *.tar.gz) show=(tar xzOf "$file") ;;
    *) show=(cat "$file") ;;
    esac
    # Not `grep -q`, which would close the pipe early.
    if named=$("${show[@]}" | grep -aoF -e "$checkout" -e "$home/" -e "$cargo" -e /root/ | sort | uniq -c); then
      echo "$file names folders of this machine:"$'\n'"$named" >&2
      found=1
    fi
  done
  exit $found
  ;;
*)
  echo "unknown command \`$1\`; expected flags or check" >&2
  exit 2
  ;;
esac
