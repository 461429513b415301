#!/usr/bin/env bash
# What gets installed: every program and file in its place, units that systemd accepts and finds well protected, and a
# Debian package with its dependencies.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
build=$(dirname "$bin")
root=$here/../..

DESTDIR=$work/tree cmake --install "$build" --prefix /usr >"$work/output" 2>&1 || {
  cat "$work/output" >&2
  fail "cmake --install"
}
for file in bin/creepd bin/creepctl bin/creep-worker bin/creep-bench lib/systemd/system/creepd.service \
  lib/systemd/user/creepd.service share/bash-completion/completions/creepctl share/creepd/certificates.sh \
  share/creepd/proto/creep/v1/creep.proto; do
  [[ -s "$work/tree/usr/$file" ]] || fail "$file is not installed"
done
if command -v help2man >/dev/null; then
  for page in man1/creepctl.1 man1/creep-worker.1 man1/creep-bench.1 man8/creepd.8; do
    gzip -dc "$work/tree/usr/share/man/$page.gz" | grep -q 'SEE ALSO' || fail "the manual page $page"
  done
fi
bash -n "$work/tree/usr/share/bash-completion/completions/creepctl" || fail "the bash completion is no bash"
for script in "$root"/deploy/*.sh "$root"/deploy/debian/{postinst,prerm,postrm}; do
  bash -n "$script" || fail "$script"
done
# The options in units and documents are those of the program.
"$work/tree/usr/bin/creepd" --help >"$work/help"
for option in $(grep -ohE -- '(creepd|OPTIONS=").*' "$root"/deploy/systemd/* | grep -oE -- '--[a-z][a-z-]+' | sort -u); do
  grep -qw -- "$option" "$work/help" || fail "creepd has no option $option"
done

if command -v systemd-analyze >/dev/null; then
  for unit in creepd.service:system creepd-user.service:user; do
    cp "$root/deploy/systemd/${unit%:*}" "$work/creepd.service"
    sed -i "s|/usr/bin/creepd|$bin/creepd|; /^Documentation=/d" "$work/creepd.service"
    XDG_RUNTIME_DIR=$work systemd-analyze verify --man=no "--${unit#*:}" "$work/creepd.service" >"$work/output" 2>&1 && [[ ! -s $work/output ]] || {
      cat "$work/output" >&2
      fail "${unit%:*}: systemd finds faults"
    }
  done
  # 0 is best, 10 worst; offline gives the level times ten to --threshold.
  systemd-analyze security --offline=true --no-pager --threshold=20 "$root/deploy/systemd/creepd.service" \
    >"$work/output" 2>&1 || {
    tail -n 1 "$work/output" >&2
    fail "the unit is exposed more than 2.0"
  }
  tail -n 1 "$work/output"
fi

command -v dpkg-shlibdeps >/dev/null && command -v file >/dev/null || skip "the package: no dpkg-shlibdeps or file"
# An installation only, never a build: that is not for a test to begin.
cpack --config "$build/CPackConfig.cmake" -G DEB -B "$work/package" -D CPACK_CMAKE_GENERATOR="Unix Makefiles" \
  -D CPACK_INSTALL_CMAKE_PROJECTS= -D CPACK_INSTALLED_DIRECTORIES="$work/tree;/" >"$work/output" 2>&1 || {
  cat "$work/output" >&2
  fail "cpack"
}
package=$(find "$work/package" -maxdepth 1 -name 'creepd_*.deb')
dpkg-deb -f "$package" Depends >"$work/output"
expect_output libgrpc++
expect_output libsqlite3
dpkg-deb -c "$package" >"$work/output"
expect_output " ./usr/bin/creepd"
expect_output " ./usr/lib/systemd/system/creepd.service"
