#!/usr/bin/env python3
"""Cost against error of the methods of the on-off scheme; question and reading in README.md.

  study.py OUT --bin BIN [--seeds N...] [--particles N] [--methods NAME...] [--into FOLDER] [--name N]

Packs each seed once, starts every method from that checkpoint, goes on where it was stopped, and writes runs.csv,
table.md and cost_error.svg, with --name as runs_N.csv and so on. Rows of a runs.csv there are kept unless they are
measured again, so methods and seeds can be added. Where the reference was not run, errors are those from what is
closest to it (REFERENCES).
"""
import argparse
import csv
import math
import pathlib
import re
import statistics
import subprocess
import sys

sys.dont_write_bytecode = True  # the source folder stays as it is
here = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(here.parent / "calibration"))
import measures  # noqa: E402

FAST = {"minimum_cycles": 1000, "drift_tolerance": 0.1}
ALL = FAST | {"inertia_scaling": '"all"'}
SWIFT = {"loading_velocity": '"1 m/s"', "inertial_number_limit": 0.003}
# The reference: half the step, one breakage a jump, every stage of full length and closer to equilibrium.
METHODS = {
    "reference": {"time_step_safety": 0.35, "breakages_per_ageing": 1, "settle_tolerance": 0.002,
                  "unbalanced_tolerance": 1e-5},
    "paper": {},
    "cycles 50 000": {"minimum_cycles": 50000},
    "cycles 10 000": {"minimum_cycles": 10000},
    "cycles 3 000": {"minimum_cycles": 3000},
    "drift 0.03": FAST | {"drift_tolerance": 0.03},
    "drift 0.1": FAST,
    "drift 0.3": FAST | {"drift_tolerance": 0.3},
    "drift 0.1, step x 0.5": FAST | {"time_step_safety": 0.35},
    "drift 0.1, step x 1.4": FAST | {"time_step_safety": 1.0},
    "drift 0.1, damping 0.3": FAST | {"local_damping": 0.3},
    "drift 0.1, damping 0.9": FAST | {"local_damping": 0.9},
    "drift 0.1, checks every 10": FAST | {"failure_check_interval": 10},
    "drift 0.1, loading 0.3 m/s": FAST | {"loading_velocity": '"0.3 m/s"'},
    "fragments scaled": FAST | {"inertia_scaling": '"fragments"'},
    "all scaled": ALL,
    "all scaled, drift 0.3": ALL | {"drift_tolerance": 0.3},
    "all scaled, n_age 1": ALL | {"breakages_per_ageing": 1},
    "all scaled, n_age 8": ALL | {"breakages_per_ageing": 8},
    "all scaled, n_age 20": ALL | {"breakages_per_ageing": 20},
    "all scaled, adaptive 0.1": ALL | {"breakages_per_ageing": '"adaptive"', "ageing_error_tolerance": 0.1},
    "all scaled, adaptive 0.3": ALL | {"breakages_per_ageing": '"adaptive"', "ageing_error_tolerance": 0.3},
    # What can be paid for where the reference cannot: its steps and breakages, but shorter stages.
    "near reference": {"time_step_safety": 0.35, "breakages_per_ageing": 1, "settle_tolerance": 0.002,
                       "unbalanced_tolerance": 1e-5, "minimum_cycles": 3000, "drift_tolerance": 0.03},
    "all scaled, loading 0.3 m/s": ALL | {"loading_velocity": '"0.3 m/s"'},
    "all scaled, loading 1 m/s, I < 0.003": ALL | SWIFT,
    "all scaled, loading 1 m/s, I < 0.003, cycles 300": ALL | SWIFT | {"minimum_cycles": 300},
    "all scaled, loading 1 m/s, I < 0.003, n_age 1": ALL | SWIFT | {"breakages_per_ageing": 1},
    # One failure a jump up to 4 500 particles.
    "all scaled, loading 1 m/s, I < 0.003, cycles 300, n_age 0.033 %":
        ALL | SWIFT | {"minimum_cycles": 300, "breakage_fraction": 0.00033},
    "all scaled, loading 1 m/s, I < 0.003, cycles 300, n_age 1":
        ALL | SWIFT | {"minimum_cycles": 300, "breakages_per_ageing": 1},
    "all scaled, loading 1 m/s, I < 0.003, cycles 300, adaptive 0.3":
        ALL | SWIFT | {"minimum_cycles": 300, "breakages_per_ageing": '"adaptive"', "ageing_error_tolerance": 0.3},
}
# Closest to exact first; the last differs from "near reference" by 0.5 +- 2.6 % in strain at 3 000 particles.
REFERENCES = ("reference", "near reference", "all scaled, loading 1 m/s, I < 0.003, cycles 300, n_age 1")
# What a job file calls a method (core/experiment/fidelity.cpp).
FIDELITIES = {"all scaled, loading 1 m/s, I < 0.003, cycles 300, n_age 0.033 %": "balanced",
              "all scaled, loading 1 m/s, I < 0.003, cycles 300": "fast"}
