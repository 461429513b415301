#!/usr/bin/env bash
# A disk that becomes full: exit 74, every checkpoint good, and the same command goes on once there is room.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
mkdir "$work/disk"
mount -t tmpfs -o size=4m tmpfs "$work/disk" 2>/dev/null || skip "needs the right to mount a small tmpfs"
mounted=$work/disk
undisturbed

folder=$work/disk/run
start_run "$folder"
wait_for 60 has_checkpoint "$folder"
dd if=/dev/zero of="$work/disk/ballast" bs=4k 2>/dev/null || true
got=0
wait "$run" || got=$?
((got == 74)) || {
  cat "$work/output" >&2
  fail "run ended with $got instead of 74"
}
expect_output 'No space left on device'
expect_exit 0 "$bin/creepctl" checkpoint show "$folder"

# Still full: still 74, and nothing is lost.
expect_exit 74 run_job "$folder"
expect_exit 0 "$bin/creepctl" checkpoint show "$folder"

rm "$work/disk/ballast"
expect_exit 0 run_job "$folder"
same_result "$folder"
grep -qF 'continues from checkpoint' "$folder/worker.log" || fail "it began from zero"

# Full from the start: no directory that looks like a run is left behind by a job file that did not fit.
dd if=/dev/zero of="$work/disk/ballast" bs=4k 2>/dev/null || true
expect_exit 74 run_job "$work/disk/second"
rm "$work/disk/ballast"
expect_exit 0 run_job "$work/disk/second"
same_result "$work/disk/second"
