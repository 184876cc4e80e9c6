#!/usr/bin/env bash
# needs the computer alone: LinuxCNC moves in real time on a kernel that keeps none
# Exported tables in a headless LinuxCNC, run by an ordinary user: where its motors stand is, by the full model, where it was commanded.
set -u
mm="$(realpath "${MM:?path of mm}")"
if [ ! -x /usr/bin/linuxcnc ]; then
  echo "ok LinuxCNC is not installed here: skipped"
  exit 0
fi
lock=/tmp/mm_linuxcnc.lock  # there can be one LinuxCNC on a computer, whoever starts it
[ -e "$lock" ] || (umask 0 && : >>"$lock")
exec 8<"$lock"  # to read is enough to lock, and is allowed where the file is another user's
if ! flock -w 600 8; then
  echo "not ok another LinuxCNC holds $lock"
  exit 1
fi
MM="$mm" exec python3 test/end_to_end/linuxcnc_export_checks.py
