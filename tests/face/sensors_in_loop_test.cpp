#include <gtest/gtest.h>

#include <filesystem>

#include "support/simulated.hpp"
#include "veridyn/control.hpp"
#include "veridyn/simulation/plausible_model.hpp"
#include "veridyn/veridyn.hpp"

// What a diagnosis finds about sensors reaches the loop: the encoder of an arm slips by 0.1 rad, a
// diagnosis puts that into the MODEL, and a controller on this MODEL does as well as before.

namespace veridyn {
namespace {

constexpr double kSlip = 0.1;      // [rad]
constexpr double kPeriod = 0.001;  // [s]

Recording recording(const Model& truth, unsigned seed, const std::vector<HiddenEffect>& hidden) {
  constexpr int kRows = 4000;
  MotionSamples m{VectorXd::LinSpaced(kRows, 0.0, 0.005 * (kRows - 1)), MatrixXd(kRows, 3), {}, {}};
  const double centre[] = {0.0, 0.0, 0.12}, size[] = {0.8, 0.5, 0.06};
  for (int i = 0; i < 3; ++i) {
    m.q.col(i).setConstant(centre[i]);
    for (int k = 1; k <= 4; ++k) {
      const double w = 2.0 * M_PI * 0.2 * k;
      m.q.col(i).array() +=
          size[i] / (k + 1.0) * (w * m.time.array() + 1.7 * k * (i + 1) + 0.9 * seed).sin();
    }
  }
  SimulationOptions options;
  options.seed = seed;
  options.noise = sensor_noise("low");
  options.hidden = hidden;
  Recording out = recording_of(simulate_recording(truth, with_derivatives(m), options));
  out.source = "run " + std::to_string(seed);
  return out;
}

// [rad], [m] rms of where the joints truly are, beside where they should be, on a motion of 4 s.
VectorXd tracking(const Model& truth, const JointSensors& real, const Model& model,
                  const JointSensors& known) {
  Plant plant(truth);
  const Eigen::Vector3d start(0.1, 0.05, 0.12);
  const Eigen::Vector3d size(0.3, 0.3, 0.03);
  constexpr double w = 3.0;  // [rad/s]
  plant.set_state(start, w * size);
  ArmState state(model);
  ComputedTorque control(3, {VectorXd::Constant(3, 400.0), VectorXd::Constant(3, 40.0)});
  FrictionCompensation friction(model);
  ModelErrorObserver error(3, {10.0, VectorXd::Constant(3, 2.0)});
  JointReference wanted(3);
  VectorXd q(3), dq(3), tau(3), off(3), sum = VectorXd::Zero(3);
  constexpr int kCycles = 4000;
  for (int k = 0; k < kCycles; ++k) {
    const double angle = w * k * kPeriod;
    wanted.q = start + std::sin(angle) * size;
    wanted.dq = w * std::cos(angle) * size;
    wanted.ddq = -w * w * std::sin(angle) * size;
    q = plant.q();
    real.add_position_errors(q);
    dq = plant.dq();
    known.correct_positions(q);
    off = wanted.q - q;
    state.update(q, dq);
    tau = control.update(state, wanted);
    tau += friction.update(state, wanted.dq, off, kPeriod);
    tau += error.update(state, control.acceleration(), kPeriod);
    known.add_torque_errors(tau);
    real.correct_torques(tau);
    EXPECT_EQ(plant.step(tau, kPeriod), StepStatus::kOk);
    sum += (plant.q() - wanted.q).cwiseAbs2();
  }
  return (sum / kCycles).cwiseSqrt();
}

class SlippedEncoder : public testing::Test {
 protected:
  // The MODEL of before, and the one that a diagnosis of new recordings made of it, through a file.
  static void SetUpTestSuite() {
    truth_ = new Model(plausible_model(read_model("psm-3dof"), 3).arm);
    const Identification before = identify(read_model("psm-3dof"), {recording(*truth_, 1, {})});
    before_ = new Model(before.model.value());
    const std::vector<HiddenEffect> slip{parse_hidden_effect("encoder_offset:pitch:offset=0.1")};
    const Diagnosis found =
        diagnose(*before_, {recording(*truth_, 2, slip)}, {recording(*truth_, 3, slip)});
    ASSERT_FALSE(found.findings.empty());
    EXPECT_EQ(to_text(*before_, found.findings[0].cause), "encoder_offset:pitch");
    const auto path = std::filesystem::temp_directory_path() / "veridyn_slipped.yaml";
    save(found.extended, path.string());
    after_ = new Model(read_model(path.string()));
    std::filesystem::remove(path);
  }
  static void TearDownTestSuite() {
    delete truth_;
    delete before_;
    delete after_;
  }

  JointSensors slipped() const {
    std::vector<RecordedChannel> shown(3);
    shown[1].position_offset = kSlip;
    return JointSensors(shown);
  }

  static Model *truth_, *before_, *after_;
};
Model* SlippedEncoder::truth_ = nullptr;
Model* SlippedEncoder::before_ = nullptr;
Model* SlippedEncoder::after_ = nullptr;

TEST_F(SlippedEncoder, TheModelHasTheSlipAsAPositionOffset) {
  EXPECT_NEAR(after_->coordinates()[1].recorded.position_offset, kSlip, 0.003);
}

TEST_F(SlippedEncoder, IsCorrectedByAControllerOnTheModel) {
  const VectorXd before = tracking(*truth_, JointSensors(*truth_), *before_, JointSensors(*before_));
  const VectorXd with = tracking(*truth_, slipped(), *after_, JointSensors(*after_));
  const VectorXd without =
      tracking(*truth_, slipped(), *after_, JointSensors(std::vector<RecordedChannel>(3)));
  // The rest is how well the slip is known.
  const double rest = std::abs(after_->coordinates()[1].recorded.position_offset - kSlip);
  RecordProperty("before_mrad", std::to_string(1e3 * before[1]));
  RecordProperty("with_mrad", std::to_string(1e3 * with[1]));
  RecordProperty("without_mrad", std::to_string(1e3 * without[1]));
  EXPECT_LT(with[1], before[1] + rest + 1e-4);
  EXPECT_GT(without[1], 0.9 * kSlip);
  for (const int i : {0, 2}) EXPECT_LT(with[i], 1.2 * before[i] + 1e-5);
}

// Gravity where the arm is, by what the encoders show: on a real arm this is the torque that holds.
TEST_F(SlippedEncoder, CorrectedPositionsReduceTheGravityErrorTenfold) {
  GravityCompensation real(*truth_), hold(*after_);
  const JointSensors known(*after_);
  VectorXd q = Eigen::Vector3d(0.4, 0.5, 0.15);
  const VectorXd needed = real.update(q);
  slipped().add_position_errors(q);
  const double uncorrected = (hold.update(q) - needed).norm();
  known.correct_positions(q);
  const double corrected = (hold.update(q) - needed).norm();
  EXPECT_LT(corrected, 0.1 * uncorrected);
}

}  // namespace
}  // namespace veridyn
