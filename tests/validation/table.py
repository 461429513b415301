#!/usr/bin/env python3
"""table.py BIN: runs the validation tests in BIN and puts what they measured into tests/README.md, between the lines
that mark the table; below them what known_answers.json of the comparisons with other programs keeps. Exit 1 if a test fails;
then nothing is written."""
import json
import pathlib
import subprocess
import sys
import tempfile

PROGRAMS = ["collision_test", "oblique_collision_test", "shear_cycle_test", "fcc_test"]
BEGIN = "<!-- validation table: tests/validation/table.py -->"
END = "<!-- end of the validation table -->"

binaries = pathlib.Path(sys.argv[1])
here = pathlib.Path(__file__).resolve().parent
readme = here.parent / "README.md"
rows = []
for program in PROGRAMS:
    with tempfile.NamedTemporaryFile(suffix=".json") as out:
        run = subprocess.run([binaries / program, f"--gtest_output=json:{out.name}"], stdout=subprocess.PIPE, text=True)
        if run.returncode != 0:
            sys.exit(run.stdout)
        for suite in json.load(out)["testsuites"]:
            for test in suite["testsuite"]:
                rows += [(json.loads(test[key]), program) for key in sorted(test) if key.startswith("known_")]
for kept in sorted(here.glob("*/known_answers.json")):
    rows += [(row, f"{kept.parent.name}/run.sh") for row in json.loads(kept.read_text())]

lines = ["| known answer | cases | largest difference | tolerance | its reason | in |", "|---|---|---|---|---|---|"]
for row, program in rows:
    lines.append(f"| {row['claim']} | {row['cases']} | {row['worst']:.1e} | {row['tolerance']:.0e} | {row['reason']} | "
                 f"`{program}` |")
text = readme.read_text()
before, rest = text.split(BEGIN)
after = rest.split(END)[1]
readme.write_text(before + BEGIN + "\n\n" + "\n".join(lines) + "\n\n" + END + after)
