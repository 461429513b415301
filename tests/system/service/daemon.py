"""A creepd of the test's own, its workers and its disk: started, killed, stopped, filled, measured."""
import os
import signal
import subprocess
import time
from pathlib import Path

from client import Client


class Broken(Exception):
    """What must always hold does not."""


def wait_until(condition, seconds, what):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise Broken(f"waited {seconds} s in vain: {what}")
        time.sleep(0.02)


class Daemon:
    def __init__(self, bin_folder, work, state, options, slower=1.0):
        """`slower`: how much longer than usual it may take to start and to stop."""
        self.slower = slower
        self.bin = Path(bin_folder)
        self.work = Path(work)
        self.state = Path(state)
        self.options = options
        self.address = f"unix:{self.work}/creepd.sock"
        self.log = self.work / "daemon.log"
        self.process = None

    def start(self):
        """True when it serves; False if it ended by itself."""
        with open(self.log, "ab") as log:
            self.process = subprocess.Popen(
                [self.bin / "creepd", "--state", self.state, "--socket", self.work / "creepd.sock", *self.options],
                stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        client = Client(self.address)
        wait_until(lambda: self.process.poll() is not None or client.serves(), 120 * self.slower,
                   "creepd does not serve")
        client.close()
        if self.process.poll() is None:
            return True
        self.process = None
        return False

    def kill(self):
        self.process.kill()
        self.process.wait()
        self.process = None

    def stop(self):
        """As a service manager does; must end well."""
        self.process.terminate()
        try:
            code = self.process.wait(timeout=200 * self.slower)
        except subprocess.TimeoutExpired:
            raise Broken("creepd does not end on SIGTERM") from None
        self.process = None
        if code != 0:
            raise Broken(f"creepd ended with {code} on SIGTERM")

    def folder(self, job):
        return self.state / "jobs" / job

    def workers(self):
        """Process of each job that has one."""
        found = {}
        jobs = str(self.state / "jobs") + "/"
        for entry in os.listdir("/proc"):
            if not entry.isdigit():
                continue
            try:
                words = Path("/proc", entry, "cmdline").read_bytes().decode(errors="replace").split("\0")
            except OSError:
                continue
            if len(words) > 1 and words[0].endswith("/creep-worker") and words[1].startswith(jobs):
                found[words[1][len(jobs):]] = int(entry)
        return found

    def kill_worker(self, process):
        try:
            os.kill(process, signal.SIGKILL)
        except ProcessLookupError:
            return False
        return True

    def memory(self):
        """Resident memory of the daemon [bytes]."""
        pages = int(Path("/proc", str(self.process.pid), "statm").read_text().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE")

    def open_files(self):
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def processor_seconds(self):
        return self.statistics(11)

    def processor_seconds_of_workers(self):
        """Of those that have ended."""
        return self.statistics(13)

    def statistics(self, first):
        """Sum of user and system time of proc(5), stat [s]."""
        words = Path("/proc", str(self.process.pid), "stat").read_text().rsplit(") ", 1)[1].split()
        return (int(words[first]) + int(words[first + 1])) / os.sysconf("SC_CLK_TCK")


class Disk:
    """The small file system that the state is on."""

    def __init__(self, folder):
        self.ballast = Path(folder) / "ballast"
        self.full = False

    def fill(self):
        self.full = True
        with open(self.ballast, "ab", buffering=0) as file:
            try:
                while file.write(bytes(4096)) > 0:
                    pass
            except OSError:
                pass

    def free(self):
        self.ballast.unlink(missing_ok=True)
        self.full = False
