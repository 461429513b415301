#!/usr/bin/env bash
# Ten kills at random moments in one job, of the worker, of the daemon or of both: it ends with the digest of an
# undisturbed run, its records without gap or repeat, and a watcher sees every event number once.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
source "$(dirname "${BASH_SOURCE[0]}")/daemon_support.sh"
RANDOM=${CREEP_TEST_SEED:-4711}
TIMEFORMAT=%U

# Ten kills need a job that outlives them on any machine: its undisturbed run takes at least 12 s of one processor,
# which another process beside it does not lengthen as it does wall time.
cycles=25000
while true; do
  sed -i "s/minimum_cycles = .*/minimum_cycles = $cycles/" "$job"
  { time undisturbed; } 2>"$work/processor_seconds"
  taken=$(awk '{ print int($1 * 1000) }' "$work/processor_seconds")
  printf 'undisturbed with %d cycles a stage: %d ms of a processor\n' "$cycles" "$taken"
  ((taken < 12000)) || break
  rm -r "$reference"
  cycles=$((cycles * 15000 / taken))
done
start_daemon --checkpoint-interval 0.2
id=$(submit)
folder=$(folder_of "$id")
creepctl watch "$id" --after 0 --json >"$work/events" 2>"$work/said" &
watch=$!
wait_for 30 computes "$id"

# A worker that was killed twice in a row is given some seconds.
works_or_is_done() { kill -0 "$(worker_of "$folder")" 2>/dev/null || is "$id" SUCCEEDED; }
kills=0
for i in 1 2 3 4 5 6 7 8 9 10; do
  wait_for 90 works_or_is_done
  sleep "0.$((RANDOM % 5 + 1))"
  if is "$id" SUCCEEDED; then break; fi
  worker=$(worker_of "$folder")
  case $((RANDOM % 3)) in
    0)
      kill -9 "$worker" 2>/dev/null || true
      what=worker
      ;;
    1)
      kill_daemon
      start_daemon --checkpoint-interval 0.2
      what=daemon
      ;;
    2)
      kill -9 "$worker" "$daemon" 2>/dev/null || true
      wait "$daemon" 2>/dev/null || true
      start_daemon --checkpoint-interval 0.2
      what=both
      ;;
  esac
  kills=$((kills + 1))
  step "kill $i: $what"
done
succeeded "$id"
wait "$watch" || fail "watch ended with $?"
numbers_once "$work/events"
last=$(tail -n 1 "$work/numbers")
[[ "$last" == "$(field "$id" last_seq)" ]] || fail "the last event seen is $last of $(field "$id" last_seq)"
[[ $(grep -c '"state": *"SUCCEEDED"' "$work/events") == 1 ]] || fail "not exactly one final state"
((kills == 10)) || fail "only $kills kills before the job was done"
step "$kills kills, $(field "$id" attempts) attempts counted, $last events"
