#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/search/explain.hpp"
#include "diagnosis/search/current_set.hpp"
#include "diagnosis/two_joint_arm.hpp"
#include "veridyn/files/model_file.hpp"

// The search of a diagnosis: hidden causes are named, and nothing is named if nothing is hidden.

namespace veridyn {
namespace {

class OneSearch : public TwoJointArm {
 protected:
  OneSearch() : bare_(as_prior(read_model("planar-2r"))) {}

  // The robot file without values.
  static Model as_prior(const Model& arm) {
    ModelDescription d = arm.description();
    d.values = RobotValues::kPrior;
    return Model(std::move(d));
  }

  std::vector<std::string> recorded(unsigned first, const std::vector<std::string>& hidden) const {
    std::vector<std::string> out;
    for (unsigned k = first; k < first + 4; ++k) out.push_back(record(k, hidden));
    return out;
  }

  Diagnosis diagnosed(const Model& robot, const std::vector<std::string>& hidden, unsigned first = 1) const {
    const std::vector<std::string> all = recorded(first, hidden);
    DiagnosisOptions options;
    options.identification.threads = 1;
    return diagnose(robot, {all[0], all[1], all[2]}, {all[3]}, options);
  }

  // A MODEL of the arm.
  Model model() const {
    const std::vector<std::string> all = recorded(21, {});
    const Identification id = identify(bare_, all);
    EXPECT_TRUE(id.model.has_value()) << id.reason;
    return *id.model;
  }

  void change(const std::function<void(ModelDescription&)>& how) {
    ModelDescription d = truth_.description();
    how(d);
    truth_ = Model(std::move(d));
  }

  // More or less mass on the last body, at the origin of its frame.
  void load(double mass) {
    change([mass](ModelDescription& d) {
      for (auto frame = d.frames.rbegin(); frame != d.frames.rend(); ++frame) {
        if (!frame->body) continue;
        frame->body->phi = *frame->body->phi + mass * inertial_parameters(1.0, {0.05, 0.0, 0.0}, Eigen::Matrix<double, 6, 1>::Zero());
        return;
      }
    });
  }

  static const Finding* find(const Diagnosis& d, const std::string& effect) {
    const auto at = std::find_if(d.findings.begin(), d.findings.end(), [&](const Finding& f) { return effect_of(f.cause) == effect; });
    return at == d.findings.end() ? nullptr : &*at;
  }
  static const FoundParameter& parameter(const Finding& f, const std::string& name) {
    return *std::find_if(f.parameters.begin(), f.parameters.end(), [&](const FoundParameter& p) { return p.name == name; });
  }

