#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "veridyn/model/suggestion.hpp"
#include "dvrk/config/io_config.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

constexpr double kMostBits = 65535.0;

// Assignment of motor channels to actuators.
class Channels {
 public:
  explicit Channels(const std::string& file) : file_(file) {}

  void claim_axis(int board, int axis, const std::string& who) {
    const auto [place, is_new] = owners_.try_emplace({board, axis}, who);
    require(is_new, file_, ": ", who, ": found board ", board, " axis ", axis, ", which ",
            place->second, " has already, expected every channel once.");
  }

 private:
  std::string file_;
  std::map<std::pair<int, int>, std::string> owners_;
};

// Section 12: the converter has 16 bits, on either side of the calibrated zero.
void require_current_within_converter(const LinearScale& amps_to_bits, double max_current,
                                      const std::string& file, const std::string& who) {
  if (!(max_current > 0.0) || amps_to_bits.scale == 0.0) return;
  const double room = std::min(amps_to_bits.offset, kMostBits - amps_to_bits.offset);
  const double possible = room / std::abs(amps_to_bits.scale);
  require(max_current <= possible, file, ": ", who, ": found MaxCurrent ", max_current,
          " A, expected at most ", possible, " A, the end of the converter.");
}

template <typename Items>
void require_unique_names(const Items& items, const std::string& what, const std::string& file) {
  std::set<std::string> names;
  for (const auto& item : items) {
    require(!item.name.empty(), file, ": found a ", what, " without a name, expected a name.");
    require(names.insert(item.name).second, file, ": found a second ", what, " '", item.name,
            "', expected unique names.");
  }
}

}  // namespace

void check_io_config(const IoConfig& config, const std::string& file) {
  require_unique_names(config.robots, "robot", file);
  require_unique_names(config.digital_inputs, "digital input", file);
  require_unique_names(config.digital_outputs, "digital output", file);
  require_unique_names(config.dallas_chips, "Dallas chip", file);
  Channels channels(file);
  std::map<int, std::string> hardware;
  for (const RobotConfig& robot : config.robots) {
    require(robot.io_only || robot.size() > 0, file, ": Robot ", robot.name,
            ": found no actuator, expected at least one.");
    for (int k = 0; k < robot.size(); ++k) {
      const ActuatorConfig& actuator = robot.actuators[k];
      const std::string who = text("Robot ", robot.name, "/Actuator ", k);
      channels.claim_axis(actuator.board, actuator.axis, who);
      require_current_within_converter(actuator.amps_to_bits, actuator.max_current, file, who);
      if (actuator.brake)
        channels.claim_axis(actuator.brake->board, actuator.brake->axis, who + "'s brake");
      if (actuator.brake)
        require_current_within_converter(actuator.brake->amps_to_bits, actuator.brake->max_current,
                                         file, who + "'s brake");
      const auto [known, is_new] = hardware.try_emplace(actuator.board, robot.hardware);
      require(is_new || known->second == robot.hardware, file, ": ", who, ": found board ",
              actuator.board, " as ", robot.hardware, ", expected ", known->second,
              " as for another robot.");
    }
  }
}

const RobotConfig& IoConfig::robot(const std::string& name) const {
  std::vector<std::string> names;
  for (const RobotConfig& robot : robots) {
    if (robot.name == name) return robot;
    names.push_back(robot.name);
  }
  if (name.empty() && robots.size() == 1) return robots.front();
  require(!robots.empty(), "found a configuration without robots, expected at least one.");
  throw InvalidInput(text("found ", name.empty() ? "no name" : "the robot '" + name + "'",
                          did_you_mean(name, names), ", expected one of: ", listed(names), "."));
}

}  // namespace veridyn::dvrk
