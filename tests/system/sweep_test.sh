#!/usr/bin/env bash
# A sweep over two seeds and two stress ratios, killed in the middle and called again, here and on a daemon: every job
# has the bits of a plain run of its job file, and none is computed or submitted twice.
source "$(dirname "$0")/support.sh"
job=$work/shear.toml
cat >"$job" <<'TOML'
[specimen]
particles = 300
void_ratio = 0.75
[[program]]
stage = "isotropic"
until = { mean_stress = "3 MPa" }
[[program]]
stage = "triaxial"
until = { q_ratio = 0.5, q_max = "4 MPa" }
axial_velocity = "0.2 m/s"
[[program]]
stage = "creep"
duration = "1 h"
TOML
sed -n '/^\[numerics\]/,$p' "$here/triaxial.toml" | sed 's/^minimum_cycles = .*/minimum_cycles = 12000/' >>"$job"
values=(--seeds 1..2 --stress-ratio 0.4,0.8)
names=(seed_1/trunk seed_1/q_0.4 seed_1/q_0.8 seed_2/trunk seed_2/q_0.4 seed_2/q_0.8)
# In the background without it: that would be a subshell.
sweep() { "$bin/creepctl" sweep "$job" "${values[@]}" "$@"; }

printf 'plain runs\n'
expect_exit 0 "$bin/creepctl" sweep "$job" "${values[@]}" --dry-run
awk -v into="$work/plain" '
  /^# seed_/ { name = $2; sub(/,$/, "", name); gsub("/", "-", name); file = into "-" name ".toml"; trunk = $2
    checkpoint = $NF; source = name; sub(/-q_.*/, "-trunk", source)
    if ($0 ~ /, from /) printf "[start]\njob = \"plain-%s\"\ncheckpoint = \"%s\"\n", source, checkpoint >(file ".start"); next }
  file { print >file }' "$work/output"
plain_of() { printf '%s/plain-%s' "$work" "${1/\//-}"; }
for name in "${names[@]}"; do
  plain=$(plain_of "$name")
  if [[ -e "$plain.toml.start" ]]; then cat "$plain.toml.start" >>"$plain.toml"; fi
  expect_exit 0 run_job "$plain" "$plain.toml"
  [[ -n $(digest_of "$plain") ]] || fail "$name: no digest"
done
[[ $(digest_of "$(plain_of seed_1/q_0.4)") != $(digest_of "$(plain_of seed_2/q_0.4)") ]] || fail "both seeds are one specimen"

printf 'killed in the middle and called again\n'
"$bin/creepctl" sweep "$job" "${values[@]}" --out "$work/swept" --jobs 1 >"$work/log" 2>&1 &
killed=$!
wait_for 60 has_worker "$work/swept/seed_1/q_0.4"
kill -9 "$killed"
wait "$killed" 2>/dev/null || true
[[ ! -e "$work/swept/seed_2/q_0.8/summary.json" ]] || fail "the sweep was over before it was killed"
"$bin/creepctl" sweep "$job" "${values[@]}" --out "$work/swept" --jobs 1 >"$work/log" 2>&1 &
stopped=$!
wait_for 60 has_worker "$work/swept/seed_1/q_0.8"
kill -TERM "$stopped"
code=0
wait "$stopped" || code=$?
((code == 75)) || fail "stopped by SIGTERM the sweep ended with $code: $(cat "$work/log")"
grep -q "The same command goes on" "$work/log" || fail "a stopped sweep does not say how it goes on"
expect_exit 0 sweep --out "$work/swept"
expect_output "seed_1/trunk: done before"
expect_output "6 of 6 jobs are done"
for name in "${names[@]}"; do
  [[ $(digest_of "$work/swept/$name") == $(digest_of "$(plain_of "$name")") ]] || fail "$name: another digest than a plain run"
done

printf 'called once more it computes nothing, also in another place, and takes more seeds\n'
mv "$work/swept" "$work/moved"
stat -c '%n %Y' "$work"/moved/*/*/summary.json >"$work/before"
expect_exit 0 sweep --out "$work/moved"
stat -c '%n %Y' "$work"/moved/*/*/summary.json | cmp - "$work/before" || fail "a finished sweep was computed again"
values=(--seeds 1..3 --stress-ratio 0.4,0.8)
expect_exit 0 sweep --out "$work/moved"
expect_output "9 of 9 jobs are done"

