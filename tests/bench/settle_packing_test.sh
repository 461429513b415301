#!/usr/bin/env bash
# settle_packing_test.sh SETTLE_PACKING CREEP_BENCH: two copies of 1 500 grains side by side come closer to rest the longer they
# are given, and what is written is a packing that creep-bench takes.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 "$here/tile_packing.py" "$here/packing_1500.txt" 2 1 1 > "$work/tiled"
"$1" "$work/tiled" 1e7 300 300 2 > "$work/short"
"$1" "$work/tiled" 1e7 6000 6000 2 > "$work/long"
unbalanced() { sed -n '1s/.*unbalanced //p' "$1"; }
python3 -c "import sys; short, long = map(float, sys.argv[1:]); sys.exit(not 0 < 3 * long < short)" \
  "$(unbalanced "$work/short")" "$(unbalanced "$work/long")" || { echo "FAILED: no closer to rest"; exit 1; }
"$2" --packing "$work/long" --steps 20 --rounds 1 | grep -q " 3000 particles"
refused() {  # what it must say, words
  local said=$1
  shift
  if "$@" > /dev/null 2> "$work/said" || ! grep -q "$said" "$work/said"; then echo "FAILED: not refused: $*"; exit 1; fi
}
refused usage "$1" "$work/tiled"
refused "no spheres" "$1" /dev/null 1e7 10 10 1
