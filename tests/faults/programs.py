"""The real programs on a folder of their own, with or without faults, and what their results must be."""

import csv
import io
import json
import os
import signal
import subprocess
import threading
import time

PATIENCE = 180.0  # s: far beyond what a case takes, on a loaded machine too

TERMINAL = ("SUCCEEDED", "FAILED", "CANCELLED")
# server/rules/job.h, is_legal(): a job may also keep its state and change the reason.
LEGAL = {
    "QUEUED": ("RUNNING", "PAUSED", "CANCELLED"),
    "RUNNING": ("QUEUED", "PAUSED", "SUCCEEDED", "FAILED", "CANCELLED"),
    "PAUSED": ("QUEUED", "CANCELLED"),
}


class Problem(Exception):
    """What must not be: a lost job, another result, a wrong exit."""


def check(condition, problem):
    if not condition:
        raise Problem(problem)


def read(path):
    with open(path, "rb") as file:
        return file.read()


def text(path):
    return read(path).decode(errors="replace") if os.path.exists(path) else ""


def faults(library, root, **settings):
    """The environment in which the calls under `root` are counted, recorded or fail."""
    return {"LD_PRELOAD": library, "CREEP_FAULTS_ROOT": root,
            **{"CREEP_FAULTS_" + name.upper(): str(value) for name, value in settings.items()}}


class Programs:
    def __init__(self, bin_folder, job, work):
        self.bin, self.job, self.work = bin_folder, job, work
        self.library = os.path.join(os.path.dirname(bin_folder.rstrip("/")), "lib", "libstorage_faults.so")
        self.environment = {name: value for name, value in os.environ.items()
                            if not name.startswith(("CREEP", "XDG_"))}
        self.environment.update(LC_ALL="C", NO_COLOR="1")
        self.reference = os.path.join(work, "reference")
        check(self.run(self.reference)[0] == 0, "the undisturbed run failed")
        self.results = results(self.reference)

    def run(self, folder, environment=None):
        """creepctl run: exit code and what it said."""
        done = subprocess.run([self.bin + "/creepctl", "run", self.job, "--out", folder, "--threads", "1"],
                              env={**self.environment, **(environment or {})}, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=PATIENCE)
        return done.returncode, done.stdout.decode(errors="replace")

    def same_results(self, folder):
        found = results(folder)
        for name in sorted(set(found) | set(self.results)):
            check(found.get(name) == self.results.get(name),
                  f"{name} " + ("is missing" if name not in found else "differs from the undisturbed run's"))


def results(folder):
    """What must be equal, bit for bit, in two folders of the same job."""
    found = {}
    for name in ("samples.csv", "breakages.csv", "gsd.csv"):
        found[name] = text(os.path.join(folder, name))
    rows = csv.reader(io.StringIO(text(os.path.join(folder, "stages.csv"))))
    found["stages.csv"] = [row[:-2] for row in rows]  # the last two columns are cost
    try:
        found["state_digest"] = json.loads(text(os.path.join(folder, "summary.json")))["state_digest"]
    except (ValueError, KeyError):
        found["state_digest"] = "no summary.json"
    try:
        found["progress.json"] = json.loads(text(os.path.join(folder, "progress.json")))["state"]
    except (ValueError, KeyError):
        found["progress.json"] = "none"
    snapshots = os.path.join(folder, "snapshots")
    for name in os.listdir(snapshots) if os.path.isdir(snapshots) else ():
        found["snapshots/" + name] = read(os.path.join(snapshots, name))
    return found


class Daemon:
    """creepd on one state folder, started again whenever it ends, as a service manager does."""

    def __init__(self, programs, place, environment=None):
        self.programs, self.place = programs, place
        self.state = os.path.join(place, "disk", "state")
        self.log = os.path.join(place, "daemon.log")
        self.socket = os.path.join(place, "socket")
        self.environment = {**programs.environment, **(environment or {})}
        self.wanted = True
        self.exits = []
        self.process = None
        self._start()
        self.keeper = threading.Thread(target=self._keep)
        self.keeper.start()

    def _start(self):
        with open(self.log, "ab") as log:
            self.process = subprocess.Popen(
                [self.programs.bin + "/creepd", "--state", self.state, "--socket", self.socket, "--slots", "2",
                 "--threads-per-job", "1", "--least-free", "0", "--checkpoint-interval", "0.2"],
                env=self.environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log)

    def _keep(self):
        while True:
            self.exits.append(self.process.wait())
            if not self.wanted:
                return
            time.sleep(0.1)
            self._start()

    def stop(self):
        """SIGTERM; the exit code, which the caller judges."""
        self.wanted = False
        try:
            self.process.send_signal(signal.SIGTERM)
            self.keeper.join(PATIENCE)
        finally:
            self.process.kill()
            self.keeper.join()
        return self.exits[-1]

    def client(self, *arguments):
        """creepctl: exit code, stdout, stderr."""
        done = subprocess.run([self.programs.bin + "/creepctl", *arguments, "--server", "unix:" + self.socket],
                              env=self.programs.environment, stdin=subprocess.DEVNULL, capture_output=True,
                              timeout=PATIENCE)
        return done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace")

    def until_done(self, *arguments, accept=()):
        """Repeats a command until it succeeds or says one of the words; its stdout."""
        until = time.monotonic() + PATIENCE
        while True:
            code, out, said = self.client(*arguments)
            if code == 0 or any(word in said for word in accept):
                return out.strip()
            check(time.monotonic() < until, f"creepctl {' '.join(arguments)}: {said.strip()}")
            time.sleep(0.1)

    def jobs(self):
        listed = json.loads(self.until_done("ls", "--json"))
        return {job["id"]: job for job in listed}

    def folder(self, job):
        return os.path.join(self.state, "jobs", job)

    def events(self, job):
        """All events of a finished job, strictly in sequence and legal; {number: line}."""
        numbers, state, seen = {}, None, 0
        code, told, said = self.client("watch", job, "--after", "0", "--json")
        check(code in (0, 1, 3), f"creepctl watch: exit {code}: {said}")
        for line in told.splitlines():
            event = json.loads(line)
            check(event["seq"] == seen + 1 + event["skipped"], f"event {event['seq']} follows {seen}")
            seen = event["seq"]
            numbers[seen] = line
            if "state_change" not in event:
                continue
            before, state = state, event["state_change"]["state"]
            check(before is None or state == before or state in LEGAL.get(before, ()), f"{state} after {before}")
            check(before not in TERMINAL, f"{state} after the final {before}")
        check(state in TERMINAL, f"the last state told is {state}")
        return numbers