# Column, meaning, and how far one seed lies from another is what an error is held against.
QUANTITIES = {
    "e_before": "void ratio before creep",
    "strain_600": "creep strain at 600 s, %",
    "strain_1e4": "creep strain at 1e4 s, %",
    "strain_end": "creep strain at the end, %",
    "rate_10_min": "rate at 10 min, %/min",
    "m": "Singh-Mitchell slope",
    "grading_index": "grading index at the end",
    "jumps": "ageing jumps",
    "ripple": "largest ripple, %",
}
# What the error of a fidelity is stated in.
STATED = ("e_before", "strain_600", "strain_1e4", "strain_end")
T_95 = {1: 12.71, 2: 4.30, 3: 3.18, 4: 2.78, 5: 2.57, 6: 2.45, 7: 2.36, 8: 2.31, 9: 2.26}


def packing_text(particles, seed):
    return (f'[specimen]\nparticles = {particles}\ngrading = {{ preset = "fontainebleau-ne34" }}\nvoid_ratio = 0.65\n'
            f'seed = {seed}\n[material]\npreset = "fontainebleau-ne34"\n[[program]]\nstage = "isotropic"\n'
            'until = { mean_stress = "0.2 MPa" }\nkeep = {}\n[numerics]\nfidelity = "paper"\n')


def method_text(trunk, settings):
    numerics = "".join(f"{key} = {value}\n" for key, value in settings.items())
    return (f'[start]\njob = "{trunk}"\ncheckpoint = "01_isotropic_end"\n[[program]]\nstage = "oedometric"\n'
            'until = { axial_stress = "21.7 MPa" }\n[[program]]\nstage = "creep"\nduration = "2 d"\n'
            f'[numerics]\nfidelity = "paper"\n{numerics}')


def compute(options, name, text):
    folder, job = options.out / name, options.out / f"{name}.toml"
    if measures.is_done(folder):
        return folder
    job.write_text(text)
    done = subprocess.run([options.bin / "creepctl", "run", job, "--out", folder, "--threads", "1"],
                          stdout=subprocess.DEVNULL, check=False)
    print(f"{name}: exit {done.returncode}", flush=True)
    return folder


def strain_at(stages, seconds):
    """Of the hold, linear in ln(creep time) between the ends of dynamic stages [-]."""
    zero = stages[0]["start_strain"]
    # Where inertia is scaled, the first dynamic stage takes no creep time; it takes some ms otherwise.
    ends = [(math.log(max(stage["creep_time_end_s"], 1e-3)), stage["axial_strain_end"] - zero) for stage in stages]
    at = math.log(seconds)
    for (t0, s0), (t1, s1) in zip(ends, ends[1:]):
        if t0 <= at <= t1:
            return s0 + (s1 - s0) * (at - t0) / (t1 - t0)
    return ends[-1][1] if at > ends[-1][0] else ends[0][1]


