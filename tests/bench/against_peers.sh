#!/usr/bin/env bash
# against_peers.sh CREEP_BENCH PACKING [ROUNDS]: particle-steps per second of creep-bench and of LAMMPS (Debian's package) on
# the same packing, one core and two, in turn, and the ratio of the medians. Needs lmp and mpirun (apt install lammps).
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
bench=${1:?creep-bench}
packing=${2:?packing file}
rounds=${3:-5}
command -v lmp > /dev/null || { echo "against_peers.sh: LAMMPS is not installed: apt-get install lammps" >&2; exit 2; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
read -r lx ly lz < <(python3 "$here/peers/lammps_data.py" "$packing" "$work/data")
particles=$(grep -vc '^#' "$packing")
steps=$((11500 * 2000 / particles + 1))
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1

lammps() {  # cores
  local run=(lmp -in "$here/peers/in.lammps" -log none -var data "$work/data" -var steps "$steps" -var lx "$lx" -var ly "$ly" -var lz "$lz")
  if [ "$1" -gt 1 ]; then run=(mpirun --oversubscribe --bind-to none -np "$1" "${run[@]}"); fi
  "${run[@]}" | awk '/Loop time/ {printf "%.4e\n", $12 * $9 / $4}'
}
creepd() { "$bench" --packing "$packing" --threads "$1" --rounds 1 --steps "$steps" $2 | awk '{last = $NF} END {print last}'; }
median() { sort -g | awk '{v[NR] = $1} END {print v[int((NR + 1) / 2)]}'; }

for cores in 1 2; do
  : > "$work/lammps"; : > "$work/rough"; : > "$work/smooth"
  for ((round = 0; round < rounds; ++round)); do
    lammps "$cores" >> "$work/lammps"
    creepd "$cores" "" >> "$work/rough"
    creepd "$cores" --smooth >> "$work/smooth"
  done
  l=$(median < "$work/lammps") r=$(median < "$work/rough") s=$(median < "$work/smooth")
  awk -v c="$cores" -v n="$particles" -v l="$l" -v r="$r" -v s="$s" 'BEGIN {
    printf "%d particles, %d core(s): LAMMPS %.3e, creepd rough %.3e (ratio %.2f), creepd smooth %.3e (ratio %.2f)\n", n, c, l, r, r / l, s, s / l }'
done
