#!/usr/bin/env bash
# VTK's own reader opens every picture and finds the numbers that stand in it.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
/usr/bin/python3 -c 'import vtk' 2>/dev/null || skip "needs VTK for python (python3-vtk9)"
printf '[output]\nsnapshots = "per decade of age"\n' >>"$job"
undisturbed
/usr/bin/python3 "$here/check_snapshots.py" --vtk "$reference/snapshots"
