# Sourced by run.sh and .ci/run: runs ctest and keeps the totals of all calls.
# shellcheck shell=bash

creep_passed=0
creep_failed=0
creep_skipped=0
creep_ctest_prefix=()  # words before ctest, e.g. setarch

# run_ctest BUILD_FOLDER CTEST_ARGUMENT...: adds to the totals; fails if a test failed, none ran or ctest broke.
run_ctest() {
  local build=$1 log status=0 summary failed total skipped
  shift
  log=$(mktemp)
  "${creep_ctest_prefix[@]}" ctest --test-dir "$build" --output-on-failure --no-tests=error --timeout 900 "$@" 2>&1 | tee "$log" || status=$?
  summary=$(grep -E '^[0-9]+% tests passed, [0-9]+ tests failed out of [0-9]+' "$log" | tail -n 1 || true)
  skipped=$(grep -cE '^\s+[0-9]+ - .* \(Skipped\)$' "$log" || true)
  rm -f "$log"
  if [[ -z "$summary" ]]; then
    printf 'run_ctest: ctest in %s gave no summary (exit code %d)\n' "$build" "$status" >&2
    creep_failed=$((creep_failed + 1))
    return 1
  fi
  read -r failed total < <(sed -E 's/^.* ([0-9]+) tests failed out of ([0-9]+).*$/\1 \2/' <<<"$summary")
  creep_failed=$((creep_failed + failed))
  creep_skipped=$((creep_skipped + skipped))
  creep_passed=$((creep_passed + total - failed - skipped))
  return "$status"
}

# run_script FILE ARGUMENT...: a system test with other programs than ctest gives it; adds to the totals, fails if it failed
# or takes longer than a quarter of an hour: a client waits for a daemon that died.
run_script() {
  local status=0
  "${creep_ctest_prefix[@]}" timeout --kill-after=30 900 "$@" || status=$?
  case "$status" in
    0) creep_passed=$((creep_passed + 1)) ;;
    77) creep_skipped=$((creep_skipped + 1)) ;;
    *) creep_failed=$((creep_failed + 1)) ;;
  esac
  ((status == 0 || status == 77))
}

# The closing line.
print_totals() {
  local line="$creep_passed passed, $creep_failed failed"
  if ((creep_skipped != 0)); then
    line+=", $creep_skipped skipped"
  fi
  printf '%s\n' "$line"
}
