#!/usr/bin/env bash
# From a fresh Debian 12 to the report of a two-day creep test: installs the packages, builds Release, starts a daemon,
# submits the example, watches it to its end, fetches it, draws its plots, names the report and stops the daemon.
# Safe to stop and to repeat: the job is submitted once; one that was cut short goes on from its newest checkpoint, a
# finished one is only reported again. Everything it makes is in build/ and results/.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

readonly job=client/examples/oedometer_creep.toml
readonly results=results/oedometer_creep
readonly state=results/creepd
readonly bin=build/release/bin

step() { printf '\n== %s\n' "$*"; }
die() {
  printf '\nquickstart: %s\n' "$*" >&2
  exit 1
}
trap 'printf "\nquickstart: failed in line %s (%s)\n" "$LINENO" "$BASH_COMMAND" >&2' ERR

mkdir -p results
exec 9>results/quickstart.lock
flock -n 9 || die "it is running already"

# shellcheck source=deploy/packages.sh
source deploy/packages.sh

step "Packages"
install_packages "${creep_build_packages[@]}"
printf 'All there.\n'

step "Build (Release, $bin)"
configure=(cmake --preset release -DCREEP_TESTS=OFF)
if command -v ccache >/dev/null; then
  configure+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
"${configure[@]}"
cmake --build --preset release

step "Start creepd (state in $state, log in $state.log)"
# A daemon whose quickstart was killed is told to end, and ends when its worker has written a checkpoint.
[[ ! -e "$state/lock" ]] || flock --timeout 200 "$state/lock" true || die "another creepd uses $state"
threads=$(nproc)
if ((threads > 2)); then
  threads=2
fi
runtime=$(mktemp -d "${TMPDIR:-/tmp}/creepd-XXXXXX")  # short: the path of a socket has at most 107 characters
export CREEPCTL_SERVER=$runtime/creepd.sock
setsid setpriv --pdeathsig TERM "$bin/creepd" --state "$state" --socket "$CREEPCTL_SERVER" --slots 1 \
  --threads-per-job "$threads" >>"$state.log" 2>&1 9>&- &
daemon=$!
stop_daemon() {
  kill "$daemon" 2>/dev/null || true
  wait "$daemon" || true
  rm -rf "$runtime"
}
trap stop_daemon EXIT
until [[ -S "$CREEPCTL_SERVER" ]]; do
  kill -0 "$daemon" 2>/dev/null || die "creepd does not start: $(tail -n 1 "$state.log")"
  sleep 0.1
done
"$bin/creepctl" doctor || true

step "Submit $job and watch it (minutes on two cores; stop it and start this script again to see it go on)"
id=$("$bin/creepctl" submit "$job" --request-id "quickstart-$(sha256sum <"$job" | cut -c 1-16)")
setpriv --pdeathsig TERM "$bin/creepctl" watch "$id" 9>&- ||
  die "the job did not end well; its log is in $state/jobs/$id; remove $state to begin anew"

step "Fetch, plots and report"
if [[ -e "$results" ]] && ! grep -qsF "$id" "$results/.creepctl-fetch.json"; then
  mv "$results" "$results.until-$(date +%Y%m%d-%H%M%S)"  # another run's
fi
"$bin/creepctl" fetch "$id" --out "$results"
"$bin/creepctl" plot "$results"
"$bin/creepctl" report "$results"

printf '\nThe report: %s\n' "$PWD/$results/report.html"
