#!/usr/bin/env bash
# Makes this study again: run.sh BIN OUT [THREADS]. BIN holds creepctl and creep-worker, OUT receives the job directories.
# The literal preset runs away and is stopped after LITERAL_MINUTES (default 10); the same command continues it.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
bin=${1:?folder of creepctl}
out=${2:?folder for the results}
threads=${3:-2}
example=$here/../../../client/examples/oedometer_creep_paper.toml
mkdir -p "$out"
"$bin/creepctl" run "$example" --out "$out/default" --threads "$threads"
sed 's/^preset = "fontainebleau-ne34"$/preset = "fontainebleau-ne34-literal"/' "$example" > "$out/literal.toml"
timeout --signal=INT "${LITERAL_MINUTES:-10}m" "$bin/creepctl" run "$out/literal.toml" --out "$out/literal" --threads "$threads" || true
for preset in default literal; do
  "$bin/creepctl" plot "$out/$preset" --out "$out/$preset/plots" --format both
  "$bin/creepctl" report "$out/$preset"
done
