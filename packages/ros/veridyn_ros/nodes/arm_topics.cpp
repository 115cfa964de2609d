#include "nodes/arm_topics.hpp"

#include <functional>
#include <map>

namespace veridyn_ros {
namespace {

using Kind = Command::Kind;

constexpr double kClockJump = 1.0;  // [s] change of the offset that counts as a jump of ROS' clock

// [s] since the stamp; 0: no stamp.
double age_of(const std_msgs::Header& header) {
  return header.stamp.isZero() ? 0.0 : (ros::Time::now() - header.stamp).toSec();
}

template <typename Event>
Command command(const Event& event, Kind kind, double age) {
  Command c;
  c.kind = kind;
  c.client = std::hash<std::string>()(event.getPublisherName());
  c.age = age;
  return c;
}

// p: position [m]; q: quaternion x, y, z, w.
void fill(geometry_msgs::Pose& pose, const double* p, const double* q) {
  pose.position.x = p[0];
  pose.position.y = p[1];
  pose.position.z = p[2];
  pose.orientation.x = q[0];
  pose.orientation.y = q[1];
  pose.orientation.z = q[2];
  pose.orientation.w = q[3];
}

void fill(geometry_msgs::Vector3& v, const double* x) {
  v.x = x[0];
  v.y = x[1];
  v.z = x[2];
}

}  // namespace

ArmTopics::ArmTopics(ros::NodeHandle space, const veridyn::Model& arm, Commands& to_loop,
                     Snapshot<Feedback>& from_loop)
    : space_(std::move(space)), to_loop_(to_loop), from_loop_(from_loop) {
  for (const veridyn::Coordinate& c : arm.coordinates()) names_.push_back(c.name);
  base_ = space_.getNamespace().substr(space_.getNamespace().find_last_of('/') + 1) + "_base";
  measured_js_ = advertise<sensor_msgs::JointState>("measured_js");
  setpoint_js_ = advertise<sensor_msgs::JointState>("setpoint_js");
  measured_cp_ = advertise<geometry_msgs::PoseStamped>("measured_cp");
  setpoint_cp_ = advertise<geometry_msgs::PoseStamped>("setpoint_cp");
  measured_cv_ = advertise<geometry_msgs::TwistStamped>("measured_cv");
  measured_cf_ = advertise<geometry_msgs::WrenchStamped>("measured_cf");
  operating_state_ = advertise<crtk_msgs::OperatingState>("operating_state", true);
  error_ = advertise<std_msgs::String>("error");
  warning_ = advertise<std_msgs::String>("warning");
  for (const auto& [name, kind] : std::map<std::string, Kind>{
           {"servo_jp", Kind::kServoJp}, {"servo_jf", Kind::kServoJf}, {"move_jp", Kind::kMoveJp}})
    subscribe<sensor_msgs::JointState>(name, [this, k = kind](const auto& e) { joints(e, k); });
  for (const auto& [name, kind] :
       std::map<std::string, Kind>{{"servo_cp", Kind::kServoCp}, {"move_cp", Kind::kMoveCp}})
    subscribe<geometry_msgs::PoseStamped>(name, [this, k = kind](const auto& e) { pose(e, k); });
  subscribe<geometry_msgs::WrenchStamped>("servo_cf", [this](const auto& e) {
    wrench(e.getMessage()->wrench, command(e, Kind::kServoCf, age_of(e.getMessage()->header)));
  });
  subscribe<geometry_msgs::TwistStamped>("servo_cv", [this](const auto& e) {
    twist(e.getMessage()->twist, command(e, Kind::kServoCv, age_of(e.getMessage()->header)));
  });
  subscribe<geometry_msgs::Wrench>("cmd_force", [this](const auto& e) {  // as in the thesis
    wrench(*e.getMessage(), command(e, Kind::kServoCf, 0.0));
  });
  subscribe<geometry_msgs::Twist>("cmd_vel", [this](const auto& e) {
    twist(*e.getMessage(), command(e, Kind::kServoCv, 0.0));
  });
  subscribe<std_msgs::Empty>("hold", [this](const auto& e) { push(command(e, Kind::kHold, 0.0)); });
  subscribe<crtk_msgs::StringStamped>("state_command", [this](const auto& e) { state_command(e); });
}

void ArmTopics::push(const Command& c) {
  if (!to_loop_.push(c)) warn("commands come faster than the loop takes them; one is left out");
}

void ArmTopics::warn(const std::string& text) {
  std_msgs::String message;
  message.data = text;
  warning_.publish(message);
  ROS_WARN_THROTTLE(1.0, "%s: %s", space_.getNamespace().c_str(), text.c_str());
}

void ArmTopics::joints(const Event<sensor_msgs::JointState>& event, Kind kind) {
  const sensor_msgs::JointState& m = *event.getMessage();
  const std::vector<double>& values = kind == Kind::kServoJf ? m.effort : m.position;
  Command c = command(event, kind, age_of(m.header));
  c.count = static_cast<int>(std::min<std::size_t>(values.size(), kMostJoints + 1));
  for (int i = 0; i < std::min(c.count, kMostJoints); ++i) c.joints[i] = values[i];
  push(c);
}

void ArmTopics::pose(const Event<geometry_msgs::PoseStamped>& event, Kind kind) {
  const geometry_msgs::PoseStamped& m = *event.getMessage();
  Command c = command(event, kind, age_of(m.header));
  const geometry_msgs::Point& p = m.pose.position;
  const geometry_msgs::Quaternion& q = m.pose.orientation;
  const double position[] = {p.x, p.y, p.z}, quaternion[] = {q.x, q.y, q.z, q.w};
  std::copy(position, position + 3, c.position);
  std::copy(quaternion, quaternion + 4, c.quaternion);
  push(c);
}

void ArmTopics::wrench(const geometry_msgs::Wrench& w, Command c) {
  const double six[] = {w.force.x, w.force.y, w.force.z, w.torque.x, w.torque.y, w.torque.z};
  std::copy(six, six + 6, c.six);
  push(c);
}

void ArmTopics::twist(const geometry_msgs::Twist& t, Command c) {
  const double six[] = {t.linear.x, t.linear.y, t.linear.z, t.angular.x, t.angular.y, t.angular.z};
  std::copy(six, six + 6, c.six);
  push(c);
}

void ArmTopics::state_command(const Event<crtk_msgs::StringStamped>& event) {
  static const std::map<std::string, Kind> kKnown = {
      {"enable", Kind::kEnable}, {"disable", Kind::kDisable}, {"pause", Kind::kPause},
      {"resume", Kind::kResume}, {"home", Kind::kHome},       {"unhome", Kind::kUnhome}};
  const auto found = kKnown.find(event.getMessage()->string);
  if (found == kKnown.end()) {
    warn("state_command: found '" + event.getMessage()->string +
             "', expected enable, disable, pause, resume, home or unhome");
    return;
  }
  // Latched topic: its stamp may be old.
  push(command(event, found->second, 0.0));
}

// Time of the loop's feedback on ROS' clock: the loop's steady clock plus an offset, which is updated only if
// ROS' clock jumped.
ros::Time ArmTopics::stamp() {
  const double now = ros::Time::now().toSec();
  if (clock_ahead_ == 0.0 || std::abs(now - clock_ahead_ - now_.time) > kClockJump)
    clock_ahead_ = now - now_.time;
  return ros::Time(std::max(1e-9, clock_ahead_ + now_.time));
}

void ArmTopics::publish() {
  if (!from_loop_.read(now_)) return;
  const auto n = static_cast<std::size_t>(now_.joints);
  sensor_msgs::JointState js;
  js.header.stamp = stamp();
  js.header.frame_id = base_;
  js.name = names_;
  js.position.assign(now_.q, now_.q + n);
  js.velocity.assign(now_.dq, now_.dq + n);
  js.effort.assign(now_.tau, now_.tau + n);
  measured_js_.publish(js);
  sensor_msgs::JointState setpoint;
  setpoint.header = js.header;
  setpoint.name = names_;
  setpoint.position.assign(now_.setpoint, now_.setpoint + n);
  setpoint_js_.publish(setpoint);
  geometry_msgs::PoseStamped cp;
  cp.header = js.header;
  fill(cp.pose, now_.position, now_.quaternion);
  measured_cp_.publish(cp);
  fill(cp.pose, now_.setpoint_position, now_.setpoint_quaternion);
  setpoint_cp_.publish(cp);
  geometry_msgs::TwistStamped cv;
  cv.header = js.header;
  fill(cv.twist.linear, now_.twist);
  fill(cv.twist.angular, now_.twist + 3);
  measured_cv_.publish(cv);
  geometry_msgs::WrenchStamped cf;
  cf.header = js.header;
  fill(cf.wrench.force, now_.wrench);
  fill(cf.wrench.torque, now_.wrench + 3);
  measured_cf_.publish(cf);
  if (!told_ || told_state_ != now_.state || told_homed_ != now_.homed || told_busy_ != now_.busy) {
    crtk_msgs::OperatingState s;
    s.header = js.header;
    s.state = name_of(now_.state);
    s.is_homed = now_.homed;
    s.is_busy = now_.busy;
    operating_state_.publish(s);
    if (now_.state == OperatingState::kFault && told_state_ != now_.state) {
      std_msgs::String why;
      why.data = veridyn::describe(now_.fault);
      error_.publish(why);
      ROS_ERROR("%s: fault: %s", space_.getNamespace().c_str(), why.data.c_str());
    }
  }
  told_ = true;
  told_state_ = now_.state;
  told_homed_ = now_.homed;
  told_busy_ = now_.busy;
  if (now_.refusals != told_refusals_) warn(std::string("command refused: ") + describe(now_.refusal));
  if (now_.lost_streams != told_lost_) warn("no commands any more: the arm is held");
  told_refusals_ = now_.refusals;
  told_lost_ = now_.lost_streams;
}

}  // namespace veridyn_ros
