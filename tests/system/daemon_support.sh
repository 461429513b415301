# Sourced behind support.sh by the tests of creepd: a daemon of its own, and what is asked of its jobs.
[[ -x "$bin/creepd" ]] || skip "no creepd"
export XDG_RUNTIME_DIR=$work/run XDG_STATE_HOME=$work/state
unset CREEPCTL_SERVER CREEPCTL_TLS_CA CREEPCTL_TLS_CERT CREEPCTL_TLS_KEY
mkdir -m 700 "$XDG_RUNTIME_DIR" "$XDG_STATE_HOME"
socket=$XDG_RUNTIME_DIR/creepd.sock
state=$XDG_STATE_HOME/creepd
daemon=

stop_daemon_and_clean_up() {
  local job
  if [[ -n "$daemon" ]]; then kill -9 "$daemon" 2>/dev/null || true; fi
  # Workers end by themselves when their daemon is gone, save those that were stopped.
  for job in "$state"/jobs/*; do kill -CONT "$(worker_of "$job")" 2>/dev/null || true; done
  wait 2>/dev/null || true
  clean_up
}
trap stop_daemon_and_clean_up EXIT

creepctl() { "$bin/creepctl" "$@"; }
step() { printf '%3d s: %s\n' "$SECONDS" "$*"; }

# start_daemon [OPTION...]: returns when it serves.
start_daemon() {
  "$bin/creepd" --slots 2 --threads-per-job 1 --state "$state" --least-free 0 "$@" >>"$work/daemon.log" 2>&1 &
  daemon=$!
  wait_for 30 serves
}
serves() { "$bin/creepctl" ls >/dev/null 2>&1; }
kill_daemon() {
  kill -9 "$daemon"
  wait "$daemon" 2>/dev/null || true
  daemon=
}
# stop_daemon: as a service manager does; must end well.
stop_daemon() {
  kill -TERM "$daemon"
  wait "$daemon" || fail "creepd did not end with 0 on SIGTERM"
  daemon=
}

submit() { creepctl submit "$job" "$@" 2>/dev/null; }
folder_of() { printf '%s/jobs/%s' "$state" "$1"; }
# field ID NAME: of the job as JSON.
field() { creepctl show "$1" --json | sed -nE "s/^  \"$2\": \"?([^\",]*)\"?,?\$/\1/p"; }
is() { [[ $(field "$1" state) == "$2" ]]; }
has_reason() { [[ $(field "$1" state_reason) == "$2" ]]; }
computes() { creepctl show "$1" --json | grep -q '"latest_sample"'; }

# succeeded ID: it ends well, with the bits of the undisturbed run.
succeeded() {
  expect_exit 0 creepctl wait "$1" --timeout "300 s"
  same_result "$(folder_of "$1")"
  [[ $(field "$1" state_digest) == $(digest_of "$reference") ]] || fail "$1: the daemon tells another digest"
}
# python_client: makes a client from the proto alone, which $python then finds; false where that is not possible.
python_client() {
  local root=$here/../..
  python=/usr/bin/python3
  "$python" -c 'import grpc' 2>/dev/null && command -v protoc >/dev/null || return 1
  mkdir "$work/python"
  protoc -I "$root/proto" --python_out="$work/python" --grpc_out="$work/python" \
    --plugin=protoc-gen-grpc=/usr/bin/grpc_python_plugin \
    creep/v1/creep.proto creep/v1/details.proto
  export PYTHONPATH=$work/python PYTHONDONTWRITEBYTECODE=1
}
# numbers_once FILE: the events in it are 1, 2, 3, ... without a gap or a repeat.
numbers_once() {
  sed -nE 's/^\{"seq":([0-9]+),.*/\1/p' "$1" >"$work/numbers"
  awk '$1 != NR { exit 1 } END { if (NR < 10) exit 1 }' "$work/numbers" || fail "the events in $1 have a gap or a repeat"
}
