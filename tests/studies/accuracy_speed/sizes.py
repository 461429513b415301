#!/usr/bin/env python3
"""How many particles does a specimen need? Question and reading in README.md.

  sizes.py OUT --bin BIN [--sizes N...] [--seeds N...] [--into FOLDER]

Packs and creeps specimens of each size with the fidelity "balanced", goes on where it was stopped, and writes
sizes.csv, sizes.md and sizes.svg. Rows of a sizes.csv there are kept, so sizes and seeds can be added. What one
specimen misses: its systematic difference, the mean of its size less that of the largest, and the scatter of one seed.
"""
import argparse
import csv
import math
import pathlib
import statistics
import sys

sys.dont_write_bytecode = True  # the source folder stays as it is
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import study  # noqa: E402

METHOD = next(method for method, fidelity in study.FIDELITIES.items() if fidelity == "balanced")
SIZES = (1500, 3000, 6000, 11500, 30000)
DRAWN = {"strain_600": ("creep strain at 600 s", "#069"), "strain_end": ("creep strain at 2 d", "#c60"),
         "e_before": ("void ratio before creep", "#393"), "rate_10_min": ("rate at 10 min", "#939")}
COLUMNS = ["particles", "seed", "outcome", *study.QUANTITIES, "particle_steps", "seconds"]


def read_rows(path):
    rows = {}
    for text in csv.DictReader(path.read_text().splitlines()) if path.exists() else []:
        row = {name: value if name == "outcome" else float(value) for name, value in text.items() if value}
        row |= {name: int(row[name]) for name in ("particles", "seed")}
        rows[row["particles"], row["seed"]] = row
    return rows


def write_rows(rows, path):
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, restval="", extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        for _, row in sorted(rows.items()):
            writer.writerow({key: f"{value:.6g}" if isinstance(value, float) else value for key, value in row.items()})


def values(rows, size, name):
    return [row[name] for row in rows.values() if row["particles"] == size and row.get(name) is not None]


def sizes_of(rows):
    """Those of which two specimens at least are there."""
    return [size for size in sorted({row["particles"] for row in rows.values()})
            if len(values(rows, size, "strain_end")) > 1]


def deviation(rows, size, name):
    """Standard deviation over the seeds, and its relative error: sqrt(1 / 2(n - 1)), of a normal distribution."""
    at = values(rows, size, name)
    return statistics.stdev(at), 1 / math.sqrt(2 * (len(at) - 1))


def write_table(rows, path):
    lines = ["| particles | seeds | particle-steps | " + " | ".join(study.QUANTITIES.values()) + " |",
             "|---" * (len(study.QUANTITIES) + 3) + "|"]
    for size in sizes_of(rows):
        cells = []
        for name in study.QUANTITIES:
            mean, half = study.interval(values(rows, size, name))
            cells.append(f"{mean:.4g} ± {half:.2g} ({deviation(rows, size, name)[0]:.2g})")
        steps = statistics.fmean(values(rows, size, "particle_steps"))
        lines.append(f"| {size} | {len(values(rows, size, 'strain_end'))} | {steps:.2g} | " + " | ".join(cells) + " |")
    path.write_text("\n".join(lines) + "\n")


class Panel:
    """Axes with logarithmic abscissa; `log` for the ordinate as well."""

    def __init__(self, left, title, x_range, y_range, log):
        self.left, self.title, self.x_range, self.y_range, self.log = left, title, x_range, y_range, log

    def x(self, value):
        low, high = map(math.log10, self.x_range)
        return self.left + 440 * (math.log10(value) - low) / (high - low)

    def y(self, value):
        low, high, at = (*map(math.log10, self.y_range), math.log10(value)) if self.log else (*self.y_range, value)
        return 480 - 420 * (at - low) / (high - low)

    def frame(self, x_ticks, y_ticks, x_name):
        parts = [f'<rect x="{self.left}" y="60" width="440" height="420" fill="none" stroke="#444"/>'
                 f'<text x="{self.left}" y="44" font-size="14">{self.title}</text>'
                 f'<text x="{self.left + 220}" y="522" text-anchor="middle">{x_name}</text>']
        for tick, text in x_ticks:
            parts.append(f'<line x1="{self.x(tick):.1f}" x2="{self.x(tick):.1f}" y1="60" y2="480" stroke="#ddd"/>'
                         f'<text x="{self.x(tick):.1f}" y="498" text-anchor="middle">{text}</text>')
        for tick in y_ticks:
            parts.append(f'<line x1="{self.left}" x2="{self.left + 440}" y1="{self.y(tick):.1f}" y2="{self.y(tick):.1f}" '
                         f'stroke="#ddd"/><text x="{self.left - 6}" y="{self.y(tick) + 4:.1f}" text-anchor="end">{tick:g}</text>')
        return parts

    def bar(self, x, low, high, colour):
        low, high = max(low, self.y_range[0]), min(high, self.y_range[1])
        return f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{self.y(low):.1f}" y2="{self.y(high):.1f}" stroke="{colour}"/>'

    def curve(self, points, colour):
        return ('<polyline fill="none" stroke="' + colour + '" stroke-width="1.5" points="'
                + " ".join(f"{self.x(a):.1f},{self.y(b):.1f}" for a, b in points) + '"/>'
                + "".join(f'<circle cx="{self.x(a):.1f}" cy="{self.y(b):.1f}" r="3.5" fill="{colour}"/>' for a, b in points))


