#!/usr/bin/env python3
"""The ten triaxial creep tests of the paper's Table 2; question and reading in README.md.

  study.py OUT run    [--particles N] [--seeds N...] --bin BIN [--jobs N] [--threads N]   computes what is not done yet
  study.py OUT tables [--particles N] [--seeds N...] --bin BIN [--into FOLDER] runs_N.csv, table_N.md and figures of what is done

With --fidelity NAME another than "balanced", in files that end in its name.

One specimen a seed is compressed and sheared, with a checkpoint at each 0.05 q_max, and serves all ten tests.
"""
import argparse
import csv
import math
import pathlib
import statistics
import subprocess
import sys

sys.dont_write_bytecode = True  # the source folder stays as it is
here = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(here.parent / "calibration"))
import measures  # noqa: E402
import tables  # noqa: E402

# q / q_max: (m, rate at 10 min [%/min]); Lei et al., Table 2
PAPER = {0.2: (0.7713, 0.00043), 0.3: (0.7356, 0.0010), 0.4: (0.7903, 0.0017), 0.5: (0.7484, 0.0038), 0.6: (0.7353, 0.0086),
         0.7: (0.7246, 0.0263), 0.75: (0.7360, 0.0558), 0.8: (0.7238, 0.1247), 0.85: (0.723, 0.30), 0.9: (0.7251, 0.855)}
COLUMNS = ("outcome", "time_to_failure_s", "jumps", "creep_strain_percent", "contraction_percent", "grading_index_change", "m",
           "rate_10_min_percent_per_min", "ripple_percent")

JOB = """name = "Table 2, {particles} grains"
[specimen]
particles = {particles}
grading = {{ preset = "fontainebleau-ne34" }}
void_ratio = 0.65

[[program]]
stage = "isotropic"
until = {{ mean_stress = "10 MPa" }}

[[program]]
stage = "triaxial"
until = {{ q_ratio = 0.9, q_max = "22.6 MPa" }}
axial_velocity = "0.1 m/s"

[[program]]
stage = "creep"
duration = "10000 s"

[numerics]
fidelity = "{fidelity}"
"""

T_95 = {1: 12.71, 2: 4.30, 3: 3.18, 4: 2.78}  # Student's, of degrees of freedom


def ending(options):
    return f"{options.particles}" + ("" if options.fidelity == "balanced" else f"_{options.fidelity}")


def folder_of(options, seed, ratio):
    return options.out / ending(options) / f"seed_{seed}" / f"q_{ratio}"


def run(options):
    """A trunk a seed, with a checkpoint at each 0.05 q_max, and the ten tests from there; done ones are left as they are."""
    options.out.mkdir(parents=True, exist_ok=True)
    job = options.out / f"table2_{ending(options)}.toml"
    job.write_text(JOB.format(particles=options.particles, fidelity=options.fidelity))
    seeds = ",".join(f"{seed}..{seed}" for seed in options.seeds)
    return subprocess.run([options.bin / "creepctl", "sweep", job, "--seeds", seeds, "--stress-ratio", ",".join(map(str, PAPER)),
                           "--out", options.out / ending(options), "--jobs", str(options.jobs),
                           "--threads", str(options.threads)], check=False).returncode


def rows_of(options):
    rows = []
    for seed in options.seeds:
        for ratio in PAPER:
            folder = folder_of(options, seed, ratio)
            if measures.is_done(folder):
                row = {"q_ratio": ratio, "seed": seed} | measures.of_run(f"creep/q_{ratio}/seed_{seed}", folder, options.bin)
                if row["outcome"] == "creep failure":
                    row["time_to_failure_s"] = measures.table(folder / "stages.csv")[-1]["creep_time_end_s"]
                rows.append(row)
    return rows


def band(values):
    """Mean and half width of its 95 % interval; none of fewer than two."""
    if len(values) < 2:
        return None
    return statistics.fmean(values), T_95[min(len(values) - 1, 4)] * statistics.stdev(values) / math.sqrt(len(values))


def spread(rows, name):
    values = [row[name] for row in rows if row.get(name) is not None]
    if not values:
        return "-"
    return f"{statistics.fmean(values):.3g}" + (f" ± {statistics.stdev(values):.2g}" if len(values) > 1 else " (one)")


def factor(rows, paper):
    """Geometric mean of rate over the paper's, with the factor of its spread."""
    logs = [math.log(row["rate_10_min_percent_per_min"] / paper) for row in rows if row.get("rate_10_min_percent_per_min")]
    if not logs:
        return "-"
    return f"{math.exp(statistics.fmean(logs)):.2f}" + (f" (× or ÷ {math.exp(statistics.stdev(logs)):.2f})" if len(logs) > 1 else "")


