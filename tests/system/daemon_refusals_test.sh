#!/usr/bin/env bash
# Who is refused what: users of one socket, whoever comes through somebody else's forwarded socket, and too much of
# anything. Certificates: daemon_client_test.sh.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
source "$(dirname "${BASH_SOURCE[0]}")/daemon_support.sh"
python_client || skip "needs python3-grpcio and protoc"
relay=
stop_relay() {
  if [[ -n "$relay" ]]; then kill "$relay" 2>/dev/null || true; fi
}
trap 'stop_relay; stop_daemon_and_clean_up' EXIT
cp "$here/daemon_probe.py" "$here/relay.py" "$work/python"

# Long enough to be there until the test ends it.
sed -i 's/minimum_cycles = 3000/minimum_cycles = 3000000/' "$job"
# ask CHECK [ARGUMENT...] and as USER COMMAND...: users are numbers that need no account.
asked_socket=$socket
ask() { "$python" "$work/python/daemon_probe.py" "$asked_socket" "$@"; }
as() { setpriv --reuid "$1" --regid "$1" --clear-groups "${@:2}"; }
alice=23001 bob=23002 mallory=23003
as_user() { as "$1" env PYTHONPATH="$PYTHONPATH" "$python" "$work/python/daemon_probe.py" "$asked_socket" "${@:2}"; }

if ((EUID == 0)) && as "$alice" true; then
  step "two users and a third who may not use the socket"
  chmod 711 "$work" "$XDG_RUNTIME_DIR"
  chmod -R a+rX "$work/python" "$job"
  start_daemon --allow-user "$alice" --allow-user "$bob"
  id=$(as_user "$alice" submit "$job")
  expect_exit 0 as_user "$alice" owner "$id"
  expect_exit 0 as_user "$bob" stranger "$id"
  expect_exit 0 as_user "$mallory" unlisted
  grep -q "refused a connection of user $mallory" "$work/daemon.log" || fail "the log does not tell who was refused"
  [[ $(as_user "$bob" submit "$job") != "$id" ]] || fail "a request id of alice gives bob her job"
  expect_exit 0 ask owner "$id"  # root
  [[ $(field "$id" owner) == uid:$alice ]] || fail "the owner is $(field "$id" owner)"
  is "$id" RUNNING || is "$id" QUEUED || fail "bob has changed the job of alice: $(field "$id" state)"

  step "a socket forwarded by somebody else"
  # The kernel names who forwards, whoever asks: root is bob here, as is anybody whom bob lets in.
  mkdir -m 711 "$work/bob"
  chown "$bob" "$work/bob"
  setpriv --reuid "$bob" --regid "$bob" --clear-groups \
    "$python" "$work/python/relay.py" "$work/bob/relay.sock" "$socket" &  # not as: that is a subshell
  relay=$!
  wait_for 20 test -S "$work/bob/relay.sock"
  asked_socket=$work/bob/relay.sock
  expect_exit 1 ask owner "$id"
  expect_output "there is no job"
  asked_socket=$socket
  stop_relay
  kill_daemon
else
  printf 'SKIPPED: a second user needs the right to become one\n'
fi

step "too much of anything"
state=$work/state/limits
start_daemon --max-jobs 4 --memory 200000000
id=$(ask submit "$job")
wait_for 30 is "$id" RUNNING
expect_exit 0 ask standard
expect_exit 0 ask limits "$id" "$job" 3
cat "$work/output"
expect_exit 0 creepctl cancel --now "$id"
stop_daemon
step "done"
