#!/usr/bin/env bash
# Every C++ file of ours is as clang-format leaves it (.clang-format). To repair: tests/check_format.sh --fix
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

mapfile -t sources < <(find core proto server client tests -type f \( -name '*.h' -o -name '*.cpp' \) | LC_ALL=C sort)
if ((${#sources[@]} == 0)); then
  printf 'check_format: no sources found\n' >&2
  exit 2
fi
if [[ "${1:-}" == --fix ]]; then
  exec clang-format -i "${sources[@]}"
fi
clang-format --dry-run -Werror "${sources[@]}"
printf 'check_format: %d files\n' "${#sources[@]}"
