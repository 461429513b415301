#!/usr/bin/env bash
# The quick start from its daemon on (packages are there, the build is this one): killed in the middle it leaves no daemon
# behind, started again it goes on to the same bits, and again it only reports.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
[[ -x "$bin/creepd" ]] || skip "no creepd"
sed -i 's/minimum_cycles = 3000/minimum_cycles = 30000/' "$job"
undisturbed

clone=$work/clone
mkdir -p "$clone"/{client/examples,build/release,stub}
cp -r "$here/../../deploy" "$clone/deploy"
ln -s "$bin" "$clone/build/release/bin"
cp "$job" "$clone/client/examples/oedometer_creep.toml"
printf '#!/bin/sh\n' >"$clone/stub/cmake"
chmod +x "$clone/stub/cmake"
export PATH=$clone/stub:$PATH TMPDIR=$work  # where a killed quick start leaves the folder of its socket
job_has_checkpoint() { compgen -G "$clone/results/creepd/jobs/*/checkpoints/ck.*[0-9]" >/dev/null; }
no_daemon() { flock -n "$clone/results/creepd/lock" true; }

"$clone/deploy/quickstart.sh" >"$work/first" 2>&1 &
first=$!
trap 'kill -9 "$first" 2>/dev/null || true; clean_up' EXIT
wait_for 60 job_has_checkpoint
expect_exit 1 "$clone/deploy/quickstart.sh"
expect_output "it is running already"
kill -9 "$first"
wait "$first" 2>/dev/null || true
wait_for 60 no_daemon

expect_exit 0 "$clone/deploy/quickstart.sh"
expect_output "The report: $clone/results/oedometer_creep/report.html"
[[ -s "$clone/results/oedometer_creep/report.html" ]] || fail "no report"
same_result "$clone/results/oedometer_creep"
grep -qF 'continues from checkpoint' "$clone/results/oedometer_creep/worker.log" || fail "it began from zero"
no_daemon || fail "the daemon was not stopped"

expect_exit 0 "$clone/deploy/quickstart.sh"
expect_output "The report: $clone/results/oedometer_creep/report.html"
(($(find "$clone/results/creepd/jobs" -mindepth 1 -maxdepth 1 | wc -l) == 1)) || fail "the job was submitted again"
