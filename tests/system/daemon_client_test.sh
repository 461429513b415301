#!/usr/bin/env bash
# creepctl and creepd, the real ones: every command, wrong inputs, a relayed socket, a daemon that is killed while it is
# watched, TCP with certificates. Results are those of `creepctl run`, bit for bit.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
[[ -x "$bin/creepd" ]] || skip "no creepd"

export XDG_RUNTIME_DIR=$work/run XDG_STATE_HOME=$work/state
unset CREEPCTL_SERVER CREEPCTL_TLS_CA CREEPCTL_TLS_CERT CREEPCTL_TLS_KEY
mkdir -m 700 "$XDG_RUNTIME_DIR" "$XDG_STATE_HOME"
socket=$XDG_RUNTIME_DIR/creepd.sock
daemon=
relay=
stop_all() {
  local process
  for process in $daemon $relay; do kill -9 "$process" 2>/dev/null || true; done
  # Workers end by themselves when their daemon is gone.
  wait 2>/dev/null || true
  clean_up
}
trap stop_all EXIT

creepctl() { "$bin/creepctl" "$@"; }
step() { printf '%3d s: %s\n' "$SECONDS" "$*"; }
start_daemon() {
  "$bin/creepd" --slots 2 --threads-per-job 1 "$@" >>"$work/daemon.log" 2>&1 &
  daemon=$!
  wait_for 20 test -S "$socket"
}
kill_daemon() {
  kill -9 "$daemon"
  wait "$daemon" 2>/dev/null || true
}
# stop_daemon: as a service manager does; must end well.
stop_daemon() {
  kill -TERM "$daemon"
  wait "$daemon" || fail "creepd did not end with 0 on SIGTERM"
  daemon=
}
start_relay() {
  /usr/bin/python3 "$here/relay.py" "$work/relay.sock" "$socket" 2>/dev/null &
  relay=$!
  wait_for 10 test -S "$work/relay.sock"
}
state_of() { creepctl show "$1" --json | sed -nE 's/^  "state": "([A-Z]+)",$/\1/p'; }
is() { [[ $(state_of "$1") == "$2" ]]; }
computes() { creepctl show "$1" --json | grep -q '"latest_sample"'; }
# same_job ID: what is fetched of it is that of the undisturbed run.
same_job() {
  expect_exit 0 creepctl fetch "$1" --out "$work/fetched-$1"
  expect_output "verified"
  same_result "$work/fetched-$1"
}
# numbers_once FILE: the events in it are 1, 2, 3, ..., save for what the daemon says it skipped.
numbers_once() {
  sed -nE 's/^\{"seq":([0-9]+),"skipped":([0-9]+),.*/\1 \2/p' "$1" >"$work/numbers"
  awk '{ if ($1 != last + 1 + $2) exit 1; last = $1 } END { if (NR < 10) exit 1 }' "$work/numbers" ||
    fail "the events in $1 have a gap or a repeat"
}

# About one and a half seconds of computing, so that there is time to meddle.
sed -i 's/minimum_cycles = 3000/minimum_cycles = 12000/' "$job"
undisturbed
start_daemon

step "round trip"
id=$(creepctl submit "$job" --label sand=ne34 --request-id once 2>/dev/null)
[[ "$id" =~ ^[A-Za-z0-9][A-Za-z0-9-]{3,}$ ]] || fail "submit printed: $id"
[[ $(creepctl submit "$job" --label sand=ne34 --request-id once 2>/dev/null) == "$id" ]] || fail "submitted twice"
creepctl watch "$id" >"$work/watched" 2>&1 &
watch=$!
creepctl logs -f "$id" >"$work/log" &
logs=$!
wait_for 20 computes "$id"
expect_exit 0 creepctl fetch "$id" --out "$work/fetched-$id"  # half of it; the rest is brought by same_job
wait "$watch" || fail "watch: $?"
grep -q 'creep, dynamic stage .*strain .*particle-steps/s' "$work/watched" || fail "watch shows no progress"
grep -q "$id: SUCCEEDED" "$work/watched" || fail "watch does not say how it ended"
grep -q $'[\x1b\r]' "$work/watched" && fail "escapes in a pipe"
expect_exit 0 creepctl wait "$id"
same_job "$id"
expect_exit 0 creepctl fetch "$id" --out "$work/fetched-$id"
expect_output "there already"
wait "$logs" || fail "logs -f"
cmp "$work/log" "$work/fetched-$id/worker.log" || fail "logs -f is not the log"
expect_exit 0 creepctl report "$work/fetched-$id"
creepctl show "$id" --spec | cmp - "$job" || fail "the job file is not as sent"
expect_exit 0 creepctl show "${id:0:7}"
expect_output "$(digest_of "$reference")"
[[ $(creepctl ls -q --label sand=ne34 --state succeeded) == "$id" ]] || fail "ls by label and state"
[[ -z $(creepctl ls -q --label sand=other) ]] || fail "ls of another label"
creepctl ls --json | /usr/bin/python3 -m json.tool >/dev/null || fail "ls --json is no JSON"
creepctl watch "$id" --after 0 --json >"$work/events"
numbers_once "$work/events"
expect_exit 0 creepctl doctor
completes() {
  bash -c 'PATH=$1:$PATH; source <(creepctl completion bash); COMP_WORDS=(creepctl show ""); COMP_CWORD=2; _creepctl
    echo "${COMPREPLY[*]}"' - "$bin" | grep -qF "$id"
}
wait_for 20 completes  # on a busy machine the list may take longer than a completion waits

