#include <gtest/gtest.h>

#include "diagnosis/search/base.hpp"
#include "diagnosis/search/numbers.hpp"
#include "diagnosis/search/search.hpp"
#include "diagnosis/two_joint_arm.hpp"
#include "veridyn/identification/base_parameters.hpp"

// What changed since a MODEL, on a simulated arm of two joints whose truth is known.

namespace veridyn {
namespace {

class Changes : public TwoJointArm {
 protected:
  // A MODEL of four recordings of the arm as it is, from a robot file with these values.
  Model model_of(ModelDescription file) const {
    std::vector<std::string> before;
    for (unsigned k = 1; k <= 4; ++k) before.push_back(record(k, {}));
    file.values = RobotValues::kPrior;
    const Identification fit = identify(Model(std::move(file)), before);
    EXPECT_TRUE(fit.model.has_value()) << fit.reason;
    return fit.model.value();
  }

  // Four recordings after the change, and one held out.
  Diagnosis since(const Model& model, const std::vector<std::string>& hidden, const std::vector<std::string>& effects) const {
    std::vector<std::string> train;
    for (unsigned k = 5; k <= 8; ++k) train.push_back(record(k, hidden));
    DiagnosisOptions options;
    options.effects = effects;
    options.identification.threads = 1;
    return diagnose(model, train, {record(9, hidden)}, options);
  }

  // A motion of an arm of three joints.
  std::string recorded(unsigned seed, const std::string& hidden = "") const {
    MotionSamples m{VectorXd::LinSpaced(3000, 0.0, 29.99), MatrixXd::Zero(3000, 3), MatrixXd::Zero(3000, 3), MatrixXd::Zero(3000, 3)};
    const double middle[3] = {0.0, 0.1, 0.12}, size[3] = {0.35, 0.25, 0.03};
    for (int i = 0; i < 3; ++i) {
      m.q.col(i).setConstant(middle[i]);
      for (const double w : {0.9 + 0.13 * seed, 2.1 + 0.1 * i, 3.7}) {
        const Eigen::ArrayXd angle = w * m.time.array() + 1.7 * seed + i;
        m.q.col(i).array() += size[i] * angle.sin();
        m.dq.col(i).array() += size[i] * w * angle.cos();
        m.ddq.col(i).array() -= size[i] * w * w * angle.sin();
      }
    }
    SimulationOptions options;
    if (!hidden.empty()) options.hidden = {parse_hidden_effect(hidden)};
    options.noise = sensor_noise("low");
    options.seed = seed;
    const std::string path = folder_.path("psm" + std::to_string(seed) + ".csv");
    write_recording(recording_of(simulate_recording(truth_, m, options)), path);
    return path;
  }