def row_of(options, method, seed, folder):
    row = {"method": method, "seed": seed, "outcome": measures.status(folder)}
    stages = measures.table(folder / "stages.csv")
    hold = [stage for stage in stages if stage["dynamic_stage"] >= 0]
    loaded = [stage for stage in stages if stage["dynamic_stage"] < 0]
    if row["outcome"] != "completed" or not hold or not loaded:
        return row
    hold[0]["start_strain"] = loaded[-1]["axial_strain_end"]
    row["e_before"] = hold[0]["void_ratio_end"]
    for name, seconds in (("strain_600", 600), ("strain_1e4", 1e4), ("strain_end", 172800)):
        row[name] = 100 * strain_at(hold, seconds)
    said = measures.report(folder, options.bin)
    row["m"] = measures.leading_number(said.get("Singh-Mitchell m"))
    row["rate_10_min"] = measures.leading_number(said.get("rate at 10 min"))
    row["grading_index"] = hold[-1]["grading_index_end"]
    row["jumps"] = len(hold) - 1
    row["ripple"] = 100 * max((stage["ripple"] for stage in hold[1:]), default=0.0)
    timings = measures.table(folder / "stage_timings.csv")
    row["particle_steps"] = sum(stage["particle_steps"] for stage in timings)
    row["seconds"] = sum(stage["wall_seconds"] for stage in timings)
    return row


def differences(rows, method, against, name):
    of = {row["seed"]: row.get(name) for row in rows if row["method"] == against}
    return [row[name] - of[row["seed"]] for row in rows if row["method"] == method
            and row.get(name) is not None and of.get(row["seed"]) is not None]


def reference_of(rows):
    """The method from which errors are counted: the strictest that two specimens have."""
    seeds = lambda method: sum(row["method"] == method for row in rows)
    return next((method for method in REFERENCES if seeds(method) > 1), None)


def reference_values(rows, name):
    return [row[name] for row in rows if row["method"] == reference_of(rows) and row.get(name) is not None]


def measured(rows):
    """Quantities that the reference has; those of old runs may be without some."""
    return [name for name in QUANTITIES if reference_values(rows, name)]


def spread(rows, name):
    values = reference_values(rows, name)
    return statistics.stdev(values) if len(values) > 1 else float("nan")


def interval(values):
    """Mean and half width of its 95 % interval."""
    if len(values) < 2:
        return float("nan"), float("nan")
    return statistics.fmean(values), T_95.get(len(values) - 1, 2.0) * statistics.stdev(values) / math.sqrt(len(values))


def cost(rows, method, name="particle_steps"):
    values = [row[name] for row in rows if row["method"] == method and row.get(name)]
    return math.exp(statistics.fmean(math.log(value) for value in values)) if values else None


def completed(rows, method):
    return sum(row["method"] == method and row["outcome"] == "completed" for row in rows)


def cheaper(rows, method):
    """Particle-steps of "paper" over those of the method, on the seeds that both have, to three digits; "-" without any."""
    of = {row["seed"]: row["particle_steps"] for row in rows if row["method"] == "paper" and row.get("particle_steps")}
    ratios = [of[row["seed"]] / row["particle_steps"] for row in rows
              if row["method"] == method and row.get("particle_steps") and row["seed"] in of]
    return f"{math.exp(statistics.fmean(math.log(ratio) for ratio in ratios)):.3g}" if ratios else "-"


def worst(rows, method):
    """Largest |mean difference| of strains and void ratio, in seed standard deviations; and whether all intervals of
    all quantities lie within one."""
    sizes, within = [], True
    for name in measured(rows):
        mean, half = interval(differences(rows, method, reference_of(rows), name))
        deviation = spread(rows, name)
        if name in STATED:
            sizes.append(abs(mean) / deviation)
        within = within and abs(mean) + half <= deviation
    return max(sizes), within


