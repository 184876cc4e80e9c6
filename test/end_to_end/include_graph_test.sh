#!/usr/bin/env bash
# The folders of src follow each other as docs/architecture.md says, and scripts/include_graph notices where they do not.
set -u
source "$(dirname "${BASH_SOURCE[0]}")/told.sh"
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

"$root/scripts/include_graph" >"$work/out" 2>"$work/err"
check 'no cycle, no ROS in the core' [ "$?" -eq 0 ]
cat "$work/err"
check 'every function of a header has a comment' grep -q '^functions in headers without a comment: 0$' "$work/out"

mkdir "$work/scripts"
cp "$root/scripts/include_graph" "$work/scripts/"
cp -r "$root/src" "$work/src"
expected=()  # names and words, in turn

# wrong <name> <file> <line to add> <words>
wrong() {
  echo "$3" >>"$work/src/$2"
  expected+=("$1: says $4" "$4")
}
wrong 'a cycle' base/error.h '#include "session/session.h"' 'cycle between folders: base, '
wrong 'ROS in the core' model/model.cpp '#include <ros/ros.h>' 'src/model/model.cpp:[0-9]*: includes ROS'
wrong 'a message in the core' session/session.cpp '#include "sensor_msgs/JointState.h"' 'src/session/session.cpp:[0-9]*: includes ROS'
wrong 'compensation beside estimation' compensation/limits.h '#include "estimation/folds.h"' 'compensation must not include estimation'
wrong 'simulation beside effects' simulation/chain.h '#include "effects/effect.h"' 'simulation must not include effects'
wrong 'drivers beside the simulator' drivers/motion_control.h '#include "simulation/simulate.h"' 'drivers must not include simulation'
wrong 'verification beside diagnosis' verification/verify.cpp '#include "diagnosis/diagnose.h"' 'verification must not include diagnosis'
"$work/scripts/include_graph" >/dev/null 2>"$work/err"
check 'what is wrong: status 1' [ "$?" -eq 1 ]
for ((i = 0; i < ${#expected[@]}; i += 2)); do check "${expected[i]}" grep -q "${expected[i + 1]}" "$work/err"; done
