#!/usr/bin/env bash
# From a fresh Debian 12 to the report of a two-day creep test: installs the packages, builds Release, runs the
# example to its end, draws its plots and names the report. Safe to repeat: a run that was cut short goes on from
# its newest checkpoint, a finished one is only reported again.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

readonly job=client/examples/oedometer_creep.toml
readonly results=results/oedometer_creep
readonly creepctl=build/release/bin/creepctl

step() { printf '\n== %s\n' "$*"; }
trap 'printf "\nquickstart: failed in line %s (%s)\n" "$LINENO" "$BASH_COMMAND" >&2' ERR

# shellcheck source=deploy/packages.sh
source deploy/packages.sh

step "Packages"
install_packages "${creep_build_packages[@]}"
printf 'All there.\n'

step "Build (Release, build/release/bin)"
configure=(cmake --preset release -DCREEP_TESTS=OFF)
if command -v ccache >/dev/null; then
  configure+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
"${configure[@]}"
cmake --build --preset release

step "Run $job (a few minutes on two cores; kill it and start this script again to see it go on)"
threads=$(nproc)
if ((threads > 2)); then
  threads=2
fi
"$creepctl" run "$job" --out "$results" --threads "$threads"

step "Plots and report"
"$creepctl" plot "$results"
"$creepctl" report "$results"

printf '\nThe report: %s\n' "$PWD/$results/report.html"
