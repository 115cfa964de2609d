// One simulated arm under CrtkArm for ROS 2, with the names and rules of the ROS 1 node (docs/ros.md).
//
// UNTESTED: Debian has no rclcpp, so nobody has ever compiled this file.

#include <atomic>
#include <chrono>
#include <cmath>
#include <crtk_msgs/msg/operating_state.hpp>
#include <crtk_msgs/msg/string_stamped.hpp>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <map>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <std_msgs/msg/empty.hpp>
#include <std_msgs/msg/string.hpp>
#include <thread>

#include "core/crtk_arm.hpp"
#include "core/lock_free.hpp"
#include "veridyn/model/model_file.hpp"
#include "veridyn/simulation/engine.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn_ros {
namespace {

using sensor_msgs::msg::JointState;
using Kind = Command::Kind;

veridyn::Model model_of(const std::string& name) {
  const veridyn::Model model = veridyn::read_model(name);
  return veridyn::plausible_model(model, 1).arm;
}

class Controller : public rclcpp::Node {
 public:
  Controller()
      : Node("veridyn_controller"),
        name_(declare_parameter("arm", "PSM1")),
        model_(model_of(declare_parameter("model", "psm-3dof"))),
        arm_(model_),
        plant_(veridyn::make_engine("veridyn", model_)),
        sensors_(model_),
        rate_(declare_parameter("rate", 1000.0)) {
    q_ = dq_ = veridyn::VectorXd::Zero(model_.joints());
    for (int i = 0; i < model_.joints(); ++i) {
      const veridyn::Limits& l = model_.coordinates()[static_cast<std::size_t>(i)].limits;
      const double middle = 0.5 * (l.lower + l.upper);
      if (std::isfinite(middle)) q_[i] = middle;
    }
    plant_->set_state(q_, dq_);
    sensors_.show_positions(q_);
    measured_js_ = create_publisher<JointState>(name_ + "/measured_js", 10);
    measured_cp_ = create_publisher<geometry_msgs::msg::PoseStamped>(name_ + "/measured_cp", 10);
    operating_state_ = create_publisher<crtk_msgs::msg::OperatingState>(name_ + "/operating_state",
                                                                        rclcpp::QoS(1).transient_local());
    warning_ = create_publisher<std_msgs::msg::String>(name_ + "/warning", 10);
    hear_joints("servo_jp", Kind::kServoJp);
    hear_joints("servo_jf", Kind::kServoJf);
    hear_joints("move_jp", Kind::kMoveJp);
    subscriptions_.push_back(create_subscription<std_msgs::msg::Empty>(
        name_ + "/hold", 10, [this](std_msgs::msg::Empty::ConstSharedPtr) { ask(Kind::kHold); }));
    subscriptions_.push_back(create_subscription<crtk_msgs::msg::StringStamped>(
        name_ + "/state_command", 10, [this](crtk_msgs::msg::StringStamped::ConstSharedPtr m) { state_command(m->string); }));
    const double publish_rate = declare_parameter("publish_rate", 100.0);
    timer_ = create_wall_timer(std::chrono::duration<double>(1.0 / publish_rate), [this] { publish(); });
    loop_ = std::thread([this] { cycles(); });
  }
  ~Controller() override {
    ends_ = true;
    loop_.join();
  }

 private:
  void ask(Kind kind) {
    Command c;
    c.kind = kind;
    commands_.push(c);
  }

  void hear_joints(const std::string& name, Kind kind) {
    subscriptions_.push_back(create_subscription<JointState>(name_ + "/" + name, 10, [this, kind](JointState::ConstSharedPtr m) {
      const std::vector<double>& values = kind == Kind::kServoJf ? m->effort : m->position;
      Command c;
      c.kind = kind;
      const rclcpp::Time stamp(m->header.stamp, get_clock()->get_clock_type());
      if (stamp.nanoseconds() != 0) c.age = (now() - stamp).seconds();
      c.count = static_cast<int>(std::min<std::size_t>(values.size(), kMostJoints + 1));
      for (int i = 0; i < std::min(c.count, kMostJoints); ++i) c.joints[i] = values[static_cast<std::size_t>(i)];
      commands_.push(c);
    }));
  }

