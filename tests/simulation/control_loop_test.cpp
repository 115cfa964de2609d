#include "veridyn/simulation/control_loop.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "simulation/plant_support.hpp"
#include "support/near.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/simulation/breakaway.hpp"
#include "veridyn/simulation/simulate_controlled.hpp"

namespace veridyn {
namespace {

MotionSamples held(const VectorXd& q, double seconds) {
  const auto rows = static_cast<Eigen::Index>(seconds * 200.0) + 1;
  const Eigen::Index n = q.size();
  return {VectorXd::LinSpaced(rows, 0.0, seconds), q.transpose().replicate(rows, 1),
          MatrixXd::Zero(rows, n), MatrixXd::Zero(rows, n)};
}

MotionSamples slow_waves(const VectorXd& middle, double size, double seconds) {
  MotionSamples m = held(middle, seconds);
  for (Eigen::Index i = 0; i < middle.size(); ++i) {
    const double w = 2.0 + 0.7 * static_cast<double>(i);
    const Eigen::ArrayXd angle = w * m.time.array();
    m.q.col(i).array() += size * (1.0 - angle.cos());
    m.dq.col(i) = size * w * angle.sin();
    m.ddq.col(i) = size * w * w * angle.cos();
  }
  return m;
}

TEST(ControlLoop, TheIntegralTermConvergesToTheWeightWithoutFriction) {
  const Model arm = planar_2r();
  const MotionSamples wanted = held(VectorXd::Constant(2, 0.4), 8.0);
  ControlledOptions options;
  const ControlledRecording done = simulate_controlled(arm, wanted, options);
  ASSERT_TRUE(done.run.complete());
  const Eigen::Index last = done.run.motion.rows() - 1;
  EXPECT_GT((done.run.motion.q - wanted.q).cwiseAbs().maxCoeff(), 1e-3);  // it sagged first
  EXPECT_TRUE(near(done.run.motion.q.row(last), wanted.q.row(last), 1e-6));
}

TEST(ControlLoop, MotorTorquesHaveTheirLimitResolutionAndLag) {
  const Model arm = planar_2r();
  const MotionSamples wanted = slow_waves(VectorXd::Constant(2, 0.1), 0.4, 3.0);
  ControlledOptions options;
  options.loop.drive.limit = VectorXd::Constant(2, 6.0);
  options.loop.drive.step = 0.25;
  const MatrixXd tau = simulate_controlled(arm, wanted, options).run.tau;
  EXPECT_EQ(tau.cwiseAbs().maxCoeff(), 6.0);
  EXPECT_TRUE(near((tau.array() / 0.25).round().matrix() * 0.25, tau, 1e-12));

  // A motor that lags by 20 ms under a constant command: tau = 6 (1 - exp(-t / lag)). The command
  // is constant as the arm falls and the motor gives all that it may.
  options.loop.drive.step = 0.0;
  options.loop.drive.limit = VectorXd::Constant(2, 0.5);
  options.loop.drive.lag = 0.02;
  const ControlledRecording lagging = simulate_controlled(arm, wanted, options);
  for (Eigen::Index k = 20; k < 60; ++k) {
    const double expected =
        0.5 + (lagging.run.tau(19, 0) - 0.5) * std::exp(-(k - 19) * 0.005 / 0.02);
    ASSERT_NEAR(lagging.run.tau(k, 0), expected, 1e-9) << k;
  }
}

TEST(ControlLoop, RecordingsSatisfyTheEquationOfMotion) {
  const Model arm = robot("psm-3dof");
  VectorXd middle(3);
  middle << 0.1, 0.0, 0.1;
  ControlledOptions options;
  options.recording.hidden = {parse_hidden_effect("torque_gain:2:gain=1.1")};
  const ControlledRecording done = simulate_controlled(arm, slow_waves(middle, 0.03, 5.0), options);
  ASSERT_TRUE(done.run.complete());
  EXPECT_TRUE(near(done.recording.tau.col(1), 1.1 * done.run.tau.col(1), 1e-12));
  EXPECT_TRUE(near(done.recording.tau.col(0), done.run.tau.col(0), 1e-12));
}

// An engine that fails at one second.
class Fragile final : public Engine {
 public:
  explicit Fragile(const Model& arm) : plant_(arm) {}
  int joints() const override { return plant_.joints(); }
  void set_state(const VectorRef& q, const VectorRef& dq) override { plant_.set_state(q, dq); }
  StepStatus step(const VectorRef& tau, double dt) noexcept override {
    return plant_.time() > 0.9995 ? StepStatus::kNotFinite : plant_.step(tau, dt);
  }
  StepStatus accelerate(const VectorRef& tau, VectorXd& ddq) noexcept override {
    return plant_.accelerate(tau, ddq);
  }
  double time() const override { return plant_.time(); }
  const VectorXd& q() const override { return plant_.q(); }
  const VectorXd& dq() const override { return plant_.dq(); }
  std::optional<JointIndex> failed_joint() const override { return JointIndex{1}; }
  const std::vector<std::string>& left_out() const override { return plant_.left_out(); }

