// Arms on dVRK boards, real or emulated, as topics: NAME/io/measured_js at the loop's rate, NAME/io/servo_jf.
// Efforts of measured_js are those of the measured currents; without power there are none. Power is on only
// while a controller publishes ENABLED or PAUSED on NAME/operating_state and sends torques; after ~patience
// without them it is switched off. NAME/io/state has the state as text.

#include <crtk_msgs/OperatingState.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/String.h>

#include <atomic>
#include <cstdio>
#include <deque>
#include <thread>

#include "nodes/motor_link.hpp"
#include "nodes/motor_topics.hpp"
#include "nodes/parameters.hpp"
#include "veridyn/control/real_time.hpp"
#include "veridyn/dvrk/board_arm.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn_ros {
namespace {

using veridyn::BoardArm;
using veridyn::VectorXd;

// State of an arm as literal texts, written by the loop.
struct BoardWords {
  const char* state = "off";
};

struct Arm {
  std::string name;
  std::unique_ptr<BoardArm> boards;
  int joints = 0;  // number of joints that the controller uses
  Snapshot<MotorTorque> asked;
  Snapshot<MotorState> measured;
  Snapshot<BoardWords> words;
  std::atomic<bool> enabled{false};
  // Used by the loop's thread only.
  MotorTorque now;
  VectorXd tau;
  bool refused = false;  // a fault occurred since the controller was enabled
  TimeHistogram answered;
  // Used by the network's thread only.
  MotorState told;
  const char* told_state = nullptr;
  sensor_msgs::JointState message;
  ros::Publisher measured_js, state;
  std::vector<ros::Subscriber> subscribers;
};

class Boards {
 public:
  explicit Boards(ros::NodeHandle& own)
      : rate_(own.param("rate", 1000.0)),
        patience_(own.param("patience", 0.02)),
        priority_(own.param("real_time_priority", 0)) {
    std::vector<std::string> names;
    veridyn::require(own.getParam("arms", names) && !names.empty(), own.resolveName("arms"),
                     ": found no list of arms, expected e.g. [PSM1].");
    veridyn::require(patience_ > 0.0, own.resolveName("patience"), ": found ", patience_, ", expected seconds above zero.");
    for (const std::string& name : names) add(own, name);
  }

