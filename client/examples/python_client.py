#!/usr/bin/python3
"""Submits a job to creepd, watches it to its end, reads its creep curve and fetches a table, with nothing of creepd but creep.proto.

Needs python3-grpcio and python3-protobuf, and the code made from the proto:

  protoc -I proto --python_out=OUT --grpc_out=OUT --plugin=protoc-gen-grpc=/usr/bin/grpc_python_plugin \\
      proto/creep/v1/creep.proto proto/creep/v1/details.proto
  PYTHONPATH=OUT python_client.py unix:/run/user/1000/creepd.sock job.toml samples.csv result.csv
"""
import sys
import uuid

import grpc
from creep.v1 import creep_pb2 as creep
from creep.v1 import creep_pb2_grpc, details_pb2

# The daemon is away, or was going down when the call came.
LOST = (grpc.StatusCode.UNAVAILABLE, grpc.StatusCode.CANCELLED)
FINAL = (creep.SUCCEEDED, creep.FAILED, creep.CANCELLED)


def violations(error):
    """Everything that is wrong with a request, as FIELD: DESCRIPTION lines."""
    for key, value in error.trailing_metadata() or ():
        if key == "grpc-status-details-bin":
            for detail in details_pb2.Status.FromString(value).details:
                if detail.type_url.endswith("/google.rpc.BadRequest"):
                    bad = details_pb2.BadRequest.FromString(detail.value)
                    return [f"{v.field}: {v.description}" for v in bad.field_violations]
    return []


def watch(service, job):
    """Yields every event of a job once, across lost connections and restarts of the daemon."""
    seq = 0
    while True:
        try:
            for event in service.WatchJob(creep.WatchJobRequest(job=job, after_seq=seq), wait_for_ready=True):
                if event.seq:  # 0 is a heartbeat
                    seq = event.seq
                yield event
            return
        except grpc.RpcError as error:
            if error.code() not in LOST:
                raise
            print(f"connection lost after event {seq}, watching again", flush=True)


def curve(service, job, *columns):
    """Some columns of the samples, thinned for a chart, as {name: values}."""
    read = creep.ReadCurvesRequest(job=job, columns=columns, thinning=creep.Thinning(), phases=[creep.DYNAMIC_STAGE])
    return {column.name: list(column.values) for column in service.ReadCurves(read).columns}


def fetch(service, job, name, path):
    with open(path, "wb") as out:
        for chunk in service.FetchArtifact(creep.FetchArtifactRequest(job=job, name=name)):
            out.write(chunk.data)


def main():
    address, job_file, artifact, path = sys.argv[1:]
    with open(job_file, encoding="utf-8") as file:
        spec = file.read()
    # A lost connection is tried again soon rather than after gRPC's minutes.
    service = creep_pb2_grpc.CreepServiceStub(
        grpc.insecure_channel(address, options=[("grpc.max_reconnect_backoff_ms", 2000)]))
    request = creep.SubmitJobRequest(spec=spec, request_id=str(uuid.uuid4()), labels={"client": "python"})
    try:
        job = service.SubmitJob(request, timeout=30).job
    except grpc.RpcError as error:
        sys.exit("\n".join([error.details(), *violations(error)]))
    print("job", job.id, flush=True)

    state = creep.JOB_STATE_UNSPECIFIED
    for event in watch(service, job.id):
        if event.HasField("state_change"):
            state = event.state_change.state
            print(event.seq, creep.JobState.Name(state), event.state_change.message, flush=True)
        elif event.HasField("sample"):
            s = event.sample
            print(f"{event.seq} strain {s.axial_strain:.6f} stress {s.axial_stress_pa:.4g} Pa "
                  f"I_G {s.grading_index:.6f} broken {s.broken_total}", flush=True)
    assert state in FINAL
    strains = curve(service, job.id, "creep_time_s", "axial_strain")
    print(f"creep curve: {len(strains['axial_strain'])} points to {max(strains['creep_time_s'], default=0):.4g} s")
    fetch(service, job.id, artifact, path)
    print("digest", service.GetJob(creep.GetJobRequest(job=job.id)).state_digest)
    return 0 if state == creep.SUCCEEDED else 1


if __name__ == "__main__":
    sys.exit(main())
