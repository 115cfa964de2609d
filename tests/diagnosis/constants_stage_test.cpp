#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "diagnosis/causes/wrong_constant.hpp"
#include "diagnosis/stage_support.hpp"
#include "veridyn/files/model_file.hpp"

// A wrong constant of the robot file, and the error of a channel that does as much: both must be certain, and borne
// out by held-out parts of the training recordings.

namespace veridyn {
namespace {

class Constants : public Stages {
 protected:
  static Model with_length(double l1) {
    ModelFileOptions other;
    other.constants["l1"] = l1;
    return read_model("planar-2r", other);
  }

  // As investigation(), with noise of 3 % of the torque before it is filtered.
  DiagnosisState noisy(const Model& robot, const std::vector<std::string>& hidden) const {
    DiagnosisState x{robot, {}, {}, {}, {}, {}, 0, {}, {}, {}};
    for (unsigned k = 1; k <= 4; ++k) {
      x.train.push_back(record(k, hidden));
      Recording r = read_recording(x.train.back());
      std::mt19937 random(k);
      std::normal_distribution<double> noise(0.0, 0.03);
      for (int i = 0; i < 2; ++i) {
        const double size = std::sqrt(r.tau.col(i).squaredNorm() / r.rows());
        for (double& torque : r.tau.col(i)) torque += size * noise(random);
      }
      write_recording(r, x.train.back());
    }
    x.options.identification.threads = 1;
    EXPECT_TRUE(fit_baseline(x));
    return x;
  }

  // Errors of x.start on held-out parts become those of another fit.
  static void predict_parts_as(const Identification& other, DiagnosisState& x) {
    x.start.factors = other.factors;
    x.start.parameters = other.parameters;
    ASSERT_LT(x.fold_errors(x.start).relative().maxCoeff(), 0.004);
  }

  static Words lines(const Diagnosis& d) {
    Words out;
    for (const NotSupported& n : d.not_supported) out.push_back(to_text(*d.baseline.model, n.cause) + ": " + n.why);
    return out;
  }
};

// The zero of an encoder in place of an angle is one of all causes that are asked about.
TEST_F(Constants, AChannelInPlaceOfAConstantIsSignificantAmongAllCauses) {
  const auto asked_at = [&](double significance) {
    DiagnosisState x = investigation(read_model("planar-2r"), {"encoder_offset:shoulder:offset=0.1"});
    x.options.thresholds.significance = significance;
    correct_constants(x);
    return x;
  };
  const DiagnosisState sure = asked_at(Thresholds().significance);
  ASSERT_EQ(sure.d.findings.size(), 1U);
  ASSERT_EQ(to_text(sure.arm, sure.d.findings[0].cause), "encoder_offset:shoulder");
  const double p = sure.d.findings[0].p_value;
  std::set<Candidate> causes;
  for (const Hypothesis& h : prepare_tests(sure, sure.list(), sure.d.baseline).q.augmented.hypotheses) causes.insert(h);
  ASSERT_GT(causes.size(), 20U);
  const auto is_named = [&](double significance) {
    const Diagnosis d = asked_at(significance).d;
    return std::any_of(d.findings.begin(), d.findings.end(), [](const Finding& f) { return effect_of(f.cause) == "encoder_offset"; });
  };
  EXPECT_FALSE(is_named(0.9 * p * static_cast<double>(causes.size())));
  EXPECT_TRUE(is_named(1.1 * p * static_cast<double>(causes.size())));
}

constexpr const char* kContradicted = "held-out parts of the training recordings contradict it";

// As if held-out parts were predicted nearly without error as the arm stands: every correction makes them worse.
TEST_F(Constants, AChannelInPlaceOfAConstantIsBorneOutByHeldOutParts) {
  const Identification nearly_without = investigation(read_model("planar-2r"), {}).start;
  DiagnosisState x = noisy(read_model("planar-2r"), {"encoder_offset:shoulder:offset=0.1"});
  predict_parts_as(nearly_without, x);
  DiagnosisState all = x;
  correct_constants(x);
  EXPECT_TRUE(x.d.findings.empty());
  const Words said = lines(x.d);
  EXPECT_EQ(std::count(said.begin(), said.end(), std::string("encoder_offset:shoulder: ") + kContradicted), 1) << testing::PrintToString(said);
  EXPECT_EQ(x.refused.size() + 1, said.size());  // the constant is no question of those that follow
  EXPECT_EQ(x.start.model->coordinates()[0].recorded.position_offset, 0.0);
  all.options.extended = ExtendedModel::kAllFindings;  // who wants all findings hears of it as one that is not confirmed
  correct_constants(all);
  ASSERT_EQ(all.d.findings.size(), 1U);
  EXPECT_EQ(all.d.findings[0].status, FindingStatus::kNotConfirmed);
}

TEST_F(Constants, AConstantThatHeldOutPartsContradictIsALine) {
  Model as_the_file = plausible_model(with_length(0.6), 3).arm;
  std::swap(truth_, as_the_file);
  const Identification nearly_without = investigation(with_length(0.6), {}).start;
  std::swap(truth_, as_the_file);
  DiagnosisState x = noisy(with_length(0.6), {});
  x.options.effects = {KinematicError::kName};
  predict_parts_as(nearly_without, x);
  correct_constants(x);
  EXPECT_TRUE(x.d.findings.empty());
  EXPECT_EQ(lines(x.d), Words{std::string("coupling_error:upper.a: ") + kContradicted});
}

// From one arm to another and back: what is gained is lost again, and the arm itself gains nothing.
TEST_F(Constants, AGainIsTheLossOfTheWayBack) {
  const Model wrong = with_length(0.6);
  const auto gain = [&](const Model& from, const Model& to) {
    DiagnosisState x = investigation(from, {});
    CandidateList list = x.list();
    list.wanted = {"joint_spring"};
    const CandidateTests asked = prepare_tests(x, list, x.start);
    return correction_gain(to, asked.q, asked.data, x.train, x.options);
  };
  const Model right = read_model("planar-2r");
  EXPECT_NEAR(gain(right, right), 0.0, 1e-9);
  const double gained = gain(wrong, right);
  EXPECT_GT(gained, 0.5);
  EXPECT_NEAR(gained, -gain(right, wrong), 1e-6 * gained);
}

}  // namespace
}  // namespace veridyn