def stated_error(rows, method):
    """Largest far end of the 95 % interval of void ratio and strains, over their mean [%]."""
    ends = []
    for name in STATED:
        mean, half = interval(differences(rows, method, reference_of(rows), name))
        ends.append((abs(mean) + half) / statistics.fmean(reference_values(rows, name)))
    return 100 * max(ends)


def label(method):
    return f"{FIDELITIES[method]}: {method}" if method in FIDELITIES else method


def write_table(rows, path):
    reference, names = reference_of(rows), measured(rows)
    lines = ["| method | seeds | cheaper than `paper` | " + " | ".join(QUANTITIES[name] for name in names)
             + " | all within one seed deviation | stated error, % |", "|---" * (len(names) + 5) + "|"]
    cells = []
    for name in names:
        cells.append(f"{statistics.fmean(reference_values(rows, name)):.4g} ({spread(rows, name):.2g})")
    lines.append(f"| {reference}: mean (seed deviation) | {completed(rows, reference)} | {cheaper(rows, reference)} | " + " | ".join(cells) + " | | |")
    for method in METHODS:
        if method == reference or cost(rows, method) is None:
            continue
        cells = []
        for name in names:
            mean, half = interval(differences(rows, method, reference, name))
            cells.append(f"{mean:+.2g} ± {half:.2g}")
        _, within = worst(rows, method)
        stopped = sum(row["method"] == method and row["outcome"] != "completed" for row in rows)
        name = f"{label(method)} ({stopped} runs stopped by a guard, left out)" if stopped else label(method)
        lines.append(f"| {name} | {completed(rows, method)} | {cheaper(rows, method)} | " + " | ".join(cells)
                     + f" | {'yes' if within else 'no'} | {stated_error(rows, method):.2g} |")
    path.write_text("\n".join(lines) + "\n")


def write_chart(rows, path):
    points = [(cost(rows, method), max(worst(rows, method)[0], 1e-3), method) for method in METHODS
              if method != reference_of(rows) and cost(rows, method) and math.isfinite(worst(rows, method)[0])]
    left, right = math.log10(min(p[0] for p in points)) - 0.1, math.log10(max(p[0] for p in points)) + 0.2
    low, high = math.log10(min(p[1] for p in points)) - 0.15, max(0.2, math.log10(max(p[1] for p in points)) + 0.15)
    x = lambda value: 80 + 800 * (math.log10(value) - left) / (right - left)
    y = lambda value: 560 - 510 * (math.log10(value) - low) / (high - low)
    parts = ['<svg xmlns="http://www.w3.org/2000/svg" width="1330" height="640" font-family="DejaVu Sans, sans-serif" '
             'font-size="12"><rect width="1330" height="640" fill="white"/>',
             '<rect x="80" y="50" width="800" height="510" fill="none" stroke="#444"/>']
    for decade in range(math.ceil(left), math.floor(right) + 1):
        parts.append(f'<line x1="{x(10**decade):.1f}" x2="{x(10**decade):.1f}" y1="50" y2="560" stroke="#ddd"/>'
                     f'<text x="{x(10**decade):.1f}" y="580" text-anchor="middle">1e{decade}</text>')
    for decade in range(math.ceil(low), math.floor(high) + 1):
        parts.append(f'<line x1="80" x2="880" y1="{y(10**decade):.1f}" y2="{y(10**decade):.1f}" stroke="#ddd"/>'
                     f'<text x="72" y="{y(10**decade) + 4:.1f}" text-anchor="end">{10.0**decade:g}</text>')
    parts.append(f'<line x1="80" x2="880" y1="{y(1):.1f}" y2="{y(1):.1f}" stroke="#b00" stroke-dasharray="6 4"/>'
                 f'<text x="874" y="{y(1) - 6:.1f}" text-anchor="end" fill="#b00">one seed standard deviation</text>')
    front, best = [], float("inf")
    for point in sorted(points):
        if point[1] < best:
            front.append(point)
            best = point[1]
    parts.append('<polyline fill="none" stroke="#069" stroke-width="1.5" points="'
                 + " ".join(f"{x(c):.1f},{y(e):.1f}" for c, e, _ in front) + '"/>')
    # Numbers, with their names beside the chart: many points lie close together.
    for place, (c, e, method) in enumerate(sorted(points), 1):
        colour = "#c60" if method == "paper" or method in FIDELITIES else "#069" if (c, e, method) in front else "#777"
        parts.append(f'<circle cx="{x(c):.1f}" cy="{y(e):.1f}" r="4" fill="{colour}"/>'
                     f'<text x="{x(c):.1f}" y="{y(e) - 7 if place % 2 else y(e) + 16:.1f}" text-anchor="middle" '
                     f'fill="{colour}" font-size="10.5">{place}</text>'
                     f'<text x="900" y="{46 + 19 * place}" fill="{colour}">{place}  {label(method).replace("<", "&lt;")}</text>')
    parts.append('<text x="480" y="612" text-anchor="middle">cost: particle-steps of loading and two days of creep</text>'
                 '<text x="24" y="305" text-anchor="middle" transform="rotate(-90 24 305)">error: largest mean deviation from '
                 'the '
                 f'{reference_of(rows)}, in seed standard deviations</text>'
                 '<text x="80" y="34" font-size="15">Cost against error: void ratio before creep, creep strain at 600 s, 1e4 s '
                 'and 2 d</text></svg>')
    path.write_text("\n".join(parts) + "\n")


