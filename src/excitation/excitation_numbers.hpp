#pragma once

#include <cstddef>

namespace veridyn {

/// All numbers that decide whether the limits of a robot file are taken for radians.
struct ExcitationNumbers {
  /// |end of a revolute joint's range| > most_turned [rad], two turns: perhaps degrees; a master's roll has
  /// 8.3, a UR10e 6.3.
  double most_turned = 12.566370614359172;
  /// speed limit of a revolute joint > fastest [rad/s]: perhaps degrees per second; a SCARA's wrist has 10
  /// rad/s, and 20 deg/s would be slow.
  double fastest = 20.0;
  /// |end of the range| > most_turned and <= most_degrees (two turns in degrees) for all revolute joints, at
  /// least fewest_joints of them: degrees.
  double most_degrees = 720.0;
  std::size_t fewest_joints = 2;
};

}  // namespace veridyn