  void state_command(const std::string& word) {
    static const std::map<std::string, Kind> kKnown = {{"enable", Kind::kEnable}, {"disable", Kind::kDisable},
                                                       {"pause", Kind::kPause},   {"resume", Kind::kResume},
                                                       {"home", Kind::kHome},     {"unhome", Kind::kUnhome}};
    const auto found = kKnown.find(word);
    if (found != kKnown.end()) return ask(found->second);
    warn("state_command: found '" + word + "', expected enable, disable, pause, resume, home or unhome");
  }

  void warn(const std::string& text) {
    std_msgs::msg::String m;
    m.data = text;
    warning_->publish(m);
  }

  // The loop: nothing here allocates, waits for the network or throws.
  void cycles() noexcept {
    const auto period = std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(1.0 / rate_));
    auto next = std::chrono::steady_clock::now();
    while (!ends_) {
      std::this_thread::sleep_until(next += period);
      Command c;
      while (commands_.pop(c)) arm_.command(c);
      const veridyn::VectorXd& tau = arm_.update(q_, dq_, 0.0, 1.0 / rate_);
      if (arm_.state() != OperatingState::kDisabled) {  // else brakes hold it
        tau_ = tau;
        sensors_.correct_torques(tau_);
        plant_->step(tau_, 1.0 / rate_);
        q_ = plant_->q();
        sensors_.show_positions(q_);
        dq_ = plant_->dq();
      }
      feedback_.write(arm_.feedback());
    }
  }

  void publish() {
    if (!feedback_.read(now_)) return;
    const auto n = static_cast<std::size_t>(now_.joints);
    JointState js;
    js.header.stamp = now();
    js.header.frame_id = name_ + "_base";
    for (const veridyn::Coordinate& c : model_.coordinates()) js.name.push_back(c.name);
    js.position.assign(now_.q, now_.q + n);
    js.velocity.assign(now_.dq, now_.dq + n);
    js.effort.assign(now_.tau, now_.tau + n);
    measured_js_->publish(js);
    geometry_msgs::msg::PoseStamped cp;
    cp.header = js.header;
    cp.pose.position.x = now_.position[0];
    cp.pose.position.y = now_.position[1];
    cp.pose.position.z = now_.position[2];
    cp.pose.orientation.x = now_.quaternion[0];
    cp.pose.orientation.y = now_.quaternion[1];
    cp.pose.orientation.z = now_.quaternion[2];
    cp.pose.orientation.w = now_.quaternion[3];
    measured_cp_->publish(cp);
    crtk_msgs::msg::OperatingState s;
    s.header = js.header;
    s.state = name_of(now_.state);
    s.is_homed = now_.homed;
    s.is_busy = now_.busy;
    if (s.state != told_.state || s.is_homed != told_.is_homed || s.is_busy != told_.is_busy) operating_state_->publish(s);
    told_ = s;
    if (now_.refusals != told_refusals_) warn(std::string("command refused: ") + describe(now_.refusal));
    told_refusals_ = now_.refusals;
  }

  std::string name_;
  veridyn::Model model_;
  CrtkArm arm_;
  std::unique_ptr<veridyn::Engine> plant_;
  veridyn::JointSensors sensors_;
  double rate_;
  veridyn::VectorXd q_, dq_, tau_;
  Queue<Command, 64> commands_;
  Snapshot<Feedback> feedback_;
  Feedback now_;
  crtk_msgs::msg::OperatingState told_;
  std::uint64_t told_refusals_ = 0;
  rclcpp::Publisher<JointState>::SharedPtr measured_js_;
  rclcpp::Publisher<geometry_msgs::msg::PoseStamped>::SharedPtr measured_cp_;
  rclcpp::Publisher<crtk_msgs::msg::OperatingState>::SharedPtr operating_state_;
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr warning_;
  std::vector<rclcpp::SubscriptionBase::SharedPtr> subscriptions_;
  rclcpp::TimerBase::SharedPtr timer_;
  std::atomic<bool> ends_{false};
  std::thread loop_;
};

}  // namespace
}  // namespace veridyn_ros

int main(int argc, char** argv) {
  rclcpp::init(argc, argv);
  try {
    rclcpp::spin(std::make_shared<veridyn_ros::Controller>());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "veridyn_controller: %s\n", error.what());
    return 3;
  }
  rclcpp::shutdown();
  return 0;
}
