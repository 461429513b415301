#!/usr/bin/env bash
# Pictures: whole, the same files and bytes after kills and after a full disk, none unless asked for.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
printf '[output]\nsnapshots = "per decade of age"\n' >>"$job"
undisturbed
"$here/check_snapshots.py" "$reference/snapshots"

same_pictures() {
  same_result "$1"
  diff -r "$1/snapshots" "$reference/snapshots" || fail "$1: other pictures"
}

# Of the same run without them, too: pictures change nothing.
grep -vF -e '[output]' -e 'snapshots = ' "$job" >"$work/plain.toml"
expect_exit 0 run_job "$work/plain" "$work/plain.toml"
same_result "$work/plain"
[[ ! -e "$work/plain/snapshots" ]] || fail "pictures without being asked for"

# Killed after some pictures, not after some time: on any machine the run is far from its end then.
has_pictures() { (($(find "$folder/snapshots" -name '*.vtp' 2>/dev/null | wc -l) >= $1)); }
has_pictures_or_ends() { has_pictures "$1" || [[ -e "$folder/verdict.json" ]]; }
folder=$work/killed
for pictures in 1 3 5; do
  start_run "$folder"
  wait_for 60 has_pictures_or_ends "$pictures"
  kill_run "$folder"
  if ((pictures == 1)); then
    [[ ! -e "$folder/verdict.json" ]] || fail "the run ended before it could be killed"
    printf 'half a picture' >"$folder/snapshots/contacts_02_creep_0001.vtp.tmp"
  fi
done
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
