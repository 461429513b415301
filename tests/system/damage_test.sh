#!/usr/bin/env bash
# Flipped bits and torn files in a job directory: a fall back with word of it, or a loud end; never another result.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
undisturbed

# flip FILE: one bit in its middle.
flip() {
  local at=$(($(stat -c %s "$1") / 2)) byte
  byte=$(od -An -tu1 -j "$at" -N 1 "$1")
  # shellcheck disable=SC2059  # the format is the byte itself
  printf "\\x$(printf %02x $((byte ^ 1)))" | dd of="$1" bs=1 seek="$at" conv=notrunc 2>/dev/null
}

has_two_checkpoints() { (($(ls "$1/checkpoints" 2>/dev/null | grep -cE '^ck\.[0-9]+$') >= 2)); }
newest() { ls "$1"/checkpoints/ck.* | sort -V | tail -n 1; }

half=$work/half
start_run "$half"
wait_for 60 has_two_checkpoints "$half"
kill_run "$half"

# The newest checkpoint damaged: the one before, and worker.log says so.
folder=$work/newest
cp -r "$half" "$folder"
damaged=$(newest "$folder")
flip "$damaged"
expect_exit 5 "$bin/creepctl" checkpoint show "$damaged"
expect_output 'damaged'
expect_exit 0 run_job "$folder"
same_result "$folder"
grep -qF "checkpoint ${damaged##*.} is set aside" "$folder/worker.log" || fail "the fall back is not in worker.log"

# The newest one cut short.
folder=$work/short
cp -r "$half" "$folder"
truncate -s 100 "$(newest "$folder")"
expect_exit 0 run_job "$folder"
same_result "$folder"

# All damaged: never silently from zero.
folder=$work/all
cp -r "$half" "$folder"
for file in "$folder"/checkpoints/ck.*; do flip "$file"; done
expect_exit 74 run_job "$folder"
expect_output 'no checkpoint is good'

# The newest one in the format of a newer program: no damage, and nothing of it is touched.
folder=$work/newer
cp -r "$half" "$folder"
newer=$(newest "$folder")
printf '\xff' | dd of="$newer" bs=1 seek=8 conv=notrunc 2>/dev/null
truncate -s -7 "$folder/samples.log"
before=$(cat "$folder"/checkpoints/* "$folder"/samples.{log,csv} | sha256sum)
expect_exit 1 run_job "$folder"
expect_output 'was made by a newer program'
grep -qF '"exit_code": 70' "$folder/verdict.json" || fail "the verdict does not say 70"
[[ -e "$newer" ]] || fail "the checkpoint of a newer program was set aside"
[[ $(cat "$folder"/checkpoints/* "$folder"/samples.{log,csv} | sha256sum) == "$before" ]] ||
  fail "files of a newer program were touched"

# The log torn in its last record, and cut so far back that no checkpoint can follow it.
folder=$work/torn
cp -r "$half" "$folder"
truncate -s -7 "$folder/samples.log"
expect_exit 0 run_job "$folder"
same_result "$folder"
folder=$work/cut
cp -r "$half" "$folder"
truncate -s 500 "$folder/samples.log"
expect_exit 74 run_job "$folder"

# Records of another run: a loud end, or superseded when that is allowed.
sed 's/void_ratio = 0.75/void_ratio = 0.75\nseed = 2/' "$job" >"$work/other.toml"
folder=$work/mixed
start_run "$folder" "$work/other.toml"
wait_for 60 has_checkpoint "$folder"
kill_run "$folder"
cp "$job" "$folder/job.toml"
expect_exit 1 run_job "$folder"
expect_output 'another experiment'
rm -r "$folder/checkpoints"
expect_exit 1 run_job "$folder"
expect_output 'differs from the one in samples.log'
grep -qF '"exit_code": 70' "$folder/verdict.json" || fail "the verdict does not say 70"
expect_exit 0 run_job "$folder" "$job" --allow-inexact
same_result "$folder"
