#!/usr/bin/env bash
# run.sh BIN_FOLDER OUT: the example undisturbed, then once more with kill -9 of creepctl and its worker at ten random
# fractions, by turns on one and two threads; compares digests and tables.
set -euo pipefail
bin=$1 out=$2
job=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)/client/examples/oedometer_creep.toml
mkdir "$out"
RANDOM=${CREEP_TEST_SEED:-20261122}

worker_of() { sed -nE 's/^attempt [0-9]+ process 0*([0-9]+)$/\1/p' "$1/lease" 2>/dev/null; }
now() { tr -d '" ,\n' <"$out/killed/progress.json" | grep -oE 'stage:[a-z]+|creep_time_s:[0-9.e+-]+' | tr '\n' ' '; }

started=$SECONDS
"$bin/creepctl" run "$job" --out "$out/whole" --threads 2 >"$out/whole.log" 2>&1
whole=$((SECONDS - started))
printf 'undisturbed: %d s\n' "$whole"
for i in 0 1 2 3 4 5 6 7 8 9; do
  [[ ! -e "$out/killed/verdict.json" ]] || break
  "$bin/creepctl" run "$job" --out "$out/killed" --threads $((i % 2 + 1)) >>"$out/killed.log" 2>&1 &
  run=$!
  # The first before the first checkpoint, the others after up to three tenths of the run.
  if ((i == 0)); then sleep 6; else sleep $((5 + whole * 3 * (RANDOM % 1000) / 10000)); fi
  kill -9 "$run" "$(worker_of "$out/killed")" 2>/dev/null || true
  wait "$run" 2>/dev/null || true
  printf 'kill %d: %s %s\n' "$i" "$(now)" "$(cd "$out/killed" && echo checkpoints/*)"
done
"$bin/creepctl" run "$job" --out "$out/killed" --threads 2 >>"$out/killed.log" 2>&1
grep -h '"state_digest"' "$out"/{whole,killed}/summary.json
for table in samples breakages gsd; do
  cmp "$out/whole/$table.csv" "$out/killed/$table.csv" && printf 'the same %s.csv\n' "$table"
done
