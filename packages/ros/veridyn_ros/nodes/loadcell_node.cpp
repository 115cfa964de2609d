// A load cell: ~source and ~calibration as `veridyn loadcell` has them; NAME/measured_cf along one axis, NAME/state in words.
// Invalid readings (none, stuck, out of range) have a stamp of zero, as in CRTK.

#include <geometry_msgs/WrenchStamped.h>
#include <std_msgs/String.h>

#include "nodes/motor_link.hpp"
#include "nodes/parameters.hpp"
#include "veridyn/control/load_cell.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn_ros {
namespace {

using namespace veridyn;

void run(ros::NodeHandle& own) {
  std::string source, calibration;
  require(own.getParam("source", source), own.resolveName("source"),
          ": found no source, expected serial:DEVICE or udp:PORT.");
  require(own.getParam("calibration", calibration), own.resolveName("calibration"),
          ": found no file, expected one of `veridyn loadcell calibrate`.");
  const std::string name = own.param("name", std::string("cell"));
  const std::string axis = own.param("axis", std::string("x"));
  require(axis == "x" || axis == "y" || axis == "z", own.resolveName("axis"), ": found '", axis, "', expected x, y or z.");
  ForceChannelOptions options;
  options.calibration = read_load_cell(calibration);
  options.cutoff = own.param("cutoff", 0.0);
  ForceChannel channel(open_force_source(source), options);
  ros::NodeHandle space(name);
  ros::Publisher force = space.advertise<geometry_msgs::WrenchStamped>("measured_cf", 10);
  ros::Publisher state = space.advertise<std_msgs::String>("state", 1, true);
  const double publish = 1.0 / own.param("publish_rate", 100.0);
  Cycle cycle(0.001);
  ForceState told = ForceState::kWaiting;
  for (double last = -1.0; ros::ok();) {
    cycle.wait();
    const ForceReading now = channel.update(steady_now());
    if (channel.state() != told || last < 0.0) {
      std_msgs::String words;
      words.data = describe(channel.state());
      state.publish(words);
      if (channel.state() != ForceState::kGood && last >= 0.0) ROS_WARN("%s: %s", name.c_str(), words.data.c_str());
      told = channel.state();
    }
    if (steady_now() - last < publish) continue;
    last = steady_now();
    geometry_msgs::WrenchStamped m;
    m.header.frame_id = name;
    if (channel.state() == ForceState::kGood) m.header.stamp = ros::Time::now();
    (axis == "x" ? m.wrench.force.x : axis == "y" ? m.wrench.force.y : m.wrench.force.z) = now.force;
    force.publish(m);
  }
}

}  // namespace
}  // namespace veridyn_ros

int main(int argc, char** argv) {
  return veridyn_ros::run_node(argc, argv, "veridyn_loadcell", veridyn_ros::run);
}