step "pause, resume, fork, cancel, delete"
id=$(creepctl submit "$job" 2>/dev/null)
wait_for 20 computes "$id"
expect_exit 0 creepctl pause "$id"
wait_for 20 is "$id" PAUSED
expect_exit 6 creepctl wait "$id" --timeout 0.3
expect_exit 0 creepctl resume "$id"
fork=$(creepctl fork "$id")
cancelled=$(creepctl submit "$job" --priority 5 2>/dev/null)
expect_exit 1 creepctl delete "$cancelled"
expect_output "cancel it first"
# All that is wrong is told: a checkpoint that is missing hides no other mistake.
expect_exit 5 creepctl fork "$cancelled"
expect_output "the job has no checkpoint yet"
expect_exit 5 creepctl fork "$cancelled" --set foo=1
expect_output "the job has no checkpoint yet"
expect_output "unknown key \"foo\""
# The answer to a submission says where in the queue the job stands.
waiting=$(creepctl submit "$job" --priority -5 --request-id waits --json)
grep -qE '"queue_position": "?[1-9]' <<<"$waiting" || fail "no place in the queue: $waiting"
expect_exit 0 creepctl logs "$(creepctl submit "$job" --priority -5 --request-id waits 2>/dev/null)"
expect_output "has no log: it is QUEUED"
forked=$(creepctl fork "$id" --priority -6 --request-id forks --json)
grep -qE '"queue_position": "?[1-9]' <<<"$forked" || fail "no place in the queue for a fork: $forked"
expect_exit 0 creepctl cancel "$(creepctl fork "$id" --priority -6 --request-id forks)"
expect_exit 0 creepctl cancel "$(creepctl submit "$job" --priority -5 --request-id waits 2>/dev/null)"
expect_exit 0 creepctl cancel "$cancelled"
expect_exit 3 creepctl wait "$cancelled"
expect_exit 3 creepctl watch "$cancelled"
expect_exit 1 creepctl resume "$cancelled"
expect_exit 0 creepctl wait "$id"
same_job "$id"
expect_exit 0 creepctl wait "$fork"
same_job "$fork"
expect_exit 0 creepctl delete "$cancelled" "$fork"
expect_exit 5 creepctl show "$cancelled"

step "wrong inputs"
expect_exit 5 creepctl show nothere
expect_output 'there is no job "nothere"'
expect_exit 5 creepctl watch nothere
expect_exit 5 creepctl delete "$id" nothere
is "$id" SUCCEEDED || fail "delete did half of what it was asked"
sed 's/void_ratio = 0.75/void_ratio = "0.75 MPa"/' "$job" >"$work/bad.toml"
expect_exit 5 creepctl submit "$work/bad.toml"
grep -qE "^$work/bad.toml:4:[0-9]+: error: " "$work/output" || fail "no FILE:LINE:COL"
expect_exit 5 creepctl submit "$job" --label Bad=1
expect_exit 0 creepctl submit "$job" --validate-only
expect_exit 2 creepctl submit "$job" --label none
expect_exit 2 creepctl ls --limit -3
expect_exit 2 creepctl submit "$job" --label sand=a --label sand=b
expect_output "given twice"
expect_exit 2 creepctl ls --limit 0
[[ $(creepctl ls -q --limit 1 | wc -l) == 1 ]] || fail "ls --limit 1"
expect_exit 2 creepctl watch "$id" --after -1
expect_exit 5 creepctl watch "$id" --after 999999
expect_output "whose last event is"
expect_exit 5 creepctl submit "$job" --request-id 'a b'
[[ $(grep -c "printable characters" "$work/output") == 1 ]] || fail "one mistake is told twice"
for option in --memory --least-free --max-jobs --slots --stall-limit; do
  expect_exit 2 "$bin/creepd" --state "$work/never" "$option" -1
done
# More than 32 bits, which cut short would be another user, root here.
expect_exit 2 "$bin/creepd" --state "$work/never" --allow-user 4294967296
expect_exit 2 "$bin/creepd" --state "$work/never" --allow-user 4294967295
# As which the kernel names everybody whom the user namespace of creepd does not know.
for user in "$(</proc/sys/kernel/overflowuid)" nobody; do
  expect_exit 2 "$bin/creepd" --state "$work/never" --allow-user "$user"
  expect_output "whose number it cannot map"