 private:
  Plant plant_;
};

TEST(ControlLoop, AStoppedRunKeepsItsRowsAndReportsTimeAndJoint) {
  const Model arm = planar_2r();
  Fragile engine(arm);
  LoopOptions loop;
  loop.gains = sensible_gains(arm);
  const EngineRun run = run_with_pid(engine, arm, held(VectorXd::Zero(2), 3.0), loop);
  EXPECT_FALSE(run.complete());
  EXPECT_EQ(run.joint, JointIndex{1});
  EXPECT_NEAR(run.stopped_at, 1.0, 1e-9);
  EXPECT_EQ(run.motion.rows(), 201);  // the row at 1 s was still sound
  EXPECT_TRUE(run.motion.q.allFinite());
  EXPECT_NE(run.stop_reason(arm).find("1 s: joint q2"), std::string::npos) << run.stop_reason(arm);
}

// At 50 Hz, motors under rows at 200 Hz hold what they give for four rows.
TEST(ControlLoop, ASlowerControllerHoldsItsTorqueBetweenItsCycles) {
  const Model arm = planar_2r();
  ControlledOptions options;
  options.loop.rate = 50.0;
  options.loop.gains = sensible_gains(arm, 1.0);
  options.recording.noise = sensor_noise("none");
  const EngineRun run =
      simulate_controlled(arm, slow_waves(VectorXd::Constant(2, 0.1), 0.4, 1.0), options).run;
  ASSERT_TRUE(run.complete());
  for (Eigen::Index k = 1; k < run.tau.rows(); ++k)
    EXPECT_EQ(run.tau.row(k) == run.tau.row(k - 1), k % 4 != 0) << k;
}

// What the controller sees is too old: each swing becomes larger than the one before.
TEST(ControlLoop, ADivergingArmIsStopped) {
  const Model arm = planar_2r();
  ControlledOptions options;
  options.loop.sensors.delay = 0.5;
  options.loop.drive.limit = VectorXd::Constant(2, 1e4);
  const EngineRun run =
      simulate_controlled(arm, slow_waves(VectorXd::Constant(2, 0.1), 0.4, 60.0), options).run;
  ASSERT_EQ(run.status, StepStatus::kRanAway);
  EXPECT_LT(run.motion.time[run.motion.rows() - 1], 59.0);
  EXPECT_TRUE(run.motion.q.allFinite());
  EXPECT_NE(run.stop_reason(arm).find("more than ten times its range"), std::string::npos) << run.stop_reason(arm);
}

TEST(ControlLoop, GainsAreReadFromAFile) {
  const Model arm = planar_2r();
  const std::string path = testing::TempDir() + "gains.yaml";
  std::ofstream(path) << "p: [200, 100]\ni: [1, 2]\n";
  const PidGains gains = read_gains(path, arm);
  EXPECT_EQ(gains.p[1], 100.0);
  EXPECT_EQ(gains.i[1], 2.0);
  EXPECT_TRUE(near(gains.d, critical_damping(arm, gains.p), 0.0));
  std::ofstream(path) << "p: [200]\n";
  EXPECT_THROW(read_gains(path, arm), InvalidInput);
  std::ofstream(path) << "p: [200, 100]\nq: [1, 2]\n";
  EXPECT_THROW(read_gains(path, arm), InvalidInput);
}

// A recording of the arm itself, made with another controller, is what the arm makes of it again:
// whatever drives.
TEST(ControlLoop, ExcessiveSensorDelaysAreRefused) {
  const MotionSamples wanted = held(VectorXd::Constant(2, 0.4), 0.1);
  ControlledOptions options;
  for (const double delay : {-1.0, 1e305, std::nan("")}) {
    options.loop.sensors.delay = delay;
    EXPECT_THROW(simulate_controlled(planar_2r(), wanted, options), InvalidInput) << delay;
  }
}

TEST(Replay, TheRecordedArmReproducesItsRecording) {
  const Model arm = robot("psm-3dof");
  VectorXd middle(3);
  middle << 0.1, 0.0, 0.1;
  ControlledOptions options;
  options.loop.gains = sensible_gains(arm, 4.0);
  const ControlledRecording made =
      simulate_controlled(arm, slow_waves(middle, 0.03, 10.0), options);
  const Eigen::Index rows = made.run.motion.rows();
  ReplayInput input{made.run.motion, made.run.tau, std::vector<char>(static_cast<size_t>(rows), 1)};
  std::fill(input.use.begin(), input.use.begin() + 200, 0);
  std::fill(input.use.end() - 100, input.use.end(), 0);
  Plant plant(arm);
  ReplayOptions how;
  how.set_point_cutoff = 0.0;
  const Replay commands = replay(plant, arm, input, how);
  EXPECT_LT(commands.torque_error.maxCoeff(), 0.02) << commands.torque_error.transpose();
  EXPECT_LT(commands.motion_max.maxCoeff(), 3e-4);
  how.drive = ReplayDrive::kSetPoints;
  const Replay set_points = replay(plant, arm, input, how);
  EXPECT_LT(set_points.torque_error.maxCoeff(), 0.1) << set_points.torque_error.transpose();

  // A wrong model shows: the error is that of the missing friction.
  std::vector<EffectTerm> fewer;
  for (const EffectTerm& term : arm.effects()) {
    if (term.effect != "coulomb_friction" || term.axis.coefficients[0] == 0.0)
      fewer.push_back(term);
  }
  const Model wrong = with_effects(arm, fewer);
  Plant other(wrong);
  how.drive = ReplayDrive::kCommands;
  const Replay off = replay(other, wrong, input, how);
  EXPECT_GT(off.torque_error[0], 3.0 * commands.torque_error[0]);
  EXPECT_NEAR(off.torque_error[0], off.inverse_error[0], 0.3 * off.inverse_error[0]);
}

// Rows that were written a little late: their positions are off by the velocity times that, as
// those of real publishers. Differences of such positions are worse than the recorded velocity.
TEST(Replay, LateRowsDoNotExciteTheArm) {
  const Model arm = robot("psm-3dof");
  VectorXd middle(3);
  middle << 0.1, 0.0, 0.1;
  ControlledOptions options;
  options.loop.gains = sensible_gains(arm, 4.0);
  const ControlledRecording made = simulate_controlled(arm, slow_waves(middle, 0.1, 10.0), options);
  const Eigen::Index rows = made.run.motion.rows();
  ReplayInput input{made.run.motion, made.run.tau, std::vector<char>(static_cast<size_t>(rows), 1)};
  std::fill(input.use.begin(), input.use.begin() + 200, 0);
  std::fill(input.use.end() - 100, input.use.end(), 0);
  Random random(3);
  for (Eigen::Index k = 0; k < rows; ++k) {
    const double late = random.in(0.0, 0.02);
    input.motion.q.row(k) -= late * input.motion.dq.row(k);
  }
  Plant plant(arm);
  const Replay found = replay(plant, arm, input, {});
  EXPECT_LT(found.torque_error[2], 0.01) << found.torque_error.transpose();
  EXPECT_LT(found.torque_error.maxCoeff(), 0.05) << found.torque_error.transpose();
}

}  // namespace
}  // namespace veridyn
