#!/usr/bin/env bash
# examples/own_controller as its reader builds it, against this package's devel space; and moved through the axis driver.
# thorough only: a package is built; test_drivers and motion.test ask the same of the interface
set -u
mm="$(realpath "${MM:?path of mm}")"
devel="$(cd "$(dirname "$mm")/../.." && pwd)"
source_folder="$(pwd)"
work="$(mktemp -d)"
master=
driver=
trap 'kill $driver $master 2>/dev/null; wait 2>/dev/null; rm -rf "$work"' EXIT
export PATH="/usr/bin:$PATH" ROS_HOME="$work/ros_home"

check() {  # check <name> <condition …>
  local name="$1"
  shift
  if "$@"; then echo "ok $name"; else echo "not ok $name"; fi
}
(set +u; source "$devel/setup.bash"; cmake -S examples/own_controller -B "$work/own" -DCMAKE_CXX_FLAGS="-Wall -Wextra -Werror" &&
  cmake --build "$work/own") >"$work/build.log" 2>&1
check 'the example builds, without a warning' [ $? -eq 0 ]
set +u
source "$work/own/devel/setup.bash"
port="$(python3 -c 'import socket; s = socket.socket(); s.bind(("", 0)); print(s.getsockname()[1])')"
export ROS_MASTER_URI="http://localhost:$port"
roscore -p "$port" >"$work/master.log" 2>&1 &
master=$!
until rosparam list >/dev/null 2>&1; do sleep 0.2; done
rosparam set -t "$source_folder/urdf/three_axis.urdf" robot_description
"$devel/lib/measuring_machine/axis_driver" _hardware:=own_controller/glass_scales >"$work/driver.log" 2>&1 &
driver=$!
until rosservice list 2>/dev/null | grep -q /axis_driver/home || ! kill -0 $driver 2>/dev/null; do sleep 0.2; done
check 'the axis driver finds it' kill -0 $driver
check 'it homes' grep -q 'success: True' <(rosservice call /axis_driver/home)
cat >"$work/move.py" <<'END'
import actionlib, rospy
from measuring_machine.msg import MoveAction, MoveGoal
rospy.init_node("move")
axes = actionlib.SimpleActionClient("axis_driver/move", MoveAction)
axes.wait_for_server()
axes.send_goal(MoveGoal(name=["x", "z"], position=[0.003, -0.002]))
axes.wait_for_result()
print(axes.get_result().outcome, axes.get_result().message)
END
check 'it goes where it is told' [ "$(python3 "$work/move.py")" = '1 ' ]
rostopic echo -n 1 /joint_states >"$work/state" 2>/dev/null
check 'and says so' grep -q 'position: \[0.003, 0.0, -0.002\]' "$work/state"
check 'unknown parameters are named' grep -q "'seed'.*not known to glass_scales" <(timeout 20 "$devel/lib/measuring_machine/axis_driver" __name:=other _hardware:=own_controller/glass_scales _controller/seed:=1 2>&1)
