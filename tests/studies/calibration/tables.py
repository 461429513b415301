"""runs.csv, tables.md and the figures, from the rows of measures.of_run()."""
import csv
import math
import statistics

import measures

# The paper's, where it gives one.
OEDOMETER_PAPER = {"e0": "0.65", "e_rest": "0.584", "jumps": "15", "ripple_percent": "< 4"}
TRIAXIAL_PAPER = {"q_max_MPa": "22.6"}
CREEP_PAPER = {"q_0.4": {"m": "0.790", "rate_10_min_percent_per_min": "0.0017"},
               "q_0.75": {"m": "0.736", "rate_10_min_percent_per_min": "0.0558"}}

OEDOMETER = ("e0", "e_loaded", "e_rest", "broken_loading_percent", "jumps", "creep_strain_percent", "ripple_percent", "m",
             "rate_10_min_percent_per_min")
TRIAXIAL = ("e0", "q_max_MPa", "strain_at_q_max_percent", "radial_stress_at_q_max_MPa")
CREEP = ("jumps", "creep_strain_percent", "contraction_percent", "grading_index_change", "m", "rate_10_min_percent_per_min",
         "ripple_percent")
SENSITIVE = ("e_rest", "broken_loading_percent", "jumps", "creep_strain_percent", "m", "ripple_percent")
REFERENCE = "default_octahedral"
COLOURS = ("#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#8c564b")


def group_of(row):
    return row["run"].split("/")[0], row["run"].split("/")[1]


def seed_of(row):
    return row["run"].rsplit("_", 1)[1]


def select(rows, kind, group):
    return [row for row in rows if group_of(row) == (kind, group)]


def values(rows, name):
    return [row[name] for row in rows if row.get(name) is not None]


def mean_and_spread(numbers):
    if not numbers:
        return "-"
    mean = statistics.fmean(numbers)
    if len(numbers) < 2:
        return f"{mean:.4g} (one)"
    return f"{mean:.4g} ± {statistics.stdev(numbers):.2g}"


def line(cells):
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def spread_table(rows, kind, groups, names, paper_of):
    """A column a group: mean and standard deviation over its seeds; the paper's beside it where there is one."""
    groups = [group for group in groups if select(rows, kind, group)]
    if not groups:
        return ["Nothing of this is done yet."]
    out = [line([""] + groups + ["paper"]), "|---" * (len(groups) + 2) + "|"]
    out.append(line(["runs, of these running away or failing in creep"] + [
        f"{len(select(rows, kind, g))}, {sum(row['outcome'] in ('runs away', 'creep failure') for row in select(rows, kind, g))}"
        for g in groups] + ["-"]))
    for name in names:
        out.append(line([measures.COLUMNS[name] + f" (`{name}`)"] +
                        [mean_and_spread(values(select(rows, kind, group), name)) for group in groups] + [paper_of(name)]))
    return out


def shifts(rows, variant, name):
    """Differences from the reference of the same seed."""
    base = {seed_of(row): row.get(name) for row in select(rows, "oedometer", REFERENCE)}
    here = (select(rows, "oedometer", "default_" + variant.removeprefix("layout_")) if variant.startswith("layout_")
            else select(rows, "sensitivity", variant))
    return [row[name] - base[seed_of(row)] for row in here
            if row.get(name) is not None and base.get(seed_of(row)) is not None]


def sensitivity(rows, variants):
    """variant -> measure -> (mean shift, number of seeds) in units of the spread of the reference over its seeds."""
    found = {}
    reference = select(rows, "oedometer", REFERENCE)
    for variant in variants:
        for name in SENSITIVE:
            moved = shifts(rows, variant, name)
            spread = values(reference, name)
            if not moved or len(spread) < 2 or statistics.stdev(spread) == 0.0:
                continue
            found.setdefault(variant, {})[name] = (statistics.fmean(moved) / statistics.stdev(spread), len(moved))
    return found


