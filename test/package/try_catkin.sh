#!/usr/bin/env bash
# The repository in an ordinary catkin workspace, with what rosdep installs for its package.xml and nothing else: catkin_make, then
# catkin_make run_tests. Run by scripts/fresh_machine catkin, on a machine that has nothing of it.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
export DEBIAN_FRONTEND=noninteractive HOME="${HOME:-/root}"
begun=$SECONDS
step() { printf '\n== %s (%d s)\n' "$*" $((SECONDS - begun)); }
install() {
  apt-get install -y -qq --no-install-recommends "$@" >/tmp/install.log 2>&1 || { tail -n 20 /tmp/install.log; exit 1; }
}

step "a computer with ROS: catkin, rosdep, a compiler"
apt-get update -qq
install build-essential catkin python3-rosdep2
if [[ -n "${CCACHE_DIR:-}" ]]; then install ccache; fi  # only to save time
index="$(mktemp)"
printf '%%YAML 1.1\n---\ndistributions: {}\ntype: index\nversion: 4\n' >"$index"
export ROSDISTRO_INDEX_URL="file://$index"
printf 'yaml file:///usr/share/python3-rosdep2/debian.yaml debian\nyaml file://%s\n' "$here/test/package/rosdep.yaml" >/etc/ros/rosdep/sources.list.d/10-debian.list
rm -f /etc/ros/rosdep/sources.list.d/20-default.list
rosdep update

step "rosdep install --from-paths src -y"
workspace="$HOME/workspace"
mkdir -p "$workspace/src"
cp -r "$here" "$workspace/src/measuring_machine"
cd "$workspace"
rosdep install --from-paths src --simulate --reinstall | tee /tmp/rosdep.txt | tail -n 60
sed -n 's/.*apt-get install -y //p' /tmp/rosdep.txt | tr ' ' '\n' | sort -u >/tmp/keys.txt
rosdep install --from-paths src -y >/tmp/rosdep.log 2>&1 || { tail -n 20 /tmp/rosdep.log; exit 1; }

step "catkin_make"
catkin_make 2>&1 | tail -n 15

step "catkin_make run_tests"
set +u
source devel/setup.bash
set -u
catkin_make run_tests -j1 >/tmp/run_tests.log 2>&1 || true
tail -n 30 /tmp/run_tests.log

step "catkin_test_results"
python3 - build/test_results <<'PYTHON'
import pathlib, sys, xml.etree.ElementTree as xml
for file in sorted(pathlib.Path(sys.argv[1]).rglob("*.xml")):
    for case in xml.parse(file).iter("testcase"):
        for wrong in [*case.iter("failure"), *case.iter("error")]:
            print("%s.%s: %s" % (case.get("classname"), case.get("name"), (wrong.text or wrong.get("message") or "")[-1500:]))
PYTHON
catkin_test_results build
