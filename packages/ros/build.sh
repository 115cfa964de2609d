#!/bin/sh
# Builds the ROS packages against the library that BUILD holds: packages/ros/build.sh BUILD [JOBS]
set -eu
here=$(cd "$(dirname "$0")" && pwd)
build=$(cd "$1" && pwd)
jobs=${2:-2}
if [ ! -f /usr/share/catkin/cmake/catkinConfig.cmake ] && [ -z "${ROS_DISTRO:-}" ]; then
  echo "ros: there is no ROS 1 here (roscpp, catkin); nothing is built" >&2
  exit 0
fi
work=$build/ros
cmake --install "$build" --prefix "$work/installed" >"$work.log" 2>&1 || { cat "$work.log"; exit 1; }
mkdir -p "$work/src"
for package in crtk_msgs veridyn_ros; do ln -sfn "$here/$package" "$work/src/$package"; done
ln -sfn /usr/share/catkin/cmake/toplevel.cmake "$work/src/CMakeLists.txt"
cmake -S "$work/src" -B "$work/build" -DCMAKE_BUILD_TYPE=Release "-DCATKIN_DEVEL_PREFIX=$work/devel" \
  "-DCMAKE_PREFIX_PATH=$work/installed;${CMAKE_PREFIX_PATH:-}" -DCATKIN_ENABLE_TESTING=OFF -DPYTHON_EXECUTABLE=/usr/bin/python3 -Wno-dev >"$work.log" 2>&1 \
  || { cat "$work.log"; exit 1; }
cmake --build "$work/build" -j "$jobs"
echo "ros: source $work/devel/setup.sh"