def sensitivity_table(rows, variants):
    found = sensitivity(rows, variants)
    if not found:
        return ["Nothing of this is done yet: it needs the reference with two seeds, and a variant."]
    spread = {name: values(select(rows, "oedometer", REFERENCE), name) for name in SENSITIVE}
    out = [line(["shift in units of the seed spread", "seeds"] + [f"`{name}`" for name in SENSITIVE]),
           "|---" * (len(SENSITIVE) + 2) + "|",
           line(["spread of the reference", max(len(numbers) for numbers in spread.values())] +
                [f"{statistics.stdev(numbers):.2g}" if len(numbers) > 1 else "-" for numbers in spread.values()])]
    for variant, shift in found.items():
        out.append(line([variant.replace("_", " "), max(seeds for _, seeds in shift.values())] +
                        [f"{shift[name][0]:+.1f}" if name in shift else "-" for name in SENSITIVE]))
    return out


def frame(width, height, title_x, title_y):
    return [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" font-size="12">',
            f'<rect width="{width}" height="{height}" fill="white"/>',
            f'<text x="{width / 2}" y="{height - 10}" text-anchor="middle">{title_x}</text>',
            f'<text x="16" y="{height / 2}" transform="rotate(-90 16 {height / 2})" text-anchor="middle">{title_y}</text>']


def creep_curve(folder):
    """(creep time [s], creep strain [%]) at the ends of the dynamic stages of the hold."""
    stages = measures.table(folder / "stages.csv")
    before = [sample for sample in measures.table(folder / "samples.csv") if sample["phase"] == 1]
    origin = before[-1]["axial_strain"] if before else 0.0
    return [(stage["creep_time_end_s"], measures.PER_CENT * (stage["axial_strain_end"] - origin)) for stage in stages
            if stage["dynamic_stage"] >= 0 and stage["creep_time_end_s"] > 0]


def draw_creep(rows, kind, jobs_folder, path):
    """Creep strain over log time, a line a run, a colour a group."""
    groups = sorted({group_of(row)[1] for row in rows if group_of(row)[0] == kind})
    curves = [(groups.index(group_of(row)[1]), creep_curve(jobs_folder / row["run"])) for row in rows
              if group_of(row)[0] == kind]
    points = [point for _, curve in curves for point in curve]
    if not points:
        return False
    width, height, left, right, bottom, top = 720, 440, 60, 200, 50, 20
    low, high = math.floor(math.log10(min(p[0] for p in points))), math.ceil(math.log10(max(p[0] for p in points)))
    most = max(max(p[1] for p in points), 0.1) * 1.05
    x_of = lambda t: left + (width - left - right) * (math.log10(t) - low) / max(1, high - low)
    y_of = lambda strain: height - bottom - (height - bottom - top) * strain / most
    out = frame(width, height, "creep time, s", "axial creep strain, %")
    out.append(f'<path d="M{left} {top}V{height - bottom}H{width - right}" fill="none" stroke="black"/>')
    for decade in range(low, high + 1):
        out.append(f'<text x="{x_of(10.0 ** decade):.1f}" y="{height - bottom + 18}" text-anchor="middle">1e{decade}</text>')
    for tick in range(6):
        out.append(f'<text x="{left - 6}" y="{y_of(most * tick / 5) + 4:.1f}" text-anchor="end">{most * tick / 5:.2f}</text>')
    for k, curve in curves:
        path_of = " ".join(f"{x_of(t):.1f},{y_of(strain):.1f}" for t, strain in curve)
        out.append(f'<polyline points="{path_of}" fill="none" stroke="{COLOURS[k % len(COLOURS)]}"/>')
        out += [f'<circle cx="{x_of(t):.1f}" cy="{y_of(s):.1f}" r="2" fill="{COLOURS[k % len(COLOURS)]}"/>' for t, s in curve]
    for k, group in enumerate(groups):
        out.append(f'<text x="{width - right + 12}" y="{top + 12 + 18 * k}" fill="{COLOURS[k % len(COLOURS)]}">{group}</text>')
    path.write_text("\n".join(out + ["</svg>\n"]))
    return True


