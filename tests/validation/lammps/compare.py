#!/usr/bin/env python3
"""compare.py FOLDER FIGURE: stress at equal strain here and in LAMMPS. Writes FIGURE (SVG) and prints a table of the largest
and the mean difference, and beside FIGURE known_answers.json for the table in tests/README.md; exit 1 if one is beyond its
tolerance."""
import csv
import json
import pathlib
import sys

folder, figure = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])

# Ours, theirs, tolerance of the largest difference in stress at equal strain, what differs between the two.
#
# Along z alone and without friction the packing buckles again and again, and each time the last digits decide between paths:
# no two programs follow one path for long. The nudged run of creepd itself tells how far; up to there LAMMPS is held against
# creepd. Taken to 20 MPa and back some times and then
# compressed on all three axes alike it hardly rearranges, and the whole range is judged.
PAIRS = [
    ("creepd_isotropic_mu_0", "lammps_isotropic_mu_0", 0.003, "isotropic, mu = 0"),
    ("creepd_isotropic_mu_0", "creepd_isotropic_mu_0_nudged", None, "isotropic, mu = 0, creepd against itself nudged by 2e-15"),
    ("creepd_isotropic_mu_0.275", "lammps_isotropic_mu_0.275", 0.02, "isotropic, mu = 0.275 (mindlin/force)"),
    ("creepd_mu_0", "lammps_mu_0", 0.003, "along z, mu = 0, as long as creepd agrees with itself nudged to 0.3 %"),
    ("creepd_mu_0", "lammps_mu_0", None, "along z, mu = 0, all"),
    ("creepd_mu_0", "creepd_mu_0_nudged", None, "along z, mu = 0, creepd against itself nudged"),
    ("creepd_mu_0.275", "lammps_mu_0.275_force", 0.02, "along z, mu = 0.275, incremental shear force (mindlin/force)"),
    ("creepd_mu_0.275", "lammps_mu_0.275_spring", 0.02, "along z, mu = 0.275, shear spring times present stiffness (mindlin)"),
]


def read(name):
    with open(folder / f"{name}.csv") as file:
        return [tuple(float(value) for value in row.values()) for row in csv.DictReader(file)]


def differences(ours, theirs):
    """Relative, axial and radial, row by row: both print the same steps."""
    rows = []
    assert abs(len(ours) - len(theirs)) <= 1, f"{len(ours)} and {len(theirs)} rows"
    for a, b in zip(ours, theirs):
        assert abs(a[0] - b[0]) < 1e-9, f"strains {a[0]} and {b[0]} differ"
        rows.append((a[0], a[1] / b[1] - 1, a[2] / b[2] - 1))
    return rows


def curve(points, x_of, y_of, style):
    path = " ".join(f"{x_of(x):.1f},{y_of(y):.1f}" for x, y in points)
    return f'<polyline points="{path}" fill="none" {style}/>'


