#!/usr/bin/env python3
"""lammps_data.py PACKING OUT: a LAMMPS data file of the spheres at rest. Prints the walls x0 y0 z0 x1 y1 z1 [m]."""
import sys

DENSITY = 2650.0  # kg/m3
MARGIN = 2e-5  # m: walls stand inside the simulation box

packing, out = sys.argv[1:]
with open(packing) as lines:
    walls = [float(word) for word in next(lines).split("box")[1].split()[:6]]
    spheres = [[float(word) for word in line.split()] for line in lines]
with open(out, "w") as data:
    data.write(f"spheres\n\n{len(spheres)} atoms\n1 atom types\n\n")
    for axis, (low, high) in zip("xyz", zip(walls[:3], walls[3:])):
        data.write(f"{low - MARGIN!r} {high + MARGIN!r} {axis}lo {axis}hi\n")
    data.write("\nAtoms\n\n")
    for i, (x, y, z, radius) in enumerate(spheres, 1):
        data.write(f"{i} 1 {2 * radius!r} {DENSITY} {x!r} {y!r} {z!r}\n")
print(*(repr(wall) for wall in walls))
