#!/usr/bin/env bash
# The workbench on a disk that fails at the n-th read or write of an action.
set -u
export MM="$(realpath "${MM:?path of mm}")"
exec python3 test/end_to_end/workbench_disk.py