def panel(left, title, axis, series, columns):
    """One chart, its left edge at LEFT: lines of creepd, circles of LAMMPS."""
    width, height, bottom = 560, 420, 50
    start, end = left + 60, left + width - 20
    x_end = max(row[0] for s in series for row in s[2])
    y_end = max(row[1] for s in series for row in s[2])
    x_of = lambda x: start + (end - start) * x / x_end
    y_of = lambda y: height - bottom - (height - bottom - 30) * y / y_end
    out = [f'<path d="M{start} 20V{height - bottom}H{end}" fill="none" stroke="black"/>',
           f'<text x="{start + 20}" y="30" font-weight="bold">{title}</text>']
    for tick in range(0, int(y_end / 1e6) + 1, 5):
        out.append(f'<text x="{start - 8}" y="{y_of(tick * 1e6) + 4:.1f}" text-anchor="end">{tick}</text>')
    thousandths = 5 if x_end > 0.01 else 2
    for tick in range(0, int(x_end * 1000) + 1, thousandths):
        out.append(f'<text x="{x_of(tick / 1000):.1f}" y="{height - bottom + 18}" text-anchor="middle">{tick / 10:g}</text>')
    out.append(f'<text x="{(start + end) / 2}" y="{height - 12}" text-anchor="middle">{axis}</text>')
    for k, (label, colour, ours, theirs) in enumerate(series):
        for column in columns:
            out.append(curve([(r[0], r[column]) for r in ours], x_of, y_of, f'stroke="{colour}" stroke-width="1.5"'))
            for row in theirs[:: max(1, len(theirs) // 25)]:
                if row[0] <= x_end:
                    out.append(f'<circle cx="{x_of(row[0]):.1f}" cy="{y_of(row[column]):.1f}" r="3" fill="none" stroke="{colour}"/>')
        out.append(f'<text x="{end}" y="{height - bottom - 34 + 18 * k}" text-anchor="end" fill="{colour}">{label}: line creepd, circles LAMMPS</text>')
    return out


def draw():
    def series(ours, theirs):
        return [(f"mu = {friction}", colour, read(ours + friction), read(theirs + friction + suffix))
                for friction, colour, suffix in (("0", "#1f77b4", ""),
                                                 ("0.275", "#d62728", "_force" if theirs == "lammps_mu_" else ""))]

    out = ['<svg xmlns="http://www.w3.org/2000/svg" width="1120" height="420" font-family="sans-serif" font-size="12">',
           '<rect width="1120" height="420" fill="white"/>',
           '<text x="16" y="210" transform="rotate(-90 16 210)" text-anchor="middle">stress, MPa</text>']
    out += panel(0, "on all three axes alike: stress along z", "strain of each axis, %",
                 series("creepd_isotropic_mu_", "lammps_isotropic_mu_"), (1,))
    out += panel(560, "along z: axial stress above, radial below", "axial strain, %", series("creepd_mu_", "lammps_mu_"), (1, 2))
    figure.write_text("\n".join(out + ["</svg>\n"]))


def comparable(rows):
    """Rows before rounding alone makes 0.3 %."""
    nudged = differences(read("creepd_mu_0"), read("creepd_mu_0_nudged"))
    split = next((k for k, row in enumerate(nudged) if max(abs(row[1]), abs(row[2])) > 0.003), len(nudged))
    return rows[:split]


REASONS = {0.003: "rounding alone moves creepd by 2e-4 in the isotropic scene; along z by 3e-3 where judging ends",
           0.02: "for the tangential law: LAMMPS' two differ by 3.3e-3 from one another"}
failed, known = False, []
print("| pair | axial strain | axial stress, MPa | largest difference, axial / radial | mean, axial / radial | tolerance |")
print("|---|---|---|---|---|---|")
for ours, theirs, tolerance, what in PAIRS:
    mine = read(ours)
    rows = differences(mine, read(theirs))
    if ours == "creepd_mu_0" and tolerance is not None:
        rows = comparable(rows)
    largest = [max(abs(row[c]) for row in rows) for c in (1, 2)]
    mean = [sum(row[c] for row in rows) / len(rows) for c in (1, 2)]
    print(f"| {what} | {rows[-1][0]:.4f} | {mine[0][1] / 1e6:.1f} to {mine[len(rows) - 1][1] / 1e6:.1f} | "
          f"{largest[0]:.1e} / {largest[1]:.1e} | {mean[0]:+.1e} / {mean[1]:+.1e} | {tolerance or '-'} |")
    if tolerance is not None:
        failed = failed or max(largest) > tolerance
        known.append({"claim": f"LAMMPS, 1500 spheres compressed, {what}; axial and radial stress at equal strain", "cases": 2 * len(rows),
                      "worst": max(largest), "tolerance": tolerance, "reason": REASONS[tolerance]})
(figure.parent / "known_answers.json").write_text(json.dumps(known, indent=1) + "\n")
draw()
sys.exit(1 if failed else 0)
