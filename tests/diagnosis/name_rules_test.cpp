#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/candidates/row_constants.hpp"
#include "diagnosis/findings/right_to_a_name.hpp"
#include "diagnosis/shapes/refinement.hpp"
#include "diagnosis/stage_support.hpp"
#include "veridyn/files/model_file.hpp"

// What a name must have to be said, and to be in the model that is written.

namespace veridyn {
namespace {

class NameRules : public Stages {
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

// A length that is 0.1 m wrong counts as one of all constants that were profiled.
TEST_F(NameRules, AConstantMustBeSignificantAmongAllThatWereProfiled) {
  ModelFileOptions longer;
  longer.constants["l1"] = 0.6;
  const Model arm = read_model("planar-2r", longer);
  const auto asked_at = [&](double significance) {
    DiagnosisState x = investigation(arm, {});
    x.options.thresholds.significance = significance;
    correct_constants(x);
    return x.d;
  };
  const Diagnosis refused = asked_at(1e-300);
  EXPECT_TRUE(refused.findings.empty());
  ASSERT_EQ(refused.not_supported.size(), 1U);
  EXPECT_EQ(effect_of(refused.not_supported[0].cause), KinematicError::kName);
  EXPECT_EQ(refused.not_supported[0].why, "its value is not certain enough among so many constants");
  const double p = refused.not_supported[0].p_value;
  const auto constants = static_cast<double>(row_constants(arm).size());
  ASSERT_GT(constants, 2.0);
  EXPECT_TRUE(asked_at(0.9 * constants * p).findings.empty());
  EXPECT_EQ(asked_at(1.1 * constants * p).findings.size(), 1U);
}

Finding force(const char* parameter, double value) {
  Finding f;
  f.cause = NewEffect{"position_force", {0}};
  f.joint = JointIndex{0};
  f.parameters = {{parameter, "N m", value, value - 1.0, value + 1.0}};
  return f;
}

// 11.9 and -12 N m on a joint of 0.43 N m: one goes, and the other is judged by what it is alone.
TEST_F(NameRules, OfAPairThatCancelsOneGoesAndTheOtherIsFittedAlone) {
  Diagnosis d;
  CompressedRecording recording;
  recording.joints.resize(1);
  recording.joints[0].maximum = 0.43;
  d.extended.factors = {recording};
  d.findings = {force("chebyshev_2", 11.9), force("chebyshev_2", -12.0)};
  std::set<size_t> kept = {0, 1};
  const std::optional<LostRight> lost = without_size(d, 0, kept);
  ASSERT_TRUE(lost.has_value());
  EXPECT_NE(lost->why.find("more than the joint's torque ever was"), std::string::npos);
  kept.erase(lost->finding);
  d.findings[*kept.begin()] = force("chebyshev_2", 0.2);
  d.findings[*kept.begin()].parameters[0].low = 0.1;
  EXPECT_FALSE(without_size(d, 0, kept).has_value());
}

// Viscosity that is lower in the first seconds, as rests at the ends of a recording make it.
TEST_F(NameRules, FrictionBelowZeroIsNoWarmUp) {
  DiagnosisOptions options;
  options.effects = {"warm_up"};
  for (const double size : {1.5, -1.5}) {
    const Diagnosis d = diagnosed({}, options, [size](Recording& r) {
      r.tau.col(0).array() += size * r.dq.col(0).array() * (-r.time.array() / 6.0).exp();
    });
    EXPECT_EQ(d.findings.empty(), size < 0.0) << d.report();
  }
}

// With limits that let nearly everything in: terms of the written model that the file has not are confirmed
// findings, each with its effect on its joint, and confirmed findings are in it.
TEST_F(NameRules, TheWrittenModelHasWhatIsConfirmedAndNothingElse) {
  DiagnosisOptions options;
  options.effects = {"joint_spring", "quadratic_drag", "asymmetric_friction", "stribeck_friction", "torque_drift",
                     "rotor_inertia", "sublinear_viscous", "position_force"};
  options.thresholds.significance = 1e3;
  options.thresholds.smallest_gain = options.thresholds.smallest_change = -1.0;
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

FoldErrors errors(const std::vector<double>& of_parts) {
  FoldErrors out;
  out.error2.resize(static_cast<Eigen::Index>(of_parts.size()), 1);
  for (size_t k = 0; k < of_parts.size(); ++k) out.error2(static_cast<Eigen::Index>(k), 0) = of_parts[k];
  out.torque2 = VectorXd::Ones(1);
  return out;
}

TEST_F(NameRules, AJointMayNotBeWorseBeyondItsStandardError) {
  Diagnosis d;
  d.findings = {force("chebyshev_2", 0.1), force("chebyshev_2", 0.1)};
  for (Finding& f : d.findings) f.folds_before = VectorXd::Constant(1, 0.5);
  d.findings[0].folds_after = VectorXd::Constant(1, 0.49);
  d.findings[1].folds_after = VectorXd::Constant(1, 0.3);
  const FoldErrors before = errors({1.0, 1.0, 1.0, 1.0});
  const auto lost = [&](const std::vector<double>& after, const std::set<size_t>& needed) {
    return worse_with(d, 0, {0, 1}, needed, before, errors(after), {});
  };
  const std::vector<double> surely = {1.3, 1.2, 1.3, 1.2};
  ASSERT_TRUE(lost(surely, {}).has_value());
  EXPECT_EQ(lost(surely, {})->finding, 0U);  // what helps the joint least
  EXPECT_EQ(lost(surely, {0})->finding, 1U);
  EXPECT_TRUE(lost({1.7, 0.9, 1.7, 0.9}, {}).has_value());   // 1.3 standard errors of the mean of four
  EXPECT_FALSE(lost({1.9, 0.6, 1.9, 0.6}, {}).has_value());  // 0.7 of them
  EXPECT_FALSE(lost({2.0, 0.2, 2.4, 0.2}, {}).has_value());  // within what differs between parts
  EXPECT_FALSE(lost({0.9, 0.9, 0.9, 0.9}, {}).has_value());
}

TEST_F(NameRules, TheLastStepEndsAtTheErrorOfTheExtendedModel) {
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

// A dead zone of the shoulder's torque channel, which is on no list: names that stand for it are withdrawn.
TEST_F(NameRules, AStepBeginsWhereTheWithdrawnOnesBeforeItBegan) {
  const auto dead_zone = [](Recording& r) {
    const double width = 0.25 * std::sqrt(r.tau.col(0).squaredNorm() / r.rows());
    for (double& tau : r.tau.col(0)) tau = tau > 0.0 ? std::max(0.0, tau - width) : std::min(0.0, tau + width);
  };
  DiagnosisOptions options;
  options.values = RobotValues::kPrior;
  const Diagnosis d = diagnosed({"quadratic_drag:shoulder"}, options, dead_zone);
  ASSERT_TRUE(std::any_of(d.remarks.begin(), d.remarks.end(), [](const std::string& s) {
    return s.find("Withdrawn") != std::string::npos;
  })) << d.report();
  const auto drag = std::find_if(d.findings.begin(), d.findings.end(), [](const Finding& f) {
    return effect_of(f.cause) == "quadratic_drag";
  });
  ASSERT_NE(drag, d.findings.end()) << d.report();
  EXPECT_EQ(drag->test_before, d.baseline.test_error.relative);
  EXPECT_EQ(drag->test_after, d.extended.test_error.relative);
  // The larger part of the error has no name, and the verdict says so.
  EXPECT_NE(d.verdict().find("has no name"), std::string::npos) << d.verdict();
}

TEST_F(NameRules, SentencesSayWhereACableComesFromAndAlongWhatFrictionActs) {
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

// Delays that differ from joint to joint are what friction with a memory looks like to first order.
TEST_F(NameRules, AMemoryOfFrictionIsNoDelayOfOneJoint) {
  DiagnosisOptions options;
  options.effects = {"time_delay", "presliding_hysteresis", "backlash"};
  const Diagnosis d = diagnosed({"presliding_hysteresis:shoulder:level=3,distance=0.1"}, options);
  ASSERT_FALSE(d.findings.empty());
  EXPECT_EQ(effect_of(d.findings.front().cause), "presliding_hysteresis") << d.report();
  for (const Finding& f : d.findings) EXPECT_NE(effect_of(f.cause), "time_delay") << d.report();
}

// The distance that one half of the recordings gives lies in the interval of the other half.
TEST_F(NameRules, TheIntervalOfADistanceHoldsWhatTheOtherHalfGives) {
  const auto found = [&](const std::vector<unsigned>& seeds) {
    DiagnosisState x{read_model("planar-2r"), {}, {}, {}, {}, {}, 0, {}, {}, {}};
    for (const unsigned k : seeds) x.train.push_back(record(k, {"presliding_hysteresis:shoulder:level=1.5,distance=0.04"}));
    x.options.identification.threads = 1;
    x.options.max_effects = 1;
    EXPECT_TRUE(fit_baseline(x));
    CandidateList list = x.list();
    list.wanted = {"presliding_hysteresis"};
    const CandidateTests asked = prepare_tests(x, list, x.start);
    Selection selection = select_effects(asked.data, asked.q.base, asked.q.augmented.hypotheses, x.options, {});
    EXPECT_EQ(selection.accepted.size(), 1U);
    const Fit fit = fit_accepted(x.start, asked.q, selection, false, x.train, {}, x.options);
    const double distance = term_of(fit.candidate_data.augmented.model, fit.candidate_data.augmented.hypotheses[0]).values.at("distance");
    EXPECT_EQ(fit.selection.shapes.size(), 1U);
    return std::make_pair(distance, fit.selection.shapes.at(0));
  };
  const auto [one, of_one] = found({1, 2});
  const auto [two, of_two] = found({3, 4});
  EXPECT_LT(of_one.low, two);
  EXPECT_GT(of_one.high, two);
  EXPECT_LT(of_two.low, one);
  EXPECT_GT(of_two.high, one);
  EXPECT_LT(of_one.high / of_one.low, 10.0);  // and it is no interval of everything
}

Finding named(const std::string& effect, int joint) {
  Finding f;
  f.cause = NewEffect{effect, {joint}};
  f.joint = JointIndex{joint};
  return f;
}

bool is_found(const Diagnosis& d, const std::string& effect) {
  return std::any_of(d.findings.begin(), d.findings.end(), [&](const Finding& f) { return effect_of(f.cause) == effect; });
}

TEST_F(NameRules, AContradictedNameGoesFromAJointAtItsFloor) {
  DiagnosisState x = investigation(read_model("planar-2r"), {});
  x.d.extended = x.start;
  x.d.findings = {named("joint_spring", 1), named("quadratic_drag", 0)};
  for (Finding& f : x.d.findings) f.folds_before = f.folds_after = x.fold_errors(x.d.extended).relative();
  x.d.findings[0].status = FindingStatus::kNotConfirmed;
  account_for_errors(x);
  ASSERT_EQ(x.d.joints.size(), 2U);
  ASSERT_EQ(x.d.joints[1].state, JointState::kAtFloor);
  EXPECT_FALSE(is_found(x.d, "joint_spring"));
  EXPECT_TRUE(is_found(x.d, "quadratic_drag"));  // the parts do not contradict it
  ASSERT_FALSE(x.d.not_supported.empty());
  EXPECT_EQ(effect_of(x.d.not_supported[0].cause), "joint_spring");
  EXPECT_NE(x.d.not_supported[0].why.find("its joint is at its floor"), std::string::npos);
}

// The elbow's amplifier passes nothing below 1.5 N m. Friction that grows with the load takes a part of that; curves
// over the same torque take more.
TEST_F(NameRules, ANameThatCurvesWithoutNamesSurpassGoes) {
  DiagnosisState x{read_model("planar-2r"), {}, {}, {}, {}, {}, 0, {}, {}, {}};
  for (unsigned k = 1; k <= 5; ++k) {
    const std::string file = record(k, {});
    Recording r = read_recording(file);
    for (double& t : r.tau.col(1)) t = std::copysign(std::max(0.0, std::abs(t) - 1.5), t);
    write_recording(r, file);
    (k < 5 ? x.train : x.test).push_back(file);
  }
  x.options.identification.threads = 1;
  ASSERT_TRUE(fit_baseline(x));
  ModelDescription with = x.arm.description();
  EffectTerm term;
  term.effect = "load_dependent_friction";
  term.axis.coefficients = VectorXd::Unit(2, 1);
  with.effects.push_back(term);
  x.d.extended = x.fit(Model(std::move(with)));
  ASSERT_TRUE(x.d.extended.model);
  Finding f = named("load_dependent_friction", 1);
  f.folds_before = x.fold_errors(x.start).relative();
  f.folds_after = x.fold_errors(x.d.extended).relative();
  x.d.findings = {f};
  account_for_errors(x);
  ASSERT_TRUE(is_found(x.d, "load_dependent_friction")) << x.d.report();
  test_names_together(x);
  EXPECT_FALSE(is_found(x.d, "load_dependent_friction")) << x.d.report();
  EXPECT_TRUE(std::any_of(x.d.findings.begin(), x.d.findings.end(), [](const Finding& c) {
    return c.shape && c.joint->value == 1 && c.shape->signals.front() == "tau2";
  })) << x.d.report();
  EXPECT_TRUE(std::any_of(x.d.not_supported.begin(), x.d.not_supported.end(), [](const NotSupported& n) {
    return effect_of(n.cause) == "load_dependent_friction" && n.why.find("without any name") != std::string::npos;
  }));
}

TEST_F(NameRules, AWrongConstantMustShowWhereTheErrorIsExplained) {
  Finding f;
  f.cause = ChannelError{"encoder_offset", JointIndex{0}};
  f.joint = JointIndex{0};
  f.folds_before = Eigen::Vector3d(0.05, 0.05, 0.3);
  f.folds_after = Eigen::Vector3d(0.05, 0.05, 0.1);
  EXPECT_NE(why_doubted({}, f, {2}).find("shows most on joints"), std::string::npos);
  EXPECT_EQ(why_doubted({}, f, {}), "");   // every joint is at its floor
  EXPECT_EQ(why_doubted({}, f, {1}), "");  // it shows on joint 3, which is explained
  f.folds_after[0] = 0.01;  // and more on joint 1 than on joint 3
  EXPECT_EQ(why_doubted({}, f, {2}), "");
}

TEST_F(NameRules, ACableFromAJointThatDependsOnItsEndIsDoubted) {
  Diagnosis d;
  ModelDescription arm = read_model("planar-2r").description();
  EffectTerm term;
  term.effect = "cable_coupling";
  term.axis.coefficients = VectorXd::Unit(2, 1);
  term.from = Axis{VectorXd::Unit(2, 0), 0.0};
  arm.effects.push_back(term);
  d.extended.model = Model(std::move(arm));
  const Finding cable = named("cable_coupling", 1);
  Finding curve = named(UnnamedShape::kName, 0);
  curve.shape = UnnamedShape();
  curve.shape->signals = {"q1", "dq1"};
  d.findings = {cable, curve};
  EXPECT_EQ(why_doubted(d, cable, {0}), "");
  d.findings[1].shape->signals = {"q1", "q2"};
  EXPECT_NE(why_doubted(d, cable, {0}).find("one cause acts on both"), std::string::npos);
  EXPECT_EQ(why_doubted(d, named("joint_spring", 1), {0}), "");
}

TEST_F(NameRules, WhatIsNotAskedIsNoCandidate) {
  DiagnosisState x = investigation(read_model("planar-2r"), {});
  const Cause spring = NewEffect{"joint_spring", {1}};
  ASSERT_TRUE(x.tests_cause(spring));
  x.not_asked = {to_text(x.arm, spring)};
  EXPECT_FALSE(x.tests_cause(spring));
  EXPECT_TRUE(x.tests_cause(NewEffect{"joint_spring", {0}}));
}

}  // namespace
}  // namespace veridyn
