#!/usr/bin/python3
"""Faults and power cuts at every storage call of creepd, creep-worker and creepctl run.

    sweep.py BIN_FOLDER run     a fault at a call, then the same command again: the undisturbed result
    sweep.py BIN_FOLDER daemon  the same for creepd with jobs that it acknowledged
    sweep.py BIN_FOLDER run --cuts, daemon --cuts
                                what a power cut at any moment leaves is completed in the same way
    ... --without 'state/creepd.db-wal'
                                a control: fsync of these files (a pattern) does nothing, which must lead to exit 1

Ends with 1 and a line a case if there is a problem. The calls under one folder are counted and recorded by
storage_faults.cpp, what a power cut leaves is worked out by power_cut.py.
"""

import argparse
import collections
import concurrent.futures
import fnmatch
import hashlib
import json
import os
import random
import re
import shutil
import sys
import tempfile
import threading
import time
import traceback

sys.dont_write_bytecode = True
import daemon_scene
import power_cut
from programs import Problem, Programs, check, faults, text

# kind of fault, and whether it goes on until it is lifted
FAULTS = (("kill", False), ("enospc", False), ("eio", False), ("enospc", True), ("eio", True), ("short", False))
PROGRAMS = {"run": ("creepctl", "creep-worker"), "daemon": ("creepd",)}
# what a power cut leaves, and the records (storage_faults.cpp) after which it leaves something else than before
TELLING = {"kept": "CTWRLUMXN", "lost": "SDN", "renamed": "CRLUMXSDN", "torn": "CTWSDRLUMXN"}

Case = collections.namedtuple("Case", "name work")


def site(line):
    """A call with its path; numbers, job ids and the process taken out."""
    line = re.sub(r"^\d+ ", "", line.strip())
    return re.sub(r"jobs/[a-z0-9]{10}", "jobs/ID", re.sub(r"(?<=[._-])\d+|_\d+", "#", line))


def digest(tree, notes):
    sum_of = hashlib.sha256(str(notes).encode())
    for path, data in sorted(tree.items()):
        sum_of.update(f"{path} {'folder' if data is None else len(data)}\n".encode())
        sum_of.update(data or b"")
    return sum_of.digest()


