#!/usr/bin/env python3
"""Where each method breaks, found by bisection; question and reading in README.md.

  study.py OUT --bin BIN [--particles N] [--seeds N...] [--at-once N] [--into FOLDER] [PROBE...]

Each probe turns one input from a sound value to its end; every seed runs at every value. A finished run is read again, not
computed again. Writes runs.csv and table.md.
"""
import argparse
import concurrent.futures
import csv
import dataclasses
import json
import math
import pathlib
import shutil
import subprocess
import sys

# Short stages that end by the drift criterion, so that a run takes seconds; everything else is the default.
BASE = {
    "specimen": {"void_ratio": 0.75},
    "material": {},
    "numerics": {"minimum_cycles": 1000, "drift_tolerance": 0.1, "unbalanced_tolerance": 0.001, "loading_velocity": '"0.2 m/s"'},
}
PROGRAM = """[[program]]
stage = "oedometric"
until = { axial_stress = "21.7 MPa" }

[[program]]
stage = "creep"
duration = "1 d"
"""
UNEXPLAINED = 0.02  # of the energy put in: a run that ends well beyond it is wrong, and nobody was told


@dataclasses.dataclass
class Probe:
    name: str
    section: str
    key: str
    values: tuple  # from sound to the end of what is taken
    written: str = "{:.6g}"
    extra: tuple = ()  # (section, key, value)
    whole: bool = False  # only whole numbers
    theory: str = ""


def grading(ratio):
    return f'{{ points = [["{0.42 / ratio:.6g} mm", 0.0], ["0.42 mm", 1.0]] }}'


UNBREAKABLE = ("material", "crushing", "false")
PROBES = (
    Probe("time step, grains that do not break", "numerics", "time_step_safety", (0.35, 0.5, 0.7, 0.85, 1.0), extra=(UNBREAKABLE,),
          theory="the lattice of tests/validation breaks at 0.5137 sqrt(m/kn), 1.26 times the bound that the step is a fraction of"),
    Probe("time step, with fragments", "numerics", "time_step_safety", (0.35, 0.5, 0.7, 0.85, 1.0),
          theory="as above until a split; then fragments press into their neighbours at full strength"),
    Probe("loading velocity, m/s", "numerics", "loading_velocity", (0.1, 0.3, 1.0, 3.0, 10.0), written='"{:.6g} m/s"',
          theory="inertial number 0.1: grains collide rather than bear"),
    Probe("breakages a jump", "numerics", "breakages_per_ageing", (1, 3, 10, 30, 100, 300), written="{:.0f}", whole=True),
    Probe("cycles a stage at least", "numerics", "minimum_cycles", (1000, 300, 100, 30, 10), written="{:.0f}", whole=True),
    Probe("unbalanced force ratio of a settled stage", "numerics", "unbalanced_tolerance", (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-9)),
    Probe("stress tolerance of a settled stage", "numerics", "settle_tolerance", (0.005, 1e-3, 1e-4, 1e-5, 1e-6)),
    Probe("local damping, downwards", "numerics", "local_damping", (0.7, 0.5, 0.3, 0.1, 0.03, 0.0)),
    Probe("local damping, upwards", "numerics", "local_damping", (0.7, 0.8, 0.9, 0.95)),
    Probe("cycles between failure checks", "numerics", "failure_check_interval", (1, 10, 100, 1000, 10000), written="{:.0f}", whole=True),
    Probe("roughness, um, downwards", "material", "roughness", (0.6, 0.1, 0.01, 0.001, 0.0), written='"{:.6g} um"'),
    Probe("roughness, um, upwards", "material", "roughness", (0.6, 2.0, 5.0, 20.0, 100.0), written='"{:.6g} um"'),
    Probe("friction", "material", "friction", (0.275, 0.0)),
    Probe("friction, upwards", "material", "friction", (0.275, 0.5, 1.0, 2.0)),
    Probe("friction at the walls", "material", "wall_friction", (0.0, 0.275, 1.0, 2.0)),
    Probe("wall stiffness factor, downwards", "material", "wall_stiffness_factor", (1.0, 0.3, 0.1)),
    Probe("wall stiffness factor, upwards", "material", "wall_stiffness_factor", (1.0, 3.0, 10.0)),
    Probe("corrosion index, downwards", "material", "corrosion_index", (60.0, 30.0, 10.0, 3.0, 1.0)),
    Probe("corrosion index, upwards", "material", "corrosion_index", (60.0, 100.0, 200.0)),
    Probe("strength floor", "material", "strength_floor", (0.05, 0.01, 0.003, 0.001)),
    Probe("mean strength, GPa", "material", "limit_stress", (3.75, 2.5, 1.5, 1.0, 0.5), written='"{:.6g} GPa"'),
    Probe("size ratio of the grains", "specimen", "grading", (2.0, 4.0, 6.0, 10.0, 16.0)),
    Probe("inertia of fragments scaled, time step", "numerics", "time_step_safety", (0.35, 0.5, 0.7, 0.85, 1.0),
          extra=(("numerics", "inertia_scaling", '"fragments"'),)),
    Probe("all inertia scaled, time step", "numerics", "time_step_safety", (0.35, 0.5, 0.7, 0.85, 1.0),
          extra=(("numerics", "inertia_scaling", '"all"'),)),
    Probe("all inertia scaled, loading velocity, m/s", "numerics", "loading_velocity", (0.1, 0.3, 1.0, 3.0, 10.0),
          written='"{:.6g} m/s"', extra=(("numerics", "inertia_scaling", '"all"'),)),
)