def write_table(options, rows, path):
    lines = ["| q/q_max | seeds; of these failed in creep | m | paper | rate at 10 min, %/min | paper | over the paper's | creep strain, % | "
             "volumetric over axial strain | change of I_G | time to failure, s | jumps | ripple, % |", "|---" * 13 + "|"]
    for ratio, (m, rate) in PAPER.items():
        of = [row for row in rows if row["q_ratio"] == ratio]
        if not of:
            continue
        for row in of:
            row["ratio_of_strains"] = row["contraction_percent"] / row["creep_strain_percent"]
        failed = sum(row["outcome"] == "creep failure" for row in of)
        lines.append(f"| {ratio} | {len(of)}; {failed} | {spread(of, 'm')} | {m} | {spread(of, 'rate_10_min_percent_per_min')} | {rate} | "
                     f"{factor(of, rate)} | {spread(of, 'creep_strain_percent')} | {spread(of, 'ratio_of_strains')} | "
                     f"{spread(of, 'grading_index_change')} | {spread(of, 'time_to_failure_s')} | {spread(of, 'jumps')} | {spread(of, 'ripple_percent')} |")
    path.write_text("\n".join(lines) + "\n")


def panel_of_ratios(out, left, low, high, name, log):
    """Axes over q/q_max from x = left; the functions of their places."""
    width, bottom, top = 420, 370, 20
    x_of = lambda ratio: left + width * (ratio - 0.15) / 0.8
    y_of = lambda value: bottom - (bottom - top) * (min(max(math.log10(value) if log else value, low), high) - low) / (high - low)
    out.append(f'<path d="M{left} {top}V{bottom}H{left + width}" fill="none" stroke="black"/>'
               f'<text x="{left - 48}" y="195" transform="rotate(-90 {left - 48} 195)" text-anchor="middle">{name}</text>'
               f'<text x="{left + width / 2}" y="{bottom + 40}" text-anchor="middle">q / q_max</text>')
    for ratio in PAPER:
        if round(20 * ratio) % 2 == 0:
            out.append(f'<text x="{x_of(ratio):.1f}" y="{bottom + 18}" text-anchor="middle">{ratio}</text>')
    ticks = ([(10.0 ** decade, f"1e{decade}") for decade in range(low, high + 1)] if log
             else [(k / 10, f"{k / 10:.1f}") for k in range(round(10 * low), round(10 * high) + 1)])
    out += [f'<text x="{left - 6}" y="{y_of(at) + 4:.1f}" text-anchor="end">{text}</text>' for at, text in ticks]
    return x_of, y_of


def draw_series(out, rows, name, paper_at, axes, log):
    """Every seed a dot, the 95 % band of the mean a bar, the paper's a line."""
    x_of, y_of = axes
    points = " ".join(f"{x_of(ratio):.1f},{y_of(values[paper_at]):.1f}" for ratio, values in PAPER.items())
    out.append(f'<polyline points="{points}" fill="none" stroke="{tables.COLOURS[1]}" stroke-width="2"/>')
    for ratio in PAPER:
        values = [row[name] for row in rows if row["q_ratio"] == ratio and row.get(name)]
        out += [f'<circle cx="{x_of(ratio):.1f}" cy="{y_of(value):.1f}" r="4" fill="none" stroke="{tables.COLOURS[0]}" '
                'stroke-width="1.5"/>' for value in values]
        found = band([math.log(value) for value in values] if log else values)
        if found:
            low, high = (math.exp(found[0] + side * found[1]) if log else found[0] + side * found[1] for side in (-1, 1))
            out.append(f'<line x1="{x_of(ratio):.1f}" x2="{x_of(ratio):.1f}" y1="{y_of(low):.1f}" y2="{y_of(high):.1f}" '
                       f'stroke="{tables.COLOURS[0]}" stroke-width="6" stroke-opacity="0.25"/>')


def draw_rates(rows, path):
    """Rate at 10 min and Singh-Mitchell slope over q/q_max."""
    out = tables.frame(1160, 430, "", "")
    draw_series(out, rows, "rate_10_min_percent_per_min", 1, panel_of_ratios(out, 75, -4, 1, "axial strain rate at 10 min, %/min", True), True)
    draw_series(out, rows, "m", 0, panel_of_ratios(out, 580, 0.5, 1.2, "Singh-Mitchell slope m", False), False)
    for k, (text, colour) in enumerate((("paper, Table 2", tables.COLOURS[1]), ("creepd, a dot a seed", tables.COLOURS[0]),
                                        ("bar: 95 % of mean", tables.COLOURS[0]))):
        out.append(f'<text x="1015" y="{32 + 18 * k}" fill="{colour}">{text}</text>')
    path.write_text("\n".join(out + ["</svg>\n"]))