class Sweep:
    def __init__(self, options, programs):
        self.options, self.programs = options, programs
        self.struck = collections.Counter()

    def place(self):
        return tempfile.mkdtemp(prefix="case-", dir=self.programs.work)

    def spread(self, items):
        """--cases of them, evenly."""
        wanted = self.options.cases
        if wanted == 0 or wanted >= len(items):
            return items
        offset = random.Random(self.options.seed).random()
        return [items[int((k + offset) * len(items) / wanted)] for k in range(wanted)]

    def outcome(self, case):
        """Nothing, or the problem in words."""
        place = self.place()
        try:
            case.work(place)
        except Problem as problem:
            return str(problem)
        except Exception:
            return traceback.format_exc()
        finally:
            if not self.options.keep:
                shutil.rmtree(place, ignore_errors=True)
        return None

    def carry_out(self, cases):
        problems, done = [], 0
        with concurrent.futures.ThreadPoolExecutor(self.options.jobs) as pool:
            futures = {pool.submit(self.outcome, case): case for case in cases}
            for future in concurrent.futures.as_completed(futures):
                done += 1
                if future.result() is not None:
                    problems.append(f"{futures[future].name}: {future.result()}")
                    print("PROBLEM", problems[-1], flush=True)
                    if len(problems) >= self.options.most_problems:
                        pool.shutdown(cancel_futures=True)
                        break
                elif self.options.verbose:
                    print("good", futures[future].name, flush=True)
        return done, problems

    # Faults

    def fault_cases(self, calls, scene):
        """Every kind of fault at each call; with --cases one kind by turns."""
        cases = []
        places = self.spread([(program, at) for program, last in calls.items() for at in range(1, last + 1)])
        for turn, (program, at) in enumerate(places):
            for kind, lasts in (FAULTS[(turn + self.options.seed) % len(FAULTS)],) if self.options.cases else FAULTS:
                name = f"{program} call {at} {kind}{' lasting' if lasts else ''}"
                cases.append(Case(name, lambda place, p=program, a=at, k=kind, l=lasts: scene(place, p, a, k, l)))
        return cases

    def settings(self, place, program, at, kind, lasts):
        mark = os.path.join(place, "mark")
        settings = {"program": program, "at": at, "kind": kind, "mark": mark}
        if lasts:
            settings["lasts"] = 1
        if kind == "eio" and self.options.reads:
            settings["reads"] = 1
        return mark, faults(self.programs.library, os.path.join(place, "disk"), **settings)

    def note_strike(self, mark, program, kind):
        if os.path.exists(mark):
            self.struck[f"{program} {kind} {site(text(mark))}"] += 1

    def run_fault(self, place, program, at, kind, lasts):
        folder = os.path.join(place, "disk", "run")
        os.mkdir(os.path.dirname(folder))
        mark, environment = self.settings(place, program, at, kind, lasts)
        code, said = self.programs.run(folder, environment)
        self.note_strike(mark, program, kind)
        allowed = {"kill": (0, 1, -9), "short": (0, 74)}.get(kind, (0, 74))
        check(code in allowed, f"exit {code} of the run that was struck: {said}")
        if lasts and code != 0:
            code, said = self.programs.run(folder, environment)
            check(code in (0, 74), f"exit {code} while the fault lasts: {said}")
        if os.path.exists(mark + ".lasts"):
            os.remove(mark + ".lasts")
        code, said = self.programs.run(folder)
        check(code == 0, f"exit {code} of the run after it: {said}")
        self.programs.same_results(folder)
        check_nothing_set_aside(folder)

    def daemon_fault(self, place, program, at, kind, lasts):
        os.mkdir(os.path.join(place, "disk"))
        mark, environment = self.settings(place, program, at, kind, lasts)
        over = threading.Event()

        def lift():  # a fault that lasts does so for a while
            while not over.wait(0.05):
                if os.path.exists(mark + ".lasts"):
                    over.wait(1.5)
                    os.remove(mark + ".lasts")
                    return

        lifting = threading.Thread(target=lift)
        lifting.start()
        scene = daemon_scene.DaemonScene(self.programs, place, environment)
        try:
            scene.act()
            scene.finish()
            for job in scene.succeeded:
                check_nothing_set_aside(scene.daemon.folder(job))
        finally:
            over.set()
            lifting.join()
            code = scene.end()
            self.note_strike(mark, program, kind)
        check(code == 0, f"creepd ended with {code} on SIGTERM")
        check(all(code in (-9, 1) for code in scene.daemon.exits[:-1]), f"creepd ended by itself: {scene.daemon.exits}")

    # Power cuts

    def cut_cases(self, journal, root, scene):
        """A case a distinct folder that a cut after some record leaves."""
        notes = [json.loads(record.data) if record.operation == "N" else None for record in journal]
        wanted = collections.defaultdict(list)
        for k, outcome in self.spread([(k, outcome) for k, record in enumerate(journal)
                                       for outcome in self.options.outcomes if record.operation in TELLING[outcome]]):
            wanted[k].append(outcome)
        disk, seen, cases = power_cut.Disk(root), set(), []
        for k, record in enumerate(journal):
            disk.apply(record)
            for outcome in wanted[k]:
                told = sum(note is not None for note in notes[:k + 1])
                key = digest(disk.after_cut(outcome, self.options.seed + k), told)
                if key in seen:
                    continue
                seen.add(key)
                after = site(f"{record.operation} {record.path[len(root) + 1:]}")

                def work(place, k=k, outcome=outcome):
                    again = power_cut.Disk(root)
                    for earlier in journal[:k + 1]:
                        again.apply(earlier)
                    power_cut.write_tree(again.after_cut(outcome, self.options.seed + k), os.path.join(place, "disk"))
                    scene(place, [note for note in notes[:k + 1] if note])

                cases.append(Case(f"cut after record {k} ({after}), {outcome}", work))
        return cases

    def recorded(self, path, root):
        """The journal, once it is sure that it tells everything."""
        journal = power_cut.read_journal(path)
        disk = power_cut.Disk(root)
        for record in journal:
            disk.apply(record)
        there = disk.after_cut("kept")
        for folder, _, files in os.walk(root):
            for file in files:
                relative = os.path.relpath(os.path.join(folder, file), root)
                if file.endswith("-shm") or file == "worker.log":
                    continue
                with open(os.path.join(folder, file), "rb") as real:
                    check(there.get(relative) == real.read(), f"the journal does not tell all of {relative}")
        return journal

    def pretending(self, journal, root, pattern):
        """The journal of programs in which fsync of these files does nothing."""
        left = [record for record in journal if record.operation not in "SD"
                or not fnmatch.fnmatch(record.path[len(root) + 1:], pattern)]
        check(len(left) < len(journal), f"no fsync has the path {pattern}")
        return left

    def controls(self, journal, root, scene):
        """Leaves out one fsync after another, by its file; whether the sweep notices."""
        sites = collections.Counter(site(r.path[len(root) + 1:]) or "." for r in journal if r.operation in "SD")
        for name, count in sorted(sites.items()):
            left = [r for r in journal if r.operation not in "SD" or (site(r.path[len(root) + 1:]) or ".") != name]
            done, problems = self.carry_out(self.cut_cases(left, root, scene))
            print(f"without fsync of {name} ({count} calls): "
                  + (f"cut {done}: {problems[0].splitlines()[0]}" if problems else f"nothing found in {done} cuts"),
                  flush=True)

    def run_cut(self, place, _):
        folder = os.path.join(place, "disk", "run")
        code, said = self.programs.run(folder)
        check(code == 0, f"exit {code} of the run after it: {said}")
        self.programs.same_results(folder)

    def daemon_cut(self, place, notes):
        scene = daemon_scene.DaemonScene(self.programs, place, {}, notes)
        try:
            scene.check_acknowledged()
            scene.finish()
        finally:
            code = scene.end()
        check(code == 0, f"creepd ended with {code} on SIGTERM")

    # The sweeps

    def cases(self):
        place = self.place()
        root = os.path.join(place, "disk")
        os.mkdir(root)
        journal = os.path.join(place, "journal")
        if self.options.cuts:
            environment = faults(self.programs.library, root, journal=journal)
            if self.options.scene == "run":
                # Killed halfway, so that cuts fall into a resumed run too.
                kill = {"program": "creep-worker", "at": 150, "kind": "kill", "mark": os.path.join(place, "mark")}
                killed = faults(self.programs.library, root, journal=journal, **kill)
                check(self.programs.run(root + "/run", killed)[0] == 1, "the recorded run was not killed")
                check(self.programs.run(root + "/run", environment)[0] == 0, "the recorded run failed")
                scene = self.run_cut
            else:
                self.daemon_undisturbed(place, environment, journal)
                scene = self.daemon_cut
            records = self.recorded(journal, root)
            for pattern in self.options.without:
                records = self.pretending(records, root, pattern)
            if self.options.controls:
                self.controls(records, root, scene)
                return []
            return self.cut_cases(records, root, scene)
        counts = {}
        for program in self.options.program or PROGRAMS[self.options.scene]:
            here = self.place()
            os.mkdir(here + "/disk")
            calls = os.path.join(here, "calls")
            settings = {"program": program, "calls": calls, **({"reads": 1} if self.options.reads else {})}
            environment = faults(self.programs.library, here + "/disk", **settings)
            if self.options.scene == "run":
                check(self.programs.run(here + "/disk/run", environment)[0] == 0, "the counted run failed")
            else:
                self.daemon_undisturbed(here, environment, None)
            lines = text(calls).splitlines()
            counts[program] = max(collections.Counter(line.split()[0] for line in lines).values())
            print(f"{program}: {counts[program]} calls at {len({site(line) for line in lines})} sites", flush=True)
        return self.fault_cases(counts, self.run_fault if self.options.scene == "run" else self.daemon_fault)

    def daemon_undisturbed(self, place, environment, journal):
        scene = daemon_scene.DaemonScene(self.programs, place, environment, journal=journal)
        try:
            scene.act()
            scene.finish()
        finally:
            code = scene.end()
        check(code == 0, f"creepd ended with {code} on SIGTERM")