def written(probe, value):
    return grading(value) if probe.key == "grading" else probe.written.format(value)


def job_text(probe, value, seed, particles):
    sections = {title: dict(values) for title, values in BASE.items()}
    sections["specimen"] |= {"particles": particles, "seed": seed}
    for title, key, text in (*probe.extra, (probe.section, probe.key, written(probe, value))):
        sections[title][key] = text
    head = "".join(f"[{title}]\n" + "".join(f"{key} = {text}\n" for key, text in values.items()) + "\n"
                   for title, values in sections.items())
    return head + PROGRAM


def read(folder):
    summary = json.loads((folder / "summary.json").read_text())
    figures = summary["figures"]
    with open(folder / "samples.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    put_in = max(float(row["wall_work_J"]) for row in rows) + float(rows[0]["normal_elastic_J"])
    unexplained = max(abs(float(row["energy_unexplained_J"])) for row in rows) / put_in
    advice = json.loads((folder / "verdict.json").read_text())["advice"]
    return {"outcome": summary["outcome"], "reason": summary["reason"], "advice": advice,
            "void_ratio": figures.get("void_ratio"), "creep_strain": figures.get("axial_creep_strain"),
            "largest_ripple": figures.get("largest_ripple"), "unexplained": unexplained, "cycles": figures.get("cycles")}


class Atlas:
    def __init__(self, options):
        self.options = options
        self.rows = []
        self.pool = concurrent.futures.ThreadPoolExecutor(options.at_once)

    def run(self, probe, value, seed):
        name = f"{PROBES.index(probe):02d}_{value:.6g}_{seed}"
        folder = self.options.out / name
        if not (folder / "summary.json").exists():
            shutil.rmtree(folder, ignore_errors=True)
            job = self.options.out / f"{name}.toml"
            job.write_text(job_text(probe, value, seed, self.options.particles))
            done = subprocess.run([self.options.bin / "creepctl", "run", job, "--out", folder, "--threads", "1"],
                                  capture_output=True, text=True, check=False)
            if not (folder / "summary.json").exists():
                raise RuntimeError(f"{job}: exit {done.returncode}: {done.stderr}")
        row = {"probe": probe.name, "value": value, "seed": seed} | read(folder)
        row["sound"] = row["outcome"] != "guard_stop" and row["unexplained"] < UNEXPLAINED
        return row

    def try_value(self, probe, value):
        """Whether all seeds end soundly there."""
        rows = list(self.pool.map(lambda seed: self.run(probe, value, seed), self.options.seeds))
        self.rows += rows
        return all(row["sound"] for row in rows)

    def explore(self, probe):
        """(last sound value, first broken one or None)."""
        good = None
        for value in probe.values:
            if self.try_value(probe, value):
                good = value
                continue
            return self.bisect(probe, good, value)
        return good, None

    def bisect(self, probe, good, bad):
        for _ in range(4 if good is not None else 0):
            middle = math.sqrt(good * bad) if good > 0 and bad > 0 else 0.5 * (good + bad)
            middle = float(f"{round(middle) if probe.whole else middle:.3g}")
            if middle in (good, bad):
                break
            good, bad = (middle, bad) if self.try_value(probe, middle) else (good, middle)
        return good, bad


def what_is_seen(rows):
    reasons = sorted({row["reason"].split(":")[0] for row in rows if row["outcome"] == "guard_stop"})
    silent = sum(row["outcome"] != "guard_stop" and not row["sound"] for row in rows)
    seen = [f"`{reason}`, {sum(row['reason'].startswith(reason + ':') for row in rows)} of {len(rows)} seeds" for reason in reasons]
    if silent:
        seen.append(f"nothing: {silent} of {len(rows)} seeds end with more than {UNEXPLAINED:.0%} of the energy unexplained")
    return "; ".join(seen)


def mean(rows, key):
    values = [row[key] for row in rows if row["sound"] and row[key] is not None]
    return sum(values) / len(values) if values else math.nan


def table(atlas, limits):
    lines = ["| turned | from | holds to | breaks at | what the user sees there | creep strain at the start, at the last that holds, % | "
             "largest unexplained energy while it holds, % | theory |", "|---|---|---|---|---|---|---|---|"]
    for probe, (good, bad) in limits:
        of = [row for row in atlas.rows if row["probe"] == probe.name]
        first = [row for row in of if row["value"] == probe.values[0]]
        last = [row for row in of if row["value"] == good]
        broken = [row for row in of if row["value"] == bad]
        seen = what_is_seen(broken) if bad is not None else "the end of what is taken; nothing breaks"
        held = max((100 * row["unexplained"] for row in of if row["sound"]), default=math.nan)
        lines.append(f"| {probe.name} | {probe.values[0]:.4g} | {'-' if good is None else f'{good:.4g}'} | "
                     f"{'-' if bad is None else f'{bad:.4g}'} | {seen} | {100 * mean(first, 'creep_strain'):.2f}, "
                     f"{100 * mean(last, 'creep_strain'):.2f} | {held:.2g} | {probe.theory} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("probes", nargs="*", metavar="PROBE", help="words of names; none: all")
    parser.add_argument("--bin", type=pathlib.Path, default=pathlib.Path("build/release/bin"))
    parser.add_argument("--particles", type=int, default=400)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--at-once", type=int, default=2)
    parser.add_argument("--into", type=pathlib.Path, help="folder for runs.csv and table.md (default: OUT)")
    options = parser.parse_intermixed_args()
    options.out, options.bin = options.out.resolve(), options.bin.resolve()
    options.out.mkdir(parents=True, exist_ok=True)
    atlas, limits = Atlas(options), []
    for probe in PROBES:
        if options.probes and not any(word in probe.name for word in options.probes):
            continue
        limits.append((probe, atlas.explore(probe)))
        print(f"{probe.name}: holds to {limits[-1][1][0]}, breaks at {limits[-1][1][1]}", flush=True)
    into = options.into or options.out
    into.mkdir(parents=True, exist_ok=True)
    with open(into / "runs.csv", "w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(atlas.rows[0]))
        writer.writeheader()
        writer.writerows(atlas.rows)
    (into / "table.md").write_text(table(atlas, limits), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