def read_rows(path):
    """By method and seed; none if there is no such file yet."""
    rows = {}
    for text in csv.DictReader(path.read_text().splitlines()) if path.exists() else []:
        row = {name: float(value) for name, value in text.items() if value and name not in ("method", "outcome")}
        row |= {"method": text["method"], "seed": int(text["seed"]), "outcome": text["outcome"]}
        rows[row["method"], row["seed"]] = row
    return rows


def write_rows(rows, path):
    columns = ["method", "seed", "outcome", *QUANTITIES, "particle_steps", "seconds"]
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, columns, restval="", extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        for row in rows:
            writer.writerow({key: f"{value:.6g}" if isinstance(value, float) else value for key, value in row.items()})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--bin", type=pathlib.Path, required=True, help="folder of creepctl and creep-worker")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4, 5])
    parser.add_argument("--particles", type=int, default=800)
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=list(METHODS), metavar="NAME")
    parser.add_argument("--into", type=pathlib.Path, help="folder for table, csv and chart (default: OUT)")
    parser.add_argument("--name", default="", help="what the names of the files written end in")
    options = parser.parse_args()
    options.out, options.bin = options.out.resolve(), options.bin.resolve()
    into, ending = options.into or options.out, f"_{options.name}" if options.name else ""
    options.out.mkdir(parents=True, exist_ok=True)
    rows = read_rows(into / f"runs{ending}.csv")
    for seed in options.seeds:
        trunk = compute(options, f"trunk_{seed}", packing_text(options.particles, seed))
        for method in options.methods:
            name = f"{re.sub('[^a-z0-9_.-]+', '_', method)}_{seed}"
            folder = compute(options, name, method_text(trunk, METHODS[method]))
            rows[method, seed] = row_of(options, method, seed, folder)
    order = sorted(rows, key=lambda key: (key[1], list(METHODS).index(key[0])))
    rows = [rows[key] for key in order]
    write_rows(rows, into / f"runs{ending}.csv")
    if reference_of(rows) is None:
        print("no table and no chart yet: they need two specimens of one of", ", ".join(REFERENCES))
        return
    write_table(rows, into / f"table{ending}.md")
    write_chart(rows, into / f"cost_error{ending}.svg")


if __name__ == "__main__":
    main()