def check_nothing_set_aside(folder):
    """A fault that is no damage must not look like one."""
    for name in os.listdir(folder) + os.listdir(os.path.join(folder, "checkpoints")):
        check(not name.startswith(("bad.", "samples.log.damaged")), f"{name} was set aside")


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin")
    parser.add_argument("scene", choices=("run", "daemon"))
    parser.add_argument("--cuts", action="store_true", help="power cuts instead of faults")
    parser.add_argument("--cases", type=int, default=0, help="only so many, evenly spread (default: all)")
    parser.add_argument("--seed", type=int, default=1, help="which these are, and what torn cuts leave")
    parser.add_argument("--jobs", type=int, default=2, help="cases at once")
    parser.add_argument("--program", action="append", help="whose calls fail (daemon: creepd, creep-worker)")
    parser.add_argument("--reads", action="store_true", help="eio strikes reading calls too")
    parser.add_argument("--outcomes", nargs="+", choices=TELLING, default=list(TELLING))
    parser.add_argument("--without", action="append", default=[], help="pattern of the paths whose fsync is pretended")
    parser.add_argument("--controls", action="store_true", help="each fsync left out in turn, until the sweep notices")
    parser.add_argument("--most-problems", type=int, default=20, help="stop after so many")
    parser.add_argument("--keep", action="store_true", help="keep the folders")
    parser.add_argument("--verbose", action="store_true")
    return parser.parse_args()


def main():
    options = parse()
    work = tempfile.mkdtemp(prefix="creep-faults-", dir="/tmp")  # short: the path of a socket has at most 107 bytes
    started = time.monotonic()
    job = os.path.join(os.path.dirname(os.path.abspath(__file__)), "tiny.toml")
    try:
        programs = Programs(os.path.abspath(options.bin), job, work)
        sweep = Sweep(options, programs)
        cases = sweep.cases()
        print(f"{len(cases)} cases", flush=True)
        done, problems = sweep.carry_out(cases)
    except Problem as problem:
        print(f"FAILED: {problem}")
        return 2
    finally:
        if options.keep:
            print(work)
        else:
            shutil.rmtree(work, ignore_errors=True)
    if sweep.struck:
        print(f"{sum(sweep.struck.values())} faults struck at {len(sweep.struck)} combinations of call, file and kind")
    print(f"{done} cases, {len(problems)} problems, {time.monotonic() - started:.0f} s")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
