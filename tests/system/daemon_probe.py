#!/usr/bin/python3
"""What creepd answers and refuses, asked through its proto alone: daemon_probe.py SOCKET CHECK [ARGUMENT...]

  submit JOB_FILE            prints the id of the job that the caller now owns
  owner JOB                  the job is the caller's to see
  stranger JOB               every call that names a job says that there is none; the caller's list is empty
  unlisted                   the socket hangs up on the caller
  standard                   health and reflection answer
  limits JOB JOB_FILE ROOM   JOB is running; the daemon takes ROOM more jobs, none of 100 000 particles
"""
import sys

import grpc
from creep.v1 import creep_pb2 as creep
from creep.v1 import creep_pb2_grpc, details_pb2
from google.protobuf import message_factory

FORGED = (("uid", "0"), ("x-uid", "0"), ("authorization", "uid 0"))  # what a caller says of itself counts for nothing
SECONDS = 120
MOST_WATCHERS = 1000
MOST_TRANSFERS = 64
LONG_FILE = 1_000_000  # bytes; of which a transfer that nobody reads brings a chunk and 64 KiB
# Else gRPC measures how much the connection carries and may buffer the whole file unread: a transfer that has ended.
FIXED_WINDOW = [("grpc.http2.bdp_probe", 0), ("grpc.http2.lookahead_bytes", 1 << 16)]


def reason_of(error):
    for key, value in error.trailing_metadata() or ():
        if key == "grpc-status-details-bin":
            for detail in details_pb2.Status.FromString(value).details:
                if detail.type_url.endswith("/google.rpc.ErrorInfo"):
                    return details_pb2.ErrorInfo.FromString(detail.value).reason
    return ""


def expect(code, reason, call, what):
    try:
        call()
    except grpc.RpcError as error:
        if (error.code().name, reason_of(error)) != (code, reason):
            sys.exit(f"{what}: {error.code().name} {reason_of(error)} ({error.details()}), not {code} {reason}")
        print(f"{what}: {code} {reason}")
        return
    sys.exit(f"{what} was not refused")


def calls_with_a_job(service, job):
    """Every method of the service whose request names a job, as (name, function that calls it)."""
    for method in creep.DESCRIPTOR.services_by_name["CreepService"].methods:
        if "job" not in method.input_type.fields_by_name:
            continue
        request = message_factory.MessageFactory().GetPrototype(method.input_type)(job=job)
        call = getattr(service, method.name)
        if method.name in ("WatchJob", "FetchArtifact"):
            if method.name == "FetchArtifact":
                request.name = "job.toml"
            yield method.name, lambda call=call, request=request: next(call(request, metadata=FORGED, timeout=SECONDS))
        else:
            yield method.name, lambda call=call, request=request: call(request, metadata=FORGED, timeout=SECONDS)


def stranger(service, job):
    names = []
    for name, call in calls_with_a_job(service, job):
        expect("NOT_FOUND", "JOB_NOT_FOUND", call, name)
        names.append(name)
    if len(names) < 10:
        sys.exit(f"only {names} were tried")
    if service.ListJobs(creep.ListJobsRequest(), metadata=FORGED, timeout=SECONDS).jobs:
        sys.exit("the list shows jobs of somebody else")


def owner(service, job):
    found = service.GetJob(creep.GetJobRequest(job=job), timeout=SECONDS)
    listed = service.ListJobs(creep.ListJobsRequest(), timeout=SECONDS).jobs
    if found.id != job or job not in [each.id for each in listed]:
        sys.exit("the job is not shown")


def unlisted(service):
    expect("UNAVAILABLE", "", lambda: service.GetServerInfo(creep.GetServerInfoRequest(), timeout=SECONDS), "any call")


def standard(channel):
    """By bytes: Debian has no Python code for these services."""
    health = channel.unary_unary("/grpc.health.v1.Health/Check")
    for name in (b"creep.v1.CreepService", b""):
        if health(b"\x0a" + bytes([len(name)]) + name, timeout=SECONDS) != b"\x08\x01":  # status: SERVING
            sys.exit(f"health of '{name.decode()}' is not SERVING")
    reflection = channel.stream_stream("/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo")
    if b"creep.v1.CreepService" not in next(reflection(iter([b"\x3a\x00"]), timeout=SECONDS)):  # list_services: ""
        sys.exit("reflection does not name the service")


