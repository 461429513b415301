#!/usr/bin/env bash
# The list of attempts is true after kills of worker and daemon, a former worker that does not end keeps only its own
# job waiting, and many jobs are deleted at once.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
source "$(dirname "${BASH_SOURCE[0]}")/daemon_support.sh"

lengthen 5
undisturbed

# attempt ID N PATTERN: the line of the table.
attempt() { creepctl show "$1" --attempts | grep -qE "^ *$2  +$3"; }

step "kill -9 of the worker"
start_daemon --checkpoint-interval 0.2
id=$(submit)
wait_for 30 has_checkpoint "$(folder_of "$id")"
worker=$(worker_of "$(folder_of "$id")")
attempt "$id" 1 "RUNNING .* local +process $worker" || fail "attempt 1 is not told as running: $(creepctl show "$id" --attempts)"
kill -9 "$worker"
wait_for 30 attempt "$id" 1 "ENDED .* process $worker +signal 9 "
wait_for 30 attempt "$id" 2 RUNNING

step "kill -9 of the daemon"
kill_daemon
start_daemon --checkpoint-interval 0.2
wait_for 30 attempt "$id" 2 "ENDED .* the daemon was stopped"
wait_for 30 attempt "$id" 3 RUNNING

step "kill -9 of both at once, as a power cut would"
worker=$(worker_of "$(folder_of "$id")")
kill -9 "$daemon" "$worker"
wait "$daemon" 2>/dev/null || true
start_daemon --checkpoint-interval 0.2
wait_for 30 attempt "$id" 3 ENDED
wait_for 30 attempt "$id" 4 RUNNING
succeeded "$id"
wait_for 10 attempt "$id" 4 "ENDED .* 0 "
creepctl show "$id" --attempts --json >"$work/attempts"
[[ $(grep -c '"number"' "$work/attempts") == 4 ]] || fail "not four attempts: $(cat "$work/attempts")"
[[ $(sed -nE 's/^ *"number": ([0-9]+),$/\1/p' "$work/attempts" | xargs) == "1 2 3 4" ]] || fail "not in order"
[[ $(grep -c '"state": "ATTEMPT_ENDED"' "$work/attempts") == 4 ]] || fail "some have not ended"
grep -q '"signal": 9' "$work/attempts" || fail "the signal is not told"

step "a worker of the last daemon that does not end: its job waits, the others do not"
id=$(submit)
wait_for 30 computes "$id"
worker=$(worker_of "$(folder_of "$id")")
kill -9 "$daemon" "$worker"
wait "$daemon" 2>/dev/null || true
exec 9<>"$(folder_of "$id")/lease"
wait_for 30 flock --nonblock 9
started=$SECONDS
"$bin/creepd" --slots 2 --threads-per-job 1 --state "$state" --least-free 0 >>"$work/daemon.log" 2>&1 9>&- &
daemon=$!
wait_for 10 serves
((SECONDS - started < 10)) || fail "the daemon was kept from serving"
is "$id" RUNNING || fail "the job is $(field "$id" state)"
creepctl show "$id" | grep -q "waits for its former worker, process $worker" || fail "it is not told: $(creepctl show "$id")"
other=$(submit)
succeeded "$other"
expect_exit 0 creepctl cancel "$id"
expect_output "cancel requested"
stop_daemon  # it does not wait for that worker either
start_daemon 9>&-
has_reason "$id" CANCEL_REQUESTED || fail "the wish to cancel is gone"
exec 9>&-
wait_for 20 is "$id" CANCELLED

step "many deletions in one call"
ids=()
for _ in {1..30}; do ids+=("$(submit)"); done
waiting=$(submit)
expect_exit 0 creepctl cancel "${ids[@]}" --now
cancelled() { [[ $(creepctl ls --state cancelled --quiet | wc -l) -ge 31 ]]; }
wait_for 30 cancelled
expect_exit 1 creepctl delete "${ids[@]:0:10}" "$waiting"
expect_output "$waiting is"
[[ $(grep -c ': deleted$' "$work/output") == 10 ]] || fail "the others were not deleted"
expect_exit 0 creepctl delete --all-final --older-than "1 d"
[[ $(creepctl ls --state cancelled --quiet | wc -l) -ge 21 ]] || fail "young jobs were deleted"
expect_exit 2 creepctl delete
expect_exit 2 creepctl delete "$waiting" --all-final
expect_exit 2 creepctl delete --older-than "1 d"
expect_exit 0 creepctl delete --all-final
[[ $(creepctl ls --quiet) == "$waiting" ]] || fail "what is left: $(creepctl ls)"
[[ $(ls "$state/jobs") == "$waiting" ]] || fail "folders are left: $(ls "$state/jobs")"
expect_exit 0 creepctl cancel "$waiting" --now
stop_daemon
