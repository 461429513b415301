#!/usr/bin/env bash
# The installed units under the real systemd: started means served, a killed and a hanging daemon come back, jobs go on,
# another user is let in or not, wrong options are not tried again; the daemon of one user too.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
((EUID == 0)) || skip "needs root"
[[ -x /lib/systemd/systemd ]] && command -v unshare nsenter >/dev/null || skip "needs systemd and unshare"
sed -i 's/minimum_cycles = 3000/minimum_cycles = 15000/' "$job"
undisturbed

DESTDIR=$work/tree cmake --install "$(dirname "$bin")" --prefix /usr >"$work/output" 2>&1 || fail "cmake --install"
mkdir -p "$work/machine"
"$here/boot_systemd.sh" "$work/machine" "$work/tree" >"$work/boot.log" 2>&1 &
boot=$!
first=
end_machine() {
  if (($? != 0)) && [[ -n "$first" ]]; then inside journalctl --no-pager --unit creepd --lines 30 >&2 || true; fi
  # The first process of a machine takes all others with it.
  kill -9 $first "$boot" 2>/dev/null || true
  wait "$boot" 2>/dev/null || true
  clean_up
}
trap end_machine EXIT

first_process() {
  first=$(pgrep --parent "$boot" -x systemd) || {
    kill -0 "$boot" 2>/dev/null || skip "no machine of namespaces here: $(tail -n 1 "$work/boot.log")"
    return 1
  }
}
inside() { nsenter -t "$first" -a -- "$@"; }
has_booted() { [[ $(inside systemctl is-system-running 2>/dev/null) =~ running|degraded ]]; }
wait_for 20 first_process
wait_for 60 has_booted

cp "$job" "$work/machine/root/tmp/job.toml"
printf 'CREEPD_OPTIONS="--slots 1 --threads-per-job 1 --checkpoint-interval 0.2 --least-free 0 --allow-user alice"\n' \
  >"$work/machine/root/etc/default/creepd"
creepctl() { inside env CREEPCTL_SERVER=/run/creepd/creepd.sock creepctl "$@"; }
property() { inside systemctl show -P "$1" creepd; }
restarts() { (($(property NRestarts) >= $1)) && [[ $(property ActiveState) == active ]]; }
computes() { creepctl show "$1" --json 2>/dev/null | grep -q '"latest_sample"'; }

printf '%3d s: started means served\n' "$SECONDS"
expect_exit 0 inside systemctl start creepd
[[ -S $work/machine/root/proc/1/root/run/creepd/creepd.sock ]] || inside test -S /run/creepd/creepd.sock ||
  fail "active without a socket"
id=$(creepctl submit /tmp/job.toml 2>/dev/null)
wait_for 30 computes "$id"

printf '%3d s: killed\n' "$SECONDS"
expect_exit 0 inside systemctl kill --signal KILL creepd
wait_for 60 restarts 1
wait_for 30 computes "$id"

printf '%3d s: hanging\n' "$SECONDS"
expect_exit 0 inside systemctl stop creepd
mkdir -p "$work/machine/root/etc/systemd/system/creepd.service.d"
printf '[Service]\nWatchdogSec=6s\n' >"$work/machine/root/etc/systemd/system/creepd.service.d/test.conf"
expect_exit 0 inside systemctl daemon-reload
expect_exit 0 inside systemctl start creepd
before=$(property NRestarts)
expect_exit 0 inside systemctl kill --kill-who main --signal STOP creepd
wait_for 60 restarts $((before + 1))
expect_exit 0 creepctl wait "$id" --timeout "300 s"
expect_exit 0 creepctl fetch "$id" --out /tmp/results
same_result "$work/machine/root/tmp/results"

printf '%3d s: users\n' "$SECONDS"
expect_exit 0 inside setpriv --reuid 1000 --regid 1000 --clear-groups \
  env HOME=/tmp CREEPCTL_SERVER=/run/creepd/creepd.sock creepctl ls
expect_exit 4 inside setpriv --reuid 1001 --regid 1001 --clear-groups \
  env HOME=/tmp CREEPCTL_SERVER=/run/creepd/creepd.sock creepctl show "$id"
expect_output "creepd --allow-user"
expect_exit 0 inside systemctl stop creepd
[[ $(property Result) == success ]] || fail "stopped with $(property Result)"

printf '%3d s: wrong options\n' "$SECONDS"
printf 'CREEPD_OPTIONS="--nonsense"\n' >"$work/machine/root/etc/default/creepd"
expect_exit 1 inside systemctl start creepd
[[ $(property ActiveState) == failed ]] || fail "wrong options are tried again"

printf '%3d s: the daemon of one user\n' "$SECONDS"
inside install -d -o alice -g alice -m 700 /run/alice /var/lib/alice
expect_exit 0 inside systemd-run --unit alice --property User=alice --property Delegate=yes \
  --setenv XDG_RUNTIME_DIR=/run/alice --setenv HOME=/var/lib/alice /lib/systemd/systemd --user
as_alice() {
  inside setpriv --reuid 1000 --regid 1000 --clear-groups env XDG_RUNTIME_DIR=/run/alice HOME=/var/lib/alice "$@"
}
user_manager() { [[ $(as_alice systemctl --user is-system-running 2>/dev/null) =~ running|degraded ]]; }
wait_for 30 user_manager
expect_exit 0 as_alice systemctl --user start creepd
expect_exit 0 as_alice creepctl doctor
expect_exit 0 as_alice systemctl --user stop creepd
