#!/usr/bin/env bash
# The folders of src follow each other as docs/architecture.md says, and scripts/include_graph notices where they do not.
set -u
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

check() {  # check <name> <condition …>
  local name="$1"
  shift
  if "$@"; then echo "ok $name"; else echo "not ok $name"; fi
}

"$root/scripts/include_graph" >"$work/out" 2>"$work/err"
check 'no cycle, no ROS in the core' [ "$?" -eq 0 ]
cat "$work/err"
check 'every function of a header has a comment' grep -q '^functions in headers without a comment: 0$' "$work/out"

# refused <name> <file> <line to add> <words>
refused() {
  rm -rf "$work/copy"
  mkdir -p "$work/copy/scripts"
  cp "$root/scripts/include_graph" "$work/copy/scripts/"
  cp -r "$root/src" "$work/copy/src"
  echo "$3" >>"$work/copy/src/$2"
  local status=0
  "$work/copy/scripts/include_graph" >/dev/null 2>"$work/err" || status=$?
  check "$1: status 1" [ "$status" -eq 1 ]
  check "$1: says $4" grep -q "$4" "$work/err"
}
refused 'a cycle' base/error.h '#include "session/session.h"' 'cycle between folders: base, '
refused 'ROS in the core' model/model.cpp '#include <ros/ros.h>' 'src/model/model.cpp:[0-9]*: includes ROS'
refused 'a message in the core' session/session.cpp '#include "sensor_msgs/JointState.h"' 'includes ROS'
refused 'compensation beside estimation' compensation/limits.h '#include "estimation/folds.h"' 'compensation must not include estimation'
refused 'simulation beside effects' simulation/chain.h '#include "effects/effect.h"' 'simulation must not include effects'
refused 'drivers beside the simulator' drivers/motion_control.h '#include "simulation/simulate.h"' 'drivers must not include simulation'
refused 'verification beside diagnosis' verification/verify.cpp '#include "diagnosis/diagnose.h"' 'verification must not include diagnosis'
