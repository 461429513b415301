#!/usr/bin/env bash
# The same bits with other instructions, another skin, another schedule of neighbour searches and another build.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
undisturbed

for instructions in portable avx2 avx512; do
  if [[ $instructions != portable ]] && ! grep -qE "^flags.* ${instructions/avx512/avx512f}( |$)" /proc/cpuinfo; then
    printf 'this processor has no %s\n' "$instructions"
    continue
  fi
  CREEP_ISA=$instructions expect_exit 0 run_job "$work/$instructions"
  grep -qF "\"instruction_set\": \"$instructions\"" "$work/$instructions/summary.json" ||
    fail "CREEP_ISA=$instructions was not obeyed"
  same_result "$work/$instructions"
done

# The default skin is 0.01 d50 = 2.1 um.
sed 's/^\[numerics\]$/&\nskin = "1.05 um"/' "$job" >"$work/skin.toml"
expect_exit 0 run_job "$work/skin" "$work/skin.toml"
same_result "$work/skin"

expect_exit 0 run_job "$work/searches" "$job" --rebuild-every 1
same_result "$work/searches"

# Looking where the time goes changes nothing, and finds all of it.
expect_exit 0 run_job "$work/profile" "$job" --profile
expect_output 'Where the time of this attempt went'
same_result "$work/profile"
awk -F, 'NR > 1 { share += $3; of[$1] = $3 }
  END { exit !(NR == 10 && share > 0.999 && share < 1.001 && of["contacts"] > 0.05 && of["particles"] > 0.02) }' \
  "$work/profile/profile.csv" || { cat "$work/profile/profile.csv"; fail "profile.csv does not tell where the time went"; }

if [[ -x "${CREEP_OTHER_BIN:-}/creep-worker" ]]; then
  mkdir "$work/other"
  cp "$job" "$work/other/job.toml"
  expect_exit 0 "$CREEP_OTHER_BIN/creep-worker" "$work/other" --threads 1
  same_result "$work/other"
else
  printf 'CREEP_OTHER_BIN does not name another build: not compared\n'
fi
