#pragma once

#include <crtk_msgs/OperatingState.h>
#include <crtk_msgs/StringStamped.h>
#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/Twist.h>
#include <geometry_msgs/TwistStamped.h>
#include <geometry_msgs/Wrench.h>
#include <geometry_msgs/WrenchStamped.h>
#include <ros/ros.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/Empty.h>
#include <std_msgs/String.h>

#include "core/crtk_arm.hpp"
#include "core/lock_free.hpp"

namespace veridyn_ros {

/// The topics of one arm, in the network's thread. They exchange a queue of commands and a snapshot of
/// feedback with the loop, and never wait for it.
class ArmTopics {
 public:
  using Commands = Queue<Command, 64>;

  /// @param space  a handle in the arm's namespace, as /PSM1.
  ArmTopics(ros::NodeHandle space, const veridyn::Model& arm, Commands& to_loop,
            Snapshot<Feedback>& from_loop);

  /// Publishes the feedback since the last call, if any; call it at the publishing rate.
  void publish();

 private:
  template <typename Message>
  using Event = ros::MessageEvent<Message const>;
  /// These convert a message to a Command for the loop, without a change of units or axes.
  void joints(const Event<sensor_msgs::JointState>& event, Command::Kind kind);
  void pose(const Event<geometry_msgs::PoseStamped>& event, Command::Kind kind);
  void wrench(const geometry_msgs::Wrench& w, Command c);
  void twist(const geometry_msgs::Twist& t, Command c);
  void state_command(const Event<crtk_msgs::StringStamped>& event);
  void push(const Command& c);  ///< dropped with a warning if the queue is full
  template <typename Message>
  ros::Publisher advertise(const std::string& name, bool latched = false) {
    return space_.advertise<Message>(name, 10, latched);
  }
  template <typename Message, typename Take>
  void subscribe(const std::string& name, Take take) {
    subscribers_.push_back(space_.subscribe<Message>(
        name, 10, boost::function<void(const Event<Message>&)>(take), ros::VoidConstPtr(),
        ros::TransportHints().tcpNoDelay()));
  }
  void warn(const std::string& text);  ///< on the topic `warning` and in the log

  ros::NodeHandle space_;
  std::string base_;
  std::vector<std::string> names_;
  std::vector<int> order_;
  Commands& to_loop_;
  Snapshot<Feedback>& from_loop_;
  Feedback now_;
  ros::Time stamp();
  double clock_ahead_ = 0.0;  // [s] ROS' clock minus the loop's clock
  OperatingState told_state_ = OperatingState::kDisabled;
  bool told_ = false, told_homed_ = false, told_busy_ = false;
  std::uint64_t told_refusals_ = 0, told_lost_ = 0;
  std::vector<ros::Subscriber> subscribers_;
  ros::Publisher measured_js_, setpoint_js_, measured_cp_, setpoint_cp_, measured_cv_, measured_cf_,
      operating_state_, error_, warning_;
};

}  // namespace veridyn_ros
