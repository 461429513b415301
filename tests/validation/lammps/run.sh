#!/usr/bin/env bash
# run.sh BIN OUT: compresses one packing of 1500 smooth unbreakable spheres from 1 to 20 MPa, on all three axes alike and along
# z alone, here and in LAMMPS (Debian package lammps): same walls, same local damping, same step. OUT receives the curves;
# compare.py judges them. 77 if LAMMPS is not installed.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
bin=${1:?folder of compress_packing and settle_packing}
out=${2:?folder for the results}
command -v lmp > /dev/null || { echo "run.sh: LAMMPS is not installed: apt-get install lammps" >&2; exit 77; }
mkdir -p "$out"
export OMP_NUM_THREADS=1

step=2e-8  # [s]
wall=$(python3 -c 'print(4 / 3 * 32e9 / (1 - 0.19))')  # Hertz prefactor of a wall like between grains [Pa]

settle() { "$bin/settle_packing" "$1" "$2" 200000 1000000 1; }
# The same with the last digits of one coordinate changed: how far rounding alone carries two runs apart.
nudge() { awk 'NR == 1 { print; next } { printf "%.17g %s %s %s\n", $1 * (1 + 2e-15), $2, $3, $4 }' "$1"; }

settle "$here/../../bench/packing_1500.txt" 1e6 > "$out/start.txt"
nudge "$out/start.txt" > "$out/start_nudged.txt"

# Four times to 20 MPa and back without friction: the packing has found the arrangement that carries both.
cp "$here/../../bench/packing_1500.txt" "$out/trained.txt"
for _ in 1 2 3 4; do
  settle "$out/trained.txt" 20e6 > "$out/compacted.txt"
  settle "$out/compacted.txt" 1e6 > "$out/trained.txt"
done
nudge "$out/trained.txt" > "$out/trained_nudged.txt"

creepd() {  # load or isotropic, start, friction, closing speed along z [m/s], steps a row, rows, table
  "$bin/compress_packing" "$1" "$out/$2.txt" "$3" "$4" "$step" "$5" "$6" > "$out/$7.csv"
}
lammps() {  # the same, then the tangential law
  local x0 y0 z0 x1 y1 z1 speed_x=0 speed_y=0
  read -r x0 y0 z0 x1 y1 z1 < <(python3 "$here/lammps_data.py" "$out/$2.txt" "$out/data")
  if [[ $1 == isotropic ]]; then
    read -r speed_x speed_y < <(python3 -c "print($4 * ($x1 - $x0) / ($z1 - $z0), $4 * ($y1 - $y0) / ($z1 - $z0))")
  fi
  lmp -in "$here/in.lammps" -log none -screen none -var data "$out/data" -var x0 "$x0" -var x1 "$x1" -var y0 "$y0" \
    -var y1 "$y1" -var z0 "$z0" -var z1 "$z1" -var wall "$wall" -var friction "$3" -var tangential "$8" -var speed_x "$speed_x" \
    -var speed_y "$speed_y" -var speed_z "$4" -var step "$step" -var steps "$(($5 * $6))" -var every "$5" -var table "$out/$7.csv"
}
creepd isotropic trained 0 0.0125 800 85 creepd_isotropic_mu_0
creepd isotropic trained_nudged 0 0.0125 800 85 creepd_isotropic_mu_0_nudged
creepd isotropic trained 0.275 0.0125 800 74 creepd_isotropic_mu_0.275
creepd load start 0 0.05 200 265 creepd_mu_0
creepd load start_nudged 0 0.05 200 265 creepd_mu_0_nudged
creepd load start 0.275 0.05 200 130 creepd_mu_0.275
lammps isotropic trained 0 0.0125 800 85 lammps_isotropic_mu_0 mindlin/force
lammps isotropic trained 0.275 0.0125 800 74 lammps_isotropic_mu_0.275 mindlin/force
lammps load start 0 0.05 200 265 lammps_mu_0 mindlin/force
lammps load start 0.275 0.05 200 130 lammps_mu_0.275_force mindlin/force
lammps load start 0.275 0.05 200 130 lammps_mu_0.275_spring mindlin
python3 "$here/compare.py" "$out" "$out/compression.svg"
