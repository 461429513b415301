# Sourced by the system tests: TEST.sh BIN_FOLDER. Gives a working folder that goes at the end, the tiny job with an
# undisturbed run of it, and checks that end the test with a line on what was wrong. One thread, where a test does not
# say otherwise: two that wait for each other on a busy machine are slow, and results do not depend on it.
set -euo pipefail
export LC_ALL=C NO_COLOR=1
unset CREEP_ISA

bin=$(cd "$1" && pwd)
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d "${TMPDIR:-/tmp}/creep-system-XXXXXX")
mounted=
clean_up() {
  if [[ -n "$mounted" ]]; then umount "$mounted"; fi
  rm -rf "$work"
}
trap clean_up EXIT
cp "$here/tiny.toml" "$work/tiny.toml"
job=$work/tiny.toml

# ctest takes this exit code for a skipped test (SKIP_RETURN_CODE).
skip() {
  printf 'SKIPPED: %s\n' "$*"
  exit 77
}

fail() {
  printf 'FAILED: %s\n' "$*" >&2
  exit 1
}

# expect_exit CODE COMMAND...: runs it; its output goes to $work/output.
expect_exit() {
  local wanted=$1 got=0
  shift
  "$@" >"$work/output" 2>&1 || got=$?
  if ((got != wanted)); then
    cat "$work/output" >&2
    fail "exit code $got instead of $wanted: $*"
  fi
}

expect_output() {
  grep -qF -- "$1" "$work/output" || {
    cat "$work/output" >&2
    fail "the output does not say: $1"
  }
}

# run_job FOLDER [JOB [OPTION...]]
run_job() { "$bin/creepctl" run "${2:-$job}" --out "$1" --threads 1 "${@:3}"; }

digest_of() { sed -nE 's/^  "state_digest": "([0-9a-f]{64})",$/\1/p' "$1/summary.json"; }

# undisturbed: the run that all others are compared with, in $reference; its wall time in $reference_ms. On a fast machine
# the job gets longer dynamic stages first, so that what is to strike it finds it still running.
undisturbed() {
  reference=$work/reference
  local started TIMEFORMAT=%3U seconds tries
  for ((tries = 1; tries <= 6; ++tries)); do
    rm -rf "$reference"
    started=$(date +%s%3N)
    { time expect_exit 0 run_job "$reference" 2>&3; } 3>&2 2>"$work/seconds"
    reference_ms=$(($(date +%s%3N) - started))
    seconds=$(tail -n 1 "$work/seconds")
    awk -v seconds="$seconds" 'BEGIN { exit seconds >= 1 }' || break
    ((tries == 6)) || lengthen "$(awk -v seconds="$seconds" 'BEGIN { print 2 / (seconds + 0.01) }')"
  done
  [[ -n $(digest_of "$reference") ]] || fail "no state_digest in summary.json"
  ls "$reference"/checkpoints/ck.* >/dev/null || fail "the tiny job is too short to make a checkpoint"
}

# lengthen FACTOR: the dynamic stages of the tiny job.
lengthen() {
  awk -v factor="$1" '/^minimum_cycles = / { $3 = int(factor * $3) } { print }' "$job" >"$work/longer.toml"
  mv "$work/longer.toml" "$job"
}

# same_result FOLDER: bit for bit that of the undisturbed run, its records without a gap or a repeat.
same_result() {
  local table
  [[ $(digest_of "$1") == $(digest_of "$reference") ]] || fail "$1: another state_digest"
  for table in samples breakages gsd; do
    cmp "$1/$table.csv" "$reference/$table.csv" || fail "$1: another $table.csv"
  done
  # The last two columns of stages.csv are cost.
  cmp <(sed -E 's/(,[^,]*){2}$//' "$1/stages.csv") <(sed -E 's/(,[^,]*){2}$//' "$reference/stages.csv") ||
    fail "$1: another stages.csv"
  cut -d, -f1 "$1"/{samples,breakages,gsd,stages}.csv | grep -E '^[0-9]+$' | sort -n |
    awk '$1 != NR - 1 { exit 1 }' || fail "$1: the sequence of records has a gap or a repeat"
}

# wait_for SECONDS COMMAND...: until the command is true.
wait_for() {
  local until=$((SECONDS + $1))
  shift
  until "$@"; do
    ((SECONDS < until)) || fail "waited too long for: $*"
    sleep 0.02
  done
}

worker_of() { sed -nE 's/^attempt [0-9]+ process 0*([0-9]+)$/\1/p' "$1/lease" 2>/dev/null; }
has_worker() { [[ -n $(worker_of "$1") ]]; }
has_checkpoint() { compgen -G "$1/checkpoints/ck.*[0-9]" >/dev/null; }

# start_run FOLDER [JOB]: in the background, its process in $run; returns when the worker has the lease.
start_run() {
  "$bin/creepctl" run "${2:-$job}" --out "$1" --threads 1 >"$work/output" 2>&1 &  # not run_job: that is a subshell
  run=$!
  wait_for 20 has_worker "$1"
}

# kill_run FOLDER: run and worker at once, as a power cut would.
kill_run() {
  kill -9 "$run" "$(worker_of "$1")" 2>/dev/null || true
  wait "$run" 2>/dev/null || true
}