def draw_scatter(rows, sizes, largest):
    """Cost against the scatter of one specimen, both logarithmic."""
    cost = {size: statistics.fmean(values(rows, size, "particle_steps")) for size in sizes}
    panel = Panel(80, "Scatter of one specimen, % of the mean", (min(cost.values()) / 1.5, max(cost.values()) * 1.5), (0.05, 100), True)
    parts = panel.frame([(cost[size], size) for size in sizes], (0.1, 1, 10, 100), "particles, placed at their cost in particle-steps")
    for place, (name, (title, colour)) in enumerate(DRAWN.items()):
        points = []
        for size in sizes:
            spread, relative = deviation(rows, size, name)
            percent = 100 * spread / largest[name][0]
            points.append((cost[size], percent))
            parts.append(panel.bar(panel.x(cost[size]) + 2 * place - 3, percent * (1 - relative), percent * (1 + relative), colour))
        parts.append(panel.curve(points, colour))
    first = 100 * deviation(rows, sizes[0], "strain_end")[0] / largest["strain_end"][0]
    slope = [(cost[size], first * math.sqrt(sizes[0] / size)) for size in sizes]
    parts.append('<polyline fill="none" stroke="#777" stroke-dasharray="5 4" points="'
                 + " ".join(f"{panel.x(a):.1f},{panel.y(b):.1f}" for a, b in slope) + '"/>')
    return parts


def draw_means(rows, sizes, largest):
    """Mean of a size over that of the largest, with its 95 % interval."""
    panel = Panel(620, "Mean over the largest size's, 95 % interval", (sizes[0] / 1.3, sizes[-1] * 1.3), (0.4, 1.6), False)
    parts = panel.frame([(size, size) for size in sizes], (0.4, 0.6, 0.8, 1, 1.2, 1.4, 1.6), "particles")
    for place, (name, (title, colour)) in enumerate(DRAWN.items()):
        points = []
        for size in sizes:
            mean, half = study.interval(values(rows, size, name))
            points.append((size * 1.02 ** (place - 1.5), mean / largest[name][0]))
            parts.append(panel.bar(panel.x(points[-1][0]), (mean - half) / largest[name][0], (mean + half) / largest[name][0], colour))
        parts.append(panel.curve(points, colour))
        parts.append(f'<circle cx="{640}" cy="{80 + 18 * place}" r="4" fill="{colour}"/>'
                     f'<text x="652" y="{84 + 18 * place}">{title}</text>')
    return parts


def write_chart(rows, path):
    sizes = sizes_of(rows)
    if len(sizes) < 2:
        return
    largest = {name: study.interval(values(rows, sizes[-1], name)) for name in DRAWN}
    parts = ['<svg xmlns="http://www.w3.org/2000/svg" width="1100" height="545" font-family="DejaVu Sans, sans-serif" '
             'font-size="12"><rect width="1100" height="545" fill="white"/>',
             *draw_scatter(rows, sizes, largest),
             '<text x="510" y="80" text-anchor="end" fill="#777">dashed: 1/sqrt(particles)</text>',
             *draw_means(rows, sizes, largest), "</svg>"]
    path.write_text("\n".join(parts) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--bin", type=pathlib.Path, required=True, help="folder of creepctl and creep-worker")
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4, 5])
    parser.add_argument("--into", type=pathlib.Path, help="folder for table, csv and chart (default: OUT)")
    options = parser.parse_args()
    options.out, options.bin = options.out.resolve(), options.bin.resolve()
    into, top = options.into or options.out, options.out
    top.mkdir(parents=True, exist_ok=True)
    rows = read_rows(into / "sizes.csv")
    for size in options.sizes:
        options.out = top / str(size)
        options.out.mkdir(exist_ok=True)
        for seed in options.seeds:
            trunk = study.compute(options, f"trunk_{seed}", study.packing_text(size, seed))
            folder = study.compute(options, f"balanced_{seed}", study.method_text(trunk, study.METHODS[METHOD]))
            rows[size, seed] = study.row_of(options, METHOD, seed, folder) | {"particles": size}
            write_rows(rows, into / "sizes.csv")
    write_table(rows, into / "sizes.md")
    write_chart(rows, into / "sizes.svg")


if __name__ == "__main__":
    main()
