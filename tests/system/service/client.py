"""The service as its proto tells it: one call, tried again while the daemon is away, with the reason of a refusal."""
import itertools
import time
from dataclasses import dataclass
from typing import Any

import grpc
from creep.v1 import creep_pb2 as creep
from creep.v1 import creep_pb2_grpc, details_pb2

# The daemon is away, was going down when the call came, or cannot store anything now. Nothing here cancels a call.
LOST = (grpc.StatusCode.UNAVAILABLE, grpc.StatusCode.CANCELLED, grpc.StatusCode.DEADLINE_EXCEEDED)

CALL_LIMIT = 120.0  # [s]


@dataclass
class Answer:
    message: Any = None  # None: refused, or nobody knows
    code: Any = grpc.StatusCode.OK
    reason: str = ""
    facts: Any = None
    tries: int = 1

    @property
    def ok(self):
        return self.message is not None

    @property
    def unknown(self):
        """Done or not."""
        return self.code in LOST

    def __str__(self):
        return "OK" if self.ok else f"{self.code.name} {self.reason}"


def refusal(error):
    """Reason and facts of an error of the daemon; of gRPC's own errors the text."""
    for key, value in error.trailing_metadata() or ():
        if key == "grpc-status-details-bin":
            for detail in details_pb2.Status.FromString(value).details:
                if detail.type_url.endswith("/google.rpc.ErrorInfo"):
                    info = details_pb2.ErrorInfo.FromString(detail.value)
                    return info.reason, dict(info.metadata)
    return error.details() or "", {}


class Client:
    def __init__(self, address):
        # Calls wait for the connection: gRPC looks after one that nobody waits for only every five seconds.
        self.channel = grpc.insecure_channel(address, options=[
            ("grpc.initial_reconnect_backoff_ms", 50), ("grpc.max_reconnect_backoff_ms", 500),
            ("grpc.use_local_subchannel_pool", 1)])
        self.service = creep_pb2_grpc.CreepServiceStub(self.channel)

    def close(self):
        self.channel.close()

    def serves(self):
        try:
            self.service.GetServerInfo(creep.GetServerInfoRequest(), timeout=1, wait_for_ready=True)
            return True
        except grpc.RpcError:
            return False

    def call(self, method, request, patience=0.0):
        """`patience`: seconds for which it is tried again while the daemon is away."""
        end = time.monotonic() + patience
        for tries in itertools.count(1):
            try:
                message = getattr(self.service, method)(request, timeout=CALL_LIMIT, wait_for_ready=True)
                return Answer(message, tries=tries)
            except grpc.RpcError as error:
                answer = Answer(None, error.code(), *refusal(error), tries)
            if not answer.unknown or time.monotonic() >= end:
                return answer
            time.sleep(0.05)

    def list(self, **filters):
        """All jobs, page by page; None if the daemon went away meanwhile."""
        jobs, token = [], ""
        while True:
            answer = self.call("ListJobs", creep.ListJobsRequest(page_size=1000, page_token=token, **filters))
            if not answer.ok:
                return None
            jobs += answer.message.jobs
            token = answer.message.next_page_token
            if not token:
                return jobs
