#!/usr/bin/env bash
# Fuzzes for SECONDS a subject (default: all of them, two at a time), under the address and undefined-behaviour sanitizers.
#
#   tests/fuzz/run.sh SECONDS [SUBJECT...]     CREEP_FUZZ_AT_ONCE=1 for one after the other
#
# Builds with clang in build/fuzz, where the corpus stays for the next time. What breaks a promise is written to
# build/fuzz/found: once understood, it goes to tests/fuzz/found/SUBJECT, where every build tries it again.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

seconds=${1:?usage: tests/fuzz/run.sh SECONDS [SUBJECT...]}
shift
subjects=("$@")
if ((${#subjects[@]} == 0)); then
  subjects=(job_file checkpoint sample_log requests)
fi

# shellcheck source=deploy/packages.sh
source deploy/packages.sh
install_packages "${creep_build_packages[@]}" "${creep_test_packages[@]}" "${creep_fuzz_packages[@]}"
launcher=()
if command -v ccache >/dev/null; then
  launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
cmake --preset fuzz "${launcher[@]}"
cmake --build --preset fuzz --target fuzzers

here=$PWD/tests/fuzz
build=$PWD/build/fuzz
mkdir -p "$build"/{corpus,found,log}

# The words of a job file are those in its reader.
grep -ohE '"[A-Za-z][A-Za-z0-9_/-]{0,30}"' core/experiment/*.cpp | LC_ALL=C sort -u >"$build/words.dict"

# In memory: each input of a store or a log is synced many times.
TMPDIR=$(mktemp -d -p "$([[ -w /dev/shm ]] && echo /dev/shm || echo /tmp)" creep-fuzz-XXXXXX)
export TMPDIR
trap 'rm -rf "$TMPDIR"' EXIT

fuzz() {
  local subject=$1 seeds=() most=65536
  "$build/bin/${subject}_replay" --write-seeds "$build/corpus/$subject"
  if [[ -d "$here/found/$subject" ]]; then
    seeds+=("$here/found/$subject")
  fi
  if [[ "$subject" == job_file ]]; then
    seeds+=(client/examples)
    most=8192
  fi
  ASAN_OPTIONS=strict_string_checks=1 UBSAN_OPTIONS=print_stacktrace=1 \
    "$build/bin/${subject}_fuzz" -max_total_time="$seconds" -max_len="$most" -dict="$build/words.dict" -timeout=60 \
    -rss_limit_mb=4096 -reload=0 -print_final_stats=1 -artifact_prefix="$build/found/$subject-" \
    "$build/corpus/$subject" "${seeds[@]}" >"$build/log/$subject.log" 2>&1
}

# The last line of a log with counts: #2097152 ... cov: 2150 ft: 8630 corp: 1017/394Kb ...
tell() {
  local subject=$1 status=$2 figures
  figures=$(grep -aoE '^#[0-9]+.* cov: [0-9]+ ft: [0-9]+ corp: [0-9]+' "$build/log/$subject.log" | tail -n 1 |
    sed -E 's/^#([0-9]+).* cov: ([0-9]+) ft: ([0-9]+) corp: ([0-9]+)$/\1 inputs, \2 edges, \3 features, corpus of \4/' || true)
  if ((status == 0)); then
    printf '%s: %s\n' "$subject" "$figures"
  else
    printf '%s: BROKEN after %s\n' "$subject" "$figures"
    tail -n 60 "$build/log/$subject.log"
  fi
}

broken=0
at_once=${CREEP_FUZZ_AT_ONCE:-2}
while ((${#subjects[@]} != 0)); do
  now=("${subjects[@]:0:at_once}")
  subjects=("${subjects[@]:at_once}")
  processes=()
  for subject in "${now[@]}"; do
    fuzz "$subject" &
    processes+=($!)
  done
  for i in "${!now[@]}"; do
    status=0
    wait "${processes[i]}" || status=$?
    tell "${now[i]}" "$status"
    ((status == 0)) || broken=1
  done
done
exit "$broken"