  void run() {
    std::thread loop([this] { run_loop(); });
    ros::AsyncSpinner spinner(1);
    spinner.start();
    while (ros::ok()) {
      bool any = false;
      for (Arm& arm : arms_) any = publish_state(arm) || any;
      if (!any) std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    ends_ = true;
    loop.join();
    for (Arm& arm : arms_) {
      const bool off = arm.boards->shutdown();
      std::fprintf(stderr, "veridyn_boards: %s: power is %s\n", arm.name.c_str(),
                   off ? "off" : "NOT CONFIRMED to be off: press the emergency stop");
    }
    std::printf("veridyn_boards: %s; torques answer positions after %s\n", figures_.timing_text(steady_now() - began_).c_str(),
                histogram_text(arms_.front().answered).c_str());
  }

 private:
  void add(ros::NodeHandle& own, const std::string& name) {
    const std::string at = name + "/";
    veridyn::BoardArmOptions o;
    o.config = own.param(at + "config", name);
    o.robot = own.param(at + "robot", std::string());
    o.instrument = own.param(at + "instrument", std::string());
    o.host = own.param(at + "host", o.host);
    o.port = static_cast<std::uint16_t>(own.param(at + "port", static_cast<int>(o.port)));
    o.watchdog = own.param(at + "watchdog", o.watchdog);
    o.rate = rate_;
    Arm& arm = arms_.emplace_back();
    arm.name = name;
    arm.boards = std::make_unique<BoardArm>(o);
    arm.joints = own.param(at + "joints", arm.boards->joints());
    veridyn::require(arm.joints > 0 && arm.joints <= std::min(arm.boards->joints(), kMostJoints), own.resolveName(at + "joints"),
                     ": found ", arm.joints, ", expected 1 to ", arm.boards->joints(), ".");
    arm.tau = VectorXd::Zero(arm.joints);
    ros::NodeHandle space{name};
    arm.measured_js = space.advertise<sensor_msgs::JointState>("io/measured_js", 1);
    arm.state = space.advertise<std_msgs::String>("io/state", 10, true);
    arm.subscribers = {
        space.subscribe<sensor_msgs::JointState>(
            "io/servo_jf", 1, [&arm](const sensor_msgs::JointState::ConstPtr& m) { receive_torques(arm.name, arm.joints, *m, arm.asked); }, ros::VoidConstPtr(),
            ros::TransportHints().tcpNoDelay()),
        space.subscribe<crtk_msgs::OperatingState>("operating_state", 10, [&arm](const crtk_msgs::OperatingState::ConstPtr& m) {
          arm.enabled = m->state == "ENABLED" || m->state == "PAUSED";
        })};
  }

  // The loop: nothing here allocates or throws; it waits only for the boards' replies.
  void run_loop() noexcept {
    if (priority_ > 0 && !(veridyn::set_real_time_priority(priority_) && veridyn::lock_memory()))
      ROS_WARN("the system allows no real-time priority: cycles may come late");
    Cycle cycle(1.0 / rate_);
    while (!ends_) {
      const double dt = cycle.wait(), begun = steady_now();
      for (Arm& arm : arms_) step(arm);
      figures_.cycles += 1.0;
      figures_.mean_period += (dt - figures_.mean_period) / figures_.cycles;
      figures_.late.add_time(cycle.latest());
      figures_.compute.add_time(steady_now() - begun);
      if (cycle.latest() > 0.5 / rate_) figures_.overruns += 1.0;
    }
  }

  // One cycle of an arm: reads, switches power as the controller requires, writes torques and state.
  void step(Arm& arm) noexcept {
    BoardArm& boards = *arm.boards;
    const bool valid = boards.read();
    if (arm.asked.read(arm.now) && arm.now.said > 0.0) arm.answered.add_time(ros::WallTime::now().toSec() - arm.now.said);
    const bool led = arm.enabled && steady_now() - arm.now.stamp < patience_;
    if (!arm.enabled) arm.refused = false;
    const char* why = boards.fault();
    if (why != nullptr) arm.refused = true;  // power returns only after a new ENABLED
    if (led && !arm.refused && !boards.powered()) {
      why = boards.power_on();
      arm.refused = why != nullptr;
    }
    if (!led && boards.powered()) boards.power_off();
    if (led && valid) {
      for (Eigen::Index i = 0; i < arm.tau.size(); ++i) arm.tau[i] = arm.now.tau[i];
      boards.set_torques(arm.tau);
    }
    boards.write();
    if (valid && !(arm.refused && arm.enabled)) write_state(arm);  // missing positions are a fault of the controller
    if (why == nullptr && arm.refused) return;              // the last text is kept
    arm.words.write({why != nullptr ? why : boards.ready() ? "on" : boards.powered() ? "powering up" : "off"});
  }

  void write_state(Arm& arm) noexcept {
    MotorState s;
    for (Eigen::Index i = 0; i < arm.joints; ++i) {
      s.q[i] = arm.boards->q()[i];
      s.dq[i] = arm.boards->dq()[i];
      s.tau[i] = arm.boards->tau()[i];
    }
    s.powered = arm.boards->ready();
    s.stamp = steady_now();
    s.said = ros::WallTime::now().toSec();
    s.seen = true;
    arm.measured.write(s);
  }

  // False: no new positions.
  bool publish_state(Arm& arm) {
    BoardWords words;
    if (arm.words.read(words) && words.state != arm.told_state) {
      std_msgs::String m;
      m.data = words.state;
      arm.state.publish(m);
      ROS_INFO("%s: %s", arm.name.c_str(), words.state);
      arm.told_state = words.state;
    }
    if (!arm.measured.read(arm.told)) return false;
    const MotorState& s = arm.told;
    sensor_msgs::JointState& m = arm.message;
    m.header.stamp = ros::Time(s.said);
    m.position.assign(s.q, s.q + arm.joints);
    m.velocity.assign(s.dq, s.dq + arm.joints);
    m.effort.assign(s.tau, s.tau + (s.powered ? arm.joints : 0));
    arm.measured_js.publish(m);
    return true;
  }

  double rate_, patience_, began_ = steady_now();
  int priority_;
  std::deque<Arm> arms_;
  LoopFigures figures_;
  std::atomic<bool> ends_{false};
};

void run(ros::NodeHandle& own) {
  Boards boards(own);
  boards.run();
}

}  // namespace
}  // namespace veridyn_ros

int main(int argc, char** argv) {
  return veridyn_ros::run_node(argc, argv, "veridyn_boards", veridyn_ros::run);
}
