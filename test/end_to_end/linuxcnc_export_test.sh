#!/usr/bin/env bash
# Exported tables in a headless LinuxCNC, run by an ordinary user: where its motors stand is, by the full model, where it was commanded.
set -u
mm="$(realpath "${MM:?path of mm}")"
if [ ! -x /usr/bin/linuxcnc ]; then
  echo "ok LinuxCNC is not installed here: skipped"
  exit 0
fi
exec 8>>/tmp/mm_linuxcnc.lock  # there can be one LinuxCNC on a computer
chmod 666 /tmp/mm_linuxcnc.lock 2>/dev/null
flock -w 600 8
MM="$mm" exec python3 test/end_to_end/linuxcnc_export_checks.py
