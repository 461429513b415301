#!/usr/bin/env bash
# A guard of speed that works on any machine: instructions of the cycles of a small scene, counted by callgrind, against
# the figures in instructions.txt. Times are not looked at.
#
#   instructions_test.sh CREEP_BENCH
#
# Counts depend on the compiler; those stored are of Debian 12's g++ 12, Release. What became slower on purpose, or
# faster, changes the stored figure in the same commit.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
bench=$1
command -v valgrind >/dev/null || { printf 'SKIPPED: no valgrind\n'; exit 77; }
grep -qw avx2 /proc/cpuinfo || { printf 'SKIPPED: this processor has no AVX2\n'; exit 77; }
work=$(mktemp -d "${TMPDIR:-/tmp}/creep-instructions-XXXXXX")
trap 'rm -rf "$work"' EXIT

# The same code counts the same to a few instructions; a percent is what a rebuild more or less makes.
tolerance=0.02
steps=60 # and a tenth more before the clock would start: six cycles that measure, one search
status=0
while read -r set law stored; do
  [[ "$set" != "#" ]] || continue
  options=()
  if [[ "$law" == smooth ]]; then options=(--smooth); fi
  CREEP_ISA=$set valgrind --tool=callgrind --callgrind-out-file="$work/out" --collect-atstart=no \
    '--toggle-collect=creep::Dynamics::cycle*' "$bench" --packing "$here/packing_1500.txt" --threads 1 \
    --rounds 1 --steps "$steps" "${options[@]}" >"$work/said" 2>&1 || { cat "$work/said"; exit 1; }
  counted=$(sed -nE 's/^(summary|totals): ([0-9]+)$/\2/p' "$work/out" | head -n 1)
  awk -v set="$set" -v law="$law" -v now="$counted" -v stored="$stored" -v tolerance="$tolerance" 'BEGIN {
    change = now / stored - 1
    printf "%s, %s law: %d instructions, stored %d (%+.1f %%)\n", set, law, now, stored, 100 * change
    if (change > tolerance) { print "  more than stored: find out why"; exit 1 }
    if (change < -tolerance) { print "  fewer than stored: write the new figure into instructions.txt"; exit 1 }
  }' || status=1
done <"$here/instructions.txt"
exit "$status"
