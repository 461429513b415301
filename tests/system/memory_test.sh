#!/usr/bin/env bash
# The memory estimate by which jobs are admitted, against the highest resident memory of real workers: never below it,
# and not three times as much. Mid-size jobs, through packing, loading, crushing, checkpoints and pictures.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
source "$(dirname "${BASH_SOURCE[0]}")/daemon_support.sh"

# spec PARTICLES STRESS SNAPSHOTS
spec() {
  sed -E "s/particles = 300/particles = $1/; s/15 MPa/$2/; s/void_ratio = 0.75/void_ratio = 0.65/" "$job"
  printf '[output]\nsnapshots = "%s"\n' "$3"
}
spec 3000 "21.7 MPa" none >"$work/plain.toml"
spec 2000 "40 MPa" "per decade of age" >"$work/pictures.toml"

# Two slots: both run at once. A checkpoint every second.
start_daemon --checkpoint-interval 1
declare -A highest=()
ids=()
for name in plain pictures; do
  ids+=("$(creepctl submit "$work/$name.toml" 2>/dev/null)")
  highest[${ids[-1]}]=0
done

# keep_highest ID: what the kernel says of its worker, in bytes, as long as there is one.
keep_highest() {
  local process kibibytes
  process=$(worker_of "$(folder_of "$1")")
  [[ -n "$process" ]] || return 0
  kibibytes=$(sed -nE 's/^VmHWM:\s+([0-9]+) kB$/\1/p' "/proc/$process/status" 2>/dev/null || true)
  if ((${kibibytes:-0} * 1024 > highest[$1])); then highest[$1]=$((kibibytes * 1024)); fi
}
all_ended() {
  local id
  for id in "${ids[@]}"; do keep_highest "$id"; done
  for id in "${ids[@]}"; do is "$id" SUCCEEDED || return 1; done
}
wait_for 400 all_ended
for id in "${ids[@]}"; do
  estimate=$(field "$id" memory_estimate_bytes)
  printf '%s: highest %d bytes, estimate %d bytes\n' "$id" "${highest[$id]}" "$estimate"
  ((highest[$id] > 10 << 20)) || fail "$id: its worker was not seen"
  ((highest[$id] <= estimate)) || fail "$id: takes ${highest[$id]} bytes, more than its estimate of $estimate"
  ((3 * highest[$id] >= estimate)) || fail "$id: takes ${highest[$id]} bytes, the estimate of $estimate is too high"
done
stop_daemon
