#!/usr/bin/env bash
# What creepd does about trouble: workers that crash or hang, a damaged checkpoint, a full disk, a second daemon, its
# own end. And a client that knows nothing but the proto.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
source "$(dirname "${BASH_SOURCE[0]}")/daemon_support.sh"

sed -i 's/minimum_cycles = 3000/minimum_cycles = 15000/' "$job"
undisturbed

step "three faulty attempts"
cat >"$work/crashing" <<'SCRIPT'
#!/bin/sh
echo "about to crash, attempt $3" >&2
kill -SEGV $$
SCRIPT
chmod +x "$work/crashing"
start_daemon --worker "$work/crashing"
id=$(submit)
expect_exit 1 creepctl wait "$id" --timeout "60 s"
has_reason "$id" CRASH_LOOP || fail "reason $(field "$id" state_reason)"
[[ $(field "$id" attempts) == 3 ]] || fail "$(field "$id" attempts) attempts instead of 3"
creepctl show "$id" --json | grep -q 'about to crash, attempt 3' || fail "the end of the log is not told"
stop_daemon

step "a second daemon"
start_daemon --checkpoint-interval 0.2
expect_exit 1 "$bin/creepd" --state "$state" --socket "$work/run/other.sock"
expect_output "another creepd uses"
expect_exit 1 "$bin/creepd" --state "$work/state/other"
expect_output "another daemon listens"
expect_exit 2 "$bin/creepd" --listen 127.0.0.1:0
expect_output "there is no TCP without them"
expect_exit 1 "$bin/creepd" --state "$work/state/third" --socket "$work/$(printf 'x%.0s' {1..120})"
expect_output "at most 107"

step "SIGTERM gives attempts back"
id=$(submit)
wait_for 30 computes "$id"
stop_daemon
[[ ! -e "$socket" ]] || fail "the socket is left behind"
has_checkpoint "$(folder_of "$id")" || fail "no checkpoint was written"
start_daemon --checkpoint-interval 0.2
succeeded "$id"
[[ $(field "$id" attempts) == 1 ]] || fail "$(field "$id" attempts) attempts instead of 1"
grep -qF 'continues from checkpoint' "$(folder_of "$id")/worker.log" || fail "it began from zero"

step "a damaged newest checkpoint"
id=$(submit)
two_checkpoints() { (($(find "$(folder_of "$id")/checkpoints" -name 'ck.*[0-9]' 2>/dev/null | wc -l) >= 2)); }
wait_for 30 two_checkpoints
expect_exit 0 creepctl pause "$id"
wait_for 30 is "$id" PAUSED
newest=$(find "$(folder_of "$id")/checkpoints" -name 'ck.*[0-9]' | sort -V | tail -n 1)
printf 'damage' | dd of="$newest" bs=1 seek=200 conv=notrunc 2>/dev/null
expect_exit 0 creepctl resume "$id"
succeeded "$id"
expect_exit 0 creepctl logs "$id"
expect_output "is set aside as bad."
stop_daemon

step "a power cut takes the folder of a queued job"
start_daemon
first=$(submit)
second=$(submit)
id=$(submit)
wait_for 30 is "$second" RUNNING
is "$id" QUEUED || fail "three jobs run in two slots"
kill_daemon
rm -r "$(folder_of "$id")"
start_daemon
for job_id in "$first" "$second" "$id"; do succeeded "$job_id"; done
stop_daemon

step "a stalled worker"
start_daemon --checkpoint-interval 0.2 --stall-limit 3
id=$(submit)
wait_for 30 computes "$id"
kill -STOP "$(worker_of "$(folder_of "$id")")"
wait_for 30 grep -q "job $id: no progress" "$work/daemon.log"
succeeded "$id"
stop_daemon

step "a full disk"
mkdir "$work/disk"
if mount -t tmpfs -o size=6m tmpfs "$work/disk" 2>/dev/null; then
  mounted=$work/disk
  state_on_disk=$state
  state=$work/disk/state
  start_daemon --checkpoint-interval 0.2
  id=$(submit)
  wait_for 30 has_checkpoint "$(folder_of "$id")"
  # A pause for lack of room is no fault and no wish of anybody; the job must not need a hand.
  dd if=/dev/zero of="$work/disk/ballast" bs=4k 2>/dev/null || true
  # The pause itself cannot be stored before there is room for it: only the worker's end is seen for sure.
  wait_for 60 grep -qE "job $id( attempt 1 ended: PAUSED|: its end cannot be stored yet)" "$work/daemon.log"
  rm "$work/disk/ballast"
  succeeded "$id"
  # A full disk does not keep the daemon from stopping.
  id=$(submit)
  wait_for 30 computes "$id"
  dd if=/dev/zero of="$work/disk/ballast" bs=4k 2>/dev/null || true
  wait_for 60 grep -qE "job $id( attempt 1 ended: PAUSED|: its end cannot be stored yet)" "$work/daemon.log"
  stop_daemon
  rm "$work/disk/ballast"
  start_daemon --checkpoint-interval 0.2
  succeeded "$id"
  stop_daemon
  state=$state_on_disk
else
  printf 'SKIPPED: a full disk needs the right to mount a small tmpfs\n'
fi

step "checkpoints of a newer program, as after going back to an older one: nothing is lost"
start_daemon --checkpoint-interval 0.2
id=$(submit)
wait_for 30 has_checkpoint "$(folder_of "$id")"
expect_exit 0 creepctl pause "$id"
wait_for 30 is "$id" PAUSED
checkpoints=$(folder_of "$id")/checkpoints
cp -r "$checkpoints" "$work/checkpoints"
for checkpoint in "$checkpoints"/ck.*; do printf '\xff' | dd of="$checkpoint" bs=1 seek=8 conv=notrunc 2>/dev/null; done
expect_exit 0 creepctl resume "$id"
wait_for 30 is "$id" FAILED
has_reason "$id" REFUSED || fail "the reason is $(field "$id" state_reason)"
expect_exit 0 creepctl show "$id"
expect_output "made by a newer program"
expect_output "a fork of this job goes on"
expect_exit 1 creepctl fork "$id"
expect_output "made by a newer program"
cp "$work/checkpoints"/* "$checkpoints"
succeeded "$(creepctl fork "$id")"
stop_daemon

step "a worker that is asked to stop before it listens"
cat >"$work/late" <<SCRIPT
#!/bin/bash
sleep 1
exec "$bin/creep-worker" "\$@"
SCRIPT
chmod +x "$work/late"
start_daemon --worker "$work/late"
id=$(submit)
wait_for 30 is "$id" RUNNING
expect_exit 0 creepctl pause "$id"
wait_for 30 is "$id" PAUSED
has_checkpoint "$(folder_of "$id")" || fail "it did not hear of it"
stop_daemon

step "a client from the proto alone"
if python_client; then
  example=$here/../../client/examples/python_client.py
  start_daemon --checkpoint-interval 0.2
  expect_exit 0 "$python" "$example" "unix:$socket" "$job" samples.csv "$work/samples.csv"
  expect_output "digest $(digest_of "$reference")"
  expect_output SUCCEEDED
  cmp "$work/samples.csv" "$reference/samples.csv" || fail "python fetched other samples"
  sed 's/void_ratio = 0.75/void_ratio = 9/; s/particles = 300/particles = 3/' "$job" >"$work/bad.toml"
  expect_exit 1 "$python" "$example" "unix:$socket" "$work/bad.toml" a "$work/b"
  expect_output "spec:3:"
  expect_output "spec:4:"
  stop_daemon
else
  printf 'SKIPPED: the python client needs python3-grpcio and protoc\n'
fi
