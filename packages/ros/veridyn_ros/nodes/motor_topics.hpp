#pragma once

#include <sensor_msgs/JointState.h>

#include <string>

#include "core/lock_free.hpp"
#include "nodes/motor_link.hpp"

namespace veridyn_ros {

/// Passes the efforts of NAME/io/servo_jf to the loop; a message with another number of efforts than the arm
/// has joints, or with a value that is not finite, is dropped with a warning.
void receive_torques(const std::string& arm, int joints, const sensor_msgs::JointState& message,
                  Snapshot<MotorTorque>& to_loop);

}  // namespace veridyn_ros
