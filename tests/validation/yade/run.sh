#!/usr/bin/env bash
# run.sh BIN OUT: shears one packing of 1500 smooth unbreakable spheres that may turn at 1 MPa of lateral stress, here and with
# YADE's TriaxialStressController (Debian package yade). OUT receives the curves; compare.py judges them.
# 77 if YADE is not installed.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
bin=${1:?folder of compress_packing and settle_packing}
out=${2:?folder for the results}
command -v yade > /dev/null || { echo "run.sh: YADE is not installed: apt-get install yade" >&2; exit 77; }
mkdir -p "$out"
stress=1e6 friction=0.275 speed=0.05 step=2e-8 every=1000 count=120  # [Pa], -, closing [m/s], [s], steps a row, rows

settle() { "$bin/settle_packing" "$1" "$2" 200000 1000000 1; }
settle "$here/../../bench/packing_1500.txt" "$stress" > "$out/start.txt"
# The same with the last digits of one coordinate changed: how far rounding alone carries two runs apart.
awk 'NR == 1 { print; next } { printf "%.17g %s %s %s\n", $1 * (1 + 2e-15), $2, $3, $4 }' "$out/start.txt" > "$out/nudged.txt"
shear() { "$bin/compress_packing" shear "$1" "$friction" "$speed" "$step" "$every" "$count" "$stress"; }
shear "$out/start.txt" > "$out/creepd.csv"
shear "$out/nudged.txt" > "$out/creepd_nudged.csv"
yade -n -x -j1 "$here/shear.py" "$out/start.txt" "$stress" "$friction" "$speed" "$step" "$every" "$count" "$out/yade.csv" > "$out/yade.log" 2>&1
python3 "$here/compare.py" "$out" "$out/shear.svg"
