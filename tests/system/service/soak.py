#!/usr/bin/python3
"""Random operations on a real creepd and its workers, against a model of what each job may be.

  soak.py --bin BIN --work FOLDER --state FOLDER --operations N --seed S JOB.toml REFERENCE [JOB.toml REFERENCE ...]

REFERENCE is the folder of an undisturbed run of the job file. With --disk FOLDER (a small file system that holds the
state) the disk becomes full now and then. Ends with 0 and a line of counts; else with what broke, the seed and the
operations. The choices follow the seed; what they meet also depends on how fast the machine is.

What must hold: an acknowledged job is there until it is deleted, once, whatever is repeated; its states follow one
another by history.NEXT, each with a cause; every answer agrees for ever with the numbered events; these are the same
for every watcher, without gap or repeat; a job ends once, bit for bit like the undisturbed run; attempts do not
overlap.
"""
import argparse
import json
import random
import sys
import threading
import time
import uuid
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import grpc
from creep.v1 import creep_pb2 as creep

from client import LOST, Client
from daemon import Broken, Daemon, Disk, wait_until
from history import FINAL, History, Reference, check_attempts, named
from watcher import Watcher, read_events

MOST_JOBS = 14
MOST_WATCHERS = 8
MOST_TRACED = 2000
PATIENCE = 60.0

WEIGHTS = {
    "submit": 12, "submit_again": 4, "fork": 6, "pause": 12, "resume": 12, "cancel": 5, "delete": 9, "watch": 10,
    "stop_watching": 4, "get": 4, "list": 3, "kill_worker": 9, "kill_daemon": 5, "kill_both": 4, "stop_daemon": 4,
    "fill_disk": 2, "wait": 8,
}


@dataclass
class Order:
    """A request that makes a job, sent until it is answered."""
    kind: int  # which job file
    method: str
    request: Any
    daemon_ends: int  # before it

    def __str__(self):
        return f"{self.method} {self.request.request_id[:8]}"


class Job:
    """What the client side knows of a job."""

    def __init__(self, job_id, order):
        self.id = job_id
        self.order = order
        self.history = History(job_id)
        self.asked = Counter()  # requests sent


