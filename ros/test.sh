#!/bin/sh
# Runs the nodes against a master of its own, with a client as a laboratory writes it: ros/test.sh BUILD
set -eu
here=$(cd "$(dirname "$0")/.." && pwd)
build=$(cd "$1" && pwd)
nodes=$build/ros/devel/lib/veridyn_ros
if [ ! -x "$nodes/veridyn_controller" ] || ! /usr/bin/python3 -c "import rospy, rosbag" 2>/dev/null; then
  echo "ros-test: skipped, there is no ROS 1 here, or \`make ros\` was not run"
  exit 77
fi
PYTHONPATH=$build/ros/devel/lib/python3/dist-packages VERIDYN_ROBOTS=$here/data/robots \
  exec /usr/bin/python3 "$here/tests/ros/laboratory.py" "$nodes" "$build/bin/veridyn"
