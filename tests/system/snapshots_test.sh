#!/usr/bin/env bash
# Pictures: whole, the same files and bytes after kills and after a full disk, none unless asked for.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
cp "$job" "$work/plain.toml"
printf '[output]\nsnapshots = "per decade of age"\n' >>"$job"
undisturbed
"$here/check_snapshots.py" "$reference/snapshots"

same_pictures() {
  same_result "$1"
  diff -r "$1/snapshots" "$reference/snapshots" || fail "$1: other pictures"
}

# Of the same run without them, too: pictures change nothing.
expect_exit 0 run_job "$work/plain" "$work/plain.toml"
same_result "$work/plain"
[[ ! -e "$work/plain/snapshots" ]] || fail "pictures without being asked for"

RANDOM=${CREEP_TEST_SEED:-20240}
folder=$work/killed
for i in 1 2 3 4 5 6; do
  [[ ! -e "$folder/verdict.json" ]] || break
  start_run "$folder"
  sleep "$(awk -v ms="$reference_ms" -v f=$((i * 100 + RANDOM % 100)) 'BEGIN { print ms * f / 1e6 }')"
  kill_run "$folder"
done
mkdir -p "$folder/snapshots"
printf 'half a picture' >"$folder/snapshots/contacts_02_creep_0001.vtp.tmp"
expect_exit 0 run_job "$folder"
same_pictures "$folder"

# No room for pictures alone.
folder=$work/full
start_run "$folder"
kill_run "$folder"
mkdir -p "$folder/snapshots"
if ! mount -t tmpfs -o size=72k tmpfs "$folder/snapshots" 2>/dev/null; then
  printf 'NOT TESTED: a full disk, which needs the right to mount a small tmpfs\n'
  exit 0
fi
mounted=$folder/snapshots
expect_exit 74 run_job "$folder"
expect_output 'No space left on device'
umount "$mounted"
mounted=
expect_exit 0 run_job "$folder"
same_pictures "$folder"
