#!/usr/bin/env bash
# PlanJob: a daemon's plan is that of this machine, its pilot a job that waits in the queue, survives the daemon and goes
# when it is done.
source "$(dirname "$0")/support.sh"
source "$here/daemon_support.sh"

start_daemon
expect_exit 0 "$bin/creepctl" plan "$job" --json --threads 1
sed -n '/^{/,$p' "$work/output" >"$work/here"
step "the same plan as here, and nothing left behind"
creepctl plan "$job" --daemon --json >"$work/there" 2>"$work/said" || fail "plan --daemon: $(cat "$work/said")"
grep -q "pilot .*\(QUEUED\|RUNNING\)" "$work/said" || fail "it does not say how far the pilot is: $(cat "$work/said")"
python3 - "$work/here" "$work/there" <<'PYTHON' || fail "another plan there than here"
import json, sys
here, there = (json.load(open(path)) for path in sys.argv[1:])
for plan in here, there:
    del plan["wall_seconds"], plan["pilot"]["wall_seconds"], plan["pilot"]["particle_steps_per_second"]
if here != there:
    sys.exit(f"{here}\n{there}")
PYTHON
[[ -z $(creepctl ls --quiet) ]] || fail "the pilot is still there: $(creepctl ls)"

step "the daemon is killed while the pilot runs"
sed 's/^particles = 300/particles = 1500/' "$here/tiny.toml" >"$work/larger.toml"
creepctl plan "$work/larger.toml" --daemon >"$work/plan" 2>&1 &
planning=$!
runs() { pilot=$(creepctl ls --label pilot= --state running --quiet) && [[ -n $pilot ]]; }
wait_for 30 runs
kill_daemon
start_daemon
wait "$planning" || fail "the plan did not outlive the daemon: $(cat "$work/plan")"
grep -q "time there" "$work/plan" || fail "no plan: $(cat "$work/plan")"

step "what cannot be planned"
printf '[start]\njob = "abcd"\n[[program]]\nstage = "creep"\nduration = "1 h"\n' >"$work/start.toml"
expect_exit 5 creepctl plan "$work/start.toml" --daemon
expect_output "cannot be planned"
sed 's/^loading_velocity = .*/loading_velocity = "10 m\/s"\nlocal_damping = 0.0/' "$here/tiny.toml" >"$work/wild.toml"
expect_exit 1 creepctl plan "$work/wild.toml" --daemon
expect_output "is FAILED: guard"
expect_exit 2 creepctl plan "$job" --daemon --threads 2
if python_client; then
  step "a plan is asked for by a request id, and is nobody else's"
  "$python" - "$socket" "$work/tiny.toml" <<'PYTHON' || fail "PlanJob answers otherwise than creep.proto says"
import sys, time, grpc
from creep.v1 import creep_pb2 as creep, creep_pb2_grpc
service = creep_pb2_grpc.CreepServiceStub(grpc.insecure_channel("unix:" + sys.argv[1]))
spec = open(sys.argv[2]).read()
def refused(request):
    try:
        service.PlanJob(request, timeout=30)
    except grpc.RpcError as error:
        return error.code()
assert refused(creep.PlanJobRequest(spec=spec)) == grpc.StatusCode.INVALID_ARGUMENT
assert refused(creep.PlanJobRequest(spec="[specimen]", request_id="a")) == grpc.StatusCode.INVALID_ARGUMENT
first = service.PlanJob(creep.PlanJobRequest(spec=spec, request_id="a"), timeout=30)
again = service.PlanJob(creep.PlanJobRequest(spec=spec, request_id="a"), timeout=30)
assert first.pilot.id == again.pilot.id and not first.HasField("plan")
assert refused(creep.PlanJobRequest(spec=spec + "# other\n[output]\n", request_id="a")) is None  # the same pilot
assert refused(creep.PlanJobRequest(spec=spec.replace("300", "310"), request_id="a")) == grpc.StatusCode.INVALID_ARGUMENT
service.CancelJob(creep.CancelJobRequest(job=first.pilot.id, mode=creep.CancelJobRequest.NOW), timeout=30)
for _ in range(100):
    if service.GetJob(creep.GetJobRequest(job=first.pilot.id), timeout=30).state == creep.CANCELLED: break
    time.sleep(0.1)
assert refused(creep.PlanJobRequest(spec=spec, request_id="a")) == grpc.StatusCode.FAILED_PRECONDITION
PYTHON
fi
stop_daemon
