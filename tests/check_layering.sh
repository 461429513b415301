#!/usr/bin/env bash
# Checks that dependencies point one way and that core keeps its promises (core/README.md, "What core does not do"
# and "Determinism contract"): who may include what, and which words a folder must not contain.
#
#   tests/check_layering.sh [ROOT]    every violation as FILE:LINE: rule: text; exit 1 if there is one
#
# tests/check_layering_test.sh plants violations in a copy and expects each to be found.
set -euo pipefail
root=$(cd "${1:-"$(dirname "${BASH_SOURCE[0]}")/.."}" && pwd)
cd "$root"

violations=0

# files FOLDER...: our C++ files in the folders that exist, sorted.
files() {
  local folder
  for folder in "$@"; do
    if [[ -e "$folder" ]]; then
      find "$folder" -type f \( -name '*.h' -o -name '*.cpp' \)
    fi
  done | LC_ALL=C sort
}

# forbid RULE PATTERN FILE...: reports each line of code (comments cut off) that matches the extended regular
# expression (perl flavour).
forbid() {
  local rule=$1 pattern=$2 found
  shift 2
  if (($# == 0)); then
    return
  fi
  found=$(RULE="$rule" PATTERN="$pattern" perl -ne '
    BEGIN { $pattern = qr/$ENV{PATTERN}/; }
    my $code = $_;
    if ($ARGV =~ /CMakeLists/) { $code =~ s/#.*//; } else { $code =~ s{(?<!:)//.*}{}; }
    print "$ARGV:$.: $ENV{RULE}: $_" if $code =~ $pattern;
    close ARGV if eof;
  ' "$@")
  if [[ -n "$found" ]]; then
    printf '%s\n' "$found"
    violations=$((violations + $(wc -l <<<"$found")))
  fi
}

# except REGEX: drops the files that match from the list on standard input.
except() { grep -Ev "$1" || true; }

# only_one WHAT PATTERN FILE...: at most one of the files may match.
only_one() {
  local what=$1 pattern=$2 users
  shift 2
  users=$(grep -lE "$pattern" "$@" /dev/null || true)
  if [[ -n "$users" && $(wc -l <<<"$users") -gt 1 ]]; then
    printf '%s is used in more than one file; go through one of them:\n%s\n' "$what" "$users"
    violations=$((violations + 1))
  fi
}

mapfile -t core < <(files core | except '^core/folder/')
mapfile -t folder < <(files core/folder)
mapfile -t worker < <(files server/worker)
mapfile -t server < <(files server | except '^server/worker/')
mapfile -t client < <(files client)
mapfile -t ours < <(files core proto server client)
if ((${#core[@]} == 0)); then
  printf 'check_layering: no sources under %s/core\n' "$root" >&2
  exit 2
fi

# Who may include whom.
forbid 'core includes only core' '#\s*include\s+"(client|server|proto|tests|creep/v1)/' "${core[@]}" "${folder[@]}"
forbid 'nothing in core but core/folder touches files' '#\s*include\s+"core/folder/' "${core[@]}"
mapfile -t below_run < <(printf '%s\n' "${core[@]}" | except '^core/run/')
forbid 'in core the run alone includes the run' '#\s*include\s+"core/run/' "${below_run[@]}"
mapfile -t below_output < <(printf '%s\n' "${below_run[@]}" | except '^core/output/')
forbid 'in core the run alone includes output' '#\s*include\s+"core/output/' "${below_output[@]}"
mapfile -t below_state < <(printf '%s\n' "${below_output[@]}" | except '^core/state/')
forbid 'in core only output and run include state' '#\s*include\s+"core/state/' "${below_state[@]}"
forbid 'the worker includes only core and its own' '#\s*include\s+"(client|proto|tests|creep/v1|server/(?!worker/))' \
  "${worker[@]}"
forbid 'the server includes only core, proto and its own' '#\s*include\s+"(client|tests)/' "${server[@]}"
forbid 'the client includes only core, proto and its own' '#\s*include\s+"(server|tests)/' "${client[@]}"
forbid 'include by the path from the root' '#\s*include\s+"(\.|[^/"]+")' "${ours[@]}"

# Libraries that would end the independence of the simulator, in code and in what is linked.
service='#\s*include\s+[<"](grpc|google/protobuf|sqlite3|spdlog)'
forbid 'no gRPC, protobuf, SQLite or logger in core' "$service|\b(grpc|spdlog|sqlite3?)::|\bsqlite3_" "${core[@]}" \
  "${folder[@]}"
forbid 'no gRPC, protobuf, SQLite or logger in the worker' "$service|\b(grpc|spdlog|sqlite3?)::|\bsqlite3_" \
  "${worker[@]}"
mapfile -t build_files < <(for folder in core server/worker; do
  if [[ -d "$folder" ]]; then find "$folder" -name CMakeLists.txt; fi
done | LC_ALL=C sort)
forbid 'core and the worker link no service library' '(?i)\b(grpc|protobuf|sqlite3?|spdlog)\b' "${build_files[@]}"

# Core never prints, reads a clock or the environment, opens a file or starts a process.
mapfile -t quiet_core < <(printf '%s\n' "${core[@]}" | except '^core/arithmetic/check\.h$')
forbid 'core does not print' 'std::(cout|cerr|clog)\b|(?<![a-z_])f?(printf|puts|putc|putchar)\s*\(' "${quiet_core[@]}"
forbid 'core reads no clock' \
  '\b(system_clock|steady_clock|high_resolution_clock|clock_gettime|gettimeofday)\b|absl::Now\b|std::time\s*\(' \
  "${core[@]}"
forbid 'core reads no environment variable' '\bgetenv\s*\(' "${core[@]}"
forbid 'core opens no file' '#\s*include\s+<(fstream|filesystem|fcntl\.h|unistd\.h)>|\bf?open\s*\(' "${core[@]}"

# One door for each library whose results or formats we depend on.
only_one 'toml++' '#[[:space:]]*include[[:space:]]+[<"]toml' "${ours[@]}"
only_one 'Random123' '#[[:space:]]*include[[:space:]]+[<"]Random123' "${ours[@]}"
only_one 'SQLite' '#[[:space:]]*include[[:space:]]+[<"]sqlite3' "${ours[@]}"

# Determinism: elementary functions differ between C libraries, hash order and thread order between runs.
mapfile -t state_path < <(files core/arithmetic core/dem core/physics core/run core/state core/output |
  except '^core/arithmetic/elementary\.(h|cpp)$')
libm='exp|exp2|expm1|log|log2|log10|log1p|pow|sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|cbrt|hypot|erf|erfc'
forbid 'elementary functions on the state path come from core/arithmetic/elementary.h' \
  "(?<![\\w.>:])(std::|::|__builtin_)?($libm)[fl]?\\s*\\(" "${state_path[@]}"
forbid 'no order of a hash table on the state path' '\bunordered_(map|set|multimap|multiset)\b|\b(flat|node)_hash_' \
  "${state_path[@]}"
kernels='^core/dem/(activity|contact_kernel|contact_search|kernels|lanes|particle_kernel|quad|team)[a-z0-9_]*\.(h|cpp)$'
mapfile -t not_kernels < <(printf '%s\n' "${core[@]}" | except "$kernels")
forbid 'threads only in the kernel files of core/dem' \
  '#\s*include\s+<(thread|mutex|atomic|barrier|latch|semaphore|condition_variable|future|pthread\.h|omp\.h)>|std::(jthread|thread|async)\b' \
  "${not_kernels[@]}"
forbid 'vector instructions only in the kernel files of core/dem' '#\s*include\s+<[a-z]*intrin\.h>|\b_mm(256|512)?_' \
  "${not_kernels[@]}"
mapfile -t all_build_files < <(find . -name CMakeLists.txt -not -path './build*' | LC_ALL=C sort)
forbid 'compiler options must not change results' '-ffast-math|-Ofast|-march=native|-ffp-contract=(fast|on)|-funsafe' \
  "${all_build_files[@]}"

if ((violations != 0)); then
  printf 'check_layering: %d violation(s)\n' "$violations"
  exit 1
fi
printf 'check_layering: %d files, no violation\n' "${#ours[@]}"
