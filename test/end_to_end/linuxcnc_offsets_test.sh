#!/usr/bin/env bash
# The HAL component linuxcnc_offsets without LinuxCNC: files that it refuses, its answer at a position, and what it gives to a motion that
# adds up counts as LinuxCNC does.
exec python3 "$(dirname "${BASH_SOURCE[0]}")/linuxcnc_offsets.py"
