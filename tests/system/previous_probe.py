#!/usr/bin/python3
"""A client of version 0.1.0: previous_probe.py SOCKET JOB_FILE OLD_DESCRIPTORS NEW_DESCRIPTORS

Its messages are made from the proto of that version (tests/system/previous). It calls everything there was; then the
descriptors are compared: whatever was there is there still, with its number and type.
"""
import sys

import grpc
from creep.v1 import creep_pb2 as creep
from creep.v1 import creep_pb2_grpc
from google.protobuf import descriptor_pb2
from google.rpc import error_details_pb2, status_pb2

SECONDS = 120


def check(condition, what):
    if not condition:
        sys.exit(f"FAILED: {what}")


def reason_and_violations(call, request):
    try:
        call(request, timeout=SECONDS)
    except grpc.RpcError as error:
        info, bad = error_details_pb2.ErrorInfo(), error_details_pb2.BadRequest()
        for key, value in error.trailing_metadata() or ():
            if key == "grpc-status-details-bin":
                for detail in status_pb2.Status.FromString(value).details:
                    detail.Unpack(info) or detail.Unpack(bad)
        return info.reason, [v.field for v in bad.field_violations]
    return sys.exit(f"not refused: {request}")


def use(service, spec):
    called = set()

    def call(method, request):
        called.add(method)
        return getattr(service, method)(request, timeout=SECONDS)

    info = call("GetServerInfo", creep.GetServerInfoRequest())
    check(info.version and info.slots > 0 and info.max_spec_bytes, f"server info: {info}")
    request = creep.SubmitJobRequest(spec=spec, request_id="old", labels={"client": "0.1.0"}, priority=3)
    submitted = call("SubmitJob", request)
    job = submitted.job.id
    check(submitted.job.state == creep.QUEUED and call("SubmitJob", request).already_existed, "submit")
    seen, states, samples = 0, [], 0
    for event in call("WatchJob", creep.WatchJobRequest(job=job)):
        if event.seq:
            check(event.seq == seen + event.skipped + 1, f"event {event.seq} after {seen}")
            seen = event.seq
        samples += event.HasField("sample")
        if event.HasField("state_change"):
            states.append(event.state_change.state)
    check(states[0] == creep.QUEUED and states[-1] == creep.SUCCEEDED and samples, f"watched {states}, {samples}")
    shown = call("GetJob", creep.GetJobRequest(job=job))
    check(shown.spec == spec and shown.state_digest and shown.last_seq == seen and
          shown.latest_sample.axial_stress_pa > 0 and shown.labels["client"] == "0.1.0", f"job: {shown}")
    listed = call("ListJobs", creep.ListJobsRequest(labels={"client": "0.1.0"}, states=[creep.SUCCEEDED])).jobs
    check([each.id for each in listed] == [job], "list")
    index = 0
    while True:
        page = call("ListSamples", creep.ListSamplesRequest(job=job, first_index=index, page_size=100))
        check([s.index for s in page.samples] == list(range(index, page.next_index)), "samples have gaps")
        index = page.next_index
        if page.at_end:
            break
    check(index > 100, f"{index} samples")
    artifacts = {a.name: a for a in call("ListArtifacts", creep.ListArtifactsRequest(job=job)).artifacts}
    chunks = list(call("FetchArtifact", creep.FetchArtifactRequest(job=job, name="samples.csv")))
    data = b"".join(chunk.data for chunk in chunks)
    check(len(data) == artifacts["samples.csv"].size_bytes and data.count(b"\n") == index + 1, "samples.csv")
    fork = call("ForkJob", creep.ForkJobRequest(job=job, overrides={"program.1.duration": "2 d"})).job
    check(fork.parent_job == job, "fork")
    for method, request in (("PauseJob", creep.PauseJobRequest(job=fork.id)),
                            ("ResumeJob", creep.ResumeJobRequest(job=fork.id)),
                            ("CancelJob", creep.CancelJobRequest(job=fork.id, mode=creep.CancelJobRequest.NOW))):
        check(call(method, request).id == fork.id, method)
    call("PlanJob", creep.PlanJobRequest(spec=spec, request_id="old-plan"))
    for each in call("ListJobs", creep.ListJobsRequest()).jobs:
        if each.state in (creep.QUEUED, creep.RUNNING):
            call("CancelJob", creep.CancelJobRequest(job=each.id, mode=creep.CancelJobRequest.NOW))
    call("DeleteJob", creep.DeleteJobRequest(job=job))
    methods = {m.name for m in creep.DESCRIPTOR.services_by_name["CreepService"].methods}
    check(called == methods, f"not called: {methods - called}")

    check(reason_and_violations(service.GetJob, creep.GetJobRequest(job=job)) == ("JOB_NOT_FOUND", []), "not found")
    wrong = "\n".join(f"wrong_{i} = 1" for i in range(20)) + "\n" + spec
    reason, fields = reason_and_violations(service.SubmitJob, creep.SubmitJobRequest(spec=wrong))
    check(reason == "INVALID_SPEC" and [f"spec:{i}:1" for i in range(1, 21)] == fields, f"{reason} {fields}")


def all_of(path):
    """Every field as (message.field, number, type, label, type name); methods and enum values likewise."""
    with open(path, "rb") as file:
        files = descriptor_pb2.FileDescriptorSet.FromString(file.read()).file
    found = set()

    def message_of(prefix, message):
        for field in message.field:
            found.add((f"{prefix}.{field.name}", field.number, field.type, field.label, field.type_name))
        for nested in message.nested_type:
            message_of(f"{prefix}.{nested.name}", nested)
        for enum in message.enum_type:
            found.update((f"{prefix}.{enum.name}.{value.name}", value.number) for value in enum.value)

    for file in files:
        if file.package != "creep.v1":
            continue
        for message in file.message_type:
            message_of(message.name, message)
        for enum in file.enum_type:
            found.update((f"{enum.name}.{value.name}", value.number) for value in enum.value)
        for service in file.service:
            found.update((f"{service.name}.{m.name}", m.input_type, m.output_type, m.client_streaming,
                          m.server_streaming) for m in service.method)
    return found


def main():
    socket, job_file, old, new = sys.argv[1:]
    before, now = all_of(old), all_of(new)
    check(len(before) > 150, f"only {len(before)} things to compare")
    check(before <= now, f"gone or changed since 0.1.0: {sorted(map(str, before - now))}")
    with open(job_file, encoding="utf-8") as file:
        spec = file.read()
    use(creep_pb2_grpc.CreepServiceStub(grpc.insecure_channel(f"unix:{socket}")), spec)
    print(f"{len(before)} names, numbers and types of 0.1.0 are as they were; every call answers")


main()
