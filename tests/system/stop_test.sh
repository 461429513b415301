#!/usr/bin/env bash
# Stopping in good order, continuing, and everything `run` refuses to do in a directory.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
undisturbed

expect_code_of_run() {
  local got=0
  wait "$run" || got=$?
  ((got == $1)) || {
    cat "$work/output" >&2
    fail "run ended with $got instead of $1"
  }
}

# SIGTERM to run: 75 and a good checkpoint, then on by the same command.
folder=$work/stopped
start_run "$folder"
wait_for 60 has_checkpoint "$folder"
kill -TERM "$run"
expect_code_of_run 75
grep -qF '"exit_code": 75' "$folder/verdict.json" || fail "the verdict does not say 75"
expect_exit 0 "$bin/creepctl" checkpoint show "$folder"
expect_output 'good, every checksum verified'

# run killed alone: the worker notices, checkpoints and ends; the next run waits for it.
start_run "$folder"
worker=$(worker_of "$folder")
sleep 0.2
kill -9 "$run"
wait "$run" 2>/dev/null || true
expect_exit 0 run_job "$folder"
kill -0 "$worker" 2>/dev/null && fail "the worker outlived its run"
same_result "$folder"
grep -qF "end of the parent's pipe" "$folder/worker.log" || fail "the worker did not say why it stopped"

# Finished: nothing is done, nothing is changed.
before=$(cat "$folder"/{samples.csv,samples.log,summary.json,verdict.json} | sha256sum)
expect_exit 0 run_job "$folder"
expect_output 'nothing to do'
[[ $(cat "$folder"/{samples.csv,samples.log,summary.json,verdict.json} | sha256sum) == "$before" ]] ||
  fail "a finished run was changed"

# Another job file, files of somebody else, no directory.
sed 's/particles = 300/particles = 301/' "$job" >"$work/other.toml"
expect_exit 5 run_job "$folder" "$work/other.toml"
expect_output 'another job file'
mkdir "$work/foreign"
echo mine >"$work/foreign/thesis.txt"
expect_exit 5 run_job "$work/foreign"
[[ $(ls "$work/foreign") == thesis.txt ]] || fail "a foreign directory was written to"
expect_exit 5 run_job "$work/foreign/thesis.txt"

# One worker at a time; the second leaves everything alone.
folder=$work/two
start_run "$folder"
expect_exit 69 "$bin/creep-worker" "$folder" --threads 1
expect_output 'is in use by another worker (attempt 1, process'
kill -INT "$run"
expect_code_of_run 75

# The worker alone, stopped by the end of its parent's pipe.
mkfifo "$work/pipe"
"$bin/creep-worker" "$folder" --threads 1 --parent-pipe 9 9<>"$work/pipe" &
worker=$!
sleep 0.2
kill -0 "$worker" || fail "the worker ended although its pipe was open"
kill -TERM "$worker"
got=0
wait "$worker" || got=$?
((got == 75)) || fail "creep-worker ended with $got instead of 75 after SIGTERM"
got=0
"$bin/creep-worker" "$folder" --threads 1 --parent-pipe 9 9</dev/null || got=$?
((got == 75)) || fail "creep-worker ended with $got instead of 75 at the end of its pipe"
expect_exit 0 run_job "$folder"
same_result "$folder"
