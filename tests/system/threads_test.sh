#!/usr/bin/env bash
# Two threads give the bits of one, also when the number changes in the middle of a run.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
undisturbed
expect_exit 0 "$bin/creepctl" run "$job" --out "$work/two" --threads 2
same_result "$work/two"

folder=$work/changed
start_run "$folder"
wait_for 60 has_checkpoint "$folder"
kill_run "$folder"
expect_exit 0 "$bin/creepctl" run "$job" --out "$folder" --threads 2
same_result "$folder"
