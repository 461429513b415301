#!/usr/bin/python3
"""The API beyond what creepctl needs of it, from its proto alone: api_probe.py SOCKET DAEMON CHECK [ARGUMENT...]

  errors JOB_FILE   refusals arrive, however much is wrong, and say where; beside another google/rpc/error_details.proto
  overrides JOB_FILE  keys set anew by a submission
  bomb              a small compressed message that inflates to a large one is refused, and costs no memory
"""
import sys

import grpc
from creep.v1 import creep_pb2 as creep
from creep.v1 import creep_pb2_grpc, details_pb2
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

SECONDS = 60


def check(condition, what):
    if not condition:
        sys.exit(f"FAILED: {what}")


def trailer_of(error):
    for key, value in error.trailing_metadata() or ():
        if key == "grpc-status-details-bin":
            return value
    return sys.exit(f"an error without details: {error.code().name} {error.details()}")


def refusal(call, request):
    """(code, ErrorInfo, BadRequest, all as bytes) of a call that must be refused."""
    try:
        call(request, timeout=SECONDS)
    except grpc.RpcError as error:
        info, bad = details_pb2.ErrorInfo(), details_pb2.BadRequest()
        for detail in details_pb2.Status.FromString(trailer_of(error)).details:
            if detail.type_url.endswith("/google.rpc.ErrorInfo"):
                info.ParseFromString(detail.value)
            elif detail.type_url.endswith("/google.rpc.BadRequest"):
                bad.ParseFromString(detail.value)
        return error.code().name, info, bad, trailer_of(error)
    return sys.exit(f"not refused: {str(request)[:200]}")


def public_bad_request():
    """google.rpc.BadRequest as the public files have it, in the pool that creep's own are in."""
    file = descriptor_pb2.FileDescriptorProto(name="google/rpc/error_details.proto", package="google.rpc",
                                              syntax="proto3")
    string, message = descriptor_pb2.FieldDescriptorProto.TYPE_STRING, descriptor_pb2.FieldDescriptorProto.TYPE_MESSAGE
    bad = file.message_type.add(name="BadRequest")
    violation = bad.nested_type.add(name="FieldViolation")
    for number, name in enumerate(("field", "description", "reason"), 1):
        violation.field.add(name=name, number=number, type=string, label=1)
    bad.field.add(name="field_violations", number=1, type=message, label=3,
                  type_name=".google.rpc.BadRequest.FieldViolation")
    pool = descriptor_pool.Default()
    pool.Add(file)
    return message_factory.MessageFactory(pool).GetPrototype(pool.FindMessageTypeByName("google.rpc.BadRequest"))


def errors(service, job_file):
    with open(job_file, encoding="utf-8") as file:
        spec = file.read()
    wrong = spec.replace("[numerics]", "[numerics]\nwrong_key = 1")
    line = wrong.splitlines().index("wrong_key = 1") + 1
    code, info, bad, _ = refusal(service.SubmitJob, creep.SubmitJobRequest(spec=wrong))
    check((code, info.reason, info.domain) == ("INVALID_ARGUMENT", "INVALID_SPEC", "creepd"), f"{code} {info}")
    first = bad.field_violations[0]
    check((first.line, first.column, first.field) == (line, 1, f"spec:{line}:1"), f"not at {line}:1: {first}")

    # Far more than a trailer holds: as many as there is room for, and the number of the others.
    many = spec + "[material]\n" + "".join(f"wrong_key_{i} = 1\n" for i in range(20_000))
    code, info, bad, trailer = refusal(service.SubmitJob, creep.SubmitJobRequest(spec=many))
    told = len(bad.field_violations) - 1
    check((code, info.reason) == ("INVALID_ARGUMENT", "INVALID_SPEC"), f"20 000 wrong keys: {code} {info}")
    check(told >= 10 and told + bad.left_out == 20_000, f"{told} told, {bad.left_out} left out")
    check(bad.field_violations[-1].description == f"and {bad.left_out} more", f"the last: {bad.field_violations[-1]}")
    print(f"20 000 wrong keys: {told} told in {len(trailer)} bytes, {bad.left_out} left out")

    # The same with the public class, loaded beside ours.
    public = public_bad_request()()
    for detail in details_pb2.Status.FromString(trailer).details:
        if detail.Is(public.DESCRIPTOR):
            check(detail.Unpack(public), "the public BadRequest does not read ours")
    check([v.field for v in public.field_violations] == [v.field for v in bad.field_violations],
          "the public BadRequest reads something else")

    # Long texts of the caller come back cut, in whatever detail.
    long = "x" * 1_000_000
    for call, request, reason in (
            (service.GetJob, creep.GetJobRequest(job=long), "JOB_NOT_FOUND"),
            (service.GetJob, creep.GetJobRequest(job="é" * 100_000), "JOB_NOT_FOUND"),
            (service.SubmitJob, creep.SubmitJobRequest(spec=spec, labels={long: ""}), "BAD_REQUEST"),
            (service.SubmitJob, creep.SubmitJobRequest(spec=f'{spec}"{"é" * 100_000}" = 1\n'), "INVALID_SPEC"),
            (service.SubmitJob, creep.SubmitJobRequest(
                spec=spec, labels={f"{i:06}" + "é" * 40: "é" * 300 for i in range(5000)}), "BAD_REQUEST")):
        code, info, bad, trailer = refusal(call, request)
        check(info.reason == reason, f"{reason} became {code} {info.reason}")

    for priority in (-2**31, 2**31 - 1, 101):
        code, info, bad, _ = refusal(service.SubmitJob, creep.SubmitJobRequest(spec=spec, priority=priority))
        check(bad.field_violations[0].field == "priority", f"priority {priority}: {code} {info}")

    foreign = '[start]\njob = "nobody-has-it"\ncheckpoint = "1"\n' + spec
    code, info, _, _ = refusal(service.SubmitJob, creep.SubmitJobRequest(spec=foreign, validate_only=True))
    check((code, info.reason) == ("NOT_FOUND", "JOB_NOT_FOUND"), f"validate_only from a job that is not there: {code}")

    code, info, bad, _ = refusal(service.SubmitJob, creep.SubmitJobRequest(
        spec=spec, overrides={"program.7.duration": "1 d", "specimen.seed": "3", "program.x": "1"}))
    check((code, info.reason) == ("INVALID_ARGUMENT", "BAD_REQUEST") and
          [v.field for v in bad.field_violations] == ["overrides[program.7.duration]", "overrides[program.x]"],
          f"overrides that cannot be set: {code} {info} {bad}")
    code, info, bad, _ = refusal(service.SubmitJob, creep.SubmitJobRequest(
        spec=spec, overrides={f"material.key_{i}": "1" for i in range(65)}))
    check(bad.field_violations[0].field == "overrides", f"65 overrides: {code} {info} {bad}")


