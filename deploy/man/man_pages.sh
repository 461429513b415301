#!/usr/bin/env bash
# Manual pages from what the programs say with --help and the sections beside this script.
#
#   deploy/man/man_pages.sh BIN_FOLDER VERSION FOLDER    makes FOLDER/man1 and FOLDER/man8; needs help2man
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
bin=$1 version=$2 folder=$3

# page SECTION PROGRAM WHAT
page() {
  local file=$folder/man$1/$2.$1
  mkdir -p "$folder/man$1"
  # Defaults as every user reads them, not those of who builds.
  env -u XDG_STATE_HOME HOME='~' XDG_RUNTIME_DIR='$XDG_RUNTIME_DIR' LC_ALL=C.UTF-8 \
    help2man --no-info --section "$1" --name "$3" --version-string "$version" --source creepd \
    --opt-include "$here/$2.h2m" "$bin/$2" >"$file"
  gzip -9nf "$file"
}

page 1 creepctl "submit, follow and report simulations of creep in quartz sands"
page 1 creep-worker "simulate creep in a quartz sand in one directory"
page 1 creep-bench "measure the speed of the contact kernels"
page 8 creepd "queue and run simulations of creep in quartz sands"
