#!/usr/bin/env bash
# A long queue and many watchers: memory per job and per watcher, and the times of calls (service/load.py). Limits of
# time are ten times those of an idle machine; the recorded run asks for the full numbers and the plain limits:
#   CREEP_LOAD="--jobs 10000 --watchers 200 --seconds 30" tests/system/load_test.sh build/release/bin
# Or what the service costs one job, in so many turns (service/overhead.py):
#   CREEP_OVERHEAD=3 tests/system/load_test.sh build/release/bin
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
source "$(dirname "${BASH_SOURCE[0]}")/daemon_support.sh"
python_client || skip "needs python3-grpcio and protoc"
daemon_folders=(--bin "$bin" --work "$work" --state "$state")

if [[ -n "${CREEP_OVERHEAD:-}" ]]; then
  sed -i 's/minimum_cycles = 3000/minimum_cycles = 20000/' "$job"
  "$python" "$here/service/overhead.py" "${daemon_folders[@]}" --turns "$CREEP_OVERHEAD" "$job"
  exit
fi
# Does not end meanwhile.
sed 's/particles = 300/particles = 3000/; s/minimum_cycles = 3000/minimum_cycles = 100000/' "$job" >"$work/running.toml"
read -ra numbers <<<"${CREEP_LOAD:---jobs 3000 --watchers 50 --seconds 5 --slower 10}"
"$python" "$here/service/load.py" "${daemon_folders[@]}" "${numbers[@]}" "$work/running.toml" "$job"