  static ModelDescription with_gravity(const Model& arm, const Eigen::Vector3d& gravity) {
    ModelDescription d = arm.description();
    d.gravity = gravity;
    return d;
  }
};

// On an upright arm no torque depends on the first moments of the first link: a MODEL has those of its file, here false ones.
TEST_F(Changes, MomentsVisibleOnlyUnderALeanAreNoLoad) {
  const Model leaning(with_gravity(truth_, {0.25, -0.15, -9.8}));
  ModelDescription upright = with_gravity(truth_, {0.0, 0.0, -9.81});
  truth_ = Model(upright);
  Frame& first = upright.frames[truth_.bodies().front().value];
  first.body->phi->segment<3>(1) *= 0.3;
  const Model model = model_of(upright);
  truth_ = leaning;
  const Diagnosis d = since(model, {}, {"gravity_tilt", "payload"});
  ASSERT_EQ(d.findings.size(), 1U) << d.report();
  EXPECT_EQ(effect_of(d.findings[0].cause), "gravity_tilt");
}

// A periodic motion with as much noise in training as before, and twice as much in the held-out recording: its error is above
// the floor, those of the training recordings are not.
TEST_F(Changes, NoiseOfAHeldOutRecordingIsNoChange) {
  const auto periodic = [this](unsigned seed, double noise) {
    MotionSamples m = waves(2, 0.0);
    for (int i = 0; i < 2; ++i) {
      for (int k = 1; k <= 4; ++k) {
        const double w = 0.6 * M_PI * k;
        const Eigen::ArrayXd angle = w * m.time.array() + 1.7 * k * seed + i;
        m.q.col(i).array() += 0.3 * angle.sin();
        m.dq.col(i).array() += 0.3 * w * angle.cos();
        m.ddq.col(i).array() -= 0.3 * w * w * angle.sin();
      }
    }
    SimulationOptions options;
    options.noise = sensor_noise("low");
    options.seed = seed;
    Recording r = recording_of(simulate_recording(truth_, m, options));
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    for (Eigen::Index i = 0; i < r.tau.cols(); ++i) {
      const double size = noise * r.tau.col(i).norm() / std::sqrt(static_cast<double>(r.tau.rows()));
      for (Eigen::Index k = 0; k < r.tau.rows(); ++k) r.tau(k, i) += size * normal(random);
    }
    const std::string path = folder_.path("periodic" + std::to_string(seed) + ".csv");
    write_recording(r, path);
    return path;
  };
  ModelDescription file = truth_.description();
  file.values = RobotValues::kPrior;
  const Identification before = identify(Model(std::move(file)), {periodic(1, 0.02), periodic(2, 0.02), periodic(3, 0.02), periodic(4, 0.02)});
  ASSERT_TRUE(before.model.has_value()) << before.reason;
  const Diagnosis d = diagnose(*before.model, {periodic(5, 0.02), periodic(6, 0.02), periodic(7, 0.02)}, {periodic(8, 0.04)});
  ASSERT_EQ(d.baseline.noise_floor.size(), 2) << d.report();
  for (int i = 0; i < 2; ++i) EXPECT_GT(d.baseline.test_error.relative[i], search::kAtFloor * d.baseline.noise_floor[i]) << d.report();
  EXPECT_EQ(d.verdict(), "nothing has changed") << d.report();
}

// The same of a robot file: under the lean these moments are base parameters, too. Without them their torque would be friction.
TEST_F(Changes, ALeaningBaseIsAllThatARobotFileLacks) {
  const Model leaning(with_gravity(truth_, {2.0, -1.2, -9.5}));
  ModelDescription upright = with_gravity(truth_, {0.0, 0.0, -9.81});
  upright.values = RobotValues::kPrior;
  Frame& first = upright.frames[truth_.bodies().front().value];
  first.body->phi->segment<3>(1) *= -1.0;
  ASSERT_GT(base_parameters(leaning).size(), base_parameters(Model(upright)).size());
  truth_ = leaning;
  std::vector<std::string> train;
  for (unsigned k = 1; k <= 4; ++k) train.push_back(record(k, {}));
  DiagnosisOptions options;
  options.identification.threads = 1;
  const Diagnosis d = diagnose(Model(upright), train, {record(5, {})}, options);
  ASSERT_EQ(d.findings.size(), 1U) << d.report();
  EXPECT_EQ(effect_of(d.findings[0].cause), "gravity_tilt");
  ASSERT_TRUE(d.extended.model);
  EXPECT_LT((d.extended.model->gravity() - leaning.gravity()).norm(), 0.1) << d.report();
}

// The MODEL's own level could move as far, at a cost: the change saves this cost and leaves the error of the torque the same.
TEST_F(Changes, ALevelOfFrictionThatChangedIsNamed) {
  const Model model = model_of(truth_.description());
  const std::vector<std::pair<const char*, std::vector<double>>> levels = {{"coulomb_friction:1:level=", {0.7, 1.4, -0.6}},
                                                                           {"coulomb_friction:2:level=", {0.35, 0.7, -0.4}}};
  for (const auto& [change, sizes] : levels) {
    for (const double size : sizes) {
      const Diagnosis d = since(model, {change + std::to_string(size)}, {});
      ASSERT_FALSE(d.findings.empty()) << change << size << "\n" << d.report();
      EXPECT_EQ(to_text(truth_, d.findings[0].cause).rfind("coulomb_friction:", 0), 0U) << change << size << "\n" << d.report();
      EXPECT_NEAR(d.findings[0].parameters.front().value, size, 0.1 * std::abs(size)) << change << size;
    }
  }
}

// One column was written twice. Curves over the torques take the whole error, and what is left of a name beside them may be zero.
TEST_F(Changes, WhatMayBeZeroIsNoFinding) {
  truth_ = plausible_model(read_model("scara"), 3).arm;
  const auto recorded = [&](unsigned seed) {
    MotionSamples m{VectorXd::LinSpaced(1500, 0.0, 29.98), MatrixXd::Zero(1500, 4), MatrixXd::Zero(1500, 4), MatrixXd::Zero(1500, 4)};
    for (int i = 0; i < 4; ++i) {
      const double size = truth_.coordinates()[i].prismatic ? 0.03 : 0.3;
      for (const double w : {0.9 + 0.13 * seed, 2.1 + 0.1 * i, 3.7}) {
        const Eigen::ArrayXd angle = w * m.time.array() + 1.7 * seed + i;
        m.q.col(i).array() += size * angle.sin();
        m.dq.col(i).array() += size * w * angle.cos();
        m.ddq.col(i).array() -= size * w * w * angle.sin();
      }
    }
    SimulationOptions options;
    options.noise = sensor_noise("low");
    options.seed = seed;
    Recording r = recording_of(simulate_recording(truth_, m, options));
    r.source = "recording " + std::to_string(seed);
    return r;
  };
  const Identification fit = identify(truth_, Recordings{recorded(1), recorded(2), recorded(3)});
  ASSERT_TRUE(fit.model) << fit.reason;
  for (const auto& [from, to] : {std::pair(0, 2), std::pair(2, 1)}) {
    std::vector<Recording> all;
    for (unsigned k = 4; k <= 7; ++k) {
      all.push_back(recorded(k));
      all.back().tau.col(to) = all.back().tau.col(from);
    }
    DiagnosisOptions options;
    options.identification.threads = 1;
    const Diagnosis d = diagnose(*fit.model, {all[0], all[1], all[2]}, all[3], options);
    EXPECT_FALSE(d.findings.empty());
    for (const Finding& f : d.findings) {
      const bool is_something = std::any_of(f.parameters.begin(), f.parameters.end(), [](const FoundParameter& p) { return p.low > 0.0 || p.high < 0.0; });
      EXPECT_TRUE(f.shape || is_something) << d.report();
    }
  }
}

// Friction does not drive a joint: no level falls below zero.
TEST_F(Changes, NoFrictionChangesItsSign) {
  const Model model = model_of(truth_.description());
  const EffectTerm& own = model.effects().front();
  const double level = own.values.at(find_effect(own.effect).parameters().front().name);
  const Diagnosis d = since(model, {own.effect + ":1:" + find_effect(own.effect).parameters().front().name + "=" + std::to_string(-1.5 * level)}, {});
  for (const Finding& f : d.findings) {
    if (!std::holds_alternative<ChangedEffect>(f.cause) || effect_of(f.cause) != own.effect) continue;
    EXPECT_GE(level + f.parameters.front().value, -1e-6 * level) << d.report();
  }
}

// Ten free parameters of a load hold masses far from the truth whose torques are nearly the same, also negative ones: a load is
// a point mass of a possible inertia, on that one of the links that move alike which is nearest.
TEST_F(Changes, ALoadIsAMassNearItsLink) {
  truth_ = plausible_model(read_model("psm-3dof"), 3).arm;
  const std::string wrist = "wrist";
  const Identification fit = identify(truth_, {recorded(1, ""), recorded(2, ""), recorded(3, "")});
  ASSERT_TRUE(fit.model) << fit.reason;
  const std::string load = "payload:" + wrist + ":mass=0.15,x=0.02,y=-0.04,z=-0.04";
  DiagnosisOptions options;
  options.identification.threads = 1;
  const Diagnosis d = diagnose(*fit.model, {recorded(4, load), recorded(5, load)}, {recorded(6, load)}, options);
  ASSERT_FALSE(d.findings.empty());
  const Finding& found = d.findings.front();
  ASSERT_TRUE(std::holds_alternative<AddedLoad>(found.cause)) << d.report();
  EXPECT_EQ(truth_.frames()[frame_of(found.cause)->value].name, wrist) << d.report();
  ASSERT_EQ(found.parameters.front().name, "mass") << d.report();
  EXPECT_NEAR(found.parameters.front().value, 0.15, 0.05) << d.report();
  EXPECT_LE(found.parameters.front().low, 0.15);
  EXPECT_GE(found.parameters.front().high, 0.15);
}

TEST(SearchLoads, ALoadHasAMassOrAMomentThatDiffersFromZero) {
  VectorXd z = VectorXd::Zero(10), deviations = VectorXd::Ones(10);
  z[0] = 1.0;
  z.segment<3>(1) = Eigen::Vector3d(0.03, 0.04, 1.0);
  deviations.segment<3>(1) = Eigen::Vector3d(0.01, 0.01, 3.0);  // torques do not see the third moment
  EXPECT_TRUE(search::is_load(z, deviations, 2.0));
  deviations.segment<2>(1).setConstant(0.03);
  EXPECT_FALSE(search::is_load(z, deviations, 2.0));
  deviations[0] = 0.4;
  EXPECT_TRUE(search::is_load(z, deviations, 2.0));
}

// Two values with nearly opposite torques, as an offset and a weight over a small range: a MODEL knows neither well, but their
// sum. What their covariance adds to their scatter is noise of torque, however large they scatter themselves.
TEST(ModelCovariance, AddsNoMoreToTheTorqueThanAShareOfItsScatter) {
  for (const double apart : {1.0, 1e-2, 1e-6}) {
    Eigen::Matrix2d G;
    G << 1.0, apart - 1.0, apart - 1.0, 1.0;
    const Eigen::Vector2d F(15.0, 15.0);
    const Eigen::Matrix2d C = search::covariance_of(F, G);
    const double scatter = F.dot(G * F);
    EXPECT_GE((G * C).trace(), scatter);
    EXPECT_LE((G * C).trace(), (1.0 + search::kNoisePart) * scatter * (1.0 + 1e-9)) << apart;
    EXPECT_LE(C(0, 0), (1.0 + search::kUncorrelatedPart) * F[0] * F[0] * (1.0 + 1e-9));
  }
}

}  // namespace
}  // namespace veridyn
