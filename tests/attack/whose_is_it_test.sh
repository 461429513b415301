#!/usr/bin/env bash
# Folders that somebody else could change are not served, and a second daemon stays out.
system=$(dirname "${BASH_SOURCE[0]}")/../system
source "$system/support.sh"
source "$system/daemon_support.sh"

as() { setpriv --reuid "$1" --regid "$1" --clear-groups "${@:2}"; }
stranger=23002
refuses() { expect_exit 2 "$bin/creepd" --slots 1 --state "$1"; }

step "no path at all, and a working directory that is gone"
expect_exit 2 "$bin/creepd" --state ""
expect_output "--state needs a path"
expect_exit 2 "$bin/creepd" --state "$state" --socket ""
expect_output "--socket needs a path"
mkdir "$work/gone"
expect_exit 2 bash -c "cd '$work/gone' && rmdir '$work/gone' && exec '$bin/creepd' --state here"
expect_output "the working directory"
expect_exit 2 "$bin/creepd" --state "$work/$(printf 'x%.0s' {1..200})/$(printf 'y%.0s' {1..200})/$(printf 'z%.0s' {1..200})"
expect_output "--state: the path has"

step "a state folder that everybody may write"
mkdir "$work/open"
chmod 777 "$work/open"
refuses "$work/open"
expect_output "chmod go-w $work/open"
[[ $(stat -c %a "$work/open") == 777 && -z $(ls "$work/open") ]] || fail "the refused folder was changed"
refuses "$work/open/below"
expect_output "chmod go-w $work/open"
chmod 1777 "$work/open"  # as /tmp: others can add here, and change nothing of ours
state=$work/open/below
start_daemon
[[ $(stat -c %a "$state") == 700 ]] || fail "others may look into the state folder"
kill_daemon

if ((EUID == 0)) && as "$stranger" true; then
  chmod 711 "$work"
  step "root's daemon on the folder of a user"
  as "$stranger" mkdir -m 777 "$work/open/theirs" "$work/open/theirs/jobs"
  refuses "$work/open/theirs"
  expect_output "belongs to user $stranger"
  refuses "$work/open/theirs/below"
  expect_output "belongs to user $stranger"
  [[ ! -e $work/open/theirs/lock ]] || fail "something was written there"

  step "a link of a user on the way, though it leads to root's own folder"
  mkdir -m 700 "$work/mine"
  as "$stranger" ln -s "$work/mine" "$work/open/link"
  refuses "$work/open/link"
  expect_output "belongs to user $stranger"
  ln -s "$work/mine" "$work/open/my_link"
  state=$work/open/my_link
  start_daemon
  kill_daemon

  step "files of a job as links to files of root"
  # With everything else passed: the folder of a queued job has become the stranger's.
  state=$work/links
  start_daemon
  first=($(submit --priority 1) $(submit --priority 1))
  second=$(submit)  # there are two slots
  creepctl pause "$second" >/dev/null
  printf 'precious\n' >"$work/precious"
  chmod 600 "$work/precious"
  for name in lease samples.log samples.csv worker.log progress.json.tmp; do
    ln -sf "$work/precious" "$(folder_of "$second")/$name"
  done
  creepctl cancel "${first[@]}" >/dev/null
  creepctl resume "$second" >/dev/null
  wait_for 30 grep -q "$second attempt" "$work/daemon.log"
  sleep 1
  [[ $(cat "$work/precious") == precious ]] || fail "a file of root was overwritten through a link"
  kill_daemon
else
  printf 'SKIPPED: a second user needs the right to become one\n'
fi

step "a second daemon, though the lock file was deleted"
state=$work/twice
start_daemon
rm "$state/lock"
expect_exit 1 "$bin/creepd" --state "$state" --socket "$work/second.sock"
expect_output "another creepd uses $state"
stop_daemon

if ((EUID == 0)) && as "$stranger" true; then
  step "a stranger listens where root's creepctl looks"
  mkdir "$work/shared"
  chmod 777 "$work/shared"
  cat >"$work/listener.py" <<'PYTHON'
import socket, sys
listener = socket.socket(socket.AF_UNIX)
listener.bind(sys.argv[1])
listener.listen()
while True:
    with open(sys.argv[2], "a") as log:
        log.write("somebody came\n") if listener.accept() else None
PYTHON
  chmod 644 "$work/listener.py"
  setpriv --reuid "$stranger" --regid "$stranger" --clear-groups \
    /usr/bin/python3 "$work/listener.py" "$work/shared/creepd.sock" "$work/shared/came" &  # not as: that is a subshell
  listener=$!
  trap 'kill "$listener" 2>/dev/null || true; stop_daemon_and_clean_up' EXIT
  wait_for 20 test -S "$work/shared/creepd.sock"
  expect_exit 4 creepctl submit "$job" --server "$work/shared/creepd.sock"
  expect_output "Nothing was sent there"
  chmod 1777 "$work/shared"
  expect_exit 4 creepctl submit "$job" --server "$work/shared/creepd.sock"
  expect_output "creepd.sock belongs to user $stranger"
  as "$stranger" ln -s "$socket" "$work/shared/link"
  expect_exit 4 creepctl ls --server "$work/shared/link"
  expect_exit 2 creepctl ls --server "$work/shared/creepd.sock" --server-user nobody-of-this-name
  [[ ! -s $work/shared/came ]] || fail "somebody connected to the stranger's socket"
  # Named, it is asked; that it never answers is another matter.
  timeout 2 "$bin/creepctl" ls --server "$work/shared/creepd.sock" --server-user "$stranger" >/dev/null 2>&1 || true
  [[ -s $work/shared/came ]] || fail "--server-user does not let creepctl use the socket"
fi
