#!/usr/bin/env bash
# The workbench in a headless browser.
set -u
export MM="$(realpath "${MM:?path of mm}")"
exec python3 test/end_to_end/workbench.py
