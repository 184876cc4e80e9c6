#!/usr/bin/env bash
# Installs a Debian package of measuring_machine, uses it as its README says, removes it, and looks for what is left.
# Run by scripts/fresh_machine package, on a machine that has nothing of it: try_package.sh <package.deb>
set -euo pipefail
package="$1"
here="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
begun=$SECONDS
step() { printf '\n== %s (%d s)\n' "$*" $((SECONDS - begun)); }
fail() {
  echo "try_package: error: $*" >&2
  exit 1
}

step "apt install"
apt-get update -qq
DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$package" >/tmp/install.log 2>&1 || {
  tail -n 20 /tmp/install.log
  fail "apt install"
}
dpkg -s measuring-machine | grep -E '^(Version|Installed-Size|Depends):'

step "a session, its calibration, what is missing"
work="$(mktemp -d)"
cd "$work"
mm --version
mm simulate --machine three_axis --plan /usr/share/measuring_machine/config/plans/nine_ball_plate.yaml --hide backlash:x=4um --seed 11 -o plate.bag
printf 'machine: three_axis\neffects:\n  - {type: scale, axis: x}\n  - {type: scale, axis: y}\n  - {type: scale, axis: z}\n' >model.yaml
mm calibrate plate.bag --model model.yaml -o plate.yaml | tail -n 3
mm diagnose plate.bag --calibration plate.yaml | tee diagnosis.txt | head -n 12
grep -q 'backlash of x\|backlash x\|type: backlash, axis: x' diagnosis.txt || fail "the hidden backlash of x is not named"
if [[ -f /usr/share/measuring_machine/web/plotly.min.js ]]; then
  mm report plate.bag --calibration plate.yaml -o page.html
  [[ -s page.html ]] || fail "no page"
else
  echo "no page: the package was built without Plotly"
fi

step "the demo, nothing built"
apt-get install -y -qq --no-install-recommends git >/tmp/git.log 2>&1 || fail "apt-get install git: $(tail -n 1 /tmp/git.log)"
git config --global --add safe.directory "$here"
shown=$SECONDS
(cd "$here" && scripts/demo 7) >demo.txt || { tail -n 20 demo.txt; fail "scripts/demo"; }
grep -q '^demo: uses the installed package of this commit' demo.txt || fail "scripts/demo did not use the package"
echo "first picture after $((SECONDS - shown)) s"
tail -n 2 demo.txt

step "what an installed program has"
[[ -e /usr/share/man/man1/mm-diagnose.1 || -e /usr/share/man/man1/mm-diagnose.1.gz ]] || fail "no manual page"
[[ -e /usr/share/bash-completion/completions/mm ]] || fail "no completion"
for program in axis_driver probe measure calibration_server compensation mm; do
  [[ -x /usr/lib/measuring_machine/$program ]] || fail "/usr/lib/measuring_machine/$program is not there"
  ! ldd "/usr/lib/measuring_machine/$program" | grep 'not found' || fail "$program: a library is missing"
done
for library in /usr/lib/*/ros/libmeasuring_machine_{controllers,simulated_controller}.so; do
  [[ -f $library ]] || fail "$library is not there"
  ! ldd "$library" | grep 'not found' || fail "$library: a library is missing"
done
[[ -f /usr/share/measuring_machine/package.xml && -d /usr/share/measuring_machine/launch ]] || fail "ROS cannot find the package"

step "the nodes: roslaunch, and a service"
DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends rosbash python3-roslaunch python3-rosservice python3-rosnode python3-std-srvs \
  ros-robot-state-publisher >/tmp/nodes.log 2>&1 || fail "apt-get install: $(tail -n 1 /tmp/nodes.log)"
rosrun measuring_machine mm --version
roslaunch measuring_machine instrument.launch >launch.log 2>&1 &
launch=$!
until rosservice list 2>/dev/null | grep -q '/axis_driver/home'; do
  kill -0 "$launch" 2>/dev/null || { cat launch.log; fail "roslaunch ended"; }
  ((SECONDS - begun < 180)) || { grep -a -m 3 "FATAL\|ERROR" launch.log; fail "no /axis_driver/home after 180 s"; }
  sleep 0.5
done
rosservice call /axis_driver/home | tee home.txt
grep -q 'success: True' home.txt || { tail -n 20 launch.log; fail "home"; }
kill -INT "$launch"
wait "$launch" || true

step "apt purge"
DEBIAN_FRONTEND=noninteractive apt-get purge -y -qq measuring-machine >/tmp/purge.log 2>&1 || fail "apt purge: $(tail -n 1 /tmp/purge.log)"
left="$(find /usr /etc /var/lib -xdev -path "$here" -prune -o -iname '*measuring*machine*' -print | grep -v '/dpkg/\|/apt/' || true)"
[[ -z "$left" ]] || fail "left behind: $left"
hash -r
! command -v mm >/dev/null || fail "mm is still there"
echo "try_package: installed, used and removed in $((SECONDS - begun)) s"
