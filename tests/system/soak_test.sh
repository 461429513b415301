#!/usr/bin/env bash
# Random operations, kills and full disks on a real creepd, held against a model (service/soak.py). More of them:
#   CREEP_SOAK_OPERATIONS=5000 CREEP_TEST_SEED=1 tests/system/soak_test.sh build/release/bin
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
source "$(dirname "${BASH_SOURCE[0]}")/daemon_support.sh"
python_client || skip "needs python3-grpcio and protoc"

# Two jobs: one that ends soon, one that is often disturbed.
sed 's/minimum_cycles = 3000/minimum_cycles = 10000/; s/particles = 300/particles = 300\nseed = 2/' "$job" >"$work/long.toml"
undisturbed
expect_exit 0 run_job "$work/long" "$work/long.toml"

mkdir "$work/disk"
if mount -t tmpfs -o size=40m tmpfs "$work/disk" 2>/dev/null; then
  mounted=$work/disk
  disk=(--disk "$work/disk")
  state=$work/disk/state
else
  printf 'without full disks: they need the right to mount a small tmpfs\n'
  disk=()
fi
"$python" "$here/service/soak.py" --bin "$bin" --work "$work" --state "$state" "${disk[@]}" \
  --operations "${CREEP_SOAK_OPERATIONS:-200}" --slower "${CREEP_SLOWER:-1}" --seed "${CREEP_TEST_SEED:-4711}" \
  "$job" "$reference" "$work/long.toml" "$work/long"
