// One to three arms under CrtkArm, in one loop. The arms are simulated in this process (~plant inside), or
// run in another node (~plant topics: NAME/io/measured_js, NAME/io/servo_jf).

#include <std_msgs/Float64MultiArray.h>

#include <atomic>
#include <cstdio>
#include <deque>
#include <thread>

#include "nodes/arm_topics.hpp"
#include "nodes/motor_link.hpp"
#include "nodes/parameters.hpp"
#include "veridyn/control/real_time.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/simulation/engine.hpp"

namespace veridyn_ros {
namespace {

using veridyn::VectorXd;

constexpr double kLostMotors = 0.02;  // [s] age of positions above which no torque is computed from them
constexpr double kOverrun = 0.5;      // share of a period by which a cycle counts as late
constexpr long kTold = 100;           // cycles between two reports of the loop's timing

// One arm of the loop; its members used by both threads are lock-free.
struct Arm {
  Arm(const ArmParameters& p, const CrtkOptions& options, bool inside)
      : arm(p.model, options), sensors(p.model), q(p.start), dq(VectorXd::Zero(p.start.size())), tau(dq) {
    if (!inside) return;
    plant = veridyn::make_engine("veridyn", p.model);
    plant->set_state(q, dq);
    sensors.add_position_errors(q);
  }
  CrtkArm arm;
  veridyn::JointSensors sensors;  // sensor errors of the simulated arm
  std::unique_ptr<veridyn::Engine> plant;
  VectorXd q, dq, tau;
  ArmTopics::Commands commands;
  Snapshot<Feedback> feedback;
  Snapshot<MotorState> from_motors;
  Snapshot<MotorTorque> to_motors;
  MotorState motors;
  bool lost = true;
};

class Controller {
 public:
  explicit Controller(ros::NodeHandle& own)
      : inside_(plant_is_inside(own)),
        priority_(own.param("real_time_priority", 0)),
        rate_(own.param("rate", 1000.0)) {
    veridyn::require(rate_ >= 100.0 && rate_ <= 10000.0, own.resolveName("rate"), ": found ", rate_,
                     " Hz, expected 100 to 10000.");
    ros::NodeHandle root;
    CrtkOptions options;
    options.hold_after = own.param("hold_after", options.hold_after);
    options.release_after = own.param("release_after", options.release_after);
    options.oldest_positions = own.param("oldest_positions", options.oldest_positions);
    options.longest_cycle = own.param("longest_cycle", options.longest_cycle);
    for (const ArmParameters& p : read_arms(own)) {
      options.tip = p.tip;
      arms_.emplace_back(p, options, inside_);
      Arm& arm = arms_.back();
      ros::NodeHandle space(root, p.name);
      topics_.push_back(std::make_unique<ArmTopics>(space, p.model, arm.commands, arm.feedback));
      if (inside_) continue;
      servo_jf_.push_back(space.advertise<sensor_msgs::JointState>("io/servo_jf", 1));
      measured_.push_back(space.subscribe<sensor_msgs::JointState>(
          "io/measured_js", 1, [&arm](const sensor_msgs::JointState::ConstPtr& m) { receive(arm, *m); },
          ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay()));
    }
    figures_ = own.advertise<std_msgs::Float64MultiArray>("loop", 1, true);
  }

