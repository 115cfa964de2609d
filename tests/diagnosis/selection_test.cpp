#include "diagnosis/evidence/selection.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "diagnosis/evidence/examiner.hpp"

// Selection on made-up columns: what is in the torque is known, and so is what only looks like it.

namespace veridyn {
namespace {

constexpr int kRecordings = 4;
constexpr int kBlocks = 8;
constexpr int kRows = 40;
constexpr double kNoise = 0.3;

// Columns of one joint: base, cause, alike (correlated with cause), other (a cause of its own),
// idle, copy (of the base), mixture (of cause and other, less half of idle).
const std::vector<std::string>& names() {
  static const std::vector<std::string> kNames = {"base", "cause", "alike",  "other",
                                                  "idle", "copy",  "mixture"};
  return kNames;
}

class Columns {
 public:
  /// Shares of the columns in the torque; what of `alike` is not `cause`.
  /// `cause` acts in the first recordings alone, as a stop does that the others never touch.
  explicit Columns(std::map<std::string, double> torque, double unlike = 0.45, int acting = kRecordings)
      : torque_(std::move(torque)), unlike_(unlike) {
    for (int r = 0; r < kRecordings; ++r) recordings_.push_back(recording(r < acting ? 1.0 : 0.0));
  }

  NormalBlocks blocks() const { return NormalBlocks(recordings_, names()); }

 private:
  CompressedRecording recording(double size_of_cause) {
    CompressedRecording out;
    out.joints.resize(1);
    for (int b = 0; b < kBlocks; ++b) {
      MatrixXd A(kRows, 7);
      VectorXd tau(kRows);
      for (int k = 0; k < kRows; ++k) {
        const double base = gauss_(random_);
        const double cause = size_of_cause * gauss_(random_);
        const double alike = 0.9 * cause + unlike_ * gauss_(random_);
        const double other = gauss_(random_);
        const double idle = gauss_(random_);
        A.row(k) << base, cause, alike, other, idle, 2.0 * base, cause + other - 0.5 * idle;
        tau[k] = kNoise * gauss_(random_);
        for (const auto& [name, share] : torque_) {
          const auto at = std::find(names().begin(), names().end(), name) - names().begin();
          tau[k] += share * A(k, at);
        }
      }
      SquareRootInformation factor(names());
      factor.absorb(A, tau);
      out.blocks.push_back({factor});
    }
    return out;
  }

