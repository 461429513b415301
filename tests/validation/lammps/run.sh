#!/usr/bin/env bash
# run.sh BIN OUT: compresses one packing of 1500 smooth unbreakable spheres along z from 1 to 20 MPa here and in LAMMPS
# (Debian package lammps): same walls, same local damping, same step. OUT receives the curves; compare.py judges them.
# 77 if LAMMPS is not installed.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
bin=${1:?folder of compress_packing}
out=${2:?folder for the results}
command -v lmp > /dev/null || { echo "run.sh: LAMMPS is not installed: apt-get install lammps" >&2; exit 77; }
mkdir -p "$out"
export OMP_NUM_THREADS=1

speed=0.05 step=2e-8 every=200  # closing speed of the platens [m/s], [s], steps a row
wall=$(python3 -c 'print(4 / 3 * 32e9 / (1 - 0.19))')  # Hertz prefactor of a wall like between grains [Pa]

"$bin/compress_packing" relax "$here/../../bench/packing_1500.txt" 1e6 > "$out/start.txt"
read -r x0 y0 z0 x1 y1 z1 < <(python3 "$here/lammps_data.py" "$out/start.txt" "$out/data")

# The same with the last digits of one coordinate changed: how far rounding alone carries two runs apart.
awk 'NR == 1 { print; next } { printf "%.17g %s %s %s\n", $1 * (1 + 2e-15), $2, $3, $4 }' "$out/start.txt" > "$out/nudged.txt"

lammps() {  # friction, tangential law, rows, table
  lmp -in "$here/in.lammps" -log none -screen none -var data "$out/data" -var x0 "$x0" -var x1 "$x1" -var y0 "$y0" \
    -var y1 "$y1" -var z0 "$z0" -var z1 "$z1" -var wall "$wall" -var friction "$1" -var tangential "$2" -var speed "$speed" \
    -var step "$step" -var steps "$(($3 * every))" -var every "$every" -var table "$4"
}
"$bin/compress_packing" load "$out/start.txt" 0 "$speed" "$step" "$every" 265 > "$out/creepd_mu_0.csv"
"$bin/compress_packing" load "$out/nudged.txt" 0 "$speed" "$step" "$every" 265 > "$out/creepd_mu_0_nudged.csv"
"$bin/compress_packing" load "$out/start.txt" 0.275 "$speed" "$step" "$every" 130 > "$out/creepd_mu_0.275.csv"
lammps 0 mindlin/force 265 "$out/lammps_mu_0.csv"
lammps 0.275 mindlin/force 130 "$out/lammps_mu_0.275_force.csv"
lammps 0.275 mindlin 130 "$out/lammps_mu_0.275_spring.csv"
python3 "$here/compare.py" "$out" "$out/compression.svg"
