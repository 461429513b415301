#!/usr/bin/python3
"""A long queue and many watchers: what they cost the daemon.

  load.py --bin BIN --work FOLDER --state FOLDER --jobs N --watchers M [--seconds S] RUNNING.toml QUEUED.toml

RUNNING.toml computes all the while in the only slot, N times QUEUED.toml waits behind it; M watchers, a few of them on
the running job, the others on waiting ones. Prints what was measured and checks it against the limits below, times
`--slower` (of a machine that does other things too). Memory has no such factor.
"""
import argparse
import statistics
import sys
import time

from creep.v1 import creep_pb2 as creep

from client import Client
from daemon import Broken, Daemon, wait_until
from history import History
from watcher import Watcher

MiB = 1 << 20


class Measured:
    def __init__(self, slower):
        self.slower = slower
        self.failed = []

    def tell(self, name, value, unit, limit=None, slower=True):
        limit = limit * self.slower if limit is not None and slower else limit
        good = limit is None or value < limit
        if not good:
            self.failed.append(name)
        print(f"{name:<46} {value:10.3f} {unit:<8}" + ("" if limit is None else f" limit {limit:g}") +
              ("" if good else "  TOO MUCH"), flush=True)


def timed(work, times):
    """Wall times [ms] of so many calls."""
    durations = []
    for i in range(times):
        start = time.perf_counter()
        answer = work(i)
        durations.append((time.perf_counter() - start) * 1e3)
        if not answer.ok:
            raise Broken(f"{answer} {answer.facts}")
    return durations


def tell_times(measured, name, durations, limit=None):
    measured.tell(f"{name}, median", statistics.median(durations), "ms", limit)
    measured.tell(f"{name}, 99th of 100", sorted(durations)[len(durations) * 99 // 100], "ms")


def fill_queue(daemon, client, measured, spec, count):
    """Ids of the jobs. Growth is that of the last third: the caches (2 MiB of SQLite) are full by then."""
    ids = []

    def submit(i):
        answer = client.call("SubmitJob", creep.SubmitJobRequest(spec=spec, request_id=f"load-{i}"))
        ids.append(answer.message.job.id if answer.ok else "")
        return answer

    early = count - count // 3
    first = timed(submit, early)
    before = daemon.memory()
    durations = first + timed(lambda i: submit(early + i), count - early)
    tell_times(measured, "submit", durations, 5.0)
    tell_times(measured, "submit, last tenth", durations[-(count // 10):], 5.0)
    measured.tell("resident memory", daemon.memory() / MiB, "MiB")
    measured.tell("memory per queued job", (daemon.memory() - before) / (count - early) / 1024, "KiB", 1.0, slower=False)
    return ids


def read_queue(client, measured, ids):
    for size, limit in ((50, 50.0), (1000, 50.0)):
        token = [""]

        def page(_, size=size, token=token):
            answer = client.call("ListJobs", creep.ListJobsRequest(page_size=size, page_token=token[0]))
            if answer.ok:
                token[0] = answer.message.next_page_token
            return answer

        tell_times(measured, f"list, page of {size}", timed(page, 50 if size == 50 else 20), limit)
    tell_times(measured, "get a queued job",
               timed(lambda i: client.call("GetJob", creep.GetJobRequest(job=ids[i * 37 % len(ids)])), 100), 5.0)
    some = ids[:: max(1, len(ids) // 50)]
    tell_times(measured, "pause a queued job",
               timed(lambda i: client.call("PauseJob", creep.PauseJobRequest(job=some[i])), len(some)), 10.0)
    tell_times(measured, "resume it",
               timed(lambda i: client.call("ResumeJob", creep.ResumeJobRequest(job=some[i])), len(some)), 10.0)
    listed = client.list()
    if len({job.id for job in listed}) != len(ids) + 1:
        raise Broken(f"{len(listed)} jobs are listed of {len(ids) + 1}")


def watch_queue(daemon, measured, running, ids, count, seconds):
    """Watchers that all have caught up, then nothing but the running job."""
    broken = []
    before = daemon.memory()
    watched = [running] * (count // 20) + [ids[i * 7 % len(ids)] for i in range(count - count // 20)]
    watchers = [Watcher(daemon.address, History(job), 0, broken.append) for job in watched]
    wait_until(lambda: broken or all(watcher.seq > 0 for watcher in watchers), 60, "watchers get nothing")
    measured.tell("memory per watcher", (daemon.memory() - before) / count / 1024, "KiB", 200, slower=False)
    time.sleep(2)
    memory, processor, start = daemon.memory(), daemon.processor_seconds(), time.monotonic()
    time.sleep(seconds)
    spent = daemon.processor_seconds() - processor
    measured.tell(f"processor while {count} watch", 100 * spent / (time.monotonic() - start), "%", 1.0)
    measured.tell(f"memory gained in {seconds:.0f} s", (daemon.memory() - memory) / MiB, "MiB", 1.0, slower=False)
    if broken:
        raise Broken(broken[0])
    for watcher in watchers:
        watcher.stop()
    for watcher in watchers:
        watcher.thread.join(30)
    time.sleep(1)
    measured.tell("memory kept when they have gone", (daemon.memory() - before) / MiB, "MiB", 20, slower=False)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", required=True)
    parser.add_argument("--work", required=True)
    parser.add_argument("--state", required=True)
    parser.add_argument("--jobs", type=int, required=True)
    parser.add_argument("--watchers", type=int, required=True)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--slower", type=float, default=1.0)
    parser.add_argument("running")
    parser.add_argument("queued")
    options = parser.parse_args()
    specs = []
    for path in (options.running, options.queued):
        with open(path, encoding="utf-8") as file:
            specs.append(file.read())
    daemon = Daemon(options.bin, options.work, options.state,
                    ["--slots", "1", "--threads-per-job", "1", "--least-free", "0"])
    measured = Measured(options.slower)
    try:
        daemon.start()
        client = Client(daemon.address)
        client.call("GetServerInfo", creep.GetServerInfoRequest())
        measured.tell("resident memory, no job", daemon.memory() / MiB, "MiB")
        running = client.call("SubmitJob", creep.SubmitJobRequest(spec=specs[0], priority=100)).message.job.id
        wait_until(lambda: client.call("GetJob", creep.GetJobRequest(job=running)).message.HasField("latest_sample"),
                   60, "the first job does not compute")
        ids = fill_queue(daemon, client, measured, specs[1], options.jobs)
        read_queue(client, measured, ids)
        watch_queue(daemon, measured, running, ids, options.watchers, options.seconds)
        measured.tell("resident memory in the end", daemon.memory() / MiB, "MiB", 150, slower=False)
        daemon.stop()
        start = time.monotonic()
        daemon.start()
        measured.tell("start again", time.monotonic() - start, "s", 5.0)
    except Broken as broken:
        print(f"FAILED: {broken}")
        return 1
    finally:
        if daemon.process is not None:
            daemon.kill()
        for process in daemon.workers().values():
            daemon.kill_worker(process)
    if measured.failed:
        print(f"FAILED: {', '.join(measured.failed)}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
