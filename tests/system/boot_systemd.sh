#!/usr/bin/env bash
# Starts systemd as the first process of a machine made of namespaces: /usr of this machine with an installed tree laid
# over it, everything else empty. Needs root. Ends with the machine.
#
#   boot_systemd.sh FOLDER TREE    FOLDER/root becomes its root; TREE/usr is what was installed
set -euo pipefail
folder=$1 tree=$2 root=$1/root

mkdir -p "$root"/{usr,etc/systemd/system,etc/default,var/lib,run,tmp,proc,sys,dev,root,old}
for name in bin sbin lib lib64; do ln -s "usr/$name" "$root/$name"; done
cp /etc/ld.so.cache "$root/etc/"
printf 'root:x:0:0::/root:/bin/sh\nalice:x:1000:1000::/tmp:/bin/sh\nbob:x:1001:1001::/tmp:/bin/sh\n' >"$root/etc/passwd"
printf 'root:x:0:\nalice:x:1000:\nbob:x:1001:\n' >"$root/etc/group"
printf 'passwd: files systemd\ngroup: files systemd\n' >"$root/etc/nsswitch.conf"
printf '%032x\n' 1 >"$root/etc/machine-id"
# The machine below is not to be set up from in here, and nobody logs in.
for unit in systemd-sysctl systemd-modules-load systemd-udevd systemd-udev-trigger systemd-remount-fs \
  systemd-random-seed systemd-sysusers systemd-binfmt systemd-logind systemd-networkd systemd-resolved \
  systemd-timesyncd dbus; do
  ln -s /dev/null "$root/etc/systemd/system/$unit.service"
done
for unit in dev-hugepages.mount sys-kernel-debug.mount sys-kernel-tracing.mount sys-fs-fuse-connections.mount \
  proc-sys-fs-binfmt_misc.automount dbus.socket; do
  ln -s /dev/null "$root/etc/systemd/system/$unit"
done

exec unshare --pid --fork --kill-child --mount --uts --ipc --net --cgroup --propagation private \
  bash -euc '
    root=$1 tree=$2
    mount --bind "$root" "$root"
    mount -t overlay -o "ro,lowerdir=$tree/usr:/usr" overlay "$root/usr"
    mount -t proc proc "$root/proc"
    mount --bind "$root/proc/sys" "$root/proc/sys"
    mount -o remount,bind,ro "$root/proc/sys"
    mount -t sysfs -o ro sysfs "$root/sys"
    mount -t cgroup2 cgroup2 "$root/sys/fs/cgroup"
    mount -t tmpfs -o mode=755 tmpfs "$root/run"
    mount -t tmpfs -o mode=755 tmpfs "$root/dev"
    mkdir "$root"/dev/{shm,pts,mqueue}
    for node in null,1,3 zero,1,5 full,1,7 random,1,8 urandom,1,9 tty,5,0; do
      IFS=, read -r name major minor <<<"$node"
      mknod -m 666 "$root/dev/$name" c "$major" "$minor"
    done
    mount -t devpts -o newinstance,ptmxmode=666 devpts "$root/dev/pts"
    ln -s pts/ptmx "$root/dev/ptmx"
    ln -s /proc/self/fd "$root/dev/fd"
    cd "$root"
    pivot_root . old
    umount -l /old
    exec env -i container=creep-test PATH=/usr/bin:/usr/sbin /lib/systemd/systemd systemd.unit=basic.target </dev/null
  ' _ "$root" "$tree"
