// veridyn::Watch on an arm's measured_js: events as lines of JSON on NAME/watch/event; the statistic over its
// threshold on NAME/watch/strength (above 1: an alarm).

#include <sensor_msgs/JointState.h>
#include <std_msgs/Float64.h>
#include <std_msgs/String.h>

#include <algorithm>
#include <deque>

#include "nodes/parameters.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/report/watch_json.hpp"

namespace veridyn_ros {
namespace {

using namespace veridyn;

struct Arm {
  Arm(const ArmParameters& p, const WatchOptions& options, ros::NodeHandle space)
      : name(p.name), model(p.model), watch(p.model, options) {
    event = space.advertise<std_msgs::String>("watch/event", 100, true);
    strength = space.advertise<std_msgs::Float64>("watch/strength", 10);
    watch.on_step([this](const WatchState& state) {
      std_msgs::Float64 m;
      m.data = state.learning ? 0.0 : state.strength;
      strength.publish(m);
    });
    measured = space.subscribe<sensor_msgs::JointState>(
        "measured_js", 1000, [this](const sensor_msgs::JointState::ConstPtr& m) { receive(*m); },
        ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
  }

  // Adds a message to the watch and publishes its events. In CRTK a stamp of zero marks invalid data.
  void receive(const sensor_msgs::JointState& m) {
    const auto n = static_cast<std::size_t>(model.joints());
    if (m.header.stamp.isZero()) return;
    if (m.position.size() != n || m.effort.size() != n) {
      ROS_WARN_THROTTLE(5.0, "%s/measured_js: found %zu positions and %zu efforts, expected %zu of each",
                        name.c_str(), m.position.size(), m.effort.size(), n);
      return;
    }
    if (first.isZero()) first = m.header.stamp;
    Recording row;
    row.source = name + "/measured_js";
    row.time = VectorXd::Constant(1, (m.header.stamp - first).toSec());
    row.q = Eigen::Map<const Eigen::RowVectorXd>(m.position.data(), model.joints());
    if (m.velocity.size() == n) row.dq = Eigen::Map<const Eigen::RowVectorXd>(m.velocity.data(), model.joints());
    row.tau = Eigen::Map<const Eigen::RowVectorXd>(m.effort.data(), model.joints());
    for (const WatchEvent& e : watch.add(row)) {
      std_msgs::String line;
      line.data = json_line(e, row.source);
      event.publish(line);
      ROS_WARN("%s: %s", name.c_str(), e.sentence.c_str());
    }
  }

  std::string name;
  Model model;
  Watch watch;
  ros::Publisher event, strength;
  ros::Subscriber measured;
  ros::Time first;
};

void run(ros::NodeHandle& own) {
  WatchOptions options;
  options.learn = own.param("learn", options.learn);
  options.learn_more = std::max(options.learn, options.learn_more);
  options.false_alarms = own.param("false_alarms", options.false_alarms);
  std::deque<Arm> arms;
  ros::NodeHandle root;
  for (const ArmParameters& p : read_arms(own)) arms.emplace_back(p, options, ros::NodeHandle(root, p.name));
  ros::spin();
}

}  // namespace
}  // namespace veridyn_ros

int main(int argc, char** argv) {
  return veridyn_ros::run_node(argc, argv, "veridyn_watch", veridyn_ros::run);
}
