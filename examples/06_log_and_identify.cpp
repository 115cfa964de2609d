// A controller that keeps what it sees, and a better model made of it. The MODEL at hand does not
// know the load that the arm has got since.
//
//   example_06_log_and_identify psm_identified.yaml     what 01_identify writes

#include <iostream>

#include "simulated_robot.hpp"
#include "veridyn/control.hpp"
#include "veridyn/identification/identification.hpp"

using namespace veridyn;

// The log holds what the robot shows, not what the controller makes of it: identification takes off
// what a model knows about sensors by itself.
Recording follow(const Model& arm, double slower) {
  SimulatedRobot robot({"payload:tool:mass=0.2"});
  const int n = arm.joints(), rows = 20000;
  const double dt = SimulatedRobot::kCycle;
  JointSensors sensors(arm);
  VelocityObserver velocity(n);
  ArmState state(arm);
  ComputedTorque control(n, {VectorXd::Constant(n, 400.0), VectorXd::Constant(n, 40.0)});
  JointReference wanted(n);
  VectorXd q(n), dq(n), tau(n), start(n);
  const Eigen::Vector3d size(0.4, 0.3, 0.03);
  robot.read(start);
  Recording log;
  log.time = VectorXd::LinSpaced(rows, 0.0, dt * (rows - 1));
  log.q = log.dq = log.tau = MatrixXd(rows, n);
  for (int k = 0; k < rows; ++k) {
    robot.read(q);
    log.q.row(k) = q.transpose();
    sensors.correct_positions(q);
    dq = velocity.update(q, control.acceleration(), dt);
    const double t = dt * k, begin = std::min(1.0, t);
    for (int i = 0; i < n; ++i) {
      const double w = (2.0 + 0.7 * i) / slower, a = 0.5 * begin * size[i];
      wanted.q[i] = start[i] + a * (std::sin(w * t) + std::sin(2.7 * w * t));
      wanted.dq[i] = a * w * (std::cos(w * t) + 2.7 * std::cos(2.7 * w * t));
      wanted.ddq[i] = -a * w * w * (std::sin(w * t) + 7.29 * std::sin(2.7 * w * t));
    }
    state.update(q, dq);
    tau = control.update(state, wanted);
    sensors.show_torques(tau);
    log.dq.row(k) = dq.transpose();
    log.tau.row(k) = tau.transpose();
    if (!robot.write(tau)) throw InvalidInput("the arm cannot go on");
  }
  return log;
}

int main(int argc, char** argv) {
  const Model arm = read_model(argc > 1 ? argv[1] : "psm_identified.yaml");
  const Identification better = identify(read_model("psm-3dof"), {follow(arm, 1.0)});
  save(better, "psm_with_load.yaml");
  // Judged by another motion, on which the new model leads the arm.
  const Recording other = follow(*better.model, 1.3);
  const VectorXd before = evaluate(arm, {other}).train_error.relative;
  const VectorXd after = evaluate(*better.model, {other}).train_error.relative;
  std::cout << "torque error by joint, old model: " << 100.0 * before.transpose()
            << " %; new model: " << 100.0 * after.transpose() << " %\n";
  return after.mean() < 0.5 * before.mean() ? 0 : 1;
}
