"""Four jobs with everything that is asked of a daemon, and what it acknowledged must hold afterwards."""

import json
import os
import subprocess
import threading
import time

import power_cut
from programs import PATIENCE, TERMINAL, Daemon, check

# what is done with each job, in this order; the runner and the paused one run to their ends
STEPS = (
    ("submit", "runner"),
    ("submit", "paused"),
    ("pause", "paused"),
    ("submit", "cancelled"),
    ("cancel", "cancelled"),
    ("submit", "deleted"),
    ("resume", "paused"),
    ("end", "deleted"),
    ("delete", "deleted"),
)


class DaemonScene:
    def __init__(self, programs, place, environment, notes=(), journal=None):
        """With notes: what was asked and answered before the power cut that this state comes from."""
        self.programs, self.journal = programs, journal
        self.ids = {}
        self.asked = []
        self.answered = []
        self.seen = {}
        self.succeeded = []
        for note in notes:
            if note["what"] == "seen":
                self.seen.setdefault(note["job"], {})[note["seq"]] = note["line"]
            else:
                getattr(self, note["what"]).append((note["step"], note["job"]))
                if "id" in note:
                    self.ids[note["job"]] = note["id"]
        os.makedirs(os.path.join(place, "disk"), exist_ok=True)
        self.daemon = Daemon(programs, place, environment)
        self.watcher = None

    def _note(self, **what):
        if self.journal:
            power_cut.note(self.journal, json.dumps(what))

    def act(self):
        for step, job in STEPS:
            self.asked.append((step, job))
            self._note(what="asked", step=step, job=job)
            if step == "submit":
                said = self.daemon.until_done("submit", self.programs.job, "--request-id", "request-" + job)
                self.ids[job] = said
            elif step == "end":
                self._see_to_end(self.ids[job])
            elif step == "delete":
                # Asked again after an answer that was lost, there is nothing left to delete.
                self.daemon.until_done("delete", self.ids[job], accept=("no job",))
            else:
                # The job may be done, or fallen to an error of the storage, before it is to be paused.
                self.daemon.until_done(step, self.ids[job], accept=("cannot be paused", "cannot be resumed"))
            self.answered.append((step, job))
            self._note(what="answered", step=step, job=job, id=self.ids[job])
            if (step, job) == ("submit", "runner") and self.journal:
                self._watch()
            if (step, job) == ("resume", "paused") and self.journal:
                self.daemon.process.kill()  # so that cuts fall into a recovery too

    def _watch(self):
        """Notes each event of the runner once somebody was told it."""
        process = subprocess.Popen(
            [self.programs.bin + "/creepctl", "watch", self.ids["runner"], "--after", "0", "--json", "--server",
             "unix:" + self.daemon.socket], env=self.programs.environment, stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL, text=True)

        def follow():
            for line in process.stdout:
                event = json.loads(line)
                self._note(what="seen", job="runner", seq=event["seq"], line=line.rstrip("\n"))
            process.wait()

        self.watcher = threading.Thread(target=follow)
        self.watcher.start()

    def check_acknowledged(self):
        """Right after a restart: nothing that was answered is undone."""
        jobs = self.daemon.jobs()
        for name, job in self.ids.items():
            asked = [step for step, of in self.asked if of == name]
            answered = [step for step, of in self.answered if of == name]
            if "delete" in asked:
                check("delete" not in answered or job not in jobs, f"the {name} job is back")
                continue
            check(job in jobs, f"the {name} job was acknowledged and is lost")
            state = jobs[job]["state"]
            if "cancel" in answered:
                check(state == "CANCELLED", f"the {name} job was cancelled and is {state}")
            if "pause" in answered and "resume" not in asked:
                check(state in ("PAUSED", "SUCCEEDED"), f"the {name} job was paused and is {state}")

    def finish(self):
        """Sees every job to its end, which must be the right one."""
        jobs = self._see_to_end()
        if self.watcher:
            self.watcher.join(PATIENCE)
        self._check_ends(jobs)

    def _see_to_end(self, only=None):
        """Waits for all jobs or for one, with the hand that a failed storage needs; the jobs."""
        until = time.monotonic() + PATIENCE
        while True:
            jobs = self.daemon.jobs()
            waiting = [job for job in jobs.values() if job["state"] not in TERMINAL and only in (None, job["id"])]
            if not waiting:
                return jobs
            check(time.monotonic() < until, f"not finished: {[(j['state'], j['state_message']) for j in waiting]}; "
                  + self._log())
            for job in waiting:
                # A full disk is waited out without a hand; a failed one wants a look at it.
                if job["state"] == "PAUSED" and job["state_reason"] != "DISK_FULL":
                    self.daemon.client("resume", job["id"])
            time.sleep(0.1)

    def _check_ends(self, jobs):
        for name, job in self.ids.items():
            steps = [step for step, of in self.asked if of == name]
            if "delete" in steps and ("delete", name) in self.answered:
                check(job not in jobs, f"the {name} job is back")
                self._wait_until(lambda: not os.path.exists(self.daemon.folder(job)),
                                 f"the files of the {name} job are left")
        for job in jobs.values():
            name = next((name for name, id in self.ids.items() if id == job["id"]), "unacknowledged")
            cancelled = any(step == "cancel" and of == name for step, of in self.asked)
            wanted = ("CANCELLED", "SUCCEEDED") if cancelled else ("SUCCEEDED",)
            if ("cancel", name) in self.answered:
                wanted = ("CANCELLED",)
            check(job["state"] in wanted, f"the {name} job is {job['state']}: {job['state_message']} {job['log_tail']}")
            events = self.daemon.events(job["id"])
            check(max(events) == job["last_seq"], f"{max(events)} of {job['last_seq']} events of the {name} job")
            for seq, line in self.seen.get(name, {}).items():
                check(seq not in events or events[seq] == line, f"event {seq} was told and is now another one")
            if job["state"] == "SUCCEEDED":
                self.programs.same_results(self.daemon.folder(job["id"]))
                check(job["state_digest"] == self.programs.results["state_digest"], "the daemon tells another digest")
                self.succeeded.append(job["id"])

    @staticmethod
    def _wait_until(condition, problem):
        until = time.monotonic() + PATIENCE
        while not condition():
            check(time.monotonic() < until, problem)
            time.sleep(0.1)

    def _log(self):
        with open(self.daemon.log, encoding="utf-8", errors="replace") as log:
            return log.read()[-2000:]

    def end(self):
        """Stops the daemon; its exit code."""
        return self.daemon.stop()
