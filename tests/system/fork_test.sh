#!/usr/bin/env bash
# One sheared specimen serves many creep tests: kept checkpoints, [start] with and without a daemon, fork with changes.
source "$(dirname "$0")/support.sh"
job=$work/triaxial.toml
cp "$here/triaxial.toml" "$job"
undisturbed
kept=$(cd "$reference/checkpoints" && echo keep.*)
for name in 01_isotropic_end 02_triaxial_end 05_unload_end 02_triaxial_axial_strain_0.01; do
  [[ " $kept " == *" keep.$name "* ]] || fail "no checkpoint $name is kept: $kept"
done
grep -q "^sequence.*,mean_stress_Pa,deviatoric_stress_Pa$" "$reference/samples.csv" || fail "samples.csv has no p and q"

creep='[{ stage = "creep", deviatoric_stress = "1 MPa", duration = "1 h" }]'
cat >"$work/started.toml" <<EOF
[start]
job = "reference"
checkpoint = "01_isotropic_end"
[[program]]
stage = "creep"
deviatoric_stress = "1 MPa"
duration = "1 h"
EOF
expect_exit 0 "$bin/creepctl" validate "$work/started.toml"
expect_output "the specimen of job reference"
expect_exit 0 run_job "$work/started" "$work/started.toml"
expect_exit 0 run_job "$work/started" "$work/started.toml"
expect_output "finished already"
expect_exit 0 "$bin/creepctl" report "$work/started"

# Killed right at its start it goes on from the checkpoint it was given, also when the source is gone.
start_run "$work/killed" "$work/started.toml"
kill_run "$work/killed"
mv "$reference" "$work/elsewhere"
expect_exit 0 run_job "$work/killed" "$work/killed/job.toml"
[[ $(digest_of "$work/killed") == $(digest_of "$work/started") ]] || fail "another digest after a kill"
expect_exit 5 run_job "$work/never" "$work/started.toml"
expect_output "is not the folder of a run"
mv "$work/elsewhere" "$reference"

sed 's/01_isotropic_end/03_creep_end/' "$work/started.toml" >"$work/unknown.toml"
expect_exit 5 run_job "$work/never" "$work/unknown.toml"
expect_output "no such checkpoint"
{ cat "$work/started.toml"; printf '[specimen]\nparticles = 301\nvoid_ratio = 0.75\n'; } >"$work/other.toml"
expect_exit 5 run_job "$work/never" "$work/other.toml"
expect_output "another specimen"
[[ ! -e "$work/never" ]] || fail "a refused run left a folder"

source "$here/daemon_support.sh"
start_daemon
source_id=$(submit)
succeeded "$source_id"
digest_of_job() { field "$1" state_digest; }

step "without changes the same experiment goes on, its records with it"
again=$(creepctl fork "$source_id" --checkpoint 02_triaxial_axial_strain_0.01)
succeeded "$again"

step "with another program a new experiment starts: the same as by run, by submit and by a repeated request"
forked=$(creepctl fork "$source_id" --checkpoint 01_isotropic_end --set "program=$creep" --request-id once)
[[ $(creepctl fork "$source_id" --checkpoint 01_isotropic_end --set "program=$creep" --request-id once) == "$forked" ]] ||
  fail "a repeated fork made a second job"
sed "s/\"reference\"/\"$source_id\"/" "$work/started.toml" >"$work/by_id.toml"
submitted=$(creepctl submit "$work/by_id.toml")
for id in "$forked" "$submitted"; do
  expect_exit 0 creepctl wait "$id" --timeout "300 s"
  [[ $(digest_of_job "$id") == $(digest_of "$work/started") ]] || fail "$id: another digest than by run"
  [[ $(field "$id" parent_job) == "$source_id" ]] || fail "$id: does not tell its parent"
done
sharper=$(creepctl fork "$source_id" --checkpoint 01_isotropic_end --set "program=$creep" --set numerics.minimum_cycles=2500)
expect_exit 0 creepctl wait "$sharper" --timeout "300 s"
[[ $(digest_of_job "$sharper") != $(digest_of "$work/started") ]] || fail "--set of a number changed nothing"

step "what cannot be is refused, and makes no job"
before=$(creepctl ls --json | grep -c '"id"')
expect_exit 1 creepctl fork "$source_id" --checkpoint 01_isotropic_end --set specimen.seed=2
expect_output "another specimen"
expect_exit 5 creepctl fork "$source_id" --checkpoint ../../../creepd.db
expect_output "keeps no checkpoint of this name"
expect_exit 1 creepctl fork "$source_id" --checkpoint 05_unload_end
expect_output "carried out"
expect_exit 5 creepctl fork "$source_id" --set numerics.minimum_cycle=3
expect_output "minimum_cycles"
expect_exit 2 creepctl fork "$source_id" --set numerics
[[ $(creepctl ls --json | grep -c '"id"') == "$before" ]] || fail "a refused fork left a job"
stop_daemon
