#include <gtest/gtest.h>

#include "diagnosis/findings/right_to_a_name.hpp"
#include "diagnosis/stage_support.hpp"
#include "diagnosis/stages/channel_correction.hpp"

// The list of findings: how many there may be, which are one, and which are fitted with the baseline.

namespace veridyn {
namespace {

class FindingLists : public Stages {
 protected:
  static Model with_wrong_length() {
    ModelFileOptions longer;
    longer.constants["l1"] = 0.6;
    return read_model("planar-2r", longer);
  }

  static Finding channel_error(const std::string& effect, int joint, double value) {
    Finding f;
    f.cause = ChannelError{effect, JointIndex{joint}};
    f.joint = JointIndex{joint};
    f.parameters = {{"", "1", value, value - 0.01, value + 0.01}};
    return f;
  }
};

TEST_F(FindingLists, AConstantCountsAsOneOfTheMostThatMayBeNamed) {
  for (const int most : {0, 1}) {
    DiagnosisState x = investigation(with_wrong_length(), {});
    x.options.max_effects = most;
    correct_constants(x);
    EXPECT_EQ(x.d.findings.size(), static_cast<size_t>(most));
  }
}

// Whether held-out parts confirm plain friction or not, it takes no name's place; nor does a contact.
TEST_F(FindingLists, ContactsAndPlainFrictionAreNoNames) {
  DiagnosisState x = investigation(without_effects(read_model("planar-2r")), {});
  x.options.max_effects = 3;
  begin_tests(x);
  ASSERT_GT(x.d.findings.size(), 0U);
  EXPECT_EQ(x.names_left(), 3);
  x.fitted_by_start.clear();  // as if no part confirmed it
  EXPECT_EQ(x.names_left(), 3);
  x.d.findings.insert(x.d.findings.begin(), Finding());
  x.contacts = 1;
  EXPECT_EQ(x.names_left(), 3);
  x.d.findings.push_back(channel_error("torque_gain", 1, 0.2));
  EXPECT_EQ(x.names_left(), 2);
}

// 20 % and then 10 % more are 32 %; delays of 20 and 10 ms are 30 ms.
TEST_F(FindingLists, WhatAChannelNeedsBesideLaterCausesIsOneErrorWithTheEarlier) {
  std::vector<Finding> gain = {channel_error("torque_gain", 1, 0.2), channel_error("torque_gain", 1, 0.1)};
  merge_corrections(truth_, 1, gain);
  ASSERT_EQ(gain.size(), 1U);
  EXPECT_NEAR(gain[0].parameters[0].value, 0.32, 1e-12);
  EXPECT_NEAR(gain[0].parameters[0].low, 0.31, 1e-12);
  EXPECT_NE(gain[0].phrase.find("32"), std::string::npos) << gain[0].phrase;
  std::vector<Finding> delay = {channel_error("time_delay", 1, 0.02), channel_error("time_delay", 1, 0.01)};
  for (Finding& f : delay) f.parameters[0].unit = "s";
  merge_corrections(truth_, 1, delay);
  ASSERT_EQ(delay.size(), 1U);
  EXPECT_NEAR(delay[0].parameters[0].value, 0.03, 1e-12);
}

// What is not confirmed is in no model: it goes, and the earlier one stays as it was. Of another joint it is no part.
TEST_F(FindingLists, AnUnconfirmedCorrectionChangesNothing) {
  std::vector<Finding> all = {channel_error("torque_gain", 1, 0.2), channel_error("torque_gain", 0, 0.3),
                              channel_error("torque_gain", 1, 0.1)};
  all[2].status = FindingStatus::kNotConfirmed;
  merge_corrections(truth_, 1, all);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].parameters[0].value, 0.2);
  EXPECT_EQ(all[1].joint, JointIndex{0});
}