  Model bare_;
};

TEST_F(OneSearch, FindsNothingIfNothingIsHidden) {
  const Diagnosis d = diagnosed(bare_, {});
  EXPECT_TRUE(d.findings.empty()) << d.report();
  for (const JointVerdict& v : d.joints) EXPECT_EQ(v.state, JointState::kAtFloor) << d.report();
  EXPECT_EQ(d.verdict(), "none");
}

TEST_F(OneSearch, FindsASpringWithItsStiffnessAndNothingElse) {
  const Diagnosis d = diagnosed(bare_, {"joint_spring:elbow:stiffness=4"});
  ASSERT_EQ(d.findings.size(), 1U) << d.report();
  const FoundParameter& stiffness = parameter(d.findings[0], "stiffness");
  EXPECT_EQ(effect_of(d.findings[0].cause), "joint_spring") << d.report();
  EXPECT_EQ(d.findings[0].joint, JointIndex{1});
  EXPECT_LT(stiffness.low, 4.0);
  EXPECT_GT(stiffness.high, 4.0);
  EXPECT_LT(d.extended.test_error.relative[1], 0.5 * d.baseline.test_error.relative[1]);
}

// The true constant lies between the values of the grid.
TEST_F(OneSearch, RefinesAShapeConstantBetweenTheGridValues) {
  const Diagnosis d = diagnosed(bare_, {"presliding_hysteresis:shoulder:level=3,distance=0.037"});
  const Finding* f = find(d, "presliding_hysteresis");
  ASSERT_NE(f, nullptr) << d.report();
  EXPECT_NEAR(parameter(*f, "distance").value, 0.037, 0.005) << d.report();
}

TEST_F(OneSearch, FindsNoChangeOfAnUnchangedArm) {
  const Diagnosis d = diagnosed(model(), {});
  EXPECT_TRUE(d.findings.empty()) << d.report();
  EXPECT_EQ(d.verdict(), "nothing has changed") << d.report();
}

// The extended model contains the load.
TEST_F(OneSearch, FindsALoadOfEitherSignAgainstAModel) {
  const Model before = model();
  for (const double mass : {0.4, -0.4}) {
    const Model as_it_was = truth_;
    load(mass);
    const Diagnosis d = diagnosed(before, {});
    ASSERT_FALSE(d.findings.empty()) << d.report();
    EXPECT_EQ(effect_of(d.findings[0].cause), "payload") << d.report();
    EXPECT_GT(mass * parameter(d.findings[0], "moment").value * (d.findings[0].parameters[0].value), 0.0) << d.report();
    EXPECT_LT(d.extended.test_error.relative.maxCoeff(), 0.5 * d.baseline.test_error.relative.maxCoeff()) << d.report();
    truth_ = as_it_was;
  }
}

// The offset of the MODEL cannot absorb the constant part of a spring.
TEST_F(OneSearch, FindsASpringWithItsRestAngleAgainstAModel) {
  const Model before = model();
  change([](ModelDescription& d) {
    EffectTerm spring;
    spring.effect = "joint_spring";
    spring.axis = {Eigen::Vector2d(0.0, 1.0), -0.3};
    spring.values = {{"stiffness", 5.0}};
    d.effects.push_back(spring);
  });
  const Diagnosis d = diagnosed(before, {});
  ASSERT_EQ(d.findings.size(), 1U) << d.report();
  EXPECT_EQ(effect_of(d.findings[0].cause), "joint_spring") << d.report();
  EXPECT_NEAR(parameter(d.findings[0], "rest").value, 0.3, 0.05) << d.report();
  EXPECT_NEAR(parameter(d.findings[0], "stiffness").value, 5.0, 0.3) << d.report();
}

// The linearisation at the direction of the file does not lead to zero gravity.
TEST_F(OneSearch, FindsTorquesWithoutGravity) {
  ASSERT_GT(truth_.gravity().norm(), 0.0);
  change([](ModelDescription& d) { d.gravity.setZero(); });
  DiagnosisState x = investigation(bare_, {});
  search::SearchRequest request;
  request.recordings = x.train;
  request.periods.assign(x.train.size(), 0.0);
  request.preprocessing = x.options.identification.preprocessing;
  const search::SearchResult found = search::search(*x.start.model, request);
  ASSERT_EQ(found.chosen.size(), 1U);
  EXPECT_EQ(effect_of(found.chosen[0].term.cause), "gravity_tilt");
  ASSERT_TRUE(found.chosen[0].gravity);
  EXPECT_EQ(*found.chosen[0].gravity, Eigen::Vector3d::Zero());
  // A diagnosis names it as a mistake of the set-up and goes on without it.
  const Diagnosis d = diagnosed(bare_, {});
  EXPECT_TRUE(d.mended);
  EXPECT_TRUE(d.findings.empty()) << d.report();
  EXPECT_NE(d.verdict().find("Gravity points along"), std::string::npos) << d.verdict();
  EXPECT_LT(d.extended.test_error.relative.maxCoeff(), 0.1 * x.start.test_error.relative.maxCoeff()) << d.report();
}

// Each cause is summed over its grid.
TEST_F(OneSearch, PriorProbabilitiesOfAllCausesSumToOne) {
  DiagnosisState x = investigation(bare_, {});
  const search::Rows rows(*x.start.model, x.train, x.options.identification.preprocessing);
  const std::vector<search::Term> all = search::dictionary(rows, {});
  std::map<std::string, double> grid, price;
  for (const search::Term& t : all) {
    double polished = 0.0;
    for (const search::TermShape& s : t.shapes) polished += s.fixed ? 0.0 : 1.0;
    grid[t.place] += std::exp(-(t.price - polished));
  }
  double sum = 0.0;
  for (const auto& [place, probability] : grid) sum += probability;
  EXPECT_NEAR(sum, 1.0, 1e-9);
}

using PresentSet = TwoJointArm;

// Columns of effects that follow the motion alone are kept where the arm changes: those of a load, of constants and of gravity
// are not. Another delay or gain of the recorded signals changes all.
TEST_F(PresentSet, HasTheColumnsOfTheArmThatItMovedTo) {
  search::SearchRequest request;
  request.recordings = {record(1, {})};
  request.periods = {0.0};
  search::CurrentSet current(truth_, request);
  const auto evaluate_all = [&] {
    for (std::size_t k = 0; k < current.dictionary().size(); ++k) current.columns_at(k);
  };
  ModelDescription leaning = truth_.description(), scaled = leaning;
  leaning.gravity = {1.0, 2.0, -9.5};
  scaled.coordinates[1].recorded.torque_gain = 1.3;
  evaluate_all();
  for (const ModelDescription& other : {leaning, scaled}) {
    ASSERT_TRUE(current.move_to(Model(other)));
    for (std::size_t k = 0; k < current.dictionary().size(); ++k) {
      const search::Term& term = current.dictionary()[k];
      const search::Columns anew = search::columns_of(term, current.rows()), kept = *current.columns_at(k);
      ASSERT_EQ(kept.joints, anew.joints) << term.place;
      for (std::size_t at = 0; at < anew.of.size(); ++at) EXPECT_TRUE(kept.of[at].isApprox(anew.of[at], 1e-12)) << term.place;
    }
    evaluate_all();
  }
}

}  // namespace
}  // namespace veridyn
