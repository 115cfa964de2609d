#include "nodes/motor_topics.hpp"

#include <ros/ros.h>

#include <cmath>

namespace veridyn_ros {

void receive_torques(const std::string& arm, int joints, const sensor_msgs::JointState& message,
                  Snapshot<MotorTorque>& to_loop) {
  if (message.effort.size() != static_cast<std::size_t>(joints)) {
    ROS_WARN_THROTTLE(1.0, "%s/io/servo_jf: found %zu efforts, expected %d", arm.c_str(),
                      message.effort.size(), joints);
    return;
  }
  MotorTorque t;
  for (std::size_t i = 0; i < message.effort.size(); ++i) {
    if (!std::isfinite(message.effort[i])) {
      ROS_WARN_THROTTLE(1.0, "%s/io/servo_jf: found an effort that is not finite", arm.c_str());
      return;
    }
    t.tau[i] = message.effort[i];
  }
  t.stamp = steady_now();
  t.said = message.header.stamp.toSec();
  to_loop.write(t);
}

}  // namespace veridyn_ros