  void run(double publish_rate) {
    const double began = steady_now();
    std::thread loop([this] { cycles(); });
    std::thread sender;
    if (!inside_) sender = std::thread([this] { send(); });
    int count = 0;
    ros::AsyncSpinner spinner(1);
    spinner.start();
    while (ros::ok()) {
      for (auto& one : topics_) one->publish();
      if (++count % static_cast<int>(publish_rate) == 0) publish_state();
      const double from = steady_now();
      while (ros::ok() && steady_now() - from < 1.0 / publish_rate)  // a wall clock may jump
        std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
    ends_ = true;
    loop.join();
    if (sender.joinable()) sender.join();
    loop_.read(told_);
    std::printf("veridyn_controller: %s\n", told_.timing_text(steady_now() - began).c_str());
  }

 private:
  static bool plant_is_inside(ros::NodeHandle& own) {
    const std::string plant = own.param("plant", std::string("inside"));
    veridyn::require(plant == "inside" || plant == "topics", own.resolveName("plant"), ": found '",
                     plant, "', expected inside or topics.");
    return plant == "inside";
  }

  // Passes positions to the loop; drops a message of another size. No efforts: power is off.
  static void receive(Arm& arm, const sensor_msgs::JointState& m) {
    const auto n = static_cast<std::size_t>(arm.q.size());
    if (m.position.size() != n || m.velocity.size() != n) return;
    MotorState s;
    std::copy(m.position.begin(), m.position.end(), s.q);
    std::copy(m.velocity.begin(), m.velocity.end(), s.dq);
    s.stamp = steady_now();
    s.said = m.header.stamp.toSec();
    s.powered = !m.effort.empty();  // CRTK omits missing values
    s.seen = true;
    arm.from_motors.write(s);
  }

  // The loop: nothing here allocates, waits or throws.
  void cycles() noexcept {
    if (priority_ > 0 && !(veridyn::set_real_time_priority(priority_) && veridyn::lock_memory()))
      ROS_WARN("the system allows no real-time priority: cycles may come late");
    Cycle cycle(1.0 / rate_);
    LoopFigures f;
    while (!ends_) {
      const double dt = cycle.wait();
      const double begun = steady_now();
      for (Arm& arm : arms_) step(arm, dt);
      const double took = steady_now() - begun;
      f.cycles += 1.0;
      f.mean_period += (dt - f.mean_period) / f.cycles;
      f.late.add_time(cycle.latest());
      f.compute.add_time(took);
      if (cycle.latest() > kOverrun / rate_) f.overruns += 1.0;
      if (static_cast<long>(f.cycles) % kTold == 0) loop_.write(f);
    }
  }

  // One cycle of an arm, dt [s] after the last one: commands, torques, and the simulated arm if it is inside.
  void step(Arm& arm, double dt) noexcept {
    double age = 0.0;
    if (!inside_) {
      arm.from_motors.read(arm.motors);
      if (!arm.motors.seen) return;
      age = steady_now() - arm.motors.stamp;
      for (Eigen::Index i = 0; i < arm.q.size(); ++i) {
        arm.q[i] = arm.motors.q[i];
        arm.dq[i] = arm.motors.dq[i];
      }
    }
    Command c;
    while (arm.commands.pop(c)) arm.arm.command(c);
    // A simulated arm advances by one cycle, whatever the clock.
    arm.tau = arm.arm.update(arm.q, arm.dq, age, inside_ ? 1.0 / rate_ : dt, inside_ || arm.motors.powered);
    if (inside_) {
      if (arm.arm.state() != OperatingState::kDisabled) {  // otherwise its brakes hold it
        arm.sensors.correct_torques(arm.tau);
        arm.plant->step(arm.tau, 1.0 / rate_);
        arm.q = arm.plant->q();
        arm.sensors.add_position_errors(arm.q);
        arm.dq = arm.plant->dq();
      } else if (arm.dq.squaredNorm() > 0.0) {
        arm.dq.setZero();
        arm.plant->set_state(VectorXd(arm.plant->q()), arm.dq);
      }
    } else if (age < kLostMotors && arm.arm.state() != OperatingState::kDisabled) {
      MotorTorque t;
      for (Eigen::Index i = 0; i < arm.q.size(); ++i) t.tau[i] = arm.tau[i];
      t.stamp = begun_ += 1.0;
      t.said = arm.motors.said;
      arm.to_motors.write(t);
    }
    arm.feedback.write(arm.arm.feedback());
  }

  // Sends torques to the motors of another node as soon as they arrive.
  void send() {
    MotorTorque t;
    while (!ends_) {
      bool any = false;
      for (std::size_t k = 0; k < arms_.size(); ++k) {
        if (!arms_[k].to_motors.read(t)) continue;
        any = true;
        sensor_msgs::JointState m;
        m.header.stamp = ros::Time(t.said);  // stamp of the positions that the torques are for
        m.effort.assign(t.tau, t.tau + arms_[k].q.size());
        servo_jf_[k].publish(m);
      }
      if (!any) std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
  }

  // Publishes the loop's timing on ~loop, see LoopFigures.
  void publish_state() {
    if (!loop_.read(told_)) return;
    const LoopFigures& f = told_;
    std_msgs::Float64MultiArray m;
    m.data = {f.cycles, f.mean_period, f.late.worst(), f.compute.worst(), f.overruns,
              f.late.quantile(0.5), f.late.quantile(0.999), f.compute.quantile(0.5), f.compute.quantile(0.999)};
    figures_.publish(m);
  }

  bool inside_;
  int priority_;  // 1 to 99: before all ordinary threads; 0: ordinary
  double rate_, begun_ = 0.0;
  std::deque<Arm> arms_;
  std::vector<std::unique_ptr<ArmTopics>> topics_;
  std::vector<ros::Publisher> servo_jf_;
  std::vector<ros::Subscriber> measured_;
  ros::Publisher figures_;
  Snapshot<LoopFigures> loop_;
  LoopFigures told_;
  std::atomic<bool> ends_{false};
};

void run(ros::NodeHandle& own) {
  Controller controller(own);
  controller.run(own.param("publish_rate", 100.0));
}

}  // namespace
}  // namespace veridyn_ros

int main(int argc, char** argv) {
  return veridyn_ros::run_node(argc, argv, "veridyn_controller", veridyn_ros::run);
}
