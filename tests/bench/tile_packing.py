#!/usr/bin/env python3
"""tile_packing.py PACKING NX NY NZ > LARGER: copies of a packing in a box (tests/bench/packing_*.txt) side by side.

Grains at the faces of two copies meet there as they met the walls. The cost of a cycle at a larger count is what such
packings are for; a specimen for physics is packed anew.
"""
import re
import sys


def main():
    path, tiles = sys.argv[1], [int(count) for count in sys.argv[2:5]]
    with open(path, encoding="utf-8") as file:
        lines = file.read().splitlines()
    head = next(line for line in lines if line.startswith("#"))
    low_high = [float(value) for value in re.search(r"box((?: \S+){6})", head).group(1).split()]
    sides = [low_high[axis + 3] - low_high[axis] for axis in range(3)]
    high = [low_high[axis] + tiles[axis] * sides[axis] for axis in range(3)]
    print("# x y z r (metres). box", *[f"{value:.12g}" for value in low_high[:3] + high])
    grains = [[float(value) for value in line.split()] for line in lines if line and not line.startswith("#")]
    for i in range(tiles[0]):
        for j in range(tiles[1]):
            for k in range(tiles[2]):
                for x, y, z, radius in grains:
                    print(f"{x + i * sides[0]:.12e} {y + j * sides[1]:.12e} {z + k * sides[2]:.12e} {radius:.12e}")


if __name__ == "__main__":
    main()
