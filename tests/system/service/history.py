"""All that was told about one job, by whomever, and what must hold for it whatever happened."""
import csv
import re
import threading
from collections import Counter

from creep.v1 import creep_pb2 as creep

from daemon import Broken

FINAL = {"SUCCEEDED", "FAILED", "CANCELLED"}

# A job in (state, reason) may come into these, and into no other. Nothing here is a fault of a program: with the
# programs as they are no kill, stop or full disk may look like one.
NEXT = {
    ("QUEUED", "SUBMITTED"): ["RUNNING", "PAUSED PAUSED_BY_USER", "CANCELLED CANCELLED_BY_USER"],
    ("RUNNING", ""): ["RUNNING PAUSE_REQUESTED", "RUNNING CANCEL_REQUESTED", "SUCCEEDED COMPLETED",
                      "QUEUED DAEMON_STOPPED", "QUEUED WORKER_LOST", "PAUSED DISK_FULL"],
    ("RUNNING", "PAUSE_REQUESTED"): ["PAUSED PAUSED_BY_USER", "SUCCEEDED COMPLETED", "RUNNING RESUMED",
                                     "RUNNING CANCEL_REQUESTED"],
    ("RUNNING", "CANCEL_REQUESTED"): ["CANCELLED CANCELLED_BY_USER", "SUCCEEDED COMPLETED"],
    ("PAUSED", "PAUSED_BY_USER"): ["QUEUED RESUMED", "CANCELLED CANCELLED_BY_USER"],
    ("PAUSED", "DISK_FULL"): ["QUEUED RESUMED", "PAUSED PAUSED_BY_USER", "CANCELLED CANCELLED_BY_USER"],
}
for reason in ("RESUMED", "DAEMON_STOPPED", "WORKER_LOST"):
    NEXT["QUEUED", reason] = NEXT["QUEUED", "SUBMITTED"]
# Paused and resumed before its worker had ended: the worker goes on, or ends and the job is queued again.
NEXT["RUNNING", "RESUMED"] = NEXT["RUNNING", ""] + ["QUEUED RESUMED"]


def named(message):
    """(state, reason) of a Job or a StateChange."""
    reason = creep.StateReason.Name(message.state_reason) if message.state_reason else ""
    return creep.JobState.Name(message.state), reason


class History:
    def __init__(self, job):
        self.job = job
        self.lock = threading.Lock()
        self.events = {}  # by number: the message as sent, without what belongs to the stream
        self.answers = []  # (last_seq, state, reason, operation)

    def add(self, event):
        """Any reader's event: the same number is the same event for everybody, for ever."""
        what = creep.Event()
        what.CopyFrom(event)
        what.skipped = 0
        sent = what.SerializeToString(deterministic=True)
        with self.lock:
            if self.events.setdefault(event.seq, sent) != sent:
                raise Broken(f"job {self.job}: event {event.seq} is told in two ways:\n{what}\n"
                             f"{creep.Event.FromString(self.events[event.seq])}")

    def last(self):
        """Number of the newest event known; all before it are known too."""
        with self.lock:
            return max(self.events, default=0)

    def add_answer(self, job, operation):
        with self.lock:
            self.answers.append((job.last_seq, *named(job), operation))

    def changes(self):
        """(number, state, reason, samples before it) of each change of state, in order; the events are complete."""
        with self.lock:
            numbers = sorted(self.events)
            if numbers != list(range(1, len(numbers) + 1)):
                gaps = [n for n, after in zip(numbers, numbers[1:]) if after != n + 1]
                raise Broken(f"job {self.job}: the events have gaps behind {gaps}")
            changes, samples = [], 0
            for number in numbers:
                event = creep.Event.FromString(self.events[number])
                if event.HasField("sample"):
                    if event.sample.index != samples:
                        raise Broken(f"job {self.job}: event {number} is sample {event.sample.index}, not {samples}")
                    samples += 1
                else:
                    changes.append((number, *named(event.state_change), samples))
            return changes

    def samples(self):
        with self.lock:
            events = [creep.Event.FromString(self.events[n]) for n in sorted(self.events)]
        return [event.sample for event in events if event.HasField("sample")]

    def check(self, causes):
        """Complete up to now: legal, caused, and as was answered. `causes`: most changes of each reason."""
        changes = self.changes()
        if not changes or changes[0][:3] != (1, "QUEUED", "SUBMITTED"):
            raise Broken(f"job {self.job} begins with {changes[:1]}")
        for (_, state, reason, _), (number, *after, _) in zip(changes, changes[1:]):
            if " ".join(after).strip() not in NEXT.get((state, reason), []):
                raise Broken(f"job {self.job}: event {number} leads from {state} {reason} to {' '.join(after)}")
        if changes[-1][1] in FINAL and changes[-1][0] != len(self.events):
            raise Broken(f"job {self.job}: there are events after its end")
        for reason, count in Counter(reason for _, _, reason, _ in changes).items():
            if reason in causes and count > causes[reason]:
                raise Broken(f"job {self.job}: {count} times {reason} for {causes[reason]} causes")
        for last, state, reason, operation in self.answers:
            then = [change[1:3] for change in changes if change[0] <= last]
            if last > len(self.events) or not then or then[-1] != (state, reason):
                raise Broken(f"job {self.job}: {operation} was answered with {state} {reason} at event {last}; "
                             f"now the events up to there say {then[-1:]}")


class Reference:
    """An undisturbed run of a job file, by the worker alone."""

    TABLES = ("samples.csv", "breakages.csv", "gsd.csv")

    def __init__(self, folder, digest):
        self.folder = folder
        self.digest = digest
        with open(folder / "samples.csv", encoding="utf-8") as file:
            self.rows = [{name.lower(): value for name, value in row.items()} for row in csv.DictReader(file)]

    def check_samples(self, job, samples, complete):
        """Those of the table, bit for bit, in order."""
        if len(samples) > len(self.rows) or (complete and len(samples) != len(self.rows)):
            raise Broken(f"job {job}: {len(samples)} samples instead of {len(self.rows)}")
        for sample, row in zip(samples, self.rows):
            for field in sample.DESCRIPTOR.fields:
                if field.name in row and getattr(sample, field.name) != float(row[field.name]):
                    raise Broken(f"job {job}: sample {sample.index} tells another {field.name}")

    def check_result(self, job, digest, folder):
        if digest != self.digest:
            raise Broken(f"job {job}: digest {digest} instead of {self.digest}")
        for table in self.TABLES:
            if (folder / table).read_bytes() != (self.folder / table).read_bytes():
                raise Broken(f"job {job}: another {table}")
        # The last two columns are cost.
        stages, wanted = ([line.rsplit(",", 2)[0] for line in (where / "stages.csv").read_text().splitlines()]
                          for where in (folder, self.folder))
        if stages != wanted:
            raise Broken(f"job {job}: another stages.csv")


def check_attempts(job, folder):
    """Who writes into worker.log holds the lease: no attempt begins there twice, or writes after a later one."""
    try:
        text = (folder / "worker.log").read_text(errors="replace")
    except FileNotFoundError:
        return
    latest, started = 0, set()
    for attempt, said in re.findall(r"^\S+Z attempt (\d+): (.*)$", text, re.MULTILINE):
        if int(attempt) < latest:
            raise Broken(f"job {job}: attempt {attempt} wrote after attempt {latest} had begun")
        latest = int(attempt)
        if said.startswith("started:"):
            if latest in started:
                raise Broken(f"job {job}: attempt {latest} began twice")
            started.add(latest)
