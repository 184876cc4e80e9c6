#!/usr/bin/env bash
# mm batch and mm fleet as they are typed: engines, kills, Ctrl-C, bad input. MACHINES, SESSIONS (of each) and KILLS set the size, STEPS what is done with each;
# PROOF=folder keeps what was made there, with the figures in figures.json.
exec python3 "$(dirname "${BASH_SOURCE[0]}")/batch.py"