  std::map<std::string, double> torque_;
  double unlike_;
  std::mt19937 random_{5};
  std::normal_distribution<double> gauss_;
  std::vector<CompressedRecording> recordings_;
};

Hypothesis hypothesis(const std::string& column, ParameterSign sign = ParameterSign::kAny) {
  Hypothesis h;
  h.cause = NewEffect{column, {0}};
  h.joint = JointIndex{0};
  h.columns = {column};
  h.signs = {sign};
  return h;
}

std::vector<Hypothesis> all_hypotheses() {
  return {hypothesis("cause"), hypothesis("alike"), hypothesis("other"), hypothesis("idle"),
          hypothesis("copy")};
}

Selection selected(const Columns& columns, const std::vector<Hypothesis>& asked,
                   const DiagnosisOptions& options = {}) {
  const NormalBlocks data = columns.blocks();
  return select_effects(data, {0}, asked, options);
}

std::vector<std::string> accepted(const Selection& s, const std::vector<Hypothesis>& asked) {
  std::vector<std::string> out;
  for (const Accepted& a : s.accepted)
    out.push_back(asked[a.evidence.hypothesis].columns.front());
  return out;
}

using Names = std::vector<std::string>;

TEST(Selection, NamesWhatIsThereTheLargestFirst) {
  const auto asked = all_hypotheses();
  const Selection s = selected(Columns({{"base", 1.0}, {"cause", 0.3}, {"other", 0.6}}), asked);
  EXPECT_EQ(accepted(s, asked), (Names{"other", "cause"}));
}

// All accepted to begin with: what does nothing beside the others goes, the rest by what it gains.
TEST(Selection, WhatIsNeededStandsInTheOrderOfItsGains) {
  const std::vector<Hypothesis> all = {hypothesis("cause"), hypothesis("idle"), hypothesis("other")};
  const NormalBlocks data = Columns({{"base", 1.0}, {"cause", 0.3}, {"other", 0.6}}).blocks();
  const Selection s = keep_needed(data, {0}, all, {});
  EXPECT_EQ(accepted(s, all), (Names{"other", "cause"}));
  EXPECT_GT(s.accepted[0].evidence.gain, s.accepted[1].evidence.gain);
}

TEST(Selection, NamesNothingWhereNothingIs) {
  const auto asked = all_hypotheses();
  EXPECT_TRUE(accepted(selected(Columns({{"base", 1.0}}), asked), asked).empty());
}

TEST(Selection, WhatExplainsTheSameIsARivalAndACauseOfItsOwnIsNone) {
  const auto asked = all_hypotheses();
  const Columns columns({{"base", 1.0}, {"cause", 0.5}, {"other", 0.45}}, 0.1);
  const Selection s = selected(columns, asked);
  ASSERT_EQ(accepted(s, asked), (Names{"cause", "other"}));
  ASSERT_EQ(s.accepted[0].rivals.size(), 1U);
  EXPECT_EQ(asked[s.accepted[0].rivals[0].hypothesis].columns.front(), "alike");
  EXPECT_LT(s.accepted[0].rivals[0].gain, s.accepted[0].evidence.gain);
  EXPECT_TRUE(s.accepted[0].refuted.empty());
  EXPECT_TRUE(s.accepted[1].rivals.empty());
}

// It gains most of what the cause gains, but the cause is needed beside it, beyond doubt.
TEST(Selection, ARivalThatLeavesAClearPartToTheCauseIsRefuted) {
  const auto asked = all_hypotheses();
  const Selection s = selected(Columns({{"base", 1.0}, {"cause", 0.5}}), asked);
  ASSERT_EQ(accepted(s, asked), Names{"cause"});
  EXPECT_TRUE(s.accepted[0].rivals.empty());
  ASSERT_EQ(s.accepted[0].refuted.size(), 1U);
  const Evidence& alike = s.accepted[0].refuted[0];
  EXPECT_EQ(asked[alike.hypothesis].columns.front(), "alike");
  EXPECT_GT(alike.gain, 0.6 * s.accepted[0].evidence.gain);
}

TEST(Selection, WhatStillGainsBesideTheFindingIsNoRival) {
  const auto asked = all_hypotheses();
  DiagnosisOptions one;
  one.max_effects = 1;
  const Columns columns({{"base", 1.0}, {"cause", 0.5}, {"other", 0.45}}, 0.1);
  const Selection s = selected(columns, asked, one);
  ASSERT_EQ(accepted(s, asked), (Names{"cause"}));
  ASSERT_EQ(s.accepted[0].rivals.size(), 1U);
  EXPECT_EQ(asked[s.accepted[0].rivals[0].hypothesis].columns.front(), "alike");
}

// A law through level and damping that both changed explains more than either of them, and less than both.
TEST(Selection, LevelAndDampingThatChangedTogetherAreOneQuestion) {
  const NormalBlocks data = Columns({{"cause", 0.3}, {"other", 0.3}}).blocks();
  std::vector<Hypothesis> all = {hypothesis("cause"), hypothesis("other"), hypothesis("mixture")};
  all[2].cause = NewEffect{"sublinear_viscous", {0}};
  const auto chosen = [&] {
    std::vector<int> out;
    for (const Accepted& a : select_effects(data, {0}, all, {}).accepted) out.push_back(a.evidence.hypothesis);
    std::sort(out.begin(), out.end());
    return out;
  };
  all[0].cause = NewEffect{"viscous_friction", {0}};
  all[1].cause = NewEffect{"coulomb_friction", {0}};
  EXPECT_EQ(chosen(), (std::vector<int>{2}));
  all[0].cause = ChangedEffect{"viscous_friction", {0}};
  all[1].cause = ChangedEffect{"coulomb_friction", {0}};
  EXPECT_EQ(chosen(), (std::vector<int>{0, 1}));
}

// Two terms that differ by a ten thousandth: data leave their difference open. As those of a force of position each stays
// of the size of the joint's torque (about one), and what they do together is found all the same.
TEST(Selection, TermsOfAForceOfPositionDoNotCancel) {
  const NormalBlocks data = Columns({{"base", 1.0}, {"cause", 0.5}}, 1e-4).blocks();
  std::vector<Hypothesis> all = {hypothesis("cause")};
  all[0].columns = {"cause", "alike"};
  all[0].signs = {ParameterSign::kAny, ParameterSign::kAny};
  const auto terms = [&](const char* effect) {
    all[0].cause = NewEffect{effect, {0}};
    const Selection s = refit(data, {0}, all, {});
    return Eigen::Vector2d(s.values.tail(2));
  };
  const Eigen::Vector2d free = terms("sublinear_viscous");
  const Eigen::Vector2d bounded = terms("position_force");
  EXPECT_GT(free.cwiseAbs().maxCoeff(), 10.0);
  EXPECT_LT(bounded.cwiseAbs().maxCoeff(), 3.0);
  EXPECT_NEAR(bounded[0] + 0.9 * bounded[1], 0.5, 0.05);
}

TEST(Selection, RecordingsInWhichACauseNeverActsSayNothingAboutIt) {
  const std::vector<Hypothesis> asked = {hypothesis("cause")};
  EXPECT_EQ(accepted(selected(Columns({{"base", 1.0}, {"cause", 1.0}}, 0.45, 2), asked), asked), Names{"cause"});
  EXPECT_TRUE(accepted(selected(Columns({{"base", 1.0}}, 0.45, 2), asked), asked).empty());
}

TEST(Selection, StopsAtTheLargestNumber) {
  const auto asked = all_hypotheses();
  DiagnosisOptions options;
  options.max_effects = 1;
  const Selection s =
      selected(Columns({{"base", 1.0}, {"cause", 0.3}, {"other", 0.6}}), asked, options);
  EXPECT_EQ(accepted(s, asked), (Names{"other"}));
}

TEST(Selection, TellsWhatWasTakenFromWhatNoDataCanAnswer) {
  const auto asked = all_hypotheses();
  const Selection s = selected(Columns({{"base", 1.0}, {"cause", 0.5}}), asked);
  ASSERT_EQ(s.last_evaluated.size(), asked.size());
  EXPECT_TRUE(s.last_evaluated[0].accepted);
  EXPECT_FALSE(s.last_evaluated[0].collinear);
  EXPECT_TRUE(s.last_evaluated[4].collinear);  // twice the base column
  EXPECT_FALSE(s.last_evaluated[4].accepted);
  EXPECT_FALSE(s.last_evaluated[3].accepted || s.last_evaluated[3].collinear);
}

TEST(Selection, AnImpossibleSignIsNoAnswer) {
  const std::vector<Hypothesis> asked = {hypothesis("cause", ParameterSign::kNonnegative)};
  EXPECT_TRUE(selected(Columns({{"cause", -0.5}}), asked).accepted.empty());
  EXPECT_EQ(selected(Columns({{"cause", 0.5}}), asked).accepted.size(), 1U);
}

// Beside both of its parts the mixture would have to be negative, which it cannot be: it goes. The
// third cause lies in the span of all three until then.
TEST(Selection, WhatASuperfluousOneHidIsAskedAgain) {
  const std::vector<Hypothesis> asked = {hypothesis("mixture", ParameterSign::kNonnegative),
                                         hypothesis("cause"), hypothesis("other"),
                                         hypothesis("idle")};
  const NormalBlocks data = Columns({{"cause", 0.6}, {"other", 0.6}, {"idle", 0.3}}).blocks();
  const Selection s = select_effects(data, {0}, asked, {}, {0, 1, 2});
  EXPECT_EQ(accepted(s, asked), (Names{"cause", "other", "idle"}));
}

TEST(Selection, AGainBelowTheLeastOneIsNotNamed) {
  const std::vector<Hypothesis> asked = {hypothesis("cause")};
  const Columns columns({{"cause", 0.09}});  // ln(1 + 0.09) = 0.086 of the noise's square
  EXPECT_EQ(selected(columns, asked).accepted.size(), 1U);
  DiagnosisOptions stricter;
  stricter.thresholds.smallest_gain = 0.1;
  EXPECT_TRUE(selected(columns, asked, stricter).accepted.empty());
}

// One recording in eight parts; the cause acts with a share of its own in each of them.
NormalBlocks one_recording(const std::vector<double>& shares) {
  std::mt19937 random(5);
  std::normal_distribution<double> gauss;
  CompressedRecording recording;
  recording.joints.resize(1);
  const std::vector<std::string> columns = {"base", "cause"};
  for (const double share : shares) {
    MatrixXd A(kRows, 2);
    VectorXd tau(kRows);
    for (int k = 0; k < kRows; ++k) {
      A.row(k) << gauss(random), gauss(random);
      tau[k] = A(k, 0) + share * A(k, 1) + kNoise * gauss(random);
    }
    SquareRootInformation factor(columns);
    factor.absorb(A, tau);
    recording.blocks.push_back({factor});
  }
  return NormalBlocks({recording}, columns);
}

// Two parts of eight disagree a little, six agree by much on the joint that it acts on: enough to
// enter and to stay. Of a cause of the whole arm it is too little to enter. Of four that disagree
// nothing can be said.
TEST(Selection, WhatWasTakenStaysWhileTheSizesOfItsGainsSpeakForIt) {
  std::vector<Hypothesis> asked = {hypothesis("cause")};
  const auto evidence = [&asked](const std::vector<double>& shares) {
    const NormalBlocks data = one_recording(shares);
    const Examiner examiner(data, {0}, asked, {});
    const Evidence e = examiner.evaluate(0, *examiner.baseline({}));
    return std::make_pair(examiner.passes(e), examiner.stays(e));
  };
  EXPECT_EQ(evidence({0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5}), std::make_pair(true, true));
  EXPECT_EQ(evidence({0.5, 0.5, 0.1, 0.5, 0.5, 0.1, 0.5, 0.5}), std::make_pair(true, true));
  EXPECT_EQ(evidence({0.5, 0.1, 0.1, 0.5, 0.1, 0.1, 0.5, 0.5}), std::make_pair(false, false));
  asked[0].joint.reset();
  EXPECT_EQ(evidence({0.5, 0.5, 0.1, 0.5, 0.5, 0.1, 0.5, 0.5}), std::make_pair(false, true));
}

TEST(Selection, StillNeededDropsTheOneThatTheOtherCovers) {
  const std::vector<Hypothesis> asked = {hypothesis("alike"), hypothesis("cause"),
                                         hypothesis("other")};
  const NormalBlocks data = Columns({{"cause", 0.5}, {"other", 0.5}}).blocks();
  EXPECT_EQ(still_needed(data, {0}, asked, {}), (std::vector<int>{1, 2}));
}

TEST(Selection, IntervalsCoverWhatIsThere) {
  const std::vector<Hypothesis> asked = {hypothesis("cause"), hypothesis("other")};
  const NormalBlocks data = Columns({{"base", 1.0}, {"cause", 0.5}, {"other", 0.4}}).blocks();
  const Selection s = refit(data, {0}, asked, {});
  const VectorXd truth = (VectorXd(3) << 1.0, 0.5, 0.4).finished();
  // 1280 rows of noise 0.3: deviations near 0.3 / sqrt(1280) = 0.0084; recordings widen them.
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(s.values[k], truth[k], 4.0 * 0.0084);
    EXPECT_GT(s.standard_deviations[k], 0.5 * 0.0084);
    EXPECT_LT(s.standard_deviations[k], 4.0 * 0.0084);
  }
}

}  // namespace
}  // namespace veridyn