// Torques of two other joints in one channel are two errors, and a share of one of them says whose it is.
TEST_F(FindingLists, CrosstalkFromAnotherJointIsAnotherError) {
  const Model arm = read_model("psm-3dof");
  std::vector<Finding> all(3, channel_error("torque_crosstalk", 1, 0.1));
  all[0].from = all[2].from = JointIndex{0};
  all[1].from = JointIndex{2};
  merge_corrections(arm, 1, all);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_NEAR(all[0].parameters[0].value, 0.2, 1e-12);
  EXPECT_NE(all[0].phrase.find("0.2 times the torque of joint 'yaw'"), std::string::npos) << all[0].phrase;
  EXPECT_EQ(all[1].from, JointIndex{2});
  EXPECT_NEAR(all[1].parameters[0].value, 0.1, 1e-12);
}

// A joint that is predicted worse is no reason to take a name from another joint that does not touch it.
TEST_F(FindingLists, OfAWorseJointItsOwnNamesGoFirst) {
  const auto named = [](int joint, const Eigen::Vector2d& after) {
    Finding f;
    f.cause = NewEffect{"joint_spring", {joint}};
    f.joint = JointIndex{joint};
    f.folds_before = Eigen::Vector2d(0.5, 0.5);
    f.folds_after = after;
    return f;
  };
  const auto errors = [](double first) {
    FoldErrors out;
    out.error2 = MatrixXd::Ones(4, 2);
    out.error2.col(0).setConstant(first);
    out.torque2 = VectorXd::Ones(2);
    return out;
  };
  Diagnosis d;
  d.findings = {named(1, {0.6, 0.1}), named(1, {0.55, 0.1}), named(0, {0.4, 0.5}), named(0, {0.3, 0.5})};
  const auto lost = [&](const std::set<size_t>& kept) { return worse_with(d, 0, kept, {}, errors(1.0), errors(1.5), {}); };
  ASSERT_TRUE(lost({0, 1, 2, 3}).has_value());
  EXPECT_EQ(lost({0, 1, 2, 3})->finding, 2U);
  EXPECT_EQ(lost({0, 1, 3})->finding, 3U);
  EXPECT_EQ(lost({0, 1})->finding, 0U);  // both cost it, and this one more
  EXPECT_EQ(lost({0, 1})->joint, 0);
  d.findings[1].folds_after[0] = 0.5;
  EXPECT_FALSE(lost({1}).has_value());
  EXPECT_FALSE(worse_with(d, 0, {2}, {2}, errors(1.0), errors(1.5), {}).has_value());
}

// Friction that is fitted with the baseline is no step of the selection: the last step is the spring's, wherever in the
// list the two come to stand.
TEST_F(FindingLists, TheLastStepIsThatOfASelectedCauseWhenOthersAreWithdrawn) {
  DiagnosisState x = investigation(read_model("planar-2r"), {});
  x.d.extended = x.start;
  const auto named = [&](const char* effect, int joint) {
    Finding f;
    f.cause = NewEffect{effect, {joint}};
    f.joint = JointIndex{joint};
    f.folds_before = f.folds_after = x.fold_errors(x.d.extended).relative();
    f.test_before = f.test_after = Eigen::Vector2d(0.5, 0.5);
    return f;
  };
  x.d.findings = {named("viscous_friction", 1), named("coulomb_friction", 1), named("joint_spring", 0)};
  x.d.findings[0].status = FindingStatus::kNotConfirmed;  // and its joint is at its floor: it goes
  x.fitted_by_start[1] = {"level"};
  account_for_errors(x);
  ASSERT_EQ(x.d.findings.size(), 2U);
  EXPECT_EQ(effect_of(x.d.findings[0].cause), "coulomb_friction");
  EXPECT_EQ(x.d.findings[0].test_after, Eigen::Vector2d(0.5, 0.5));
  EXPECT_EQ(x.d.findings[1].test_after, x.d.extended.test_error.relative);
}

}  // namespace
}  // namespace veridyn
