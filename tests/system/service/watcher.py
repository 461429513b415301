"""A reader of one job's events that watches again after every lost connection, as creepctl does."""
import threading
import time

import grpc
from creep.v1 import creep_pb2 as creep

from client import CALL_LIMIT, LOST, Client, refusal
from daemon import Broken


class Watcher:
    def __init__(self, address, history, after_seq=0, report=None):
        self.client = Client(address)
        self.history = history
        self.seq = after_seq
        self.report = report  # takes what broke
        self.ended = False    # by the service: the final event was seen, or the job is gone
        self.lost = False     # the job is gone
        self.stopping = False
        self.stream = None
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        try:
            while not self.stopping and not self.ended:
                self.follow()
        except Broken as broken:
            self.report(str(broken))
        finally:
            self.client.close()

    def follow(self):
        job = self.history.job
        try:
            self.stream = self.client.service.WatchJob(creep.WatchJobRequest(job=job, after_seq=self.seq, every_sample=True),
                                                       wait_for_ready=True)
            if self.stopping:  # meanwhile
                return self.stream.cancel()
            for event in self.stream:
                self.take(event)
            self.ended = True
        except grpc.RpcError as error:
            if self.stopping:
                return
            reason, facts = refusal(error)
            if reason == "JOB_NOT_FOUND":
                self.lost = self.ended = True
            elif error.code() not in LOST:
                raise Broken(f"job {job}: a watcher behind event {self.seq} was told {error.code().name} {reason} "
                             f"{facts}") from None
            else:
                time.sleep(0.02)

    def take(self, event):
        if event.seq == 0:
            if event.heartbeat.last_seq < self.seq:
                raise Broken(f"job {self.history.job}: a heartbeat behind event {self.seq} says there are only "
                             f"{event.heartbeat.last_seq}")
            return
        if event.seq != self.seq + event.skipped + 1:
            raise Broken(f"job {self.history.job}: event {event.seq} after {self.seq}, {event.skipped} skipped")
        self.history.add(event)
        self.seq = event.seq

    def stop(self):
        self.stopping = True
        if self.stream is not None:
            self.stream.cancel()


def read_events(client, history, last_seq):
    """All events up to this one, anew."""
    stream = client.service.WatchJob(creep.WatchJobRequest(job=history.job, every_sample=True), timeout=CALL_LIMIT)
    seq = 0
    while seq < last_seq:
        event = next(stream)
        if event.seq == 0:
            continue
        if event.seq != seq + 1:
            raise Broken(f"job {history.job}: event {event.seq} after {seq} in a whole reading")
        history.add(event)
        seq = event.seq
    stream.cancel()
