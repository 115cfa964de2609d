// A controller that records its signals, and a better model identified from them. The MODEL does not contain
// the load that the arm has carried since.
//
//   example_06_log_and_identify psm_identified.yaml     written by 01_identify

#include <iostream>

#include "simulated_robot.hpp"
#include "veridyn/veridyn.hpp"

using namespace veridyn;

// The log holds measured positions: identification corrects the sensor errors of the model.
Recording record(const Model& arm, double frequency) {
  SimulatedRobot robot({"payload:tool:mass=0.2"});
  JointController controller(arm, {.kp = 400, .kd = 40, .cycle = {.torque = 40}});
  Measured measured(arm.joints());
  robot.read(measured.q);
  JointReference wanted = controller.reference_at(measured);
  MatrixXd a(3, 4);  // [rad/s], [m/s] of four harmonics, which cancel at the start
  a << 0.4, 0.2, -0.4, -0.2, 0.15, -0.3, -0.15, 0.3, -0.04, 0.04, 0.02, -0.02;
  const FourierTrajectory path(frequency, a, MatrixXd::Zero(3, 4), wanted.q);
  const MotionSamples motion = path.samples(VectorXd::LinSpaced(20000, 0.0, 20.0 - SimulatedRobot::kCycle));
  Recording log{"the log", motion.time, motion.q, motion.dq, {}, motion.q, {}};
  for (int k = 0; k < log.rows(); ++k) {
    robot.read(measured.q);
    set_reference_from(motion, k, wanted);
    log.q.row(k) = measured.q;
    log.tau.row(k) = controller.update(measured, wanted, SimulatedRobot::kCycle);
    log.dq.row(k) = controller.state().dq();
    robot.write(log.tau.row(k));
  }
  return log;
}

int main(int argc, char** argv) {
  const Model arm = read_model(argc > 1 ? argv[1] : "psm_identified.yaml");
  const Identification better = identify(read_model("psm-3dof"), record(arm, 0.3));
  save(better, "psm_with_load.yaml");
  const Recording other = record(*better.model, 0.23);  // tested on another motion
  double before = 0.0, after = 0.0;
  for (const JointScore& joint : validate(arm, other)) std::cout << "old, " << joint << '\n', before += joint.error;
  for (const JointScore& joint : validate(better, other)) std::cout << "new, " << joint << '\n', after += joint.error;
  return after < 0.5 * before ? 0 : 1;
}
