#!/usr/bin/env python3
"""The calibration study: question and reading of its results in README.md.

  study.py OUT list   [PATTERN...]             the runs, and how far each is
  study.py OUT run    [PATTERN...] --bin BIN   computes what is not done yet, in the order of the list
  study.py OUT tables [--into FOLDER]          runs.csv, tables.md and figures of what is done

A PATTERN is a shell pattern of names: 'oedometer/default/*', '*/seed_1'. Without one: everything but the long runs.
A run that is done is skipped, one that was cut short is continued by creepctl: the same command goes on after a kill.
"""
import argparse
import dataclasses
import fnmatch
import pathlib
import signal
import subprocess
import sys
import time

sys.dont_write_bytecode = True  # the source folder stays as it is

import measures  # noqa: E402
import tables  # noqa: E402

SEEDS = range(1, 6)
LAYOUTS = ("octahedral", "cubic", "tetrahedral")
PRESETS = {"default": "fontainebleau-ne34", "literal": "fontainebleau-ne34-literal"}
CYCLES = 40000           # a dynamic stage, as in client/examples/oedometer_creep.toml; the paper has 150 000
MOST_STAGES = 30         # twice the paper's 15: a hold with more runs away and is stopped
Q_MAX = 22.6             # [MPa], the paper's
# One multiple of this step of deviatoric stress is 0.4 q_max, another 0.75 q_max.
KEPT_STEP = 0.05 * Q_MAX
CREEP_RATIOS = (0.4, 0.75)
AXIAL_VELOCITY = "0.1 m/s"

# What section 7 of the model leaves open: name, (section, key, value), seeds. Held against the same seeds of the default.
VARIANTS = {
    "roughness_of_each_grain": ("material", "roughness", '"0.84853 um"'),  # a pair: sqrt(2) x 0.6 um
    "layout_cubic": ("material", "split_layout", '"cubic"'),
    "layout_tetrahedral": ("material", "split_layout", '"tetrahedral"'),
    "strength_floor_0.2": ("material", "strength_floor", "0.2"),
    # Between the two presets, and the default a tenth weaker: what would bring e to the paper's.
    "size_exponent_0.2": ("material", "size_exponent", "0.2"),
    "strength_less_10_percent": ("material", "limit_stress", '"3.375 GPa"'),
    "rigid_walls": ("material", "wall_stiffness_factor", "2.0"),
    "wall_friction_0.275": ("material", "wall_friction", "0.275"),
    "damping_0.3": ("numerics", "local_damping", "0.3"),
    "loading_0.3_m_s": ("numerics", "loading_velocity", '"0.3 m/s"'),
    "loading_0.03_m_s": ("numerics", "loading_velocity", '"0.03 m/s"'),
    "settle_0.02": ("numerics", "settle_tolerance", "0.02"),
    "settle_0.002": ("numerics", "settle_tolerance", "0.002"),
    "check_every_10_cycles": ("numerics", "failure_check_interval", "10"),
    # The friction while packing is found from the void ratio asked for (summary.json: generation_friction).
    "looser_packing_0.66": ("specimen", "void_ratio", "0.66"),
    "particles_1500": ("specimen", "particles", "1500"),
    "particles_11500": ("specimen", "particles", "11500"),
}
LONG = ("particles_11500",)


@dataclasses.dataclass
class Job:
    name: str
    text: str
    stops_when_it_runs_away: bool = False
    long: bool = False
    needs: str = ""  # the run whose checkpoint it starts from


def section(title, values):
    return f"[{title}]\n" + "".join(f"{key} = {value}\n" for key, value in values.items())


def job_text(values, program):
    head = "".join(section(title, values[title]) + "\n" for title in ("specimen", "material"))
    return head + program + "\n" + section("numerics", {"fidelity": '"paper"', "minimum_cycles": CYCLES} | values["numerics"])


def specimen_values(particles, seed, preset="default"):
    return {"specimen": {"particles": particles, "grading": '{ preset = "fontainebleau-ne34" }', "void_ratio": "0.65",
                         "seed": seed},
            "material": {"preset": f'"{PRESETS[preset]}"'}, "numerics": {}}


OEDOMETER = """[[program]]
stage = "oedometric"
until = { axial_stress = "21.7 MPa" }

[[program]]
stage = "creep"
duration = "2 d"
"""

SHEAR = f"""[[program]]
stage = "isotropic"
until = {{ mean_stress = "10 MPa" }}

[[program]]
stage = "triaxial"
until = {{ deviatoric_strain = 0.3 }}
axial_velocity = "{AXIAL_VELOCITY}"
keep = {{ every_deviatoric_stress = "{KEPT_STEP:.6g} MPa" }}
"""


