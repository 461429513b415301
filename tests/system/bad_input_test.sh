#!/usr/bin/env bash
# Wrong job files: exit 5, the place of every error, and nothing written. The worker itself: exit 65.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"

# bad NAME SED_SCRIPT WORDS: the tiny job with an error in it.
bad() {
  local file=$work/$1.toml
  sed "$2" "$job" >"$file"
  expect_exit 5 run_job "$work/out" "$file"
  expect_output "$file:"
  expect_output 'error: '
  expect_output "$3"
  [[ ! -e "$work/out" ]] || fail "$1: a directory was made"
  mkdir "$work/job"
  cp "$file" "$work/job/job.toml"
  expect_exit 65 "$bin/creep-worker" "$work/job"
  expect_output 'job.toml:'
  rm -r "$work/job"
}

bad unknown_key 's/^void_ratio/void_ratoi/' void_ratio
bad wrong_dimension 's/"15 MPa"/"15 mm"/' MPa
bad bare_number 's/"1 d"/86400/' duration
bad negative_size 's/particles = 300/side = "-4 mm"/' side
bad no_program '/^\[\[program\]\]$/,/^duration/d' program
bad tiny_void_ratio 's/void_ratio = 0.75/void_ratio = 0.01/' void_ratio
bad too_many 's/particles = 300/particles = 100000000000/' particles
bad empty d ''
head -c 4096 /dev/urandom >"$work/random.toml"
expect_exit 5 run_job "$work/out" "$work/random.toml"
expect_exit 5 run_job "$work/out" "$work/not-there.toml"
[[ ! -e "$work/out" ]] || fail "a directory was made"

expect_exit 2 "$bin/creepctl" run "$job"
expect_exit 2 "$bin/creepctl" run "$job" --out "$work/out" --threads 0
expect_exit 64 "$bin/creep-worker" "$work/not-there"
mkdir "$work/empty"
expect_exit 65 "$bin/creep-worker" "$work/empty"
expect_exit 5 "$bin/creepctl" checkpoint show "$work/empty"
expect_exit 5 "$bin/creepctl" checkpoint show "$job"
