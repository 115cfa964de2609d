#!/bin/sh
# Runs the nodes against a master of its own, with a client as a laboratory writes it: packages/ros/test.sh BUILD
set -eu
here=$(cd "$(dirname "$0")/../.." && pwd)
build=$(cd "$1" && pwd)
nodes=$build/ros/devel/lib/veridyn_ros
skip() {
  echo "ros-test: skipped: $1"
  exit 77
}
/usr/bin/python3 -c "import rospy, rosbag" 2>/dev/null || skip "there is no ROS 1 here (rospy, rosbag); \`make ros\` installs it"
command -v rosmaster >/dev/null 2>&1 || skip "there is no rosmaster here; \`make ros\` installs it"
[ -x "$nodes/veridyn_controller" ] || skip "the nodes are not built; \`make ros\` builds them into $build/ros"
PYTHONPATH=$build/ros/devel/lib/python3/dist-packages VERIDYN_ROBOTS=$here/data/robots \
  exec /usr/bin/python3 "$here/packages/ros/tests/laboratory.py" "$nodes" "$build/bin/veridyn"