printf 'a job that fails stops no other and is named\n'
# The specimen never bears 36 MPa; the trunk is stopped by a guard after it has kept the checkpoint of the smaller ratio.
expect_exit 1 "$bin/creepctl" sweep "$job" --stress-ratio 0.1,0.9 --q-max "40 MPa" --out "$work/weak"
expect_output "1 of 3 jobs are done"
grep -E '^seed_1/trunk +failed .*guard ' "$work/output" >/dev/null || fail "the stopped trunk is not listed with its guard"
grep -E '^seed_1/q_0.9 +failed .*ended without the checkpoint' "$work/output" >/dev/null || fail "the failed job is not listed"
[[ -n $(digest_of "$work/weak/seed_1/q_0.1") ]] || fail "a branch whose checkpoint was kept did not run"
values=(--seeds 1..2 --stress-ratio 0.4,0.8)

printf 'wrong input\n'
expect_exit 5 sweep --q-max "4 m" --out "$work/never"
expect_output "--q-max"
expect_exit 5 "$bin/creepctl" sweep "$here/tiny.toml" --stress-ratio 0.4 --out "$work/never"
expect_output "has no triaxial stage"
expect_exit 5 "$bin/creepctl" sweep "$job" --set numerics.minimum_cycle=1,2 --out "$work/never"
expect_output "minimum_cycles"
expect_exit 2 "$bin/creepctl" sweep "$job" --seeds 3..1 --out "$work/never"
expect_output "--seeds"
expect_exit 2 "$bin/creepctl" sweep "$job" --seeds 2 --out "$work/never" --name both
expect_exit 2 "$bin/creepctl" sweep "$job" --out "$work/never"
expect_output "what is to be varied"
[[ ! -e "$work/never" ]] || fail "a refused sweep left a folder"
sed 's/^particles = 300/particles = 310/' "$job" >"$work/other.toml"
expect_exit 5 "$bin/creepctl" sweep "$work/other.toml" "${values[@]}" --out "$work/moved"
expect_output "holds the run of another job file"

source "$here/daemon_support.sh"
start_daemon
step "on a daemon, client and daemon killed in the middle"
"$bin/creepctl" sweep "$job" "${values[@]}" --name tri >"$work/log" 2>&1 &
killed=$!
forked() { (($(creepctl ls --label sweep=tri --quiet | wc -l) > 2)); }
wait_for 60 forked
kill -9 "$killed"
wait "$killed" 2>/dev/null || true
kill_daemon
start_daemon
expect_exit 0 sweep --name tri --fetch "$work/fetched"
expect_output "(submitted before)"
expect_output "6 of 6 jobs are done"
(($(creepctl ls --label sweep=tri --quiet | wc -l) == 6)) || fail "other than six jobs: $(creepctl ls)"
for name in "${names[@]}"; do
  id=$(creepctl ls --label sweep=tri --label "member=$name" --quiet)
  [[ $(field "$id" state_digest) == $(digest_of "$(plain_of "$name")") ]] || fail "$name: another digest on the daemon"
  [[ $name == *trunk ]] || [[ $(digest_of "$work/fetched/$name") == $(digest_of "$(plain_of "$name")") ]] ||
    fail "$name: fetched another digest"
done

step "called again nothing is submitted; another job file under the same name is refused"
expect_exit 0 sweep --name tri
(($(creepctl ls --quiet | wc -l) == 6)) || fail "a repeated sweep made more jobs"
expect_exit 5 "$bin/creepctl" sweep "$work/other.toml" "${values[@]}" --name tri
expect_output "give --name"
(($(creepctl ls --quiet | wc -l) == 6)) || fail "a refused sweep made jobs"
step "a client that waits sees the daemon go and come back"
"$bin/creepctl" sweep "$job" --seeds 5..5 --stress-ratio 0.4,0.8 --name patient >"$work/log" 2>&1 &
patient=$!
submitted() { [[ -n $(creepctl ls --label sweep=patient --quiet) ]]; }
wait_for 30 submitted
kill_daemon
start_daemon
code=0
wait "$patient" || code=$?
((code == 0)) || fail "the waiting sweep ended with $code: $(cat "$work/log")"
grep -q "3 of 3 jobs are done" "$work/log" || fail "the waiting sweep does not say that all are done"

step "what is only submitted is said to wait"
expect_exit 75 sweep --name later --no-wait
expect_output "waits for seed_1/trunk"
stop_daemon
expect_exit 4 sweep --name gone --server "$work/none.sock"