def draw_sensitivity(rows, variants, path):
    """A row a variant; a mark a measure where the variant moves its mean, in units of the seed spread."""
    found = sensitivity(rows, variants)
    if not found:
        return False
    width, left, step, top = 760, 200, 24, 50
    height = top + step * len(found) + 60
    most = max(3.0, max(abs(shift) for of in found.values() for shift, _ in of.values()))
    x_of = lambda shift: left + (width - left - 20) * (shift + most) / (2 * most)
    out = frame(width, height, "shift of the mean over the spread of seeds (grey: within one)", "")
    out.append(f'<rect x="{x_of(-1):.1f}" y="{top - 14}" width="{x_of(1) - x_of(-1):.1f}" height="{step * len(found)}" fill="#eee"/>')
    for tick in range(-math.floor(most), math.floor(most) + 1, max(1, round(most / 5))):
        out.append(f'<text x="{x_of(tick):.1f}" y="{height - 34}" text-anchor="middle">{tick}</text>')
    for k, name in enumerate(SENSITIVE):
        out.append(f'<text x="{left + k * 92}" y="20" fill="{COLOURS[k]}" font-size="10">{name.removesuffix("_percent")}</text>')
    for row, (variant, shift) in enumerate(found.items()):
        y = top + step * row
        out.append(f'<text x="{left - 10}" y="{y + 4}" text-anchor="end">{variant.replace("_", " ")}</text>')
        for k, name in enumerate(SENSITIVE):
            if name in shift:
                out.append(f'<circle cx="{x_of(shift[name][0]):.1f}" cy="{y - 6 + 2.4 * k:.1f}" r="4" fill="{COLOURS[k]}"/>')
    path.write_text("\n".join(out + ["</svg>\n"]))
    return True


def write(rows, variants, jobs_folder, into):
    names = ["run", "outcome"] + list(measures.COLUMNS)
    with open(into / "runs.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, names, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        for row in rows:
            writer.writerow({name: f"{row[name]:.6g}" if isinstance(row.get(name), float) else row.get(name) for name in names})
    oedometer = [f"{preset}_{layout}" for preset in ("default", "literal") for layout in ("octahedral", "cubic", "tetrahedral")]
    text = ["Mean ± standard deviation over the seeds done; every run is a row of [runs.csv](runs.csv).", "",
            "### Oedometer: 21.7 MPa, two days", ""]
    text += spread_table(rows, "oedometer", oedometer, OEDOMETER, lambda name: OEDOMETER_PAPER.get(name, "-"))
    if draw_creep(rows, "oedometer", jobs_folder, into / "oedometer_creep.svg"):
        text += ["", "![creep strain over log time](oedometer_creep.svg)"]
    text += ["", "### Shear at 10 MPa", ""]
    text += spread_table(rows, "sheared", ["default"], TRIAXIAL, lambda name: TRIAXIAL_PAPER.get(name, "-"))
    text += ["", "### Creep of the sheared specimens, 10 000 s", ""]
    for group in sorted(CREEP_PAPER):
        text += spread_table(rows, "creep", [group], CREEP, lambda name: CREEP_PAPER[group].get(name, "-")) + [""]
    if draw_creep(rows, "creep", jobs_folder, into / "triaxial_creep.svg"):
        text += ["![creep strain over log time](triaxial_creep.svg)"]
    text += ["", "### What the open readings move", ""] + sensitivity_table(rows, variants)
    if draw_sensitivity(rows, variants, into / "sensitivity.svg"):
        text += ["", "![shifts in units of the seed spread](sensitivity.svg)"]
    (into / "tables.md").write_text("\n".join(text) + "\n")
