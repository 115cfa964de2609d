#pragma once

#include <map>
#include <string>
#include <vector>

namespace veridyn {

/// A joint that is looked for in a recording.
struct WantedJoint {
  std::string name;
  bool prismatic = false;
};

/// What of a recording is the arm, where the file holds more or names things in its own way.
struct SignalChoice {
  /// Topics to take joints from; empty: the one that holds them.
  std::vector<std::string> topics;
  /// Where a signal is found, by signal and joint (`tau1` = `/arm/effort/0`), for all joints (`tau`
  /// = `/arm/effort`), for the time (`t` = `stamp`), or under which name a joint is recorded
  /// (`yaw` = `outer_yaw`). A source may be a signal of another joint (`tau1` = `tau2`).
  std::map<std::string, std::string> map;
  /// Units by signal (`q`, `tau`, `t`) or signal and joint (`q3`), where they are not SI: deg, mm,
  /// ms, us, ns, mNm, Ncm, mA, rpm, deg/s, mm/s; a - in front turns the sign; `tau` = `A` says that
  /// efforts are motor currents.
  std::map<std::string, std::string> units;
  /// Joints in the order of the columns; empty: those of the file, in its order.
  std::vector<WantedJoint> joints;
};

}  // namespace veridyn
