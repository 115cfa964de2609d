// Simulated arms with the topics of boards: NAME/io/measured_js at the loop's rate, NAME/io/servo_jf. If no
// torques arrive for some milliseconds, brakes hold an arm. With ~clock true it publishes /clock, which other
// nodes then use as their clock (/use_sim_time).

#include <rosgraph_msgs/Clock.h>
#include <sensor_msgs/JointState.h>

#include <atomic>
#include <cstdio>
#include <deque>
#include <optional>
#include <thread>

#include "nodes/motor_link.hpp"
#include "nodes/motor_topics.hpp"
#include "nodes/parameters.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/joint_sensors.hpp"
#include "veridyn/simulation/engine.hpp"

namespace veridyn_ros {
namespace {

using veridyn::VectorXd;

struct Arm {
  std::unique_ptr<veridyn::Engine> plant;
  std::optional<veridyn::JointSensors> sensors;
  VectorXd q, dq, tau;  // sensor readings, and torques in the scale of the drives
  VectorXd acting;
  Snapshot<MotorTorque> asked;
  MotorTorque now;
  TimeHistogram* answered = nullptr;  // [s] times from positions to the torques that answer them
  ros::Subscriber servo_jf;
  ros::Publisher measured_js;
  sensor_msgs::JointState message;
  bool braked = true;
  std::string name;
};

// Advances an arm by `dt` [s]; without torques for `patience` [s] brakes hold it.
void advance_arm(Arm& arm, double dt, double patience) {
  if (arm.asked.read(arm.now) && arm.now.said > 0.0) arm.answered->add_time(ros::Time::now().toSec() - arm.now.said);
  const bool braked = steady_now() - arm.now.stamp > patience;
  if (braked && !arm.braked) ROS_WARN("%s: no torques any more; brakes hold it", arm.name.c_str());
  arm.braked = braked;
  if (braked) {
    if (arm.dq.squaredNorm() == 0.0) return;
    arm.dq.setZero();
    arm.plant->set_state(VectorXd(arm.plant->q()), arm.dq);
    return;
  }
  for (Eigen::Index i = 0; i < arm.q.size(); ++i) arm.tau[i] = arm.now.tau[i];
  arm.acting = arm.tau;
  arm.sensors->correct_torques(arm.acting);
  const veridyn::StepStatus status = arm.plant->step(arm.acting, dt);
  if (status != veridyn::StepStatus::kOk)
    ROS_ERROR_THROTTLE(1.0, "%s: an arm %s", arm.name.c_str(), veridyn::describe(status));
  arm.q = arm.plant->q();
  arm.sensors->add_position_errors(arm.q);
  arm.dq = arm.plant->dq();
}

void run(ros::NodeHandle& own) {
  const double rate = own.param("rate", 1000.0);
  const double patience = own.param("patience", 0.02);
  veridyn::require(rate > 0.0 && patience > 0.0, "~rate, ~patience: expected numbers above zero.");
  std::deque<Arm> arms;
  LoopFigures figures;
  TimeHistogram answered;
  ros::NodeHandle root;
  for (const ArmParameters& p : read_arms(own)) {
    Arm& arm = arms.emplace_back();
    arm.name = p.name;
    arm.answered = &answered;
    arm.plant = veridyn::make_engine(own.param("engine", std::string("veridyn")), p.model);
    arm.q = p.start;
    arm.dq = arm.tau = VectorXd::Zero(p.start.size());
    arm.plant->set_state(arm.q, arm.dq);
    arm.sensors.emplace(p.model);
    arm.sensors->add_position_errors(arm.q);
    for (const veridyn::Coordinate& c : p.model.coordinates()) arm.message.name.push_back(c.name);
    ros::NodeHandle space(root, p.name);
    arm.measured_js = space.advertise<sensor_msgs::JointState>("io/measured_js", 1);
    arm.servo_jf = space.subscribe<sensor_msgs::JointState>(
        "io/servo_jf", 1, [&arm](const sensor_msgs::JointState::ConstPtr& m) {
          receive_torques(arm.name, static_cast<int>(arm.q.size()), *m, arm.asked);
        },
        ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
  }
  ros::Publisher clock;
  if (own.param("clock", false)) clock = root.advertise<rosgraph_msgs::Clock>("/clock", 10);
  ros::AsyncSpinner spinner(1);
  spinner.start();
  Cycle cycle(1.0 / rate);
  const double began = steady_now();
  rosgraph_msgs::Clock time;
  for (long k = 1; ros::ok(); ++k) {
    const double dt = cycle.wait(), began_cycle = steady_now();
    figures.cycles += 1.0;
    figures.mean_period += (dt - figures.mean_period) / figures.cycles;
    figures.late.add_time(cycle.latest());
    if (cycle.latest() > 0.5 / rate) figures.overruns += 1.0;
    time.clock = ros::Time(static_cast<double>(k) / rate);
    const ros::Time stamp = clock ? time.clock : ros::Time::now();
    for (Arm& arm : arms) {
      advance_arm(arm, 1.0 / rate, patience);
      arm.message.header.stamp = stamp;
      arm.message.position.assign(arm.q.data(), arm.q.data() + arm.q.size());
      arm.message.velocity.assign(arm.dq.data(), arm.dq.data() + arm.dq.size());
      arm.message.effort.assign(arm.tau.data(), arm.tau.data() + arm.tau.size());
      arm.measured_js.publish(arm.message);
    }
    if (clock) clock.publish(time);
    figures.compute.add_time(steady_now() - began_cycle);
  }
  std::printf("veridyn_plant: %s; torques answer positions after %s\n", figures.timing_text(steady_now() - began).c_str(),
              histogram_text(answered).c_str());
}

}  // namespace
}  // namespace veridyn_ros

int main(int argc, char** argv) {
  return veridyn_ros::run_node(argc, argv, "veridyn_plant", veridyn_ros::run);
}
