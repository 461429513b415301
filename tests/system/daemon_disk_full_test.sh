#!/usr/bin/env bash
# A full disk under creepd: the pause is stored and told, the daemon starts, old jobs can be deleted, and what was paused
# goes on by itself once there is room. The reserve is what makes this possible (server/host/reserve.h).
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
source "$(dirname "${BASH_SOURCE[0]}")/daemon_support.sh"
sed -i 's/minimum_cycles = 3000/minimum_cycles = 15000/' "$job"
mkdir "$work/disk"
mount -t tmpfs -o size=16m tmpfs "$work/disk" 2>/dev/null || skip "needs the right to mount a small tmpfs"
mounted=$work/disk
state=$work/disk/state
undisturbed
reserve_is() { [[ $(stat -c %s "$state/reserve") == "$1" ]]; }

step "full"
start_daemon --checkpoint-interval 0.2
reserve_is 4194304 || fail "no reserve is made"
old=$(submit)
expect_exit 0 creepctl cancel "$old" --now
id=$(submit)
wait_for 30 has_checkpoint "$(folder_of "$id")"
dd if=/dev/zero of="$work/disk/ballast" bs=4k 2>/dev/null || true
wait_for 60 is "$id" PAUSED
has_reason "$id" DISK_FULL || fail "reason $(field "$id" state_reason)"
reserve_is 0 || fail "the reserve is kept although the disk is full"

step "starts on the full disk, and nothing uses up what is left"
waiting=$(submit || true)
kill_daemon
start_daemon --checkpoint-interval 0.2
is "$id" PAUSED || fail "$id is $(field "$id" state)"
[[ -z "$waiting" ]] || is "$waiting" QUEUED || fail "a job was started into the reserve"

step "deletes"
expect_exit 0 creepctl delete "$old"
[[ ! -e $(folder_of "$old") ]] || fail "its files are still there"

step "goes on by itself"
rm "$work/disk/ballast"
succeeded "$id"
[[ -z "$waiting" ]] || succeeded "$waiting"
wait_for 30 reserve_is 4194304
stop_daemon
