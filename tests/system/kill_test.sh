#!/usr/bin/env bash
# kill -9 at ten random fractions of a run, one of them before the first checkpoint: the same command ends with the
# same bits.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
undisturbed
RANDOM=${CREEP_TEST_SEED:-20240}
printf 'undisturbed: %d ms\n' "$reference_ms"

folder=$work/early
start_run "$folder"
wait_for 20 test -s "$folder/samples.log"
has_checkpoint "$folder" && fail "there is a checkpoint before the first kill"
kill_run "$folder"
expect_exit 0 run_job "$folder"
same_result "$folder"
grep -qF 'attempt 2: begins from zero' "$folder/worker.log" || fail "the early kill did not begin from zero"

killed=0
for i in 1 2 3 4 5 6 7 8 9; do
  folder=$work/kill-$i
  # From the i-th ninth, so that no part of the run goes untried.
  fraction=$(((i - 1) * 1000 / 9 + RANDOM % 111))
  start_run "$folder"
  sleep "$(awk -v ms="$reference_ms" -v f="$fraction" 'BEGIN { print ms * f / 1e6 }')"
  kill_run "$folder"
  if [[ ! -e "$folder/verdict.json" ]]; then killed=$((killed + 1)); fi
  expect_exit 0 run_job "$folder"
  same_result "$folder"
  printf 'killed at %d/1000: %s\n' "$fraction" "$(grep -E 'attempt 2: (continues|begins|nothing)' "$folder/worker.log")"
  rm -rf "$folder"
done
# A machine that becomes faster meanwhile lets the last ones finish first.
((killed >= 5)) || fail "only $killed of 9 runs were alive when they were to be killed"

# Killed again and again: every attempt gets a little further.
folder=$work/often
for delay in 0.3 0.6 0.9 1.2; do
  start_run "$folder"
  sleep "$delay"
  kill_run "$folder"
done
expect_exit 0 run_job "$folder"
same_result "$folder"
