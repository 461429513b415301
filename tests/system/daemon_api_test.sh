#!/usr/bin/env bash
# The API as its own clients see it, beyond what creepctl uses: errors, and what a caller must not be able to do.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
source "$(dirname "${BASH_SOURCE[0]}")/daemon_support.sh"
python_client || skip "needs python3-grpcio and protoc"
probe() { expect_exit 0 "$python" "$here/api_probe.py" "$socket" "$daemon" "$@" && cat "$work/output"; }

start_daemon
step "errors"
probe errors "$job"
step "overrides"
probe overrides "$job"
expect_exit 2 creepctl submit "$job" --set specimen.seed
expect_exit 5 creepctl submit "$job" --set program.9.duration="1 d"
expect_output "with --set: cannot set \"program.9.duration\""
expect_exit 5 creepctl submit "$job" --set specimen.void_ratio=-1
id=$(creepctl submit "$job" --set specimen.seed=41 --set 'program.1.duration=3 d' 2>/dev/null)
creepctl show "$id" --spec | grep -q "seed = 41" || fail "--set does not reach the job"
expect_exit 0 creepctl cancel --now "$id"
step "a bomb"
probe bomb
expect_exit 5 creepctl submit "$job" --label "x=$(printf '\377')"
expect_output "cannot be parsed"
step "a client of version 0.1.0"
mkdir "$work/old"
protoc -I "$here/previous" --python_out="$work/old" --grpc_out="$work/old" --plugin=protoc-gen-grpc=/usr/bin/grpc_python_plugin \
  --descriptor_set_out="$work/old.pb" creep/v1/creep.proto google/rpc/status.proto google/rpc/error_details.proto
protoc -I "$here/../../proto" --descriptor_set_out="$work/new.pb" creep/v1/creep.proto
PYTHONPATH=$work/old expect_exit 0 "$python" "$here/previous_probe.py" "$socket" "$job" "$work/old.pb" "$work/new.pb"
cat "$work/output"
stop_daemon
step "done"
