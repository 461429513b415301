#!/usr/bin/env python3
"""lammps_data.py PACKING OUT: a LAMMPS data file of spheres with seeded velocities up to 5 mm/s a component.
Prints the edges of the box [m]."""
import random
import sys

DENSITY = 2650.0  # kg/m3
LARGEST_VELOCITY = 5e-3  # m/s
MARGIN = 2e-5  # m: walls stand inside the simulation box

packing, out = sys.argv[1:]
spheres = []
with open(packing) as lines:
    for number, line in enumerate(lines):
        if number == 0:
            box = [float(word) for word in line.split("box")[1].split()[:6]]
        elif not line.startswith("#"):
            spheres.append([float(word) for word in line.split()])
edges = box[3:]
draw = random.Random(1)
with open(out, "w") as data:
    data.write(f"spheres\n\n{len(spheres)} atoms\n1 atom types\n\n")
    for axis, edge in zip("xyz", edges):
        data.write(f"{-MARGIN!r} {edge + MARGIN!r} {axis}lo {axis}hi\n")
    data.write("\nAtoms\n\n")
    for i, (x, y, z, radius) in enumerate(spheres, 1):
        data.write(f"{i} 1 {2 * radius!r} {DENSITY} {x!r} {y!r} {z!r}\n")
    data.write("\nVelocities\n\n")
    for i in range(1, len(spheres) + 1):
        v = [LARGEST_VELOCITY * (2 * draw.random() - 1) for _ in range(3)]
        data.write(f"{i} {v[0]!r} {v[1]!r} {v[2]!r} 0 0 0\n")
print(*edges)
