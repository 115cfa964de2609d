#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/two_joint_arm.hpp"
#include "veridyn/files/model_file.hpp"

// Conditions on a finding, and on the model that is written.

namespace veridyn {
namespace {

class NameRules : public TwoJointArm {
 protected:
  Diagnosis diagnosed(const std::vector<std::string>& hidden, DiagnosisOptions options,
                      const std::function<void(Recording&)>& change = {}) const {
    std::vector<std::string> files;
    for (unsigned k = 1; k <= 5; ++k) {
      files.push_back(record(k, hidden));
      if (!change) continue;
      Recording r = read_recording(files.back());
      change(r);
      write_recording(r, files.back());
    }
    options.identification.threads = 1;
    const std::string test = files.back();
    files.pop_back();
    return diagnose(read_model("planar-2r"), files, {test}, options);
  }

  static bool has(const Model& arm, const std::string& effect, int joint) {
    return std::any_of(arm.effects().begin(), arm.effects().end(), [&](const EffectTerm& e) {
      return e.effect == effect && e.axis.coefficients[joint] != 0.0;
    });
  }
};

// Rests at the ends of a recording look like a viscosity that is lower in the first seconds.
TEST_F(NameRules, NegativeFrictionIsNoWarmUp) {
  DiagnosisOptions options;
  options.effects = {"warm_up"};
  for (const double size : {1.5, -1.5}) {
    const Diagnosis d = diagnosed({}, options, [size](Recording& r) {
      r.tau.col(0).array() += size * r.dq.col(0).array() * (-r.time.array() / 6.0).exp();
    });
    EXPECT_EQ(d.findings.empty(), size < 0.0) << d.report();
  }
}

// The effects of the written model beyond those of the file are the confirmed findings.
TEST_F(NameRules, TheWrittenModelContainsTheConfirmedFindingsAndNothingElse) {
  DiagnosisOptions options;
  options.effects = {"joint_spring", "quadratic_drag", "asymmetric_friction", "stribeck_friction", "torque_drift",
                     "rotor_inertia", "sublinear_viscous", "position_force"};
  options.max_effects = 12;
  const Model file = read_model("planar-2r");
  const Diagnosis d = diagnosed({"joint_spring:elbow:stiffness=4"}, options);
  const auto confirmed = [&d](const std::string& effect, int joint) {
    return std::any_of(d.findings.begin(), d.findings.end(), [&](const Finding& f) {
      return f.status == FindingStatus::kConfirmed && effect_of(f.cause) == effect && f.joint == JointIndex{joint};
    });
  };
  const Model& written = *d.extended.model;
  EXPECT_GT(written.effects().size(), file.effects().size());
  for (const EffectTerm& term : written.effects()) {
    for (int j = 0; j < 2; ++j) {
      if (term.axis.coefficients[j] == 0.0 || has(file, term.effect, j)) continue;
      EXPECT_TRUE(confirmed(term.effect, j)) << term.effect << "\n" << d.report();
    }
  }
  for (const Finding& f : d.findings) {
    if (!std::holds_alternative<NewEffect>(f.cause) || f.shape) continue;
    EXPECT_EQ(has(written, effect_of(f.cause), f.joint->value), f.status == FindingStatus::kConfirmed) << d.report();
  }
}

TEST_F(NameRules, TheErrorAfterTheLastFindingIsThatOfTheExtendedModel) {
  DiagnosisOptions options;
  options.effects = {"joint_spring", "quadratic_drag", "presliding_hysteresis"};
  const Diagnosis d = diagnosed({"joint_spring:elbow:stiffness=4", "presliding_hysteresis:shoulder:level=3,distance=0.04"}, options);
  std::vector<Finding> named;
  std::copy_if(d.findings.begin(), d.findings.end(), std::back_inserter(named),
               [](const Finding& f) { return !f.shape && f.status == FindingStatus::kConfirmed; });
  ASSERT_GE(named.size(), 2U) << d.report();
  EXPECT_TRUE(std::any_of(named.begin(), named.end(), [&d](const Finding& f) {
    return (f.test_after - d.extended.test_error.relative).norm() < 1e-9;
  })) << d.report();
}

// A dead zone of the shoulder's torque channel is no cause of the dictionary.
TEST_F(NameRules, TheVerdictStatesThatMostOfTheErrorIsUnnamed) {
  const auto dead_zone = [](Recording& r) {
    const double width = 0.25 * std::sqrt(r.tau.col(0).squaredNorm() / r.rows());
    for (double& tau : r.tau.col(0)) tau = tau > 0.0 ? std::max(0.0, tau - width) : std::min(0.0, tau + width);
  };
  DiagnosisOptions options;
  options.values = RobotValues::kPrior;
  const Diagnosis d = diagnosed({"quadratic_drag:elbow:coefficient=0.05"}, options, dead_zone);
  ASSERT_EQ(d.findings.size(), 2U) << d.report();
  EXPECT_EQ(effect_of(d.findings[0].cause), "quadratic_drag");
  EXPECT_EQ(d.findings[0].joint, JointIndex{1});
  EXPECT_TRUE(d.findings[1].shape) << d.report();
  EXPECT_NE(d.verdict().find("has no name"), std::string::npos) << d.verdict();
}

TEST_F(NameRules, SentencesNameTheSourceOfACableAndTheSignalOfFriction) {
  const Model arm = read_model("planar-2r");
  EffectTerm term;
  term.effect = "cable_coupling";
  term.axis.coefficients = VectorXd::Unit(2, 1);
  term.from = Axis{VectorXd::Unit(2, 0), 0.0};
  EXPECT_EQ(BoundEffect(arm, term).phrase({0.1, 0.0, 0.2}).find("a cable from joint 1: "), 0U);
  term.effect = "viscous_friction";
  term.from.reset();
  EXPECT_EQ(BoundEffect(arm, term).phrase({0.1}).find(" along "), std::string::npos);
  term.axis.coefficients << 1.0, -0.5;
  const std::string text = BoundEffect(arm, term).phrase({0.1});
  EXPECT_EQ(text.substr(text.find(" along ")), " along joint 1 - 0.5 joint 2");
}

// To first order presliding looks like delays that differ from joint to joint.
TEST_F(NameRules, PreslidingIsNotNamedAsADelay) {
  DiagnosisOptions options;
  options.effects = {"time_delay", "presliding_hysteresis", "backlash"};
  const Diagnosis d = diagnosed({"presliding_hysteresis:shoulder:level=3,distance=0.1"}, options);
  ASSERT_FALSE(d.findings.empty());
  EXPECT_EQ(effect_of(d.findings.front().cause), "presliding_hysteresis") << d.report();
  for (const Finding& f : d.findings) EXPECT_NE(effect_of(f.cause), "time_delay") << d.report();
}

TEST_F(NameRules, TheIntervalOfADistanceContainsTheEstimateFromOtherRecordings) {
  const auto found = [&](const std::vector<unsigned>& seeds) {
    std::vector<std::string> train;
    for (const unsigned k : seeds) train.push_back(record(k, {"presliding_hysteresis:shoulder:level=1.5,distance=0.04"}));
    DiagnosisOptions options;
    options.identification.threads = 1;
    options.effects = {"presliding_hysteresis"};
    options.max_effects = 1;
    const Diagnosis d = diagnose(read_model("planar-2r"), train, train, options);
    EXPECT_EQ(d.findings.size(), 1U) << d.report();
    for (const FoundParameter& p : d.findings.at(0).parameters) {
      if (p.name == "distance") return p;
    }
    ADD_FAILURE() << d.report();
    return FoundParameter();
  };
  const FoundParameter one = found({1, 2}), two = found({3, 4});
  EXPECT_LT(one.low, two.value);
  EXPECT_GT(one.high, two.value);
  EXPECT_LT(two.low, one.value);
  EXPECT_GT(two.high, one.value);
  EXPECT_LT(one.high / one.low, 10.0);  // and it is no interval of everything
}

}  // namespace
}  // namespace veridyn
