#pragma once

#include <limits>
#include <map>
#include <string>
#include <vector>

namespace veridyn {

/// A joint to be found in a recording.
struct WantedJoint {
  std::string name;
  bool prismatic = false;
  double lower = -std::numeric_limits<double>::infinity();  ///< [rad] or [m] limits of its position
  double upper = std::numeric_limits<double>::infinity();
  double effort = std::numeric_limits<double>::infinity();  ///< [N m] or [N] limit of its torque
};

/// A joint of the robot that with_fixed() holds; a recording may contain it nevertheless.
struct HeldJoint {
  int number = 0;  ///< number among all joints of the robot, from 1
  WantedJoint joint;
  double position = 0.0;  ///< [rad] or [m]
};

/// Selection of the arm's signals in a recording with more signals, or with other names.
struct SignalChoice {
  /// Topics from which joints are taken; empty: the topic that contains them.
  std::vector<std::string> topics;
  /// Source of a signal, by signal and joint (`tau1` = `/arm/effort/0`), for all joints (`tau` =
  /// `/arm/effort`) or for the time (`t` = `stamp`), or the recorded name of a joint (`yaw` =
  /// `outer_yaw`). A source may be a signal of another joint (`tau1` = `tau2`).
  std::map<std::string, std::string> map;
  /// Units by signal (`q`, `tau`, `t`) or signal and joint (`q3`), where they are not SI: deg, mm,
  /// ms, us, ns, mNm, Ncm, mA, rpm, deg/s, mm/s; a leading - reverses the sign; `tau` = `A`
  /// declares efforts to be motor currents.
  std::map<std::string, std::string> units;
  /// Joints in the order of the columns; empty: those of the file, in its order.
  std::vector<WantedJoint> joints;
  /// Joints that are held, by number; if a recording contains them, they are ignored.
  std::vector<HeldJoint> held = {};
  /// True: rows that are clearly wrong are kept (dropouts, wrapped angles, bursts).
  bool as_recorded = false;
};

}  // namespace veridyn
