#!/usr/bin/env bash
# What a service manager learns from creepd: ready when recovery is over and the socket is open, a sign of life as long
# as the thread that owns the workers turns, stopping.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
source "$(dirname "${BASH_SOURCE[0]}")/daemon_support.sh"
command -v python3 >/dev/null || skip "no python3"

sed -i 's/minimum_cycles = 3000/minimum_cycles = 60000/' "$job"
export NOTIFY_SOCKET=$work/run/notify WATCHDOG_USEC=2000000
unset WATCHDOG_PID
told=$work/told
python3 "$here/notify_receiver.py" "$NOTIFY_SOCKET" "$socket" >"$told" &
receiver=$!
stop_receiver() {
  kill "$receiver" 2>/dev/null || true
  stop_daemon_and_clean_up
}
trap stop_receiver EXIT
wait_for 10 test -S "$NOTIFY_SOCKET"

says() { grep -qx -- "$1" "$told"; }
signs_of_life() { grep -cx 'WATCHDOG=1' "$told" || true; }
more_signs_than() { (($(signs_of_life) > $1)); }

step "ready, and alive"
start_daemon --checkpoint-interval 0.2
wait_for 10 says "READY=1 open"
wait_for 20 more_signs_than 2
wait_for 10 says "STATUS=0 of 2 slots in use"
id=$(submit)
folder=$(folder_of "$id")
wait_for 30 computes "$id"
wait_for 10 says "STATUS=1 of 2 slots in use"

step "no sign of life from a supervisor that hangs, though callers are answered"
kill -STOP "$(worker_of "$folder")"
rm "$folder/progress.json"
mkfifo "$folder/progress.json"  # whoever opens it to read waits for a writer
until_it_hangs() {
  local before
  before=$(signs_of_life)
  sleep 3  # three signs of life are due
  (($(signs_of_life) == before))
}
wait_for 30 until_it_hangs
expect_exit 0 creepctl ls
before=$(signs_of_life)
: >"$folder/progress.json"
rm "$folder/progress.json"
wait_for 20 more_signs_than "$before"

step "ready though a worker of the last daemon does not end"
# The test itself stands in for a worker that still has the job: one that is stopped may be woken by the kernel when its
# daemon dies.
kill -CONT "$(worker_of "$folder")"
kill_daemon
exec 9<>"$folder/lease"
wait_for 30 flock --nonblock 9
: >"$told"
"$bin/creepd" --slots 2 --threads-per-job 1 --state "$state" --least-free 0 >>"$work/daemon.log" 2>&1 9>&- &
daemon=$!
wait_for 20 grep -q "job $id: waits for its former worker" "$work/daemon.log"
wait_for 10 says "STATUS=recovering the jobs of the last creepd"
wait_for 10 says "READY=1 open"
exec 9>&-

step "stopping"
stop_daemon
wait_for 10 says "STOPPING=1"
! grep -q closed "$told" || fail "ready with the socket closed"
