#!/usr/bin/env bash
# `rosrun measuring_machine mm`, as README says it: after the README's own build, and in a catkin workspace.
set -u
source "$(dirname "${BASH_SOURCE[0]}")/told.sh"
mm="$(realpath "${MM:?path of mm}")"
source_folder="$(pwd)"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
export PATH="/usr/bin:$PATH" ROS_HOME="$work/ros_home"
unset ROS_PACKAGE_PATH CMAKE_PREFIX_PATH

version="mm $(sed -n 's|.*<version>\(.*\)</version>.*|\1|p' package.xml)"
# The package as it lies after the README's build: `build` is where that leaves it, whatever folder this test runs in.
package="$work/measuring_machine"
mkdir -p "$package/build/devel/lib/measuring_machine"
cp -r package.xml CMakeLists.txt urdf scripts "$package/"
touch "$package/build/CATKIN_IGNORE"
ln -s "$mm" "$package/build/devel/lib/measuring_machine/mm"
in_package() { (cd "$work" && ROS_PACKAGE_PATH="$package" rosrun measuring_machine mm "$@"); }
check 'rosrun finds mm' [ "$(in_package --version)" = "$version" ]
in_package check nowhere.bag 2>"$work/error"
check 'its exit status is kept' [ $? -eq 2 ]
check 'its words are kept' grep -q 'nowhere.bag' "$work/error"
check 'what stands between quotes stays one word' grep -q "'a b' is not an effect" <(in_package effects 'a b' 2>&1)

# README's line: the devel space's setup.bash says where the package is.
devel="$(cd "$(dirname "$mm")/../.." && pwd)"
sourced() { (set +u; cd "$work"; source "$devel/setup.bash"; rosrun measuring_machine mm "$@"); }
if [[ "$devel" == "$source_folder/build/devel" ]]; then
  check 'after sourcing build/devel/setup.bash' [ "$(sourced --version)" = "$version" ]
fi

rm "$package/build/devel/lib/measuring_machine/mm"
in_package --version 2>"$work/error"
check 'not built: status 2' [ $? -eq 2 ]
check 'not built: what to do' grep -q 'cmake --build' "$work/error"