def creep_text(seed, ratio):
    source = f"../../sheared/default/seed_{seed}"  # from OUT/creep/q_...
    stress = ratio * Q_MAX
    return (f'[start]\njob = "{source}"\ncheckpoint = "02_triaxial_deviatoric_stress_{stress:.6g}MPa"\n\n'
            f'[[program]]\nstage = "creep"\ndeviatoric_stress = "{stress:.6g} MPa"\nduration = "10000 s"\n')


def jobs(particles):
    for seed in SEEDS:
        for preset in PRESETS:
            for layout in LAYOUTS:
                values = specimen_values(particles, seed, preset)
                values["material"]["split_layout"] = f'"{layout}"'
                yield Job(f"oedometer/{preset}_{layout}/seed_{seed}", job_text(values, OEDOMETER), True)
    for seed in SEEDS:
        sheared = f"sheared/default/seed_{seed}"
        yield Job(sheared, job_text(specimen_values(particles, seed), SHEAR))
        for ratio in CREEP_RATIOS:
            yield Job(f"creep/q_{ratio}/seed_{seed}", creep_text(seed, ratio), True, needs=sheared)
    for seed in SEEDS:
        for variant, (title, key, value) in VARIANTS.items():
            if variant.startswith("layout_"):
                continue  # among the oedometer runs
            values = specimen_values(particles, seed)
            values[title][key] = value
            yield Job(f"sensitivity/{variant}/seed_{seed}", job_text(values, OEDOMETER), True, variant in LONG)


def chosen(particles, patterns):
    for job in jobs(particles):
        if any(fnmatch.fnmatchcase(job.name, pattern) for pattern in patterns) or (not patterns and not job.long):
            yield job


def stage_count(folder):
    return len(measures.table(folder / "stages.csv"))


def compute(job, arguments):
    """Runs or continues one job; true if it is done then."""
    folder = arguments.out / job.name
    job_file = folder.parent / f"{folder.name}.toml"
    job_file.parent.mkdir(parents=True, exist_ok=True)
    job_file.write_text(job.text)
    begin = time.monotonic()
    with open(folder.parent / f"{folder.name}.log", "a") as log:
        process = subprocess.Popen([arguments.bin / "creepctl", "run", job_file, "--out", folder, "--threads",
                                    str(arguments.threads)], stdout=log, stderr=log)
        try:
            while process.poll() is None:
                time.sleep(1.0)
                if job.stops_when_it_runs_away and stage_count(folder) > MOST_STAGES + 2:
                    (folder / measures.STOPPED).write_text(f"stopped: more than {MOST_STAGES} dynamic stages\n")
                    process.send_signal(signal.SIGINT)
                    process.wait()
        except KeyboardInterrupt:
            process.wait()  # it had the signal too, and writes its checkpoint
            raise
    print(f"{job.name}: {measures.status(folder)}, {time.monotonic() - begin:.0f} s", flush=True)
    return measures.is_done(folder)


def run(arguments):
    failed = []
    for job in chosen(arguments.particles, arguments.patterns):
        if measures.is_done(arguments.out / job.name):
            continue
        if job.needs and not measures.is_done(arguments.out / job.needs):
            print(f"{job.name}: left out, {job.needs} is not done", flush=True)
            failed.append(job.name)
        elif not compute(job, arguments):
            failed.append(job.name)
    return 1 if failed else 0


def show(arguments):
    for job in chosen(arguments.particles, arguments.patterns or ["*"]):
        print(f"{job.name}: {measures.status(arguments.out / job.name)}{' (long)' if job.long else ''}")
    return 0


def write_tables(arguments):
    rows = [measures.of_run(job.name, arguments.out / job.name, arguments.bin)
            for job in jobs(arguments.particles) if measures.is_done(arguments.out / job.name)]
    if not rows:
        print("nothing is done yet", file=sys.stderr)
        return 1
    into = arguments.into or arguments.out
    into.mkdir(parents=True, exist_ok=True)
    tables.write(rows, list(VARIANTS), arguments.out, into)
    print(into / "tables.md")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path, help="folder of the job directories")
    parser.add_argument("what", choices=("list", "run", "tables"))
    parser.add_argument("patterns", nargs="*", metavar="PATTERN")
    parser.add_argument("--bin", type=pathlib.Path, default=pathlib.Path("build/release/bin"), help="folder of creepctl")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--particles", type=int, default=3000)
    parser.add_argument("--into", type=pathlib.Path, help="folder for tables and figures (default: OUT)")
    arguments = parser.parse_args()
    arguments.out, arguments.bin = arguments.out.resolve(), arguments.bin.resolve()
    return {"list": show, "run": run, "tables": write_tables}[arguments.what](arguments)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
