#!/usr/bin/env bash
# Installs what the tests need, builds Release and runs every test that is not labelled long; ends with the line
# "N passed, N failed". Works from any folder and from a clean clone with nothing but git installed.
#
#   tests/run.sh          the usual tests
#   tests/run.sh --all    the long ones too
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

clocked='^(system|faults|attack)$'
selection=(--label-exclude '^(long|system|faults|attack)$')
clocked_selection=(--label-regex "$clocked" --label-exclude '^long$')
long=0
case "${1:-}" in
  "") ;;
  --all)
    selection=(--label-exclude "$clocked")
    clocked_selection=(--label-regex "$clocked")
    long=1
    ;;
  *)
    printf 'usage: tests/run.sh [--all]\n' >&2
    exit 2
    ;;
esac

# shellcheck source=deploy/packages.sh
source deploy/packages.sh
# shellcheck source=tests/run_ctest.sh
source tests/run_ctest.sh
install_packages "${creep_build_packages[@]}" "${creep_test_packages[@]}"
if ((long)); then
  install_packages "${creep_long_test_packages[@]}"
fi

launcher=()
if command -v ccache >/dev/null; then
  launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
cmake --preset release -DCREEP_TESTS=ON "${launcher[@]}"
cmake --build --preset release

# A second, unoptimised build of the simulator: the system tests compare its results with Release, bit for bit.
cmake --preset debug -DCREEP_TESTS=ON "${launcher[@]}"
cmake --build --preset debug --target creep-worker
export CREEP_OTHER_BIN=$PWD/build/debug/bin

status=0
run_ctest build/release --parallel 2 "${selection[@]}" || status=1
# These wait for real processes with limits of wall time, which a busy machine can exceed: they have a second try, and
# the first one stays to be seen above.
run_ctest build/release --parallel 2 "${clocked_selection[@]}" --repeat until-pass:2 || status=1
print_totals
exit "$status"