def overrides(service, job_file):
    """The job is that of the text with the keys set, and is found again by its request_id."""
    with open(job_file, encoding="utf-8") as file:
        spec = file.read()
    request = creep.SubmitJobRequest(spec=spec, overrides={"specimen.seed": "41", "program.1.duration": "3 d"},
                                     request_id="overridden")
    first = service.SubmitJob(request, timeout=SECONDS)
    again = service.SubmitJob(request, timeout=SECONDS)
    check(again.already_existed and again.job.id == first.job.id, "asked for twice, made twice")
    stored = service.GetJob(creep.GetJobRequest(job=first.job.id), timeout=SECONDS)
    by_hand = spec.replace("particles = 300", "particles = 300\nseed = 41").replace('"1 d"', '"3 d"')
    checked = service.SubmitJob(creep.SubmitJobRequest(spec=by_hand, validate_only=True), timeout=SECONDS)
    check("seed = 41" in stored.spec and stored.experiment_hash == checked.job.experiment_hash,
          f"another experiment than the same text written by hand:\n{stored.spec}")
    service.CancelJob(creep.CancelJobRequest(job=first.job.id, mode=creep.CancelJobRequest.NOW), timeout=SECONDS)
    print("overrides", stored.spec)


def garbled(channel):
    for method, stream in (("SubmitJob", False), ("GetJob", False), ("WatchJob", True), ("FetchArtifact", True)):
        kind = channel.unary_stream if stream else channel.unary_unary
        call = kind(f"/creep.v1.CreepService/{method}")
        code, info, _, _ = refusal(
            lambda request, timeout, call=call, stream=stream:
                list(call(request, timeout=timeout)) if stream else call(request, timeout=timeout), b"\x0a\x02\xc3\x28")
        check((code, info.reason) == ("INVALID_ARGUMENT", "BAD_REQUEST"), f"{method} of no message: {code}")
    try:
        channel.unary_unary("/creep.v1.CreepService/NoSuchCall")(b"", timeout=SECONDS)
    except grpc.RpcError as error:
        check(error.code() == grpc.StatusCode.UNIMPLEMENTED, f"a call that does not exist: {error.code()}")


def bomb(service, daemon):
    """300 MB of one letter are 300 kB of gzip."""
    request = creep.SubmitJobRequest(spec="#" * 300_000_000)
    for compression in (grpc.Compression.Gzip, grpc.Compression.Deflate):
        try:
            service.SubmitJob(request, timeout=SECONDS, compression=compression)
            sys.exit("a compressed message is taken")
        except grpc.RpcError as error:
            check(error.code() in (grpc.StatusCode.UNIMPLEMENTED, grpc.StatusCode.INTERNAL), f"{error.code()}")
            print("bomb:", error.details()[:100])
    with open(f"/proc/{daemon}/status", encoding="utf-8") as status:
        peak = next(int(line.split()[1]) for line in status if line.startswith("VmHWM"))
    print(f"peak of the daemon: {peak / 1024:.0f} MiB")
    check(peak < 100 << 10, f"the daemon took {peak} KiB")


def main():
    socket, daemon, what, *arguments = sys.argv[1:]
    options = [("grpc.max_send_message_length", -1), ("grpc.enable_http_proxy", 0)]
    channel = grpc.insecure_channel(f"unix:{socket}", options=options)
    service = creep_pb2_grpc.CreepServiceStub(channel)
    if what == "errors":
        errors(service, *arguments)
        garbled(channel)
    elif what == "overrides":
        overrides(service, *arguments)
    elif what == "bomb":
        bomb(service, daemon)
    else:
        sys.exit(f"no check {what}")


main()