class Soak:
    def __init__(self, options):
        self.random = random.Random(options.seed)
        self.daemon = Daemon(options.bin, options.work, options.state, [
            "--slots", "2", "--threads-per-job", "1", "--checkpoint-interval", "0.2", "--least-free", "0"],
            options.slower)
        self.slower = options.slower
        self.disk = Disk(options.disk) if options.disk else None
        files = list(zip(options.jobs[::2], options.jobs[1::2]))
        self.specs = [Path(spec).read_text(encoding="utf-8") for spec, _ in files]
        self.references = []
        for _, folder in files:
            summary = json.loads((Path(folder) / "summary.json").read_text())
            self.references.append(Reference(Path(folder), summary["state_digest"]))
        self.jobs = {}
        self.jobs_made = 0
        self.deleted = {}
        self.unanswered = []  # orders of jobs that may be there or not
        self.kills = Counter()  # of a job's worker
        self.watchers = []
        self.client = None
        self.daemon_ends = 0
        self.fills = 0
        self.counts = Counter()
        self.outcomes = Counter()
        self.most_memory = self.most_files = 0
        self.started = time.monotonic()
        self.trace = []
        self.broken = []

    # ---------------------------------------------------------------------------------------------------- telling

    def say(self, text):
        self.trace.append(f"{time.monotonic() - self.started:8.2f} s  {text}")

    def report(self, text):
        """What a watcher found."""
        self.broken.append(text)

    # ---------------------------------------------------------------------------------------------------- asking

    def patience(self):
        return 0.0 if self.disk and self.disk.full else PATIENCE * self.slower

    def ask(self, job, method, request, operation):
        """Of one job. The answer is held against the job's events in the end."""
        job.asked[operation] += 1
        answer = self.client.call(method, request, self.patience())
        if answer.ok:
            self.say(f"{operation} {job.id}: {' '.join(named(answer.message))}")
            job.history.add_answer(answer.message, operation)
        else:
            self.say(f"{operation} {job.id}: {answer} {answer.facts}")
            self.check_refusal(job, operation, answer)

    def check_refusal(self, job, operation, answer):
        if not answer.unknown and answer.reason != "WRONG_STATE":
            raise Broken(f"{operation} of job {job.id}, which was acknowledged: {answer} {answer.facts}")

    def a_job(self):
        return self.random.choice(list(self.jobs.values())) if self.jobs else None

    # ---------------------------------------------------------------------------------------------- making jobs

    def new_order(self, kind, method, request):
        request.request_id = str(uuid.UUID(int=self.random.getrandbits(128)))
        request.labels["order"] = request.request_id
        return Order(kind, method, request, self.daemon_ends)

    def submit(self):
        if len(self.jobs) >= MOST_JOBS:
            return self.delete()
        kind = self.random.randrange(len(self.specs))
        request = creep.SubmitJobRequest(spec=self.specs[kind], priority=self.random.randint(-2, 2))
        self.place(self.new_order(kind, "SubmitJob", request))

    def fork(self):
        parent = self.a_job()
        if parent is None or len(self.jobs) >= MOST_JOBS:
            return self.delete()
        self.place(self.new_order(parent.order.kind, "ForkJob", creep.ForkJobRequest(job=parent.id)))

    def place(self, order):
        answer = self.client.call(order.method, order.request, self.patience())
        self.say(f"{order}: {answer}" + (f" {answer.message.job.id}" if answer.ok else ""))
        if answer.ok:
            self.made(order, answer.message.job)
        elif answer.unknown:
            self.unanswered.append(order)
        elif not self.may_be_refused(order, answer):
            raise Broken(f"{order} was refused with {answer} {answer.facts}")

    def may_be_refused(self, order, answer):
        if self.fills and answer.code == grpc.StatusCode.RESOURCE_EXHAUSTED:
            return True
        return order.method == "ForkJob" and (
            answer.reason in ("CHECKPOINT_NOT_FOUND", "NOTHING_LEFT") or
            (answer.reason == "JOB_NOT_FOUND" and order.request.job not in self.jobs))

    def made(self, order, message):
        if message.labels["order"] != order.request.request_id:
            raise Broken(f"{order} was answered with the job of another order: {message.id}")
        if message.id in self.deleted:
            raise Broken(f"job {message.id} was deleted and is there again")
        if message.id not in self.jobs:
            self.jobs[message.id] = job = Job(message.id, order)
            self.jobs_made += 1
            if self.random.random() < 0.5:
                self.watch_job(job, 0)
        self.jobs[message.id].history.add_answer(message, order.method)

    def submit_again(self):
        """A client that did not get the answer."""
        known = [*self.jobs.values(), *self.deleted.values()]
        if not known:
            return
        job = self.random.choice(known)
        answer = self.client.call(job.order.method, job.order.request, self.patience())
        self.say(f"{job.order} again, of {job.id}: {answer}")
        parent_is_gone = job.order.method == "ForkJob" and answer.reason == "JOB_NOT_FOUND"
        if answer.unknown or parent_is_gone:
            return
        if job.id in self.deleted:
            if answer.reason != "REQUEST_ID_REUSED":
                raise Broken(f"the order of the deleted job {job.id}, repeated, was answered with {answer}")
        elif not answer.ok or answer.message.job.id != job.id or not answer.message.already_existed:
            raise Broken(f"the order of job {job.id}, repeated, was answered with {answer} {answer.message}")
        else:
            job.history.add_answer(answer.message.job, "order again")

    # ------------------------------------------------------------------------------------------- changing jobs

    def pause(self):
        if job := self.a_job():
            self.ask(job, "PauseJob", creep.PauseJobRequest(job=job.id), "pause")

    def resume(self):
        if job := self.a_job():
            self.ask(job, "ResumeJob", creep.ResumeJobRequest(job=job.id), "resume")

    def cancel(self):
        if job := self.a_job():
            mode = self.random.choice([creep.CancelJobRequest.CHECKPOINT, creep.CancelJobRequest.NOW])
            self.ask(job, "CancelJob", creep.CancelJobRequest(job=job.id, mode=mode), "cancel")

    def delete(self):
        """All about the job is checked before it goes."""
        job = self.a_job()
        if job is None or not self.check_job(job):
            return
        request = creep.DeleteJobRequest(job=job.id)
        answer = self.client.call("DeleteJob", request, self.patience())
        self.say(f"delete {job.id}: {answer}")
        tries = answer.tries
        if answer.unknown:
            self.free_disk()
            answer = self.client.call("DeleteJob", request, 10 * PATIENCE * self.slower)
            self.say(f"delete {job.id} again: {answer}")
            tries += answer.tries
        if answer.ok or (answer.reason == "JOB_NOT_FOUND" and tries > 1):
            self.deleted[job.id] = self.jobs.pop(job.id)
            job.history = History(job.id)
            if len(self.deleted) > 100:
                del self.deleted[next(iter(self.deleted))]
        else:
            self.check_refusal(job, "delete", answer)

    # --------------------------------------------------------------------------------------------------- reading

    def watch(self):
        if job := self.a_job():
            self.watch_job(job, self.random.choice([0, job.history.last()]))

    def watch_job(self, job, after_seq):
        if len(self.watchers) < MOST_WATCHERS:
            self.watchers.append(Watcher(self.daemon.address, job.history, after_seq, self.report))
            self.say(f"watch {job.id} behind {after_seq}")

    def stop_watching(self):
        if self.watchers:
            self.watchers.pop(self.random.randrange(len(self.watchers))).stop()

    def get(self):
        if job := self.a_job():
            self.ask(job, "GetJob", creep.GetJobRequest(job=job.id), "get")

    def list(self):
        listed = self.client.list()
        if listed is None:
            return
        self.say(f"list: {len(listed)} jobs")
        self.check_list(listed)

    # ---------------------------------------------------------------------------------------------------- trouble

    def kill_worker(self):
        workers = self.daemon.workers()
        if workers:
            job = self.random.choice(sorted(workers))
            self.kill_worker_of(job, workers[job])

    def kill_worker_of(self, job, process):
        self.kills[job] += 1
        if self.daemon.kill_worker(process):
            self.say(f"kill -9 worker of {job}")

    def kill_daemon(self):
        self.while_asking(lambda: self.end_daemon("kill -9 daemon", self.daemon.kill))

    def kill_both(self):
        def kill():
            workers = self.daemon.workers()
            self.end_daemon("kill -9 daemon and workers", self.daemon.kill)
            for job, process in workers.items():
                self.kill_worker_of(job, process)
        self.while_asking(kill)

    def stop_daemon(self):
        self.while_asking(lambda: self.end_daemon("stop daemon", self.daemon.stop))

    def end_daemon(self, how, end):
        self.note_size()
        self.daemon_ends += 1
        self.say(how)
        end()

    def while_asking(self, trouble):
        """Often something is being asked at that moment, and asked again until there is an answer."""
        asked = self.random.choice([None, "submit", "fork", "pause", "resume", "cancel", "submit_again"])
        delay, pause = self.random.random() * 0.01, self.random.random() * 0.2
        asking = None
        if asked and not (self.disk and self.disk.full):
            asking = threading.Thread(target=self.guarded, args=(getattr(self, asked),))
            asking.start()
            time.sleep(delay)
        trouble()
        time.sleep(pause)
        self.start_daemon()
        if asking:
            asking.join()

    def guarded(self, operation):
        try:
            operation()
        except Broken as broken:
            self.report(str(broken))

    def start_daemon(self):
        while not self.daemon.start():
            if not (self.disk and self.disk.full):
                raise Broken("creepd ends as soon as it is started")
            self.say("the daemon does not start on a full disk")
            self.free_disk()
        self.say("daemon serves")

    def fill_disk(self):
        if not self.disk or self.disk.full:
            return
        self.fills += 1
        self.say("fill the disk")
        self.disk.fill()
        for _ in range(self.random.randint(1, 6)):
            self.operate(self.choose())
            if not self.disk.full:
                return
        time.sleep(self.random.random())
        self.free_disk()

    def free_disk(self):
        if self.disk and self.disk.full:
            self.say("free the disk")
            self.disk.free()

    def wait(self):
        time.sleep(self.random.random() * 0.5)

    # --------------------------------------------------------------------------------------------------- checking

    def causes(self, job):
        daemon_ends = self.daemon_ends - job.order.daemon_ends
        return {
            "SUBMITTED": 1,
            # A worker that a killed daemon had just started may take the lease before that of the next daemon.
            "WORKER_LOST": self.kills[job.id] + daemon_ends,
            "DAEMON_STOPPED": daemon_ends,
            "PAUSE_REQUESTED": job.asked["pause"], "PAUSED_BY_USER": job.asked["pause"],
            "CANCEL_REQUESTED": job.asked["cancel"], "CANCELLED_BY_USER": job.asked["cancel"],
            # A resumption may show twice: asked of the worker that still ran, and queued when it had ended.
            **({} if self.fills else {"RESUMED": 2 * job.asked["resume"], "DISK_FULL": 0}),
        }

    def check_list(self, listed):
        ids = [job.id for job in listed]
        if len(set(ids)) != len(ids):
            raise Broken("a job is listed twice")
        if lost := set(self.jobs) - set(ids):
            raise Broken(f"acknowledged and lost: {sorted(lost)}")
        orders = Counter(job.labels["order"] for job in listed)
        if max(orders.values(), default=1) > 1:
            raise Broken(f"one order made two jobs: {orders.most_common(1)}")
        unanswered = {order.request.request_id for order in self.unanswered}
        if stray := {job.id for job in listed if job.labels["order"] not in unanswered} - set(self.jobs):
            raise Broken(f"nobody knows the jobs {sorted(stray)}")
        for job in listed:
            if job.id in self.jobs:
                self.jobs[job.id].history.add_answer(job, "list")

    def check_job(self, job):
        """False if the daemon is away or the storage full; else the job is well up to now."""
        answer = self.client.call("GetJob", creep.GetJobRequest(job=job.id), self.patience())
        if answer.unknown:
            return False
        if not answer.ok:
            raise Broken(f"job {job.id} was acknowledged; GetJob says {answer}")
        now = answer.message
        job.history.add_answer(now, "get")
        try:
            read_events(self.client, job.history, now.last_seq)
        except grpc.RpcError as error:
            if error.code() in LOST:
                return False
            raise Broken(f"job {job.id}: reading its events: {error.code().name} {error.details()}") from None
        job.history.check(self.causes(job))
        state = named(now)[0]  # the history may know more by now
        check_attempts(job.id, self.daemon.folder(job.id))
        reference = self.references[job.order.kind]
        reference.check_samples(job.id, job.history.samples(), state == "SUCCEEDED")
        if state == "SUCCEEDED":
            reference.check_result(job.id, now.state_digest, self.daemon.folder(job.id))
        self.outcomes[state] += 1
        return True

    def note_size(self):
        self.most_memory = max(self.most_memory, self.daemon.memory())
        self.most_files = max(self.most_files, self.daemon.open_files())

    # --------------------------------------------------------------------------------------------------- the run

    def choose(self):
        return self.random.choices(list(WEIGHTS), list(WEIGHTS.values()))[0]

    def operate(self, operation):
        self.counts[operation] += 1
        getattr(self, operation)()
        if not (self.disk and self.disk.full):
            self.place_again()
        self.check_watchers()

    def place_again(self):
        """The orders without an answer."""
        orders, self.unanswered = self.unanswered, []
        for order in orders:
            self.place(order)

    def check_watchers(self):
        if self.broken:
            raise Broken(self.broken[0])
        for watcher in self.watchers:
            if watcher.lost and watcher.history.job in self.jobs:
                raise Broken(f"a watcher was told that there is no job {watcher.history.job}")
        self.watchers = [watcher for watcher in self.watchers if not watcher.ended]

    def run(self, operations):
        self.client = Client(self.daemon.address)
        self.start_daemon()
        while sum(self.counts.values()) < operations:
            self.operate(self.choose())
            if len(self.trace) > MOST_TRACED:
                del self.trace[:MOST_TRACED // 2]
        self.finish()

    def finish(self):
        """Everything is let run to its end, and looked at once more after a restart."""
        self.say("finish")
        self.free_disk()
        self.place_again()
        for job in self.jobs.values():
            self.ask(job, "ResumeJob", creep.ResumeJobRequest(job=job.id), "resume")
        self.wait_for_ends()
        wait_until(lambda: self.broken or all(watcher.ended for watcher in self.watchers), PATIENCE * self.slower,
                   "watchers of finished jobs are not told so")
        self.check_watchers()
        self.end_daemon("stop daemon", self.daemon.stop)
        self.start_daemon()
        self.check_list(self.client.list())
        for job in self.jobs.values():
            if not self.check_job(job):
                raise Broken("the daemon does not answer")
        self.check_watchers()
        folders = {folder.name for folder in (self.daemon.state / "jobs").iterdir()}
        if folders != set(self.jobs):
            raise Broken(f"folders without a job or jobs without a folder: {sorted(folders ^ set(self.jobs))}")
        self.note_size()
        self.daemon.stop()

    def wait_for_ends(self):
        """However slow the machine: something must happen."""
        told, since = -1, time.monotonic()
        while True:
            self.check_watchers()
            jobs = self.client.list()
            if jobs is None:
                raise Broken("the daemon does not answer")
            if all(named(job)[0] in FINAL for job in jobs):
                return
            events = sum(job.last_seq for job in jobs)
            if events != told:
                told, since = events, time.monotonic()
            elif time.monotonic() - since > 3 * PATIENCE * self.slower:
                raise Broken(f"nothing happens: {[(job.id, *named(job), job.state_message) for job in jobs]}")
            time.sleep(0.2)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", required=True)
    parser.add_argument("--work", required=True)
    parser.add_argument("--state", required=True)
    parser.add_argument("--disk")
    parser.add_argument("--operations", type=int, required=True)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--slower", type=float, default=1.0, help="how much more patience than usual to have")
    parser.add_argument("jobs", nargs="+")
    options = parser.parse_args()
    soak = Soak(options)
    try:
        soak.run(options.operations)
    except Broken as broken:
        print(*soak.trace, sep="\n")
        print("creepd says:", *soak.daemon.log.read_text(errors="replace").splitlines()[-40:], sep="\n")
        print(f"FAILED: {broken}\nseed {options.seed}, after {sum(soak.counts.values())} operations (above)")
        return 1
    finally:
        if soak.daemon.process is not None:
            soak.daemon.kill()
        for process in soak.daemon.workers().values():
            soak.daemon.kill_worker(process)
    print(f"seed {options.seed}: {dict(soak.counts)}")
    print(f"{sum(soak.counts.values())} operations, {soak.jobs_made} jobs, "
          f"checked {dict(soak.outcomes)}; daemon ended {soak.daemon_ends} times, at most "
          f"{soak.most_memory >> 20} MiB resident and {soak.most_files} open files; "
          f"{time.monotonic() - soak.started:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
