#!/usr/bin/env bash
# The documents as their readers use them: what they tell to type is typed, examples are read, ranges hold, links lead somewhere.
exec python3 "$(dirname "${BASH_SOURCE[0]}")/documents.py"
