#!/usr/bin/python3
"""The same job by creep-worker alone and under creepd with a watcher, in turns: what the service costs a job.

  overhead.py --bin BIN --work FOLDER --state FOLDER --turns N JOB.toml
"""
import argparse
import os
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path

from creep.v1 import creep_pb2 as creep

from client import Client
from daemon import Broken, Daemon, wait_until
from history import History
from watcher import Watcher

NICER = 5  # as creepd has it


def alone(options, spec):
    """(wall, processor) seconds."""
    folder = Path(options.work) / "alone"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    (folder / "job.toml").write_text(spec)
    start = time.monotonic()
    worker = subprocess.Popen([Path(options.bin) / "creep-worker", folder, "--threads", "1"],
                              preexec_fn=lambda: os.nice(NICER), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(worker.pid, 0)
    if status != 0:
        raise Broken(f"creep-worker ended with {status}")
    return time.monotonic() - start, used.ru_utime + used.ru_stime


def under_daemon(daemon, client, spec):
    """(wall, processor of the worker, processor of the daemon) seconds."""
    broken = []
    before, children, start = daemon.processor_seconds(), daemon.processor_seconds_of_workers(), time.monotonic()
    job = client.call("SubmitJob", creep.SubmitJobRequest(spec=spec)).message.job.id
    watcher = Watcher(daemon.address, History(job), 0, broken.append)
    wait_until(lambda: broken or watcher.ended, 600, "the job does not end")
    wall = time.monotonic() - start
    if broken or client.call("GetJob", creep.GetJobRequest(job=job)).message.state != creep.SUCCEEDED:
        raise Broken(f"the job did not end well {broken}")
    return wall, daemon.processor_seconds_of_workers() - children, daemon.processor_seconds() - before


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", required=True)
    parser.add_argument("--work", required=True)
    parser.add_argument("--state", required=True)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("job")
    options = parser.parse_args()
    spec = Path(options.job).read_text(encoding="utf-8")
    daemon = Daemon(options.bin, options.work, options.state, ["--slots", "1", "--threads-per-job", "1"])
    runs = []
    try:
        daemon.start()
        client = Client(daemon.address)
        for _ in range(options.turns):
            runs.append((*alone(options, spec), *under_daemon(daemon, client, spec)))
            print("alone: wall %.2f s, processor %.2f s; under creepd: wall %.2f s, processor %.2f s, "
                  "of the daemon %.2f s" % runs[-1], flush=True)
        daemon.stop()
    except Broken as broken:
        print(f"FAILED: {broken}")
        return 1
    finally:
        if daemon.process is not None:
            daemon.kill()
    wall, processor, daemon_wall, daemon_processor, service = (statistics.median(column) for column in zip(*runs))
    print(f"medians of {len(runs)}: the daemon spent {100 * service / daemon_wall:.2f} % of the job's time; "
          f"wall time {100 * (daemon_wall / wall - 1):+.2f} % ({daemon_wall - wall:+.2f} s), "
          f"processor of the worker {100 * (daemon_processor / processor - 1):+.2f} %")
    return 0


if __name__ == "__main__":
    sys.exit(main())