def grading_curve(folder):
    """(creep time [s], I_G less that at the first of these) at the ends of the dynamic stages of the hold."""
    stages = [stage for stage in measures.table(folder / "stages.csv") if stage["dynamic_stage"] >= 0]
    return [(stage["creep_time_end_s"], stage["grading_index_end"] - stages[0]["grading_index_end"]) for stage in stages]


def draw_strains(options, rows, path):
    """Creep strain and growth of I_G over creep time, a line a run, a colour a stress ratio."""
    height, bottom, top, low, high = 480, 50, 20, -3, 4  # of log10 s
    out = tables.frame(1330, height, "", "")
    log_strain = lambda value: min(math.log10(value), 1.5)
    panels = ((65, tables.creep_curve, log_strain, -3, 1.5, [(d, f"1e{d}") for d in range(-3, 2)], "axial creep strain, %", 1e-3),
              (710, grading_curve, lambda value: value, 0.0, 0.15, [(k / 100, f"{k / 100:.2f}") for k in range(0, 16, 3)], "growth of I_G", 0.0))
    for left, curve_of, scale, least, most, ticks, name, smallest in panels:
        x_of = lambda seconds: left + 530 * (math.log10(seconds) - low) / (high - low)
        y_of = lambda value: height - bottom - (height - bottom - top) * (value - least) / (most - least)
        out.append(f'<path d="M{left} {top}V{height - bottom}H{left + 530}" fill="none" stroke="black"/>'
                   f'<text x="{left - 48}" y="225" transform="rotate(-90 {left - 48} 225)" text-anchor="middle">{name}</text>'
                   f'<text x="{left + 265}" y="{height - 10}" text-anchor="middle">creep time, s</text>')
        out += [f'<text x="{x_of(10.0 ** d):.1f}" y="{height - bottom + 18}" text-anchor="middle">1e{d}</text>' for d in range(low, high + 1)]
        out += [f'<text x="{left - 6}" y="{y_of(at) + 4:.1f}" text-anchor="end">{text}</text>' for at, text in ticks]
        ratios, ends = list(PAPER), {}
        for row in rows:
            curve = [(t, value) for t, value in curve_of(folder_of(options, row["seed"], row["q_ratio"])) if t >= 10.0 ** low and value > smallest]
            if not curve:
                continue
            colour = f"hsl({270 * (1 - ratios.index(row['q_ratio']) / (len(ratios) - 1)):.0f},70%,45%)"
            points = " ".join(f"{x_of(t):.1f},{y_of(scale(value)):.1f}" for t, value in curve)
            out.append(f'<polyline points="{points}" fill="none" stroke="{colour}"/>')
            ends.setdefault(row["q_ratio"], (colour, []))[1].append((x_of(curve[-1][0]), y_of(scale(curve[-1][1]))))
        for ratio, (colour, points) in ends.items():
            x, y = max(x for x, _ in points), statistics.fmean(y for _, y in points)
            out.append(f'<text x="{x + 6:.1f}" y="{y + 4:.1f}" fill="{colour}">{ratio}</text>')
    path.write_text("\n".join(out + ["</svg>\n"]))


def write_tables(options):
    rows = rows_of(options)
    if not rows:
        print("nothing is done yet", file=sys.stderr)
        return 1
    into = options.into or options.out
    into.mkdir(parents=True, exist_ok=True)
    n = ending(options)
    write_table(options, rows, into / f"table_{n}.md")
    draw_rates(rows, into / f"rates_{n}.svg")
    draw_strains(options, rows, into / f"creep_{n}.svg")
    with open(into / f"runs_{n}.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, ["q_ratio", "seed", *COLUMNS], extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        for row in rows:
            writer.writerow({name: f"{value:.6g}" if isinstance(value, float) else value for name, value in row.items()})
    print(into / f"table_{n}.md")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("what", choices=("run", "tables"))
    parser.add_argument("--bin", type=pathlib.Path, default=pathlib.Path("build/release/bin"))
    parser.add_argument("--particles", type=int, default=11500)
    parser.add_argument("--fidelity", default="balanced", choices=("paper", "balanced", "fast"))
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--jobs", type=int, default=1, help="so many at a time")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--into", type=pathlib.Path, help="folder for tables and figures (default: OUT)")
    options = parser.parse_args()
    options.out, options.bin = options.out.resolve(), options.bin.resolve()
    return {"run": run, "tables": write_tables}[options.what](options)


if __name__ == "__main__":
    sys.exit(main())