def submit(service, job_file):
    with open(job_file, encoding="utf-8") as file:
        print(service.SubmitJob(creep.SubmitJobRequest(spec=file.read(), request_id="mine"), timeout=SECONDS).job.id)


def served_of_many(streams, refusal, room):
    """Those of the streams that were not refused, as (first message, the rest unread). As many as there is room for."""
    served = []
    for stream in streams:
        try:
            served.append((next(stream), stream))
        except grpc.RpcError as error:
            if reason_of(error) != refusal:
                sys.exit(f"not {refusal}: {error.details()}")
    if len(served) != room:
        sys.exit(f"{refusal}: of {len(streams)} asked for at once {len(served)} were served, not {room}")
    return served


def limits(service, job, job_file, room):
    with open(job_file, encoding="utf-8") as file:
        spec = file.read()
    long = spec + "#" * (5 << 20)

    def submit_one(text=spec):
        return service.SubmitJob(creep.SubmitJobRequest(spec=text), timeout=SECONDS).job.id

    expect("RESOURCE_EXHAUSTED", "", lambda: submit_one(long), "a message of 5 MiB")
    expect("INVALID_ARGUMENT", "INVALID_SPEC", lambda: submit_one(long[: 1 << 21]), "a job file of 2 MiB")
    many = spec.replace("particles = 300", "particles = 1000000000")
    expect("INVALID_ARGUMENT", "INVALID_SPEC", lambda: submit_one(many), "a billion particles")
    large = spec.replace("particles = 300", "particles = 100000")
    expect("RESOURCE_EXHAUSTED", "TOO_LARGE", lambda: submit_one(large), "more memory than there is for jobs")
    for name in ("../creepd.db", "/etc/passwd", "checkpoints/../lease", "lease", ""):
        expect("NOT_FOUND", "ARTIFACT_NOT_FOUND",
               lambda name=name: next(service.FetchArtifact(creep.FetchArtifactRequest(job=job, name=name))),
               f"artifact '{name}'")
    for path in ("../" + job, job + "/../" + job, "/etc", "."):
        expect("NOT_FOUND", "JOB_NOT_FOUND",
               lambda path=path: service.GetJob(creep.GetJobRequest(job=path)), f"job '{path}'")

    for _ in range(int(room) - 1):
        submit_one()
    padded = submit_one(spec + "#" * (LONG_FILE - len(spec)))
    expect("RESOURCE_EXHAUSTED", "QUEUE_FULL", submit_one, f"a job beyond the {room} there is room for")

    quiet = service.WatchJob(creep.WatchJobRequest(job=padded, after_seq=1))
    one_more = creep.FetchArtifactRequest(job=padded, name="job.toml")
    transfers = [service.FetchArtifact(one_more) for _ in range(4 * MOST_TRANSFERS)]
    served = served_of_many(transfers, "TOO_MANY_TRANSFERS", MOST_TRANSFERS)
    expect("RESOURCE_EXHAUSTED", "TOO_MANY_TRANSFERS", lambda: next(service.FetchArtifact(one_more)), "a transfer more")
    for first, transfer in served:
        if len(first.data) + sum(len(chunk.data) for chunk in transfer) != LONG_FILE:
            sys.exit("a transfer within the limit was not served whole")
    if sum(len(chunk.data) for chunk in service.FetchArtifact(one_more)) != LONG_FILE:
        sys.exit("no transfer again after the others ended")

    one_more = creep.WatchJobRequest(job=padded)
    watchers = [service.WatchJob(one_more) for _ in range(2 * MOST_WATCHERS)]
    served = served_of_many(watchers, "TOO_MANY_WATCHERS", MOST_WATCHERS - 1)  # and quiet
    expect("RESOURCE_EXHAUSTED", "TOO_MANY_WATCHERS", lambda: next(service.WatchJob(one_more)), "a watcher more")
    for _, watcher in served:
        watcher.cancel()
    if next(quiet).WhichOneof("what") != "heartbeat":
        sys.exit("no heartbeat where there is no news")


def main():
    socket, check, *arguments = sys.argv[1:]
    options = [("grpc.max_send_message_length", -1), ("grpc.enable_http_proxy", 0), *FIXED_WINDOW]
    channel = grpc.insecure_channel(f"unix:{socket}", options=options)
    if check == "standard":
        return standard(channel)
    checks = {"submit": submit, "owner": owner, "stranger": stranger, "unlisted": unlisted, "limits": limits}
    return checks[check](creep_pb2_grpc.CreepServiceStub(channel), *arguments)


main()
