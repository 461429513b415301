#!/usr/bin/env bash
# The Debian 12 packages that creepd is built and tested with: the only list of them.
#
# Source it and call install_packages, or run it: deploy/packages.sh [build|package|test|long-test|tidy|fuzz ...] (default: build).
# Each package's reason is in deploy/README.md.

creep_build_packages=(
  g++ cmake ninja-build pkg-config
  libeigen3-dev libtomlplusplus-dev librandom123-dev libabsl-dev libcli11-dev nlohmann-json3-dev
  libssl-dev libcairo2-dev fonts-dejavu-core
  libgrpc++-dev protobuf-compiler-grpc protobuf-compiler libprotobuf-dev libsqlite3-dev libsystemd-dev
)
creep_package_packages=(dpkg-dev file help2man)
creep_test_packages=(libgtest-dev clang-format python3-grpcio valgrind libbenchmark-dev)
creep_long_test_packages=(python3-vtk9 lammps yade)
creep_tidy_packages=(clang-tidy)
creep_fuzz_packages=(clang libclang-rt-14-dev)

# Sets missing_packages to those of the given packages that are not installed.
find_missing_packages() {
  # dpkg-query fails when it does not know one of them; the others are printed all the same.
  local installed package
  installed=" $( (dpkg-query --show --showformat='${binary:Package}/${db:Status-Status}\n' "$@" 2>/dev/null || true) |
    sed -n 's|^\([^:/]*\)\(:[a-z0-9]*\)\{0,1\}/installed$|\1|p' | tr '\n' ' ')"
  missing_packages=()
  for package in "$@"; do
    [[ "$installed" == *" $package "* ]] || missing_packages+=("$package")
  done
}

# Installs what is missing of the given packages, as root or through sudo. Does nothing, offline, if all are there.
install_packages() {
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    printf 'This script installs Debian packages (Debian 12 is what is tested), but there is no apt-get here.\n' >&2
    printf 'Install the equivalents of: %s\nthen configure and build with cmake --preset release.\n' "$*" >&2
    return 1
  fi
  local missing_packages
  find_missing_packages "$@"
  if ((${#missing_packages[@]} == 0)); then
    return 0
  fi
  local as_root=()
  if ((EUID != 0)); then
    if ! command -v sudo >/dev/null; then
      printf 'Missing packages: %s\nInstall them as root, or run this again as root or with sudo installed.\n' \
        "${missing_packages[*]}" >&2
      return 1
    fi
    as_root=(sudo)
  fi
  printf 'Installing: %s\n' "${missing_packages[*]}"
  local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300)
  "${apt[@]}" update &&
    "${apt[@]}" install --yes --no-install-recommends "${missing_packages[@]}" || return 1
  find_missing_packages "${missing_packages[@]}"
  if ((${#missing_packages[@]} != 0)); then
    printf 'Still missing after the installation: %s\n' "${missing_packages[*]}" >&2
    return 1
  fi
}

if [[ "${BASH_SOURCE[0]}" == "$0" ]]; then
  set -euo pipefail
  if (($# == 0)); then
    set -- build
  fi
  for list in "$@"; do
    case "$list" in
      build) install_packages "${creep_build_packages[@]}" ;;
      package) install_packages "${creep_package_packages[@]}" ;;
      test) install_packages "${creep_test_packages[@]}" ;;
      long-test) install_packages "${creep_long_test_packages[@]}" ;;
      tidy) install_packages "${creep_tidy_packages[@]}" ;;
      fuzz) install_packages "${creep_fuzz_packages[@]}" ;;
      *)
        printf 'usage: %s [build|package|test|long-test|tidy|fuzz ...]\n' "$0" >&2
        exit 2
        ;;
    esac
  done
fi