done
[[ ! -e "$work/never" ]] || fail "a refused option left a state folder"
expect_exit 2 creepctl ls --server nowhere
expect_exit 2 creepctl ls --server http://localhost:7443
expect_output "is a URL"
expect_exit 2 creepctl ls --server "$work"
expect_output "is no socket"
expect_exit 2 creepctl wait "$id" --timeout soon
expect_exit 2 creepctl wait "$id" --timeout -3
expect_output "negative"
expect_exit 5 creepctl fetch "$id" --out "$here"
expect_output "holds other files"

step "a relayed socket that breaks, a daemon that is killed"
start_relay
export CREEPCTL_SERVER=$work/relay.sock
id=$(creepctl submit "$job" 2>/dev/null)
# Held, so that it is not over before the relay breaks.
wait_for 20 has_worker "$XDG_STATE_HOME/creepd/jobs/$id"
held=$(worker_of "$XDG_STATE_HOME/creepd/jobs/$id")
kill -STOP "$held"
creepctl watch "$id" --after 0 --json >"$work/events" 2>"$work/said" &
watch=$!
creepctl wait "$id" >"$work/waited" 2>&1 &
waiter=$!
wait_for 20 grep -q '"state":"RUNNING"' "$work/events"
kill -9 "$relay"
wait "$relay" 2>/dev/null || true
wait_for 20 grep -q 'lost the daemon' "$work/said"
start_relay
wait_for 20 grep -q 'connected again' "$work/said"
kill -CONT "$held"
wait_for 20 grep -q sample "$work/events"
kill_daemon
(
  unset CREEPCTL_SERVER
  creepctl ls >"$work/patient" 2>&1  # asked while there is no daemon, answered by the next
) &
patient=$!
sleep 0.5
start_daemon
wait "$patient" || fail "ls did not wait for the daemon"
wait "$watch" || fail "watch ended with $? over a restart"
wait "$waiter" || fail "wait ended with $? over a restart"
numbers_once "$work/events"
grep -q '"state":"SUCCEEDED"' "$work/events" || fail "watch missed the end"
same_job "$id"
unset CREEPCTL_SERVER

step "restored from a backup; certificates"
"$here/../../deploy/certificates.sh" "$work/tls" 127.0.0.1 alice bob >"$work/output"
"$here/../../deploy/certificates.sh" "$work/other" 127.0.0.1 mallory >"$work/output"
creepctl ls -q >"$work/ids"
stop_daemon
# A backup of a stopped daemon is the state of another one.
mv "$XDG_STATE_HOME/creepd" "$work/moved"
tar -C "$work" -cf "$work/backup.tar" moved
mkdir "$work/restored"
tar -C "$work/restored" -xf "$work/backup.tar"
port=$((20000 + RANDOM % 20000))
start_daemon --state "$work/restored/moved" --listen "127.0.0.1:$port" --tls-cert "$work/tls/server.crt" \
  --tls-key "$work/tls/server.key" --tls-client-ca "$work/tls/ca.crt"
creepctl ls -q | cmp - "$work/ids" || fail "the restored daemon knows other jobs"
# as USER [FOLDER [CA]]: the options of a user with a certificate of a folder.
as() {
  local folder=$work/${2:-tls}
  who=(--server "127.0.0.1:$port" --tls-ca "$work/${3:-tls}/ca.crt" --tls-cert "$folder/$1.crt" --tls-key "$folder/$1.key")
}
as alice
id=$(creepctl submit "$work/tiny.toml" "${who[@]}" 2>/dev/null) || fail "alice cannot submit"
creepctl show "$id" "${who[@]}" >"$work/output"
expect_output "tls:alice"
expect_exit 0 creepctl cancel "$id" --now "${who[@]}"
expect_exit 3 creepctl wait "$id" "${who[@]}"
as bob
expect_exit 5 creepctl show "$id" "${who[@]}"
[[ -z $(creepctl ls -q "${who[@]}") ]] || fail "bob sees a job of alice"
# Refused for good, but only the daemon knows: the client tries for its ten seconds, both at once.
as mallory other
creepctl ls "${who[@]}" >"$work/refused-1" 2>&1 &
refused_1=$!
as alice tls other
creepctl ls "${who[@]}" >"$work/refused-2" 2>&1 &
refused_2=$!
creepctl ls --server "127.0.0.1:$port" >"$work/refused-3" 2>&1 &
refused_3=$!
expect_exit 2 creepctl ls --server "127.0.0.1:$port" --tls-ca "$work/tls/ca.crt"
code=0
for process in "$refused_1" "$refused_2" "$refused_3"; do
  wait "$process" || code=$?
  ((code == 4)) || fail "exit code $code instead of 4 for a wrong certificate"
done
step "no daemon"
stop_daemon
started=$SECONDS
expect_exit 4 creepctl ls
((SECONDS - started >= 9)) || fail "gave up before ten seconds"
expect_exit 4 creepctl doctor
step "done"
