#!/usr/bin/env bash
# check_layering.sh finds each planted violation, names its rule, and is content with what is allowed.
set -euo pipefail
check=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/check_layering.sh
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
passed=0

# clean: a small tree that uses everything where it is allowed.
clean() {
  rm -rf "${tree:?}"/*
  mkdir -p "$tree"/core/{arithmetic,dem,physics,run,experiment,folder} "$tree"/server/worker "$tree"/client "$tree"/proto
  put core/arithmetic/check.h 'std::fputs(message.c_str(), stderr);'
  put core/arithmetic/elementary.cpp 'double y = std::exp(x);'
  put core/arithmetic/random.cpp '#include <Random123/philox.h>'
  put core/dem/kernels_avx2.cpp '#include <immintrin.h>'
  put core/dem/team.h '#include <thread>'
  put core/physics/strength.cpp 'double s = elementary::exp(x) + std::sqrt(x);  // not std::exp(x), not printf(x)'
  put core/run/run.cpp '#include "core/dem/specimen.h"'
  put core/folder/lease.cpp '#include <filesystem>' '#include "core/output/record.h"'
  put core/experiment/document.cpp '#include <toml++/toml.h>'
  put core/CMakeLists.txt 'target_compile_options(creep_core PRIVATE -ffp-contract=off)'
  put server/worker/main.cpp '#include "core/run/run.h"' '#include <thread>' 'auto now = std::chrono::steady_clock::now();'
  put server/worker/CMakeLists.txt '# no gRPC in it' 'target_link_libraries(creep-worker PRIVATE creep_core)'
  put server/service.cpp '#include "proto/service.h"' '#include <grpcpp/grpcpp.h>'
  put client/main.cpp '#include "core/run/record.h"' 'double y = std::log10(x);'
}

put() {
  local file=$1
  shift
  printf '%s\n' "$@" >"$tree/$file"
}

fail() {
  printf 'FAILED: %s\n' "$1"
  exit 1
}

# plant FILE LINE RULE: the line must be reported in that file under that rule, and nothing else.
plant() {
  local file=$1 line=$2 rule=$3 report
  clean
  mkdir -p "$tree/$(dirname "$file")"
  printf '%s\n' "$line" >>"$tree/$file"
  if report=$("$check" "$tree"); then
    fail "not found: '$line' in $file"
  fi
  grep -qF "$file:" <<<"$report" || fail "'$line': the report does not name $file: $report"
  grep -qF "$rule" <<<"$report" || fail "'$line' in $file: the report does not say '$rule': $report"
  [[ $(grep -c . <<<"$report") == 2 ]] || fail "'$line' in $file: more than one report: $report"
  passed=$((passed + 1))
}

clean
"$check" "$tree" >/dev/null || fail "the clean tree is refused: $("$check" "$tree")"

plant core/run/run.cpp '#include "server/worker/lock.h"' 'core includes only core'
plant core/run/run.cpp '#include "creep/v1/creep.pb.h"' 'core includes only core'
plant core/folder/lease.cpp '#include "server/rules/job.h"' 'core includes only core'
plant core/run/run.cpp '#include "core/folder/lease.h"' 'nothing in core but core/folder'
plant core/state/checkpoint.cpp '#include "core/run/run.h"' 'in core the run alone includes the run'
plant core/state/checkpoint.cpp '#include "core/output/samples.h"' 'in core the run alone includes output'
plant core/dem/servo.cpp '#include "core/state/state.h"' 'in core only output and run include state'
plant core/folder/lease.cpp '#include <sqlite3.h>' 'no gRPC'
plant server/worker/main.cpp '#include "server/service.h"' 'the worker includes only core'
plant server/worker/main.cpp '#include "proto/service.h"' 'the worker includes only core'
plant server/service.cpp '#include "client/chart.h"' 'the server includes only'
plant client/main.cpp '#include "server/worker/lock.h"' 'the client includes only'
plant client/main.cpp '#include "chart.h"' 'by the path from the root'
plant core/run/run.cpp '#include <grpcpp/grpcpp.h>' 'no gRPC'
plant server/worker/main.cpp '#include <sqlite3.h>' 'no gRPC'
plant server/worker/CMakeLists.txt 'target_link_libraries(creep-worker PRIVATE gRPC::grpc++)' 'link no service library'
plant core/run/run.cpp 'std::cout << strain;' 'core does not print'
plant core/run/run.cpp 'std::printf("%g", strain);' 'core does not print'
plant core/run/run.cpp 'auto now = std::chrono::system_clock::now();' 'core reads no clock'
plant core/run/run.cpp 'const char* wish = std::getenv("CREEP_ISA");' 'core reads no environment'
plant core/run/run.cpp '#include <fstream>' 'core opens no file'
plant core/physics/crack.cpp 'double v = std::pow(x, 60.0);' 'elementary functions'
plant core/dem/servo.cpp 'double v = exp(x);' 'elementary functions'
plant core/dem/specimen.h 'std::unordered_map<int, int> slots;' 'hash table'
plant core/run/run.cpp '#include <atomic>' 'threads only in the kernel files'
plant core/physics/contact_law.cpp '#include <immintrin.h>' 'vector instructions only'
plant core/CMakeLists.txt 'add_compile_options(-ffast-math)' 'compiler options'

# Two doors to one library.
clean
put core/run/other.cpp '#include <toml++/toml.h>'
if "$check" "$tree" >/dev/null; then fail 'a second user of toml++ is not found'; fi
clean
put core/physics/other.cpp '#include <Random123/threefry.h>'
if "$check" "$tree" >/dev/null; then fail 'a second user of Random123 is not found'; fi
clean
put server/database.cpp '#include <sqlite3.h>'
"$check" "$tree" >/dev/null || fail 'the one user of SQLite is refused'
put server/jobs.cpp '#include <sqlite3.h>'
if "$check" "$tree" >/dev/null; then fail 'a second user of SQLite is not found'; fi

printf 'check_layering finds %d planted violations and all second doors\n' "$passed"
