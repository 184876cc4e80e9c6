#!/usr/bin/env bash
# Hostile clients against the workbench, a second of each kind (MM_LONG_TESTS=1: ten).
set -u
export MM="$(realpath "${MM:?path of mm}")"
exec python3 test/end_to_end/workbench_load.py
